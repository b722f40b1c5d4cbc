# SPDX-License-Identifier: Apache-2.0
"""Fixtures: a model and the ledger of its paper, for each MODEL/test_ledger.py."""

from __future__ import annotations

import pytest

from mehvar.codegen.ledger.ledger import Ledger
from mehvar.models.system import System
from tests import derived


def _model(request: pytest.FixtureRequest) -> str:
    return request.path.parent.name


@pytest.fixture(scope="module")
def system(request: pytest.FixtureRequest) -> System:
    return derived.system(_model(request))


@pytest.fixture(scope="module")
def ledger(request: pytest.FixtureRequest) -> Ledger:
    return derived.ledger(_model(request))
