# SPDX-License-Identifier: Apache-2.0
"""Models beyond the papers: claims hold, their words have their numbers from the checks, wrong files are refused."""

from __future__ import annotations

import shutil
from pathlib import Path
from types import SimpleNamespace

import pytest

from mehvar.base.errors import InputError
from mehvar.codegen.generate import installed_tree
from mehvar.reproduction.beyond import Beyond, differences, load_beyond, read_beyond
from mehvar.reproduction.claims import ClaimVerdict
from mehvar.reproduction.runs import Runs
from mehvar.runtime.model.model import load
from tests.papers.shared import LIGHT, beyond_runs
from tests.papers.words import silent, wrong_words

MODELS = [LIGHT, pytest.param("satellite", marks=pytest.mark.soak)]


@pytest.fixture(scope="module", params=MODELS)
def model(request: pytest.FixtureRequest) -> str:
    name: str = request.param
    return name


@pytest.fixture(scope="module")
def beyond(model: str) -> Beyond:
    found = load_beyond(model)
    assert found is not None
    return found


def test_a_paper_without_an_extension_has_none() -> None:
    assert load_beyond("slosh") is None


@pytest.fixture(scope="module")
def runs(model: str) -> Runs:
    return beyond_runs(model)


def test_claims_hold_and_have_their_numbers_from_the_checks(beyond: Beyond, runs: Runs) -> None:
    claims = beyond.claims(runs)
    captions = SimpleNamespace(readings=beyond.words.text)
    words = SimpleNamespace(
        texts=beyond.words.claim, figures=beyond.figures, captions=captions, checks=beyond.checks, readings={}
    )
    assert {claim.number: claim.verdict for claim in claims} == {
        text.number: ClaimVerdict.HOLDS for text in beyond.words.claim
    }
    assert list(wrong_words(words, claims, runs.model.manifest)) == []
    assert list(silent(words, runs)) == []


def test_the_structure_is_that_of_the_words_and_larger_than_the_papers(model: str, beyond: Beyond, runs: Runs) -> None:
    new = runs.model.manifest
    assert dict(beyond.words.structure).items() <= dict(new.structure).items()
    rows = {row.what: row for row in differences(load(model).manifest, new)}
    assert int(rows["operations of the rates"].beyond) == new.functions["rhs"].operations
    assert int(rows["operations of the rates"].paper) < int(rows["operations of the rates"].beyond)
    assert rows["states"].beyond.startswith(f"{len(new.states)}, of these ")
    assert int(rows["parameters of the plant"].beyond) == len(new.parameters)


def test_the_page_that_is_named_exists(beyond: Beyond) -> None:
    assert (Path(__file__).parents[2] / "docs" / "explanation" / f"{beyond.words.page}.md").is_file()


def test_a_claim_without_a_function_is_refused(tmp_path: Path) -> None:
    shutil.copy(installed_tree().root / "papers" / "triangle" / "beyond.toml", tmp_path)
    drawn = dict.fromkeys((1, 2))
    with pytest.raises(
        InputError, match=r"beyond\.toml: claims \['B1', .*do not match the functions of the code, \['B1'\]"
    ):
        read_beyond(tmp_path, drawn, {"B1": lambda *_: []})  # type: ignore[arg-type]
