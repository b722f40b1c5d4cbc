# SPDX-License-Identifier: Apache-2.0
"""A model and the ledger of its paper, once for each MODEL/test_ledger.py."""

from __future__ import annotations

import importlib

import pytest

from mehvar.codegen.ledger.ledger import Ledger, judge
from mehvar.models.system import System


def _model(request: pytest.FixtureRequest) -> str:
    return request.path.parent.name


@pytest.fixture(scope="module")
def system(request: pytest.FixtureRequest) -> System:
    model: System = importlib.import_module(f"mehvar.models.{_model(request)}").system()
    return model


@pytest.fixture(scope="module")
def ledger(request: pytest.FixtureRequest, system: System) -> Ledger:
    return judge(importlib.import_module(f"mehvar.models.{_model(request)}.paper").paper(system), system.name)
