# SPDX-License-Identifier: Apache-2.0
"""Whatever reads a store asks each record whose it is, and says so while somebody is writing."""

from __future__ import annotations

import json
import shutil
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import pytest

import mehvar
from mehvar.base.errors import InputError, MehvarError
from mehvar.cli import app
from mehvar.runtime.batch.evaluation.statistics import summarise
from mehvar.runtime.batch.fill import run_batch
from mehvar.runtime.batch.plan import Campaign
from mehvar.runtime.batch.store import files
from mehvar.runtime.batch.store.lock import FILE, Lock, is_abandoned, lock_owner
from mehvar.runtime.batch.store.records import END, DamageError
from mehvar.runtime.batch.store.store import open_store
from mehvar.runtime.batch.store.verification import verify
from tests.fuzz.campaign import in_process
from tests.mehvar.test_effects import parameters_of
from tests.runtime.batch.forgery import CAMPAIGN, CHUNK, PENDULUM, contents, flip, mend

COMMANDS = {
    "verify": [("verify", "{}")],
    "stats": [("stats", "{}"), ("stats", "{}", "--json"), ("stats", "{}", "--plot", "a.png")],
    "require": [("require", "{}", "--that", "r=quantile(0.5, t_stop) < 9")],
    "convert": [("convert", "{}", "--to", to, "--out", f"a.{to}") for to in ("csv", "parquet", "mat")]
    + [("convert", "{}", "--to", "netcdf", "--out", "a.nc")],
    "report": [("report", "{}")],
    "simulate": [("simulate", str(PENDULUM), "--from", "{}", "--run", "17")],
}
"""Lines of each command that reads a store; they read block 1."""
LINES = [line for lines in COMMANDS.values() for line in lines]
PYTHON: dict[str, Callable[[Path], object]] = {
    "stored": lambda path: open_store(path).stored(),
    "read": lambda path: open_store(path).read("status"),
    "about": lambda path: open_store(path).about(1),
    "dataset": lambda path: open_store(path).dataset().load(),
    "summarise": lambda path: summarise(open_store(path)),
}


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> dict[int, Path]:
    """A batch of two seeds."""
    folder = tmp_path_factory.mktemp("whole")
    for seed in (0, 1):
        run_batch(PENDULUM, replace(CAMPAIGN, seed=seed), folder / f"{seed}.zarr", chunk=CHUNK)
    return {seed: folder / f"{seed}.zarr" for seed in (0, 1)}


def copied(source: Path, block: int, store: Path, place: int) -> None:
    """Copy record and chunks of a block into the place of another one."""
    for name in contents(source):
        parts = name.split("/")
        if name == f"records/{block}.json":
            shutil.copy(source / name, store / f"records/{place}.json")
        elif parts[1:3] == ["c", str(block)] and parts[0] not in ("state", "variable", "t"):
            target = store.joinpath(parts[0], "c", str(place), *parts[3:])
            shutil.copy(source / name, target)


@pytest.fixture(params=["ended", "unfinished"])
def store(
    request: pytest.FixtureRequest, whole: dict[int, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Path:
    monkeypatch.chdir(tmp_path)
    shutil.copytree(whole[0], tmp_path / "runs.zarr")
    if request.param == "unfinished":
        (tmp_path / "runs.zarr" / END).unlink()
    return tmp_path / "runs.zarr"


def test_every_command_that_reads_a_store_has_its_lines() -> None:
    """Commands with such arguments; `batch` writes a store."""
    words = {
        command
        for command in app.COMMANDS
        for parameter in parameters_of(command).values()
        if "batch" in (parameter.help or "").lower() and "STORE" in f"{parameter.metavar}MODEL_OR_FILE".upper()
    }
    assert words - {"batch"} <= {*COMMANDS} | {"simulate"}
    assert {*COMMANDS} <= {*app.COMMANDS}


@pytest.mark.parametrize(("seed", "block", "what"), [(1, 1, "of another batch"), (0, 0, "of another block")])
@pytest.mark.share(4)
def test_a_block_that_belongs_elsewhere_is_refused_by_every_reader(
    store: Path, whole: dict[int, Path], seed: int, block: int, what: str
) -> None:
    """Its digests are right; only its record says whose it is."""
    copied(whole[seed], block, store, 1)
    assert [damage.block for damage in mehvar.verify(store).damaged] == [1]
    for line in LINES:
        status, said = in_process(*(word.format(store) for word in line))
        assert status in (1, 2), line
        assert f"records/1.json is {what}" in said, (line, said)
    for name, look in PYTHON.items():
        with pytest.raises(DamageError) as refused:
            look(store)
        assert "block 1 (runs 16 to 31): " * (name != "summarise") in str(refused.value)
        assert f"records/1.json is {what}" in str(refused.value)
    assert [path.name for path in store.parent.iterdir()] == ["runs.zarr"], "nothing was written"
    mend(store)
    assert contents(store) == contents(whole[0])


def test_an_end_of_another_batch_is_refused_and_mended(store: Path, whole: dict[int, Path]) -> None:
    shutil.copy(whole[1] / END, store / END)
    assert verify(store).files == {END: "of another batch"}
    with pytest.raises(DamageError, match=r"end\.json is of another batch"):
        summarise(open_store(store))
    mend(store)
    assert contents(store) == contents(whole[0])


def test_a_block_that_is_gone_after_the_end_is_told_by_every_reader(store: Path) -> None:
    """Before the end it may not have been computed yet."""
    ended = (store / END).exists()
    (store / "records/1.json").unlink()
    for name, look in PYTHON.items():
        if ended:
            with pytest.raises(DamageError, match=r"records/1.json is missing"):
                look(store)
        elif name != "about":
            look(store)


@contextmanager
def written(store: Path) -> Iterator[None]:
    """Have somebody write the store."""
    lock = Lock(store, "it")
    try:
        yield
    finally:
        lock.release()


def test_what_is_not_whole_while_somebody_writes_is_not_called_damaged(
    store: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("mehvar.runtime.batch.store.verification._LOOK", 0.001)
    flip(store / "status" / "c" / "1")
    with written(store):
        verification = verify(store)
        assert verification.whole == (0, 2)
        assert verification.writer
        status, said = in_process("verify", str(store))
        assert status == 1
        assert "being written: block 1" in said
        assert "being written by process" in said
        assert "damaged" not in said
        assert "--resume" not in said
        status, said = in_process("stats", str(store))
        assert status == 0
        assert "24 of 40 runs" in said
        assert "being written by process" in said
        assert json.loads(in_process("stats", str(store), "--json")[1])["writer"]
    status, said = in_process("verify", str(store))
    assert "damaged: block 1" in said
    assert in_process("stats", str(store))[0] == 2


def test_metadata_that_are_being_rewritten_are_waited_for(store: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The end of a batch that is cut short does so; what lasts longer is said to be written."""
    content = (store / "zarr.json").read_bytes()
    (store / "zarr.json").write_bytes(b"")
    with written(store):
        threading.Timer(0.3, (store / "zarr.json").write_bytes, [content]).start()
        assert open_store(store).n == 40
        (store / "zarr.json").write_bytes(b"")
        monkeypatch.setattr("mehvar.runtime.batch.store.verification._LOOK", 0.0)
        with pytest.raises(InputError, match=r"being written by process .*: its metadata are incomplete") as refused:
            open_store(store)
        assert not isinstance(refused.value, DamageError)
    with pytest.raises(DamageError, match="is damaged"):
        open_store(store)


def test_no_look_at_a_batch_that_is_written_says_damaged(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """From its first file to its end, which cuts it short: looks between any two steps of the writer."""
    out = tmp_path / "runs.zarr"
    looks: list[str] = []

    def look(*_: object) -> None:
        for read in (verify, lambda path: summarise(open_store(path))):
            try:
                verification = read(out)
                sound = getattr(verification, "sound", True) or verification.writer
                looks.append("" if sound else verification.summary())
            except MehvarError as error:
                looks.append(str(error) if "damaged" in str(error) else "")

    def between(function: Callable[..., object]) -> Callable[..., object]:
        def looked(*arguments: object, **more: object) -> object:
            if out.exists():
                thread = threading.Thread(target=look)
                thread.start()
                thread.join()
            return function(*arguments, **more)

        return looked

    monkeypatch.setattr("mehvar.runtime.batch.store.verification._LOOK", 0.0)
    for name in ("force_files", "write_record", "remove_beyond"):
        monkeypatch.setattr(files, name, between(getattr(files, name)))
    campaign = Campaign("pd", n=80, vary={"g": "uniform(1, 9)"}, options={"t_end": 0.05})
    assert run_batch(PENDULUM, campaign, out, chunk=8, until="ci(success) < 0.3").n < 80
    assert len(looks) > 12
    assert {*looks} == {""}


@pytest.mark.share(2)
def test_who_looks_keeps_nobody_from_writing(store: Path) -> None:
    """Nor from looking: a look locks a file that a killed process left."""
    (store / FILE).write_text("process 1 on nowhere\n")
    stop = threading.Event()
    threads = [threading.Thread(target=lambda: [lock_owner(store) for _ in iter(stop.is_set, True)]) for _ in range(4)]
    for thread in threads:
        thread.start()
    try:
        for _ in range(60):
            with written(store):
                pass
            (store / FILE).write_text("process 1 on nowhere\n")
    finally:
        stop.set()
        for thread in threads:
            thread.join()
    assert lock_owner(store) is None


def test_what_is_being_made_is_not_abandoned(tmp_path: Path) -> None:
    assert not is_abandoned(tmp_path)
    (tmp_path / FILE).touch()
    assert not is_abandoned(tmp_path), "its process has not locked it yet"
    lock = Lock(tmp_path, "it")
    assert not is_abandoned(tmp_path)
    lock.release()
    (tmp_path / FILE).write_text("process 1 on nowhere\n")
    assert is_abandoned(tmp_path)
