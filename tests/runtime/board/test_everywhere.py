# SPDX-License-Identifier: Apache-2.0
"""The short form of the table of laws and targets, and the page of the long one."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from mehvar.base.errors import MissingError
from tests.runtime.board.everywhere import OWN, PAGE, TARGETS, Cell, Target, cell, laws, page, short

SAMPLES = 30


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("everywhere")


@pytest.fixture(scope="module")
def checksums(place: Path) -> dict[str, str]:
    """Checksums of the self-test on this machine, by law."""
    return {law: cell(law, TARGETS[0], SAMPLES, place).crc for law in laws()}


@pytest.mark.parametrize(("law", "target"), [pytest.param(*c, id=f"{c[0]}, {c[1].title}") for c in short()])
@pytest.mark.soak
def test_a_law_has_the_same_bits_on_a_target(law: str, target: Target, place: Path, checksums: dict[str, str]) -> None:
    try:
        result = cell(law, target, SAMPLES, place)
    except MissingError as error:
        pytest.skip(str(error))
    assert result.ulp == 0, result
    assert result.crc in ("", checksums[law])
    assert result.compared > SAMPLES or not result.crc


def test_the_short_form_has_every_law_and_every_kind_of_target() -> None:
    cells = list(short())
    assert {law for law, _ in cells} == set(laws())
    assert {target.target for _, target in cells} == {target.target for target in TARGETS}
    boards = {target.board for _, target in cells}
    assert boards == {target.board for target in TARGETS} - {"riscv64-soft"}, "that one needs a C library from zig"


def test_the_page_has_every_law_and_target_and_no_difference() -> None:
    text = PAGE.read_text()
    for law in laws():
        assert law.replace("/", " ") in text
    rows = {line.split(" | ")[0].strip("| "): line for line in text.splitlines() if line.startswith("|")}
    for target in TARGETS:
        numbers = [part.strip() for part in rows[target.title].strip("|").split("|")[1:]]
        assert len(numbers) == len(laws())
        assert set(numbers) <= {"0", "–"}
    assert re.search(r"(\d+) of \d+ cells", text)


def test_a_difference_is_on_the_page() -> None:
    own = f"{OWN}/balance"
    given = {"law": own, "samples": 9, "digest": "", "compared": 9, "reason": ""}
    cells = [
        Cell(**given, title=TARGETS[0].title, ulp=0, crc="aa"),
        Cell(**given, title=TARGETS[1].title, ulp=3, crc="aa"),
        Cell(**given, title=TARGETS[2].title, ulp=0, crc="bb"),
    ]
    rows = [line for line in page(cells).splitlines() if line.startswith(tuple(f"| {t.title}" for t in TARGETS[:4]))]
    assert [row.split("|")[-2].strip() for row in rows] == ["0", "3", "0, checksum bb", "–"]
