# SPDX-License-Identifier: Apache-2.0
"""A store that was edited and sealed again: what it says of itself is refused, told or harmless, never a crash."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import pytest

from mehvar.base.errors import InputError, MehvarError
from mehvar.runtime.batch.evaluation.sensitivity import sensitivities
from mehvar.runtime.batch.evaluation.statistics import summarise
from mehvar.runtime.batch.repeat import difference, plan_of, repeat_run
from mehvar.runtime.batch.store.lock import FILE, Lock
from mehvar.runtime.batch.store.records import END, STORE, DamageError, read_record
from mehvar.runtime.batch.store.store import StoreError, open_store
from mehvar.runtime.batch.store.verification import verify
from tests.fuzz.campaign import in_process
from tests.runtime.batch.forgery import PENDULUM, contents, edit, mend, seal

OTHERS: tuple[Any, ...] = (None, 1.5, "text", [3], {"a": 1}, 10**40)
"""One of each kind that JSON has."""
HARMLESS = {"title", "model_source", "flags", "compiler", "profile", "versions", "until"}
"""Texts for people; `model_source` is not taken without trust."""


@contextmanager
def changed(store: Path, name: str, change: Callable[[dict[str, Any]], object], **about: Any) -> Iterator[None]:
    """Change a file, seal the store, and undo both."""
    names = list((store / "records").iterdir())
    kept = {path: path.read_bytes() for path in (*names, store / name)}
    edit(store / name, change)
    seal(store, **about)
    yield
    for path, content in kept.items():
        path.write_bytes(content)


@contextmanager
def changed_array(store: Path, name: str, change: Callable[[dict[str, Any]], object]) -> Iterator[None]:
    """Change what the group and the array itself say of an array."""
    with (
        changed(store, "zarr.json", lambda content: change(content["consolidated_metadata"]["metadata"][name])),
        changed(store, f"{name}/zarr.json", change),
    ):
        yield


def without(table: str, key: str) -> Callable[[dict[str, Any]], object]:
    return lambda content: content[table].pop(key)


def with_value(table: str, key: str, value: Any) -> Callable[[dict[str, Any]], object]:
    return lambda content: content[table].update({key: value})


def refused(store: Path) -> None:
    """Nothing reads it, and nothing but our errors says so."""
    with pytest.raises(MehvarError):
        summarise(open_store(store))
    with suppress(InputError):
        assert not verify(store).complete


def attributes(store: Path) -> dict[str, Any]:
    values: dict[str, Any] = json.loads((store / "zarr.json").read_bytes())["attributes"]
    return values


def kinds(value: object) -> list[Any]:
    return [other for other in OTHERS if type(other) is not type(value)]


@pytest.mark.soak
def test_an_attribute_that_is_gone_or_of_another_kind_is_refused(store: Path) -> None:
    for name, value in attributes(store).items():
        with changed(store, "zarr.json", without("attributes", name)), pytest.raises(MehvarError):
            open_store(store)
        for other in kinds(value):
            with changed(store, "zarr.json", with_value("attributes", name, other)), pytest.raises(MehvarError):
                open_store(store)


@pytest.mark.parametrize("name", ["campaign", "numerics", "drawn", "metrics", "nominal", "structure", "versions"])
@pytest.mark.share(3)
def test_a_text_in_an_attribute_is_held_against_a_schema_too(store: Path, name: str) -> None:
    value = json.loads(attributes(store)[name])
    texts = ["", "{", *(json.dumps(other) for other in kinds(value)), "[[1]]", "NaN", "[" * 99_999]
    if name == "campaign":
        texts += [json.dumps({key: v for key, v in value.items() if key != gone}) for gone in value]
        texts += [json.dumps({**value, key: other}) for key in value for other in ([1], [[]], {"a": []})]
    for text in texts:
        with changed(store, "zarr.json", with_value("attributes", name, text)), pytest.raises(MehvarError):
            open_store(store)


@pytest.mark.soak
def test_a_value_that_is_another_is_told_or_harmless(store: Path) -> None:
    for name, value in attributes(store).items():
        others = [value + 1] if isinstance(value, int) else [value[:-1]] if isinstance(value, list) else ["", "other"]
        if name in ("nominal", "structure", "numerics"):
            others = [json.dumps({**json.loads(value), "g": "0" if name != "nominal" else 1.0})]
        for other in others:
            with changed(store, "zarr.json", with_value("attributes", name, other)):
                told = other == value or name in HARMLESS
                try:
                    opened = open_store(store)
                    summarise(opened)
                    sensitivities(opened)
                    opened.dataset().load()
                    plan = plan_of(opened, PENDULUM)
                    told |= difference(repeat_run(plan, opened, 1), plan, opened, 1) != ""
                except MehvarError:
                    told = True
                assert told or name in ("numerics", "versions"), (name, other)


def test_what_a_record_says_is_held_against_a_schema(store: Path) -> None:
    """Format, block, runs, refusals: gone, or of another kind."""
    for name in (STORE, "records/1.json", END):
        record = read_record(store / name)
        assert record is not None
        kept = (store / name).read_bytes()
        for fact, value in record.about.items():
            if fact == "provenance":
                continue  # for people
            others = [{"1": 3}, {"one": "text"}] if fact == "refusals" else [*kinds(value), -1]
            changes = [{**record.about, fact: other} for other in others]
            if fact != "refusals":  # of a block without impossible runs
                changes.append({key: v for key, v in record.about.items() if key != fact})
            for facts in changes:
                (store / name).write_bytes(type(record)(facts, record.digests).content())
                with suppress(MehvarError):
                    assert not verify(store).complete, (name, facts)
            with pytest.raises(MehvarError):
                summarise(open_store(store))
        (store / name).write_bytes(kept)
    assert verify(store).complete


def test_what_a_variable_says_of_itself_changes_no_value(store: Path, whole: Path) -> None:
    """In xarray `scale_factor` multiplies, `_FillValue` hides, and "days since" makes dates."""
    for name in ("t_stop", "angle", "status", "t"):
        for key, value in (("scale_factor", 2.0), ("_FillValue", 0.1), ("dtype", "bool"), ("units", 3)):
            changes = with_value("attributes", key, value)
            with changed_array(store, name, changes), pytest.raises(MehvarError):
                open_store(store)
    for name in ("t_stop", "angle", "t"):
        with changed_array(store, name, with_value("attributes", "units", "days since 2000-01-01")):
            values = open_store(store).dataset().load()
            assert values[name].equals(open_store(whole).dataset()[name].load())
    for key in ("units", "long_name"):
        with changed_array(store, "g", without("attributes", key)), pytest.raises(MehvarError):
            open_store(store)
    with changed(store, "g/zarr.json", without("attributes", "units")), pytest.raises(MehvarError, match="contradicts"):
        open_store(store)


def test_another_version_is_refused_by_name_and_not_called_damaged(store: Path) -> None:
    with changed(store, "zarr.json", with_value("attributes", "mehvar_batch", 3), format=3):
        for look in (verify, open_store, mend):
            with pytest.raises(InputError, match="of another version: its format is 3"):
                look(store)
        assert in_process("verify", str(store))[0] == 2
    with changed(store, "zarr.json", with_value("attributes", "mehvar_batch", 3)):
        for look in (verify, open_store, mend):
            with pytest.raises(InputError, match="mehvar_batch = 3: must be 2"):
                look(store)
    assert verify(store).complete


def pipe(path: Path, _: Path) -> None:
    path.unlink(missing_ok=True)
    os.mkfifo(path)


def link(path: Path, outside: Path) -> None:
    """Move a file or folder out of the store, and link to it."""
    if path.exists():
        shutil.move(path, outside)
    else:
        outside.write_text("precious")
    path.symlink_to(outside)


FILES = ("final/c/1/0", "records/1.json", "g/c/0", END, "zarr.json", "g/zarr.json", "variable/c/0", FILE)
FOLDERS = ("final", "final/c", "records")


@pytest.mark.parametrize(("what", "names"), [(pipe, FILES), (link, (*FILES, STORE, *FOLDERS))])
@pytest.mark.share(2)
def test_links_and_pipes_are_refused_and_nothing_is_written_through_them(
    whole: Path, tmp_path: Path, what: Callable[[Path, Path], None], names: tuple[str, ...]
) -> None:
    """Whatever a link leads to, and even if its bytes are right."""
    for k, name in enumerate(names):
        store = tmp_path / f"{k}.zarr"
        shutil.copytree(whole, store)
        what(store / name, tmp_path / f"{k}")
        before = contents(tmp_path)
        kind = {pipe: "a pipe or a device", link: "a link"}[what]
        for look in (verify, open_store, mend):
            with pytest.raises(DamageError, match=f"{name} is {kind}; remove"):
                look(store)
        assert contents(tmp_path) == before, name


@pytest.mark.parametrize("name", [*FILES[:6], *FOLDERS[:2]])
@pytest.mark.share(2)
def test_a_folder_for_a_file_or_a_file_for_a_folder_stops_a_resume_until_it_is_gone(
    store: Path, whole: Path, name: str
) -> None:
    place = store / name
    if place.is_dir():
        shutil.rmtree(place)
        place.write_text("")
    else:
        place.unlink()
        place.mkdir()
    refused(store)
    with pytest.raises(StoreError, match=r"cannot write .*runs\.zarr.*: (Is|Not) a directory"):
        mend(store)
    place.rmdir() if place.is_dir() else place.unlink()
    mend(store)
    assert contents(store) == contents(whole)


def test_who_is_writing_is_said(store: Path) -> None:
    (store / END).unlink()
    lock = Lock(store, "it")
    writer = f"process {os.getpid()} on "
    assert str(verify(store).facts()["writer"]).startswith(writer)
    status, said = in_process("verify", str(store))
    assert status == 1
    assert f"being written by {writer}" in said
    lock.release()
    assert verify(store).writer is None
