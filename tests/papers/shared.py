# SPDX-License-Identifier: Apache-2.0
"""The runs of each paper and of the system beyond it, and what is decided from them, made once for all tests.

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
"""The model whose system beyond its paper the suite runs: those of the others take a minute of a processor."""
HEAVY = ("satellite", "slosh")
"""Models whose claims take ten seconds of a processor and more: soak has them, and `make run`."""
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
    """Return how far a model's code and CasADi's own C agree."""
    return agreement(paper_runs(model))
