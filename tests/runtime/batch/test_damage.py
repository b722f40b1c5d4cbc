# SPDX-License-Identifier: Apache-2.0
"""A store that proves itself: whatever file of it is damaged is seen, named, and mended to the same bytes."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest

from mehvar.base.errors import InputError
from mehvar.runtime.batch.evaluation.statistics import summarise
from mehvar.runtime.batch.fill import run_batch
from mehvar.runtime.batch.plan import Campaign
from mehvar.runtime.batch.repeat import difference, plan_of, repeat_run
from mehvar.runtime.batch.store.records import END, STORE, DamageError, read_record
from mehvar.runtime.batch.store.store import open_store
from mehvar.runtime.batch.store.verification import verify
from tests.fuzz.campaign import in_process
from tests.runtime.batch.forgery import (
    CHUNK,
    DAMAGES,
    PENDULUM,
    contents,
    cut,
    empty,
    flip,
    is_complete,
    mend,
    remove,
)


def test_a_key_that_is_there_twice_is_damage(store: Path) -> None:
    """Readers of JSON keep one of the two without a word."""
    for path in sorted(store.rglob("*.json")):
        text = path.read_text()
        path.write_text(re.sub(r'("\w+"):', r"\1: 0, \1:", text, count=1))
        json.loads(path.read_text())
        assert not is_complete(store), path
        path.write_text(text)
    assert is_complete(store)


@pytest.mark.parametrize(
    "name",
    ["zarr.json", "angle/zarr.json", "variable/c/0", END, "records/0.json", "final/c/2/0", "g/c/1"],
)
@pytest.mark.share(4)
def test_whatever_is_damaged_is_mended_to_the_same_bytes(store: Path, whole: Path, name: str) -> None:
    """One by one, and with the metadata too: the store's record says of which batch the rest is."""
    flip(store / name)
    mend(store)
    assert contents(store) == contents(whole)
    flip(store / name)
    (store / "zarr.json").unlink()
    mend(store)
    assert contents(store) == contents(whole)


@pytest.mark.parametrize("damage", DAMAGES)
@pytest.mark.share(2)
def test_a_damaged_block_is_named_and_it_alone_is_computed_again(
    store: Path, whole: Path, damage: Callable[[Path], None]
) -> None:
    damage(store / "angle" / "c" / "1" / "0")
    what = "missing" if damage is remove else "changed"
    line = f"block 1 (runs 16 to 31): angle/c/1/0 is {what}"
    with pytest.raises(DamageError, match="is damaged: ") as refused:
        open_store(store).dataset()["angle"].load()
    assert line in str(refused.value)
    assert "--resume" in str(refused.value)
    with pytest.raises(DamageError) as refused:
        summarise(open_store(store))
    assert line in str(refused.value)
    before = {name: (store / name).stat().st_mtime_ns for name in contents(store)}
    assert mend(store) == [f"{store}: {line}; computed again"]
    again = {name for name in before if (store / name).stat().st_mtime_ns != before[name]}
    assert {name.split("/")[2] for name in again if "/c/" in name} <= {"1"}
    assert contents(store) == contents(whole)


def test_a_batch_that_mends_its_store_does_not_wait_for_itself(store: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    flip(store / "angle" / "c" / "1" / "0")
    monkeypatch.setattr("mehvar.runtime.batch.store.verification.time", SimpleNamespace(sleep=pytest.fail))
    mend(store)


def test_a_whole_store_is_left_as_it_is(store: Path) -> None:
    before = {name: (store / name).stat().st_mtime_ns for name in contents(store)}
    assert mend(store) == []
    assert {name: (store / name).stat().st_mtime_ns for name in contents(store)} == before


def test_an_unfinished_store_says_what_is_missing(store: Path) -> None:
    for name in (END, "records/1.json"):
        (store / name).unlink()
    verification = verify(store)
    assert verification.sound
    assert not verification.complete
    assert verification.missing == (1,)
    assert summarise(open_store(store)).stored == 24
    assert open_store(store).dataset()["status"].values[16:32].tolist() == [255] * 16, "chunks without a record"


@pytest.mark.parametrize("damage", DAMAGES)
def test_a_run_is_repeated_whatever_became_of_other_blocks(store: Path, damage: Callable[[Path], None]) -> None:
    for place in ("records/1.json", "t_stop/c/1"):
        damage(store / place)
    opened = open_store(store)
    plan = plan_of(opened, PENDULUM)
    here, there = (next(run for run in range(first, 40) if not plan.refusal(run)) for first in (0, CHUNK))
    assert difference(repeat_run(plan, opened, here), plan, opened, here) == ""
    with pytest.raises(DamageError, match=r"records/1\.json"):
        difference(repeat_run(plan, opened, there), plan, opened, there)


@pytest.mark.parametrize("damage", DAMAGES)
def test_a_store_whose_own_record_is_not_intact_is_refused_by_name(store: Path, damage: Callable[[Path], None]) -> None:
    damage(store / STORE)
    before = contents(store)
    for look in (verify, open_store, mend):
        with pytest.raises(DamageError, match=rf"{STORE} is missing or changed, so that nothing identifies its batch"):
            look(store)
    assert contents(store) == before
    shutil.rmtree(store / "records")
    for look in (verify, open_store, mend):
        with pytest.raises(InputError, match="is not a batch store: it has no records"):
            look(store)


def test_blocks_of_another_batch_are_not_taken_for_ones_own(store: Path) -> None:
    (store / "zarr.json").unlink()
    with pytest.raises(ValueError, match="its records belong to another batch"):
        run_batch(PENDULUM, Campaign("pd", n=40, vary={"g": "uniform(-1, 9)"}), store, resume=True)


def test_a_block_that_is_not_the_one_of_the_end_is_damage(store: Path) -> None:
    """It is whole and of this batch; but what the end sealed was another, or is gone."""
    place = store / "records/1.json"
    record = read_record(place)
    assert record is not None
    place.write_bytes(replace(record, about={**record.about, "provenance": {"compiler": "another"}}).content())
    assert [damage.files for damage in verify(store).damaged] == [
        {"records/1.json": "not the record that the end of the batch lists"}
    ]
    place.unlink()
    assert [damage.files for damage in verify(store).damaged] == [{"records/1.json": "missing"}]


def test_facts_for_programs(store: Path) -> None:
    cut(store / "status" / "c" / "2")
    facts = verify(store).facts()
    assert facts["complete"] is False
    assert facts["damaged"] == [{"block": 2, "first": 32, "last": 39, "files": {"status/c/2": "changed"}}]
    assert (facts["runs"], facts["blocks"], facts["whole"]) == (40, 3, 2)


def test_what_no_record_lists_is_named_and_changes_nothing(store: Path) -> None:
    before = verify(store).facts()
    assert not before["others"]
    (store / "notes.txt").write_text("mine")
    (store / "status" / "c" / "77").write_bytes(b"x")
    after = verify(store)
    assert after.others == ("notes.txt", "status/c/77")
    assert after.facts() == before | {"others": ["notes.txt", "status/c/77"]}
    status, text = in_process("verify", str(store))
    assert status == 0
    assert "note: files that no record lists and mehvar does not read: notes.txt, status/c/77" in text


@pytest.mark.parametrize("file", range(0, 40, 3))
def test_a_file_is_either_held_against_a_record_or_named(store: Path, file: int) -> None:
    """Whatever file is damaged or put there, verification knows of it."""
    places = sorted(path for path in store.rglob("*") if path.is_file() and path.name != "lock")
    place = places[file % len(places)]
    beside = place.with_name(f"{place.name}.copy")
    beside.write_bytes(place.read_bytes())
    assert beside.relative_to(store).as_posix() in verify(store).others
    damage = (flip, cut, empty, remove)[file % 4 if place.name != "end.json" else 0]
    damage(place)
    assert not is_complete(store)
    with pytest.raises(DamageError, match="is damaged: "):
        summarise(open_store(store))
