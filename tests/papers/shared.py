# SPDX-License-Identifier: Apache-2.0
"""The runs of each paper and the claims that are decided from them, made once for all tests of the papers.

They are half the cost of these tests; tests/conftest.py lets one process have all of them.
"""

from __future__ import annotations

import functools

from mehvar.reproduction.claims import Claim
from mehvar.reproduction.paper import load_reproduction
from mehvar.reproduction.runs import Runs
from mehvar.runtime.model.model import load


@functools.cache
def paper_runs(model: str) -> Runs:
    """Return the runs that a paper's claims share."""
    return Runs(load(model))


@functools.cache
def paper_claims(model: str) -> tuple[Claim, ...]:
    """Return the claims in their order."""
    return tuple(load_reproduction(model).claims(paper_runs(model)))
