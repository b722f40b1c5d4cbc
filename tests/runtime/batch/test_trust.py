# SPDX-License-Identifier: Apache-2.0
"""Reading data never executes it: a store that is a gift, with the traps that a giver can set."""

from __future__ import annotations

import ctypes
import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import mehvar
from mehvar.base.errors import InputError
from mehvar.runtime.batch.evaluation.statistics import summarise
from mehvar.runtime.batch.fill import run_batch
from mehvar.runtime.batch.numerics import generated_digest
from mehvar.runtime.batch.plan import Campaign
from mehvar.runtime.batch.repeat import TrustError, is_model_of, plan_of
from mehvar.runtime.batch.store.records import END, Record, read_record
from mehvar.runtime.batch.store.store import open_store
from mehvar.runtime.batch.store.verification import verify
from mehvar.runtime.compiling import compiler
from mehvar.runtime.model.catalogue import find_model, known_models
from tests.fuzz.campaign import in_process
from tests.runtime.batch.forgery import edit, seal

PENDULUM = Path(__file__).parents[1] / "pendulum"
CAMPAIGN = Campaign("pd", n=60, vary={"g": "uniform(-2, 9)"}, options={"t_end": 0.05})
TRIPWIRE = "__attribute__((constructor)) static void trip(void) { __builtin_trap(); }\n"


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a model of one's own and a store that was made from it."""
    place = tmp_path_factory.mktemp("made")
    shutil.copytree(PENDULUM, place / "model")
    text = (place / "model" / "pendulum.c").read_text()
    (place / "model" / "pendulum.c").write_text(text + "/* our own */\n")
    run_batch(place / "model", CAMPAIGN, place / "runs.zarr", chunk=30)
    return place


@pytest.fixture
def gift(made: Path, tmp_path: Path) -> Path:
    """The same with C that kills the process which loads it."""
    shutil.copytree(made, tmp_path / "gift")
    source = tmp_path / "gift" / "model" / "pendulum.c"
    source.write_text(source.read_text() + TRIPWIRE)
    point_to(tmp_path / "gift" / "runs.zarr", tmp_path / "gift" / "model")
    return tmp_path / "gift"


def point_to(store: Path, model: Path, **changes: Any) -> None:
    """Let a store name a model, and prove itself: records are no signatures."""
    edit(store / "zarr.json", lambda content: content["attributes"].update({"model_source": str(model), **changes}))
    seal(store)
    assert verify(store).complete


Command = Callable[..., tuple[int, str]]


@pytest.fixture
def command(monkeypatch: pytest.MonkeyPatch) -> Command:
    """A function that runs a command in a folder, and returns its status and what it says."""

    def run(*arguments: str, cwd: Path) -> tuple[int, str]:
        monkeypatch.chdir(cwd)
        return in_process(*arguments)

    return run


@pytest.mark.parametrize(
    "look",
    [
        lambda path: summarise(open_store(path)),
        lambda path: open_store(path).dataset().load(),
        lambda path: mehvar.verify(path),
    ],
)
def test_looking_at_a_store_compiles_nothing(
    gift: Path, monkeypatch: pytest.MonkeyPatch, look: Callable[[Path], object]
) -> None:
    monkeypatch.setattr(ctypes, "CDLL", lambda *_, **__: pytest.fail("a library was loaded"))
    monkeypatch.setattr(compiler, "_find", lambda *_: pytest.fail("a compiler was looked for"))
    look(gift / "runs.zarr")


def test_commands_that_look_need_no_compiler_and_no_model(
    gift: Path, command: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The store has the reason why runs were impossible."""
    shutil.rmtree(gift / "model")
    monkeypatch.setattr(compiler, "_find", lambda *_: pytest.fail("a compiler was looked for"))
    status, said = command("stats", "runs.zarr", "--plot", "a.png", cwd=gift)
    assert status == 0, said
    impossible = [line for line in said.splitlines() if "must be in [0, inf)" in line]
    assert len(impossible) == 3
    assert command("verify", "runs.zarr", cwd=gift)[0] == 0


def test_a_run_is_not_repeated_with_code_that_only_the_store_names(gift: Path, command: Command) -> None:
    """Its text hashes to whatever the giver has recorded: the hash is no reason to trust it."""
    digest = find_model(PENDULUM).hash
    attributes = open_store(gift / "runs.zarr").attributes
    assert attributes["model_hash"] == digest, "the manifest alone tells nothing"
    forged = {**json.loads(attributes["numerics"]), "generated": generated_digest(find_model(gift / "model"))}
    point_to(gift / "runs.zarr", gift / "model", numerics=json.dumps(forged))
    status, said = command("simulate", "--from", "runs.zarr", "--run", "1", cwd=gift)
    assert status == 2, "neither run nor killed by the trap"
    assert "add --trust-model" in said
    assert str(gift / "model") in said
    with pytest.raises(TrustError):
        plan_of(open_store(gift / "runs.zarr"))


def test_trust_is_for_the_text_that_made_the_store(gift: Path, command: Command) -> None:
    """Edited since, under an unchanged manifest."""
    status, said = command("simulate", "--from", "runs.zarr", "--run", "1", "--trust-model", cwd=gift)
    assert status == 2
    assert "was made from another version" in said


def test_a_model_of_ones_own_is_named_or_trusted(made: Path, command: Command) -> None:
    for arguments in (("model",), ()):
        trust = () if arguments else ("--trust-model",)
        status, said = command("simulate", *arguments, "--from", "runs.zarr", "--run", "1", *trust, cwd=made)
        assert status == 0, said
        assert "the same as in the store, bit for bit" in said
        assert "note:" not in said
    _, said = command("simulate", str(PENDULUM), "--from", "runs.zarr", "--run", "1", cwd=made)
    assert "note: runs.zarr was made from another version of the model pendulum" in said
    assert not is_model_of(open_store(made / "runs.zarr"), mehvar.load(PENDULUM))


def test_a_store_finds_the_model_of_its_project(made: Path, tmp_path: Path, command: Command) -> None:
    """Moved: the folder that the store names is gone; the project that one stands in has the same text, or another."""
    again = ("simulate", "--from", "runs.zarr", "--run", "1")
    project = tmp_path / "project"
    shutil.copytree(made, project)
    point_to(project / "runs.zarr", project / "gone")
    for trust in ((), ("--trust-model",)):
        status, said = command(*again, *trust, cwd=project)
        assert status == 2
        assert "does not exist here. Name a generated folder" in said
    (project / "generated").mkdir()
    (project / "model").rename(project / "generated" / "pendulum")
    (project / "models" / "pendulum").mkdir(parents=True)
    (project / "models" / "pendulum" / "parameters.toml").touch()
    status, said = command(*again, cwd=project)
    assert status == 0, said
    assert "the same as in the store, bit for bit" in said
    source = project / "generated" / "pendulum" / "pendulum.c"
    source.write_text(source.read_text() + TRIPWIRE)
    status, said = command(*again, cwd=project)
    assert status == 2, "another text is neither run nor loaded"
    assert "neither installed nor in this project" in said
    (source.parent / "manifest.json").write_text("{")
    point_to(project / "runs.zarr", shutil.copytree(made / "model", project / "elsewhere"))
    status, said = command(*again, "--trust-model", cwd=project)
    assert status == 0, f"a damaged model of the project is not the one that is trusted: {said}"


def test_an_installed_model_is_taken_when_its_text_made_the_store(tmp_path: Path) -> None:
    run_batch("triangle", Campaign("path", n=4, options={"t_end": 0.05}), tmp_path / "runs.zarr")
    point_to(tmp_path / "runs.zarr", tmp_path / "elsewhere")
    assert plan_of(open_store(tmp_path / "runs.zarr")).model.manifest.folder == known_models()["triangle"]


@pytest.mark.parametrize("codec", ["numcodecs.pickle", "pickle", "numcodecs.zlib"])
def test_a_chunk_is_not_decoded_by_code_that_the_store_names(gift: Path, codec: str) -> None:
    store = gift / "runs.zarr"
    coded = [{"name": codec, "configuration": {}}]
    edit(store / "g" / "zarr.json", lambda content: content.update(codecs=coded))
    edit(store / "zarr.json", lambda content: content["consolidated_metadata"]["metadata"]["g"].update(codecs=coded))
    seal(store)
    with pytest.raises(InputError, match="is not a batch store"):
        open_store(store)


def test_arrays_of_the_old_format_which_may_hold_pickles_are_not_read(gift: Path) -> None:
    """Zarr's format 2 has objects that are unpickled."""
    store = gift / "runs.zarr"
    for file in store.rglob("zarr.json"):
        file.unlink()
    (store / ".zgroup").write_text('{"zarr_format": 2}')
    (store / ".zattrs").write_text('{"mehvar_batch": 2, "variables": ["status"]}')
    with pytest.raises(InputError):
        open_store(store)


@pytest.mark.parametrize("place", ["../outside", "/etc/passwd", "a/../../outside"])
def test_a_record_points_to_nothing_outside_its_store(gift: Path, place: str) -> None:
    store = gift / "runs.zarr"
    record = read_record(store / END)
    assert record is not None
    (store / END).write_bytes(Record(record.about, {**record.digests, place: "0"}).content())
    assert read_record(store / END) is None
    assert not verify(store).complete
