# SPDX-License-Identifier: Apache-2.0
"""Runs of each paper and of its extended system, with the decided claims, computed once for all tests.

They are half the cost of these tests; tests/conftest.py lets one process have all of them, the report's tests last: it
takes the papers' runs for its own.
"""

from __future__ import annotations

import functools
from collections.abc import Iterable, Iterator
from pathlib import Path

from mehvar.report.papers.backends import Agreement, agreement
from mehvar.report.papers.content import beyond_folders
from mehvar.reproduction.claims import Claim
from mehvar.reproduction.paper import load_reproduction
from mehvar.reproduction.runs import Runs
from mehvar.reproduction.statements import Statements
from mehvar.runtime.model.model import Model, load

LIGHT = "triangle"
"""Model whose extended system the suite runs; each of the others takes a minute."""
HEAVY = ("satellite", "slosh")
"""Models whose claims take ten seconds or more; `make soak` and `make run` check them."""
_RUNS: dict[Path, Runs] = {}


def shared_runs(model: Model, paper: Runs | None = None) -> Runs:
    """Return the runs of a model, the same object each time; those of an extension beside its paper's."""
    return _RUNS.setdefault(model.manifest.folder, Runs(model, paper))


def paper_runs(model: str) -> Runs:
    """Return the runs that a paper's claims share."""
    return shared_runs(load(model))


@functools.cache
def beyond_runs(model: str) -> Runs:
    """Return the runs of the system beyond a paper."""
    return shared_runs(load(beyond_folders([model])[model]), paper_runs(model))


@functools.cache
def paper_claims(model: str) -> tuple[Claim, ...]:
    """Return the claims in their order."""
    return tuple(load_reproduction(model).claims(paper_runs(model)))


@functools.cache
def paper_agreement(model: str) -> Agreement:
    """Return the agreement of a model's code with CasADi's C."""
    return agreement(paper_runs(model))


def missing(
    statements: Statements, claims: Iterable[str], equations: Iterable[str], figures: Iterable[int]
) -> Iterator[str]:
    """Return the paper's printed items that have no entry in the file, and its claims that have no statement."""
    places = {statement.place for statement in statements.statement}
    entries, drawn = set(equations), set(figures)
    printed = statements.printed
    yield from (f"equation ({k})" for k in range(1, printed.equations + 1) if f"({k})" not in entries)
    yield from (f"table {k}" for k in range(1, printed.tables + 1) if f"table {k}" not in places)
    for k in range(1, printed.figures + 1):
        if f"figure {k}" not in places:
            yield f"statement of figure {k}"
        if k not in drawn:
            yield f"drawing of figure {k}"
    resting = {number for statement in statements.statement for number in statement.claims}
    yield from (f"statement for claim {number}" for number in claims if number not in resting)
    for section in ("abstract", "conclusions"):
        if not any(place.startswith(section) for place in places):
            yield section
