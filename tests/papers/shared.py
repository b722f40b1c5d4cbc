# SPDX-License-Identifier: Apache-2.0
"""Runs of each paper and of its extended system, with the decided claims, computed once for all tests.

They are half the cost of these tests; tests/conftest.py lets one process have all of them, the report's tests last: it
takes the papers' runs for its own.
"""

from __future__ import annotations

import functools
from pathlib import Path

from mehvar.report.backends import Agreement, agreement
from mehvar.report.content import beyond_folders
from mehvar.reproduction.claims import Claim
from mehvar.reproduction.paper import load_reproduction
from mehvar.reproduction.runs import Runs
from mehvar.runtime.model.model import Model, load

LIGHT = "triangle"
"""Model whose extended system the suite runs; each of the others takes a minute."""
HEAVY = ("satellite", "slosh")
"""Models whose claims take ten seconds or more; `make soak` and `make run` check them."""
_RUNS: dict[Path, Runs] = {}


def shared_runs(model: Model) -> Runs:
    """Return the runs of a model, the same object each time."""
    return _RUNS.setdefault(model.manifest.folder, Runs(model))


def paper_runs(model: str) -> Runs:
    """Return the runs that a paper's claims share."""
    return shared_runs(load(model))


@functools.cache
def beyond_runs(model: str) -> Runs:
    """Return the runs of the system beyond a paper."""
    return shared_runs(load(beyond_folders([model])[model]))


@functools.cache
def paper_claims(model: str) -> tuple[Claim, ...]:
    """Return the claims in their order."""
    return tuple(load_reproduction(model).claims(paper_runs(model)))


@functools.cache
def paper_agreement(model: str) -> Agreement:
    """Return the agreement of a model's code with CasADi's C."""
    return agreement(paper_runs(model))
