# SPDX-License-Identifier: Apache-2.0
"""The store of a batch: blocks whole or absent, plain Zarr for others, clear words when it cannot be written."""

from __future__ import annotations

import errno
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray
import zarr.storage._local

from mehvar.errors import InputError
from mehvar.runtime.batch.store import NOT_RUN, STATUS, Coordinate, Store, StoreError, Variable, create, open_store

VARIABLES = [
    Variable("m1", "float64", attributes={"units": "kg"}),
    Variable("final", "float64", "state", 2),
    Variable("theta", "float64", "t", 3),
    Variable(STATUS, "uint8"),
]
COORDINATES = {"state": Coordinate(["a", "b"]), "t": Coordinate(np.array([0.0, 0.5, 1.0]), {"units": "s"})}


def values(first: int, count: int) -> dict[str, np.ndarray]:
    runs = np.arange(first, first + count, dtype=np.float64)
    wide = runs[:, None]
    return {
        "m1": runs + 0.5,
        "final": np.concatenate([wide, -wide], axis=1),
        "theta": wide + np.array([0.0, 0.1, 0.2]),
        STATUS: (runs % 3).astype(np.uint8),
    }


@pytest.fixture
def store(tmp_path: Path) -> Store:
    return create(tmp_path / "runs.zarr", 10, 4, VARIABLES, COORDINATES, title="test", seed=3)


def test_plain_xarray_reads_names_units_and_values(store: Store) -> None:
    for block in range(3):
        store.write(block, values(store.runs(block).start, len(store.runs(block))))
    with xarray.open_zarr(store.path) as plain:
        assert dict(plain.sizes) == {"run": 10, "state": 2, "t": 3}
        assert plain.m1.attrs["units"] == "kg"
        assert plain.attrs["seed"] == 3
        assert np.array_equal(plain.final.sel(state="b"), -np.arange(10.0))
        assert np.array_equal(plain.theta.sel(t=1.0), np.arange(10.0) + 0.2)
        assert plain.status.dtype == np.uint8


def test_a_block_counts_when_its_status_is_there(store: Store) -> None:
    assert store.stored() == []
    store.write(1, values(4, 4))
    assert store.stored() == [1]
    assert np.array_equal(store.read("m1"), np.arange(4, 8) + 0.5)
    assert (store.dataset().status.values[:4] == NOT_RUN).all()
    assert open_store(store.path).stored() == [1]


def test_the_status_of_a_block_is_written_last(store: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    """At whichever write the process dies, the block does not count."""
    real, written = zarr.storage._local._put, []

    def put(path: Path, *rest: Any, **options: Any) -> int:
        written.append(path.relative_to(store.path))
        return real(path, *rest, **options)

    monkeypatch.setattr(zarr.storage._local, "_put", put)
    store.write(0, values(0, 4))
    assert written[-1].as_posix() == "status/c/0"
    assert len(written) == 4


@pytest.mark.parametrize("failing", range(4))
def test_a_full_disk_loses_no_block_and_repeats_none(
    store: Store, monkeypatch: pytest.MonkeyPatch, failing: int
) -> None:
    store.write(0, values(0, 4))
    real, count = zarr.storage._local._put, iter(range(100))

    def full(path: Path, *rest: Any, **options: Any) -> int:
        if next(count) == failing:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.with_suffix(".half.partial").write_bytes(b"half")
            raise OSError(errno.ENOSPC, "No space left on device")
        return real(path, *rest, **options)

    monkeypatch.setattr(zarr.storage._local, "_put", full)
    with pytest.raises(StoreError, match=r"cannot write .*runs.zarr: No space left on device"):
        store.write(1, values(4, 4))
    monkeypatch.undo()
    again = open_store(store.path)
    assert again.stored() == [0]
    with again.writing():
        assert not list(store.path.rglob("*.partial"))
        again.write(1, values(4, 4))
    assert np.array_equal(again.read("m1"), np.arange(8) + 0.5)


def test_two_processes_do_not_write_at_once(store: Store) -> None:
    other = open_store(store.path)
    with store.writing(), pytest.raises(InputError, match="another process is writing"), other.writing():
        pass
    with other.writing():
        pass


def test_a_store_cut_short_keeps_whole_blocks(store: Store) -> None:
    for block in range(3):
        store.write(block, values(store.runs(block).start, len(store.runs(block))))
    store.cut(4)
    assert store.n == open_store(store.path).n == 4
    with xarray.open_zarr(store.path) as plain:
        assert np.array_equal(plain.m1, np.arange(4) + 0.5)


def test_a_store_in_memory_is_the_same(tmp_path: Path, store: Store) -> None:
    memory = create(None, 10, 4, VARIABLES, COORDINATES, title="test", seed=3)
    for block in (0, 2):
        for each in (memory, store):
            each.write(block, values(each.runs(block).start, len(each.runs(block))))
    assert memory.stored() == store.stored() == [0, 2]
    assert memory.dataset().load().identical(store.dataset().load())


def test_series_are_chunked_in_time_too(tmp_path: Path) -> None:
    """Bands read all runs at one instant."""
    long = [Variable("theta", "float64", "t", 10_000), Variable(STATUS, "uint8")]
    coordinates = {"t": Coordinate(np.arange(10_000.0))}
    store = create(tmp_path / "long.zarr", 4096, 4096, long, coordinates)
    with xarray.open_zarr(store.path) as plain:
        assert plain.theta.encoding["chunks"] == (4096, 128)


def test_what_is_there_already_is_not_touched(store: Store, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"exists already.*--resume"):
        create(store.path, 10, 4, VARIABLES, COORDINATES)
    with pytest.raises(InputError, match=r"folder .* does not exist"):
        create(tmp_path / "no" / "runs.zarr", 10, 4, VARIABLES, COORDINATES)


def test_an_interrupted_creation_leaves_no_store(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: Any, **__: Any) -> int:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(zarr.storage._local, "_put", full)
    with pytest.raises(OSError, match=r"cannot write .*new.zarr: No space left on device"):
        create(tmp_path / "new.zarr", 10, 4, VARIABLES, COORDINATES)
    monkeypatch.undo()
    assert list(tmp_path.iterdir()) == []
    create(tmp_path / "new.zarr", 10, 4, VARIABLES, COORDINATES)
    assert [path.name for path in tmp_path.iterdir()] == ["new.zarr"]


def test_what_is_no_batch_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no batch store"):
        open_store(tmp_path / "none.zarr")
    with pytest.raises(InputError, match="is not a batch store"):
        open_store(tmp_path)
    xarray.Dataset({"x": ("run", [1.0])}).to_zarr(tmp_path / "other.zarr", consolidated=False)
    with pytest.raises(InputError, match="is not a batch store"):
        open_store(tmp_path / "other.zarr")
