# SPDX-License-Identifier: Apache-2.0
"""Records, each asked whose it is: of this batch, of this block, and the one that the end has sealed."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from mehvar.runtime.batch.store.records import (
    END,
    FORMAT,
    STORE,
    Record,
    Records,
    block_record,
    file_digest,
    read_record,
    write_record,
)

OURS = {"format": FORMAT, "batch": "ours", "chunk": 4}


def write(folder: Path, block: int, place: int, **changes: Any) -> None:
    """Write the record of a block of four runs in the place of one."""
    facts = {**OURS, "block": block, "first": 4 * block, "last": 4 * block + 3, **changes}
    write_record(folder, block_record(place), Record(facts, {}))


def seal(folder: Path, **changes: Any) -> None:
    digests = {block_record(block): str(file_digest(folder / block_record(block))) for block in (0, 1)}
    write_record(folder, END, Record({**OURS, "runs": 8, **changes}, digests))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """The records of two blocks and their end."""
    write_record(tmp_path, STORE, Record({**OURS, "runs": 8}, {}))
    for block in (0, 1):
        write(tmp_path, block, block)
    seal(tmp_path)
    return tmp_path


OTHERS: list[tuple[str, Callable[[Path], object]]] = [
    ("of another batch", lambda folder: write(folder, 1, 1, batch="theirs")),
    ("of another batch", lambda folder: write(folder, 1, 1, chunk=2)),
    ("of another block", lambda folder: write(folder, 0, 1)),
    ("changed", lambda folder: (folder / block_record(1)).write_text("{}")),
    ("changed", lambda folder: write(folder, 1, 1, format=FORMAT + 1)),
    ("changed", lambda folder: write(folder, 1, 1, first=-1)),
    ("changed", lambda folder: write(folder, 1, 1, refusals={"one": "text"})),
]
"""Verdicts on a record in the place of another, of a batch that has ended or not."""
SEALED: list[tuple[str, Callable[[Path], object]]] = [
    ("missing", lambda folder: (folder / block_record(1)).unlink()),
    ("not the record that the end of the batch lists", lambda folder: write(folder, 1, 1, refusals={"4": "text"})),
]
"""Verdicts that need the end of the batch."""


@pytest.mark.parametrize("ended", [True, False])
@pytest.mark.parametrize(("what", "change"), [*OTHERS, *SEALED])
def test_a_record_in_the_place_of_another_is_told(
    folder: Path, what: str, change: Callable[[Path], object], ended: bool
) -> None:
    """Before the end a block is what its record says, if there is one."""
    assert isinstance(Records(folder).block(1), Record)
    change(folder)
    if not ended:
        (folder / END).unlink()
    told = ended or (what, change) in OTHERS
    assert Records(folder).block(1) == (what if told else read_record(folder / block_record(1)))
    assert Records(folder).block(0) == read_record(folder / block_record(0))


def test_an_end_of_another_batch_seals_nothing(folder: Path) -> None:
    seal(folder, batch="theirs")
    write(folder, 1, 1, refusals={"4": "text"})
    assert Records(folder).end == "of another batch"
    assert isinstance(Records(folder).block(1), Record)


@pytest.mark.parametrize("name", ["../outside", "/outside", "inside/../../outside"])
def test_a_record_lists_nothing_outside_its_store(folder: Path, name: str) -> None:
    write_record(folder, STORE, Record({**OURS, "runs": 8}, {name: "0"}))
    assert read_record(folder / STORE) is None
