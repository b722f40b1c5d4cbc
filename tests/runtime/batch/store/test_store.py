# SPDX-License-Identifier: Apache-2.0
"""The store of a batch: blocks recorded or absent, plain Zarr for others, clear words when it cannot be written."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray

from mehvar.base.errors import InputError
from mehvar.runtime.batch.plan import Campaign
from mehvar.runtime.batch.store import files
from mehvar.runtime.batch.store import store as store_module
from mehvar.runtime.batch.store.layout import NOT_RUN, STATUS, Coordinate, Layout, Variable
from mehvar.runtime.batch.store.lock import Lock
from mehvar.runtime.batch.store.records import block_record, read_record
from mehvar.runtime.batch.store.store import Store, StoreError, create, open_store, resume
from mehvar.runtime.batch.store.verification import verify
from tests.runtime.batch.forgery import contents

VARIABLES = [
    Variable("m1", "float64", attributes={"units": "kg", "long_name": "mass"}),
    Variable("final", "float64", "state", 2),
    Variable("theta", "float64", "t", 3),
    Variable(STATUS, "uint8"),
]
COORDINATES = {"state": Coordinate(["a", "b"]), "t": Coordinate(np.array([0.0, 0.5, 1.0]), {"units": "s"})}
CAMPAIGN = Campaign("law", n=10, seed=3, options={"method": "rk4", "rtol": 1e-6})
IDENTITY = {
    **{"model": "m", "model_hash": "0", "campaign": CAMPAIGN.json_text(), "success": "", "until": ""},
    "numerics": '{"generated": "0", "options": "{}", "profile": "portable"}',
}
ATTRIBUTES = {
    **{"title": "test", "model_source": "m", "controller": "law", "scenario": "s", "seed": 3, "drawn": "[]"},
    **{"metrics": '["m1"]', "profile": "portable", "flags": "", "compiler": "cc"},
    **dict.fromkeys(("nominal", "structure", "versions"), "{}"),
}
LAYOUT = Layout(10, 4, VARIABLES, COORDINATES, {**ATTRIBUTES, **IDENTITY})


def values(first: int, count: int) -> dict[str, np.ndarray]:
    runs = np.arange(first, first + count, dtype=np.float64)
    wide = runs[:, None]
    return {
        "m1": runs + 0.5,
        "final": np.concatenate([wide, -wide], axis=1),
        "theta": wide + np.array([0.0, 0.1, 0.2]),
        STATUS: (runs % 3).astype(np.uint8),
    }


def fill(store: Store) -> None:
    """Write all blocks."""
    for block in range(store.blocks()):
        store.write(block, values(store.runs(block).start, len(store.runs(block))))


@pytest.fixture
def store(tmp_path: Path) -> Store:
    return create(tmp_path / "runs.zarr", LAYOUT)


def test_plain_xarray_reads_names_units_and_values(store: Store) -> None:
    fill(store)
    with xarray.open_zarr(store.path) as plain:
        assert dict(plain.sizes) == {"run": 10, "state": 2, "t": 3}
        assert plain.m1.attrs["units"] == "kg"
        assert plain.attrs["seed"] == 3
        assert np.array_equal(plain.final.sel(state="b"), -np.arange(10.0))
        assert np.array_equal(plain.theta.sel(t=1.0), np.arange(10.0) + 0.2)
        assert plain.status.dtype == np.uint8


def test_variables_come_back_as_they_were_declared(store: Store) -> None:
    assert store.variables() == {variable.name: variable for variable in VARIABLES}
    assert open_store(store.path).variables() == store.variables()


def test_a_block_counts_when_its_record_is_there(store: Store) -> None:
    assert store.stored() == []
    store.write(1, values(4, 4))
    assert store.stored() == [1]
    assert np.array_equal(store.read("m1"), np.arange(4, 8) + 0.5)
    assert (store.dataset().status.values[:4] == NOT_RUN).all()
    assert open_store(store.path).stored() == [1]


def test_a_block_of_an_ended_store_is_written_anew_with_other_numbers_and_the_end_follows(store: Store) -> None:
    fill(store)
    store.end(10)
    assert store.path is not None
    (store.path / block_record(1)).unlink()
    with store.writing():
        pass  # lets the store go
    going = resume(store.path, LAYOUT, lambda _: None)
    with going.writing():
        going.write(1, values(100, 4))
        assert np.array_equal(going.read("m1", [1]), np.arange(100, 104) + 0.5)
        going.end(10)
    assert verify(store.path).complete


def test_chunks_are_on_the_disk_before_their_record_has_its_name(store: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    """At whichever instant the power goes, what a record lists is there: files, names in folders, then the record."""
    forced: list[Path] = []
    at_record: list[set[Path]] = []
    real_fsync, real_replace = os.fsync, Path.replace

    def fsync(handle: int) -> None:
        forced.append(Path(f"/proc/self/fd/{handle}").readlink())
        real_fsync(handle)

    def replace(path: Path, target: Path) -> Path:
        if target.name == "0.json":
            at_record.append({*forced, path})
            assert path in forced
        return real_replace(path, target)

    monkeypatch.setattr(os, "fsync", fsync)
    monkeypatch.setattr(Path, "replace", replace)
    store.write(0, values(0, 4))
    record = read_record(store.path / block_record(0))
    chunks = [store.path / name for name in record.digests]
    assert len(chunks) == 4
    assert {*chunks, *(chunk.parent for chunk in chunks), store.path} <= at_record[0]
    assert forced[-1] == store.path / "records", "the name of the record"


@pytest.mark.parametrize("failing", range(4))
def test_a_full_disk_loses_no_block_and_repeats_none(
    store: Store, monkeypatch: pytest.MonkeyPatch, failing: int
) -> None:
    store.write(0, values(0, 4))
    real, count = files.write_file, iter(range(100))

    def full(path: Path, *rest: Any, **options: Any) -> None:
        if next(count) == failing:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.with_suffix(f".{0:032x}.partial").write_bytes(b"half")
            raise OSError(errno.ENOSPC, "No space left on device")
        real(path, *rest, **options)

    monkeypatch.setattr(files, "write_file", full)
    with store.writing(), pytest.raises(StoreError, match=r"cannot write .*runs.zarr: No space left on device"):
        store.write(1, values(4, 4))
    monkeypatch.undo()
    assert open_store(store.path).stored() == [0]
    again = goes_on(store.path)
    with again.writing():
        assert not list(store.path.rglob("*.partial"))
        again.write(1, values(4, 4))
    assert np.array_equal(again.read("m1"), np.arange(8) + 0.5)


def goes_on(path: Path, layout: Layout = LAYOUT) -> Store:
    return resume(path, layout, lambda _: None)


def test_two_processes_do_not_write_at_once(store: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    """The second is told who has it; the lock leaves no file behind."""
    monkeypatch.setattr("mehvar.runtime.batch.store.lock._LOOKS", 2)  # a second is for readers on a busy machine
    me = rf"another process is writing .*runs.zarr: process {os.getpid()} on "
    with pytest.raises(InputError, match=me):
        goes_on(store.path)
    with pytest.raises(InputError, match=me):
        create(store.path, LAYOUT)
    with store.writing():
        pass
    assert not (store.path / "lock").exists()
    with goes_on(store.path).writing(), pytest.raises(InputError, match=me):
        goes_on(store.path)


def test_the_lock_of_a_killed_process_holds_nobody(store: Store, tmp_path: Path) -> None:
    with store.writing():
        pass
    code = (
        "import os, sys; from pathlib import Path; from mehvar.runtime.batch.store.lock import Lock\n"
        "lock = Lock(Path(sys.argv[1]), 'it'); os._exit(9)"
    )
    subprocess.run([sys.executable, "-c", code, str(store.path)], check=False)
    assert (store.path / "lock").read_text().startswith("process ")
    with goes_on(store.path).writing():
        pass
    scratch = tmp_path / ".other.zarr.0123.new"
    scratch.mkdir()
    subprocess.run([sys.executable, "-c", code, str(scratch)], check=False)
    create(tmp_path / "other.zarr", LAYOUT)
    assert not scratch.exists(), "what was killed while it was made is removed"


def test_what_a_living_process_makes_is_not_removed(tmp_path: Path) -> None:
    """Nor what has no lock yet: it may have been made this instant."""
    living, new = (tmp_path / f".other.zarr.{number}.new" for number in ("01", "02"))
    for folder in (living, new):
        folder.mkdir()
        (folder / "begun").write_text("")
    lock = Lock(living, "it")
    create(tmp_path / "other.zarr", LAYOUT)
    lock.release()
    assert [(folder / "begun").exists() for folder in (living, new)] == [True, True]


def test_a_store_cut_short_keeps_whole_blocks(store: Store, tmp_path: Path) -> None:
    """It is the store that was made so short, byte for byte."""
    with store.writing():
        fill(store)
        store.end(4)
    assert store.n == open_store(store.path).n == 4
    with xarray.open_zarr(store.path) as plain:
        assert np.array_equal(plain.m1, np.arange(4) + 0.5)
    short = create(tmp_path / "short.zarr", replace(LAYOUT, n=4))
    with short.writing():
        fill(short)
        short.end(4)
    assert contents(store.path) == contents(short.path)


def test_a_store_that_was_being_cut_is_cut(store: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    with store.writing():
        fill(store)
        whole = contents(store.path)
        store.end(4)
    cut = contents(store.path)
    for stop in range(5):
        for path in sorted(store.path.rglob("*"), reverse=True):
            path.unlink() if path.is_file() else path.rmdir()
        for name, content in whole.items():
            (store.path / name).parent.mkdir(parents=True, exist_ok=True)
            (store.path / name).write_bytes(content)
        again, real, count = goes_on(store.path), files.replace_file, iter(range(100))

        def die(*file: Any, stop: int = stop, real: Any = real, count: Any = count) -> None:
            if next(count) == stop:
                raise KeyboardInterrupt
            real(*file)

        with again.writing(), monkeypatch.context() as patch:
            patch.setattr(files, "replace_file", die)
            with pytest.raises(KeyboardInterrupt):
                again.end(4)
        assert not verify(store.path).sound
        with goes_on(store.path).writing():
            pass
        assert contents(store.path) == cut, stop


def test_a_store_in_memory_is_the_same(tmp_path: Path, store: Store) -> None:
    memory = create(None, LAYOUT)
    for block in (0, 2):
        for each in (memory, store):
            each.write(block, values(each.runs(block).start, len(each.runs(block))))
    assert memory.stored() == store.stored() == [0, 2]
    assert memory.dataset().load().identical(store.dataset().load())


def test_series_are_chunked_in_time_too(tmp_path: Path) -> None:
    """Bands read all runs at one instant."""
    long = [Variable("theta", "float64", "t", 10_000), Variable(STATUS, "uint8")]
    coordinates = {"t": Coordinate(np.arange(10_000.0))}
    store = create(tmp_path / "long.zarr", Layout(4096, 4096, long, coordinates))
    with xarray.open_zarr(store.path) as plain:
        assert plain.theta.encoding["chunks"] == (4096, 128)


def test_what_is_there_already_is_not_touched(store: Store, tmp_path: Path) -> None:
    with store.writing():
        pass
    with pytest.raises(InputError, match=r"exists already.*--resume"):
        create(store.path, LAYOUT)
    with pytest.raises(InputError, match=r"folder .* does not exist"):
        create(tmp_path / "no" / "runs.zarr", LAYOUT)


def test_an_interrupted_creation_leaves_no_store(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: Any, **__: Any) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(store_module, "write_file", full)
    with pytest.raises(OSError, match=r"cannot write .*new.zarr: No space left on device"):
        create(tmp_path / "new.zarr", LAYOUT)
    monkeypatch.undo()
    assert list(tmp_path.iterdir()) == []
    create(tmp_path / "new.zarr", LAYOUT)
    assert [path.name for path in tmp_path.iterdir()] == ["new.zarr"]


def test_what_is_no_batch_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no batch store"):
        open_store(tmp_path / "none.zarr")
    with pytest.raises(InputError, match="is not a batch store"):
        open_store(tmp_path)
    xarray.Dataset({"x": ("run", [1.0])}).to_zarr(tmp_path / "other.zarr", consolidated=False)
    with pytest.raises(InputError, match="is not a batch store"):
        open_store(tmp_path / "other.zarr")
