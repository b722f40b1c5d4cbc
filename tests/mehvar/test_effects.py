# SPDX-License-Identifier: Apache-2.0
"""No argument is ignored: each option of each verb and function changes what is done, or is refused by name.

The tables below are compared with the table of options, the commands and the signatures, so that a new option fails
until a line shows what it does.
"""

from __future__ import annotations

import functools
import importlib
import re
import warnings
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NoReturn

import pytest
import typer
import xarray

import mehvar
from mehvar import runtime
from mehvar.base.errors import InputError
from mehvar.cli import app
from mehvar.cli.board import evidence, flash, report
from mehvar.fmu import export
from mehvar.runtime.batch.fill import run_batch
from mehvar.runtime.batch.plan import Campaign
from mehvar.runtime.board.run import BoardRequest
from mehvar.runtime.run.options import OPTIONS
from tests.fuzz.campaign import in_process, snapshot

ROOT = Path(mehvar.__file__).parents[1]
GENERATED = str(ROOT / "generated" / "triangle")
PENDULUM = str(ROOT / "tests" / "runtime" / "pendulum")
SHORT: dict[str, Any] = {"t_end": 0.2, "dt_out": 0.02}
NOISY: dict[str, Any] = {"noise": 5e-5, "t_end": 20.0}

EFFECTS: Mapping[str, tuple[dict[str, Any], object]] = {
    "t_end": ({}, 0.1),
    "dt_out": ({}, 0.05),
    "hold": ({}, 0.1),
    "delay": ({"hold": 0.02}, 1),
    "seed": (NOISY, 1),
    "run": (NOISY, 1),
    "real": ({"hold": 0.02}, "float"),
    "method": ({}, "rk4"),
    "rtol": ({"atol": 1e-12}, 1e-3),
    "atol": ({"rtol": 1e-12}, 1e-2),
    "step": ({"method": "rk4"}, 0.001),
    "max_steps": ({"rtol": 1e-13}, 1),
    "backend": ({"backend": "c"}, "python"),
    "profile": ({}, "fast"),
}
"""For each option, the options it is given beside, and the value it is changed to."""
WITHOUT: Mapping[str, dict[str, Any]] = {
    "delay": {},
    "seed": {"hold": 0.02},
    "run": {},
    "real": {},
    "rtol": {"method": "rk4"},
    "atol": {"method": "rk4"},
    "step": {"method": "dopri5"},
}
"""Options beside which another has no effect, and is refused."""
SIMULATE = ("simulate", PENDULUM, "--controller", "pd", "--t-end", "0.1")
SAVED = (*SIMULATE, "--out", "a.csv")
BOARD = ("board", "run", "triangle", "--controller", "path", "--target", "sil", "--samples", "3")
BUILD = ("board", "build", "triangle", "--controller", "path", "--target", "sil")
REPORT = ("board", "report", *BOARD[2:], "--out", "a")
EMIT = ("board", "emit", "triangle", "--controller", "path", "--for", "cmake", "--out", "a")
TUNE = ("board", "tune", "triangle", "--controller", "path", "--journal", "a", "--set", "R=0.6")
REPLAY = ("board", "replay", "triangle", "--controller", "path", "--journal", "a")
EVIDENCE = ("board", "evidence", "triangle", "--controller", "path", "--samples", "3", "--disturbed", "2", "--out", "a")
FLASH = ("board", "flash", "triangle", "--controller", "path", "--dry-run")
BATCH = ("batch", PENDULUM, "--controller", "pd", "-n", "2", "--t-end", "0.1", "--vary", "k_p=normal(16, 0.1)")
REQUIRE = ("require", "done.zarr", "--that", "r=probability(peak < 99) > 0.5")
STORED = (*BATCH, "--out", "s.zarr")
OPEN = (*SIMULATE[:3], "none", *SIMULATE[4:], "--out", "a.csv")
CONVERT = ("convert", "done.zarr", "--to", "csv", "--out", "a.csv")
FMU = ("export", "fmu", PENDULUM, "--out", "a.fmu")
WEB = ("export", "web", str(PENDULUM), "--out", "pages")
REPEAT = ("simulate", "--from", "done.zarr", "--run", "0")
COMMANDS: Mapping[str, Mapping[str, object]] = {
    "list": {"as_json": (("list",), ("list", "--json"))},
    "doctor": {"as_json": (("doctor",), ("doctor", "--json"))},
    "show": {
        "model": (("show", PENDULUM), ("show", "triangle")),
        "as_json": (("show", PENDULUM), ("show", PENDULUM, "--json")),
    },
    "new": {
        "name": (("new", "numpy"), ("new", "math")),
        "plant": (("new", "mine", "--from", "none"), ("new", "mine", "--from", "nil")),
    },
    "simulate": {
        "model": (SIMULATE, ("simulate", "none", *SIMULATE[2:])),
        "controller": (SIMULATE, (*SIMULATE[:3], "p-sum", *SIMULATE[4:])),
        "scenario": (SIMULATE, (*SIMULATE, "--scenario", "stiff")),
        "settings": (SAVED, (*SAVED, "--set", "m=1.5")),
        "input_texts": (OPEN, (*OPEN, "--input", "torque=1")),
        "inputs": (OPEN, (*OPEN, "--inputs", "in.csv")),
        "interpolation": ((*OPEN, "--inputs", "in.csv"), (*OPEN, "--inputs", "in.csv", "--interpolation", "linear")),
        "t_end": (SAVED, (*SAVED[:5], "0.2", *SAVED[6:])),
        "out": (SIMULATE, (*SIMULATE, "--out", "a.csv")),
        "plot": (SIMULATE, (*SIMULATE, "--plot", "a.svg")),
        "store": (SIMULATE, (*SIMULATE, "--from", "s.zarr")),
        "run": (SIMULATE, (*SIMULATE, "--run", "0")),
        "trust_model": (REPEAT, (*REPEAT, "--trust-model")),
        "as_json": (SIMULATE, (*SIMULATE, "--json")),
    },
    "batch": {
        "model": (STORED, ("batch", "none", *STORED[2:])),
        "controller": (STORED, (*STORED[:3], "p-sum", *STORED[4:])),
        "n": (STORED, (*STORED[:5], "3", *STORED[6:])),
        "scenario": (STORED, (*STORED, "--scenario", "stiff")),
        "seed": (STORED, (*STORED, "--seed", "1")),
        "settings": (STORED, (*STORED, "--set", "m=1.1")),
        "vary": (STORED, (*STORED, "--vary", "rate=uniform(0, 1)")),
        "out": (STORED, (*BATCH, "--out", "other.zarr")),
        "save": (STORED, (*STORED, "--save", "every=0.05")),
        "resume": (STORED, (*STORED[:-1], "done.zarr", "--resume")),
        "until": (STORED, (*STORED, "--until", "ci(success) < 0.99")),
        "success": (STORED, (*STORED, "--success", "peak < 0")),
        "sampling": (STORED, (*STORED, "--sampling", "latin")),
        "t_end": (STORED, (*STORED[:7], "0.2", *STORED[8:])),
        "strict": ((*STORED, "--vary", "m=choice(1000, 1)"), (*STORED, "--vary", "m=choice(1000, 1)", "--strict")),
        "scheduler": (STORED, (*STORED, "--scheduler", "tls://127.0.0.1:9")),
        "threads": (STORED, (*STORED, "--threads", "0")),
    },
    "stats": {
        "path": (("stats", "done.zarr"), ("stats", "none.zarr")),
        "success": (("stats", "done.zarr"), ("stats", "done.zarr", "--success", "peak < 0")),
        "plot": (("stats", "done.zarr"), ("stats", "done.zarr", "--plot", "a.svg")),
        "of": (("stats", "done.zarr"), ("stats", "done.zarr", "--of", "peak")),
        "as_json": (("stats", "done.zarr"), ("stats", "done.zarr", "--json")),
    },
    "require": {
        "path": (REQUIRE, ("require", "none.zarr", *REQUIRE[2:])),
        "texts": (REQUIRE, (*REQUIRE[:3], "r=probability(peak < 0) > 0.5")),
        "confidence": (REQUIRE, (*REQUIRE, "--confidence", "0.6")),
        "out": (REQUIRE, (*REQUIRE, "--out", "other.zarr")),
        "resume": (REQUIRE, (*REQUIRE, "--resume")),
        "rare": (REQUIRE, (*REQUIRE, "--rare")),
        "page": (REQUIRE, (*REQUIRE, "--page", "a.html")),
        "as_json": (REQUIRE, (*REQUIRE, "--json")),
    },
    "verify": {
        "path": (("verify", "done.zarr"), ("verify", "none.zarr")),
        "as_json": (("verify", "done.zarr"), ("verify", "done.zarr", "--json")),
    },
    "generate": {
        "models": (("generate", "--check", "none"), ("generate", "--check", "nil")),
        "check": (("generate", "triangle"), ("generate", "triangle", "--check")),
        "structure": (("generate", "--check"), ("generate", "--check", "--structure", "a=b")),
        "out": (("generate", "--check"), ("generate", "--check", "--out", "a")),
        "emit": (("generate", "--check"), ("generate", "--check", "--emit", "casadi")),
    },
    "diff": {
        "old": (("diff", GENERATED, GENERATED), ("diff", "none", GENERATED)),
        "new": (("diff", GENERATED, GENERATED), ("diff", GENERATED, "none")),
        "model": "tests/mehvar/comparison/test_compare.py: --model",
        "paper": "tests/mehvar/comparison/test_compare.py: --paper",
        "form": (("diff", GENERATED, GENERATED), ("diff", GENERATED, GENERATED, "--format", "json")),
        "out": "tests/mehvar/comparison/test_compare.py: --out",
        "plot": (("diff", GENERATED, GENERATED), ("diff", GENERATED, GENERATED, "--plot", "a.bmp")),
        "structures": (("diff", GENERATED, GENERATED), ("diff", GENERATED, GENERATED, "--structures", "none")),
    },
    "convert": {
        "source": (CONVERT, (CONVERT[0], "none.zarr", *CONVERT[2:])),
        "to": (CONVERT, (*CONVERT[:3], "mat", *CONVERT[4:])),
        "out": (CONVERT, (*CONVERT[:-1], "b.csv")),
        "about": (CONVERT, (*CONVERT, "--about", "epoch=2026-01-01T00:00:00")),
    },
    "report": {
        "subject": (("report", "none"), ("report", "nil")),
        "out": (("report", PENDULUM, "--out", "file"), ("report", PENDULUM, "--out", "file/below")),
    },
    "reproduce": {"out": (("reproduce", "--out", "file"), ("reproduce", "--out", "file/below"))},
    "git-diff": {"arguments": (("git-diff", "a"), ("git-diff", "b"))},
    "git-textconv": {"file": (("git-textconv", "file"), ("git-textconv", "none"))},
    "board run": {
        **dict.fromkeys(("target", "samples", "form", "inline", "tunable"), "tests/mehvar/cli/test_board.py: {flag}"),
        "journal": (BOARD, (*BOARD, "--journal", "no/such/journal")),
        "restarts": (BOARD, (*BOARD, "--restarts", "0")),
        "raw": (BOARD, (*BOARD, "--raw")),
        "scenario": (BOARD, (*BOARD, "--scenario", "paper-b")),
        "model": (BOARD, (*BOARD[:2], "none", *BOARD[3:])),
        "controller": (BOARD, (*BOARD[:4], "none", *BOARD[5:])),
        "settings": (BOARD, (*BOARD, "--set", "R=0.6")),
        "board": "tests/mehvar/cli/test_board.py: --board",
        "compiler": "tests/runtime/board/test_equivalence.py: compiler=",
    },
    "board build": {
        "model": (BUILD, (*BUILD[:2], "none", *BUILD[3:])),
        "controller": (BUILD, (*BUILD[:4], "sliding", *BUILD[5:])),
        "board": (BUILD, (*BUILD, "--board", "stm32f4")),
        "compiler": (BUILD, (*BUILD, "--compiler", "tcc")),
        "scenario": (BUILD, (*BUILD, "--scenario", "paper-b")),
        "target": (BUILD, (*BUILD[:6], "unicorn")),
        "raw": (BUILD, (*BUILD, "--raw")),
        "inline": (BUILD, (*BUILD, "--inline-parameters")),
        "tunable": ((*BUILD, "--inline-parameters"), (*BUILD, "--inline-parameters", "--tunable", "R")),
        "out": (BUILD, (*BUILD, "--out", "a")),
    },
    "board report": {
        "model": (REPORT, (*REPORT[:2], "none", *REPORT[3:])),
        "controller": (REPORT, (*REPORT[:4], "sliding", *REPORT[5:])),
        "target": (REPORT, (*REPORT[:6], "nosuch", *REPORT[7:])),
        "samples": (REPORT, (*REPORT[:8], "4", *REPORT[9:])),
        "board": (REPORT, (*REPORT, "--board", "stm32f4")),
        "compiler": (REPORT, (*REPORT, "--compiler", "tcc")),
        "scenario": (REPORT, (*REPORT, "--scenario", "paper-b")),
        "settings": (REPORT, (*REPORT, "--set", "R=0.6")),
        "out": (REPORT, (*REPORT[:-1], "file")),
    },
    "board tune": {
        "model": (TUNE, (*TUNE[:2], "none", *TUNE[3:])),
        "controller": (TUNE, (*TUNE[:4], "none", *TUNE[5:])),
        "journal": (TUNE, (*TUNE[:6], "b", *TUNE[7:])),
        "settings": (TUNE, (*TUNE[:-1], "R=0.7")),
        "at": (TUNE, (*TUNE, "--at", "3")),
    },
    "board replay": {
        "model": (REPLAY, (*REPLAY[:2], "none", *REPLAY[3:])),
        "controller": (REPLAY, (*REPLAY[:4], "none", *REPLAY[5:])),
        "journal": (REPLAY, (*REPLAY[:-1], "b")),
    },
    "board evidence": {
        "model": (EVIDENCE, (*EVIDENCE[:2], "none", *EVIDENCE[3:])),
        "controller": (EVIDENCE, (*EVIDENCE[:4], "none", *EVIDENCE[5:])),
        "board": (EVIDENCE, (*EVIDENCE, "--board", "none")),
        "compiler": (EVIDENCE, (*EVIDENCE, "--compiler", "tcc")),
        "samples": (EVIDENCE, (*EVIDENCE[:6], "1", *EVIDENCE[7:])),
        "disturbed": "tests/runtime/board/test_evidence.py: disturbed=",
        "elf": (EVIDENCE, (*EVIDENCE, "--elf", "none.elf")),
        "linked": (EVIDENCE, (*EVIDENCE, "--map", "none.map")),
        "out": (EVIDENCE, (*EVIDENCE[:-1], "file")),
    },
    "board emit": {
        "model": (EMIT, (*EMIT[:2], "none", *EMIT[3:])),
        "controller": (EMIT, (*EMIT[:4], "sliding", *EMIT[5:])),
        "kind": (EMIT, (*EMIT[:6], "zephyr", *EMIT[7:])),
        "scenario": ((*EMIT, "--link"), (*EMIT, "--link", "--scenario", "paper-b")),
        "within": (EMIT, (*EMIT, "--range", "rho=0:1")),
        "link": (EMIT, (*EMIT, "--link")),
        "inline": ((*EMIT, "--link"), (*EMIT, "--link", "--inline-parameters")),
        "tunable": (
            (*EMIT, "--link", "--inline-parameters"),
            (*EMIT, "--link", "--inline-parameters", "--tunable", "k_phi"),
        ),
        "out": (EMIT, (*EMIT[:-1], "b")),
    },
    "board flash": {
        "model": (FLASH, (*FLASH[:2], "none", *FLASH[3:])),
        "controller": (FLASH, (*FLASH[:4], "sliding", *FLASH[5:])),
        "board": (FLASH, (*FLASH, "--board", "stm32f4-usart2")),
        "compiler": (FLASH, (*FLASH, "--compiler", "tcc")),
        "scenario": (FLASH, (*FLASH, "--scenario", "paper-b")),
        "inline": (FLASH, (*FLASH, "--inline-parameters")),
        "tunable": ((*FLASH, "--inline-parameters"), (*FLASH, "--inline-parameters", "--tunable", "R")),
        "dry_run": (FLASH, FLASH[:-1]),
    },
    "export fmu": {
        "model": (FMU, (*FMU[:2], "none", *FMU[3:])),
        "out": (FMU, (*FMU[:-1], "b.fmu")),
        "controller": (FMU, (*FMU, "--controller", "pd")),
        "scenario": (FMU, (*FMU, "--scenario", "stiff")),
        "fmi": (FMU, (*FMU, "--fmi", "3.0")),
        "kind": (FMU, (*FMU, "--kind", "me")),
    },
    "export web": {
        "model": (WEB, (*WEB[:2], "none", *WEB[3:])),
        "out": (WEB, (*WEB[:-1], "file")),
        "success": (WEB, (*WEB, "--success", "nothing < 1")),
    },
}
"""Of each parameter of a command: two lines that differ in it alone, or the file whose text shows what it does."""


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a finished store and a file, in which a command leaves what it is to leave."""
    folder: Path = tmp_path_factory.mktemp("effects")
    (folder / "file").write_text("text")
    (folder / "in.csv").write_text("t [s],torque [N m]\n0,0\n0.1,1\n")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        assert in_process(*BATCH, "--out", "done.zarr")[0] == 0
    return folder


def observed(dataset: xarray.Dataset) -> tuple[object, ...]:
    """Return all numbers of a run, and what computed them."""
    return (dataset.attrs.get("backend"), {name: array.values.tobytes() for name, array in dataset.variables.items()})


def single(**options: Any) -> xarray.Dataset:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        if "noise" in options:
            return mehvar.simulate("satellite", "pd", **options)
        return mehvar.simulate(PENDULUM, "pd", **{**SHORT, **options})


def batch(**options: Any) -> tuple[object, ...]:
    vary = {"k_p": "normal(16, 0.1)"}
    store = run_batch(PENDULUM, Campaign("pd", n=2, vary=vary, options={**SHORT, **options}))
    return (*observed(store.dataset().load()), store.attributes["profile"])


def test_every_option_has_its_line():
    assert EFFECTS.keys() == OPTIONS.keys()
    assert WITHOUT.keys() == {name for name, row in OPTIONS.items() if row.needs}


@pytest.mark.parametrize("name", [name for name, row in OPTIONS.items() if "run" not in row.refused])
def test_an_option_changes_a_run(name):
    beside, value = EFFECTS[name]
    assert observed(single(**beside)) != observed(single(**{**beside, name: value}))


@pytest.mark.parametrize("name", [name for name, row in OPTIONS.items() if "batch" not in row.refused])
@pytest.mark.share(2)
def test_an_option_changes_a_batch(name):
    beside, value = EFFECTS[name]
    assert batch(**beside) != batch(**{**beside, name: value})


@pytest.mark.parametrize("name", WITHOUT)
def test_an_option_without_effect_is_refused_in_python_on_the_command_line_and_in_toml(name, tmp_path):
    beside, value = WITHOUT[name], EFFECTS[name][1]
    default = OPTIONS[name].default
    refusal = rf"{name} = .*: must be left out unless {'the'}"
    for given in (value, *([] if default is None else [default])):
        with pytest.raises(mehvar.InputError, match=refusal):
            single(**beside, **{name: given})
        settings = [word for item in {**beside, name: given}.items() for word in ("--set", "{}={}".format(*item))]
        status, text = in_process(*SIMULATE, *settings)
        assert status == 2
        assert re.search(refusal, text)
        if "batch" in OPTIONS[name].refused:
            continue
        with pytest.raises(mehvar.InputError, match=refusal):
            mehvar.batch(PENDULUM, "pd", 2, **SHORT, **beside, **{name: given})
        lines = [f"{key} = {word!r}" for key, word in {**beside, name: given}.items()]
        file = tmp_path / "campaign.toml"
        file.write_text("\n".join([f"model = '{PENDULUM}'", "controller = 'pd'", "n = 2", "[set]", *lines]))
        with pytest.raises(mehvar.InputError, match=refusal):
            mehvar.batch(file)


def parameters_of(command: str) -> dict[str, Any]:
    place = app.PLACES.get(command, command).replace(" ", ".")
    module = importlib.import_module(f"mehvar.cli.{place.replace('-', '_')}")
    single_command = typer.Typer(add_completion=False)
    single_command.command()(module.command)
    return {p.name: p for p in typer.main.get_command(single_command).params}


def outcome(arguments: tuple[str, ...], place: Path) -> tuple[object, ...]:
    """Run a command; return status, text without times, and the new files with their contents; these are removed."""
    before = snapshot(place)
    status, text = in_process(*arguments)
    paths = sorted(snapshot(place).keys() - before.keys())
    new = {path: (place / path).read_bytes() for path in paths if (place / path).is_file()}
    for path in new:
        (place / path).unlink()
    for folder in sorted((p for p in place.rglob("*") if p.is_dir()), reverse=True):
        if not any(folder.iterdir()):
            folder.rmdir()
    return (
        status,
        re.sub(
            r"[\d.]+ ms|in [\d.e+-]+ s.*|, \d+ a second|\"run_seconds\": [^,]+|(ticks of a step|exchanges) .*", "", text
        ),
        new,
    )


@functools.cache  # many parameters are shown beside one line
def repeated(arguments: tuple[str, ...], place: Path) -> tuple[object, ...]:
    """Run a command twice, which must be the same."""
    first = outcome(arguments, place)
    assert first == outcome(arguments, place)
    return first


ROWS = [(command, name) for command, rows in COMMANDS.items() for name in rows]
BUILT = [("board flash", name) for name in ("board", "tunable", "inline", "scenario")]
"""Rows that build two images each, as those of `board build` do; soak has them."""


GROUPS = [f"{group} {name}" for group, names in (("export", app.EXPORT), ("board", app.BOARD)) for name in names]


@pytest.mark.parametrize("command", [*app.COMMANDS, *app.FOR_GIT, *GROUPS])
def test_every_parameter_of_a_command_has_its_line(command):
    assert COMMANDS[command].keys() == parameters_of(command).keys()


def _told(model: runtime.Model, request: BoardRequest) -> NoReturn:
    """Say what a report would be of: what it measures is never the same twice."""
    raise InputError(f"{model.name} {request}")


@pytest.mark.parametrize(
    ("command", "name"),
    [pytest.param(*row, marks=pytest.mark.soak if row in BUILT else ()) for row in ROWS],
    ids=lambda text: text,
)
def test_a_parameter_of_a_command_changes_what_is_done(command, name, place, monkeypatch, tmp_path):
    shown = COMMANDS[command][name]
    if isinstance(shown, str):
        path, text = shown.split(": ")
        flag = parameters_of(command)[name].opts[0]
        assert text.format(flag=flag) in (ROOT / path).read_text(encoding="utf-8")
        return
    monkeypatch.chdir(place)
    monkeypatch.setattr(report, "outcome_of", _told)
    monkeypatch.setattr(evidence, "findings", lambda _: Counter())  # MISRA's addon takes seconds: test_evidence.py
    monkeypatch.setattr(flash, "shutil", SimpleNamespace(which=lambda _: None))

    def text_of(_: str, sources: Mapping[str, str], *__: object) -> Path:
        (library := tmp_path / "library").write_text(repr(sorted(sources.items())), encoding="utf-8")
        return library

    monkeypatch.setattr(export, "compiled", text_of)  # tests/mehvar/fmu compiles units
    one, other = shown
    assert repeated(one, place) != outcome(other, place)


def test_interpolation_of_no_file_is_refused():
    status, text = in_process(*OPEN[:-2], "--interpolation", "linear")
    assert status == 2
    assert "--interpolation = 'linear': must be left out without --inputs" in text


def test_arguments_of_python_that_would_be_ignored_are_refused(tmp_path):
    calls: dict[str, Any] = {
        "resume": lambda: mehvar.batch(PENDULUM, "pd", 2, resume=True),
        "threads": lambda: run_batch(PENDULUM, Campaign("pd", 2), threads=1, client=type("C", (), {"submit": 1})()),
        "seed": lambda: mehvar.batch(PENDULUM, "pd", 2, seed=1),
        "sampling": lambda: mehvar.batch(PENDULUM, "pd", 2, sampling="latin"),
        "real": lambda: runtime.simulate("satellite", "pd", t_end=1.0, real="float", law=lambda x, r, v, z: (v, z)),
        "rtol": lambda: mehvar.simulate(PENDULUM, "pd", parameters={"rtol": 1e-6}),
        "t_end": lambda: mehvar.simulate(PENDULUM, "pd", t_end=True),
    }
    for name, call in calls.items():
        with pytest.raises(mehvar.InputError, match=rf"^{name} = "):
            call()
