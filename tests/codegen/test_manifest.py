# SPDX-License-Identifier: Apache-2.0
"""The manifest of a system whose vocabulary is an older one."""

from collections.abc import Mapping
from types import SimpleNamespace
from typing import get_origin, get_type_hints

import pytest
from sympy import S

from mehvar.base.manifest import Choice, Metric, Scenario
from mehvar.codegen.manifest import manifest_of
from mehvar.models.system import Controller, Group
from tests.models.edits import cart


class Older(SimpleNamespace):
    """A law as a vocabulary had it whose field was called `bears_loss`."""


@pytest.mark.parametrize("lost", [True, False])
def test_a_field_is_found_under_its_former_name(lost):
    law = Controller("free", "", Group("c", ()), (S.Zero,))
    fields = {name: value for name, value in vars(law).items() if name != "tolerates_loss"}
    system = cart()
    object.__setattr__(system, "controllers", (Older(**fields, bears_loss=lost),))
    assert manifest_of(system, (), {}).controllers["free"].tolerates_loss is lost


@pytest.mark.parametrize("kind", [Choice, Metric, Scenario])
def test_older_vocabularies_can_check_the_classes_that_they_share(kind):
    """Their check of fields knows no Literal."""
    assert {get_origin(hint) for hint in get_type_hints(kind).values()} <= {None, tuple, Mapping}
