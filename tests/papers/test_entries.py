# SPDX-License-Identifier: Apache-2.0
"""Everything that a paper prints has an entry, and the words of an entry say what was measured."""

from __future__ import annotations

import importlib
from collections import Counter

import pytest

from mehvar.base.errors import InputError
from mehvar.models.paper import Paper
from mehvar.reproduction.claims import Claim
from mehvar.reproduction.deviations import deviations, table_claims
from mehvar.reproduction.paper import Reproduction, load_reproduction
from mehvar.reproduction.runs import Runs
from mehvar.reproduction.statements import statement_verdicts
from tests.derived import REPRODUCED, system
from tests.papers.shared import HEAVY, missing, paper_claims, paper_runs
from tests.papers.words import silent, wrong_words

EVERY = [pytest.param(name, marks=pytest.mark.soak) if name in HEAVY else name for name in REPRODUCED]


@pytest.fixture(scope="module", params=EVERY)
def model(request: pytest.FixtureRequest) -> str:
    name: str = request.param
    return name


@pytest.fixture(scope="module")
def paper(model: str) -> Reproduction:
    return load_reproduction(model)


@pytest.fixture(scope="module")
def printed(model: str) -> Paper:
    """Return the paper's ledger, not judged."""
    written: Paper = importlib.import_module(f"papers.{model}.ledger").paper(system(model))
    return written


@pytest.fixture(scope="module")
def entries(printed: Paper) -> list[str]:
    """Return the numbers of the ledger's entries, as its verdicts have them."""
    return [f"({entry.number})" if entry.number.isdecimal() else entry.number for entry in printed.entries]


@pytest.fixture(scope="module")
def runs(model: str) -> Runs:
    return paper_runs(model)


@pytest.fixture(scope="module")
def claims(model: str, runs: Runs) -> list[Claim]:
    return [*paper_claims(model), *table_claims(runs.model.manifest, deviations(runs))]


def test_everything_printed_has_an_entry(paper: Reproduction, entries: list[str], claims: list[Claim]) -> None:
    numbers, drawn = (claim.number for claim in claims), (figure.number for figure in paper.figures)
    assert list(missing(paper.statements, numbers, entries, drawn)) == []


def test_every_statement_names_what_exists(paper: Reproduction, entries: list[str], claims: list[Claim]) -> None:
    try:
        statement_verdicts(paper.statements, claims, dict.fromkeys(entries, "holds"))
    except InputError as error:
        pytest.fail(str(error))
    drawn = {figure.number for figure in paper.figures}
    assert not {number for statement in paper.statements.statement for number in statement.figures} - drawn


def test_as_much_is_printed_as_the_ledger_says(paper: Reproduction, printed: Paper, entries: list[str]) -> None:
    """The equations are counted by the ledger; tables have entries there too."""
    assert paper.statements.printed.equations == printed.numbers
    tables = {number.split(",")[0].lower() for number in entries if number.startswith("Table ")}
    assert {f"table {k}" for k in range(1, paper.statements.printed.tables + 1)} == tables


def test_no_more_is_called_printed_than_is(paper: Reproduction) -> None:
    printed = paper.statements.printed
    for kind, count in (("table", printed.tables), ("figure", printed.figures)):
        places = {s.place for s in paper.statements.statement if s.place.startswith(f"{kind} ")}
        assert places == {f"{kind} {k}" for k in range(1, count + 1)}


def test_places_are_named_once_but_for_sections(paper: Reproduction) -> None:
    places = Counter(statement.place for statement in paper.statements.statement)
    once = ("table ", "figure ", "abstract ", "conclusions ")
    assert [place for place, count in places.items() if place.startswith(once) and count > 1] == []
    for kind in ("abstract", "conclusions"):
        numbers = sorted(int(place.split()[1]) for place in places if place.startswith(f"{kind} "))
        assert numbers == list(range(1, len(numbers) + 1))


def test_the_words_of_claims_and_captions_have_their_numbers_from_the_checks(
    paper: Reproduction, claims: list[Claim], runs: Runs
) -> None:
    """A number that was written by hand and that no check has, or has no more, is named."""
    assert list(wrong_words(paper, claims, runs.model.manifest)) == []


@pytest.mark.soak
def test_no_check_keeps_its_words_when_what_it_expects_changes(paper: Reproduction, runs: Runs) -> None:
    assert list(silent(paper, runs)) == []
