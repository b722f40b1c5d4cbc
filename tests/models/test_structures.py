# SPDX-License-Identifier: Apache-2.0
"""A sample of the structures that the models declare; `make soak` goes through all of them."""

import random

import pytest

from tests.models.structures import MODELS, outcome, structures


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.share(3)
def test_a_declared_structure_is_derived_or_refused_by_a_rule_of_its_model(model):
    small = [s for s in structures(model) if int(s.get("pendulums", "1")) <= 3]
    assert any(outcome(model, structure) == "" for structure in random.Random(32).sample(small, 3))


def test_a_rule_of_a_model_says_what_it_refuses():
    assert "needs model = 'dynamic'" in outcome("triangle", {"rods": "uniform"})
