# SPDX-License-Identifier: Apache-2.0
"""A target that cannot be written is refused before the work, by every command that writes."""

from __future__ import annotations

import importlib
import os
from collections.abc import Mapping
from pathlib import Path
from typing import NoReturn

import pytest

from mehvar.base.errors import InputError
from mehvar.cli import app
from tests.fuzz.campaign import in_process
from tests.mehvar.test_effects import (
    BOARD,
    BUILD,
    EMIT,
    EVIDENCE,
    FMU,
    GROUPS,
    PENDULUM,
    REPORT,
    SIMULATE,
    parameters_of,
)

NOWHERE, BELOW_A_FILE = "no/such/{}", "file/{}"
LINES: Mapping[tuple[str, str], tuple[tuple[str, ...], str, str]] = {
    ("simulate", "out"): (SIMULATE, "a.nc", "mehvar.cli.simulate.simulate_run"),
    ("simulate", "plot"): (SIMULATE, "a.png", "mehvar.cli.simulate.simulate_run"),
    ("stats", "plot"): (("stats", "s.zarr"), "a.png", "mehvar.cli.store.stats.open_store"),
    ("diff", "out"): (("diff",), "a.html", "mehvar.cli.diff.diff_versions"),
    ("diff", "plot"): (("diff",), "a.png", "mehvar.cli.diff.diff_versions"),
    ("convert", "out"): (("convert", "r.nc", "--to", "csv"), "a.csv", "mehvar.formats.conversion.open_result"),
    ("generate", "out"): (("generate", "triangle"), "", "mehvar.codegen.generate.generate"),
    ("report", "out"): (("report", PENDULUM), "", "mehvar.cli.report._page"),
    ("reproduce", "out"): (("reproduce",), "", "mehvar.cli.reproduce._in_background"),
    ("board run", "journal"): (BOARD, "a", "mehvar.cli.board.run.outcome_of"),
    ("board build", "out"): (BUILD, "", "mehvar.cli.board.build.build_image"),
    ("board report", "out"): (REPORT[:-2], "", "mehvar.cli.board.report.outcome_of"),
    ("board evidence", "out"): (EVIDENCE[:-2], "", "mehvar.cli.board.evidence.collect"),
    ("board emit", "out"): (EMIT[:-2], "", "mehvar.cli.board.emit.program"),
    ("export fmu", "out"): (FMU[:-2], "a.fmu", "mehvar.fmu.export.load"),
    ("export web", "out"): (("export", "web", PENDULUM), "", "mehvar.web.export.cases_of"),
}
"""For each option that names an output: a line without it, a name of its kind, empty for a folder, and the work."""
ELSEWHERE = {("batch", "out"): "a store takes its place before its first run: tests/mehvar/cli/test_batch.py"}
ELSEWHERE[("require", "out")] = ELSEWHERE[("batch", "out")]
READ = {("board tune", "journal"), ("board replay", "journal")}
FILES = [row for row, (_, name, _) in LINES.items() if name and row != ("board run", "journal")]
"""Outputs whose ending gives the format."""


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "file").write_text("text")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def refused(row: tuple[str, str], target: str, monkeypatch: pytest.MonkeyPatch) -> str:
    """Return the message of a command whose work must not begin."""
    line, _, work = LINES[row]

    def began(*_: object, **__: object) -> NoReturn:
        pytest.fail("the work began")

    module, _, name = work.rpartition(".")
    monkeypatch.setattr(importlib.import_module(module), name, began)
    status, text = in_process(*line, f"--{row[1]}", target)
    assert status == 2, text
    return text


def test_every_option_that_names_an_output_has_its_line() -> None:
    outputs = {
        (command, name)
        for command in (*app.COMMANDS, *GROUPS)
        for name in parameters_of(command)
        if name in ("out", "plot", "journal")
    }
    assert outputs == {*LINES, *ELSEWHERE, *READ}


@pytest.mark.parametrize("row", LINES, ids=" ".join)
def test_a_place_that_cannot_be_is_refused_before_the_work(
    row: tuple[str, str], place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    name = LINES[row][1]
    for target in (BELOW_A_FILE.format(name), *([NOWHERE.format(name)] if name else [])):
        assert "must be" in refused(row, target, monkeypatch)
    assert [path.name for path in place.iterdir()] == ["file"]


THERE = {
    "generate": "manifest.json",
    "report": "index.html",
    "reproduce": "claims.json",
    "board build": "build.sh",
    "board report": "board.json",
    "board evidence": "evidence.md",
    "board emit": "README.md",
    "export web": "pendulum.html",
}
"""File that a command would replace in a folder, by the command's name."""


@pytest.mark.parametrize("row", [row for row, (_, name, _) in LINES.items() if not name], ids=" ".join)
def test_what_a_command_did_not_make_is_not_replaced(
    row: tuple[str, str], place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    own = place / "own" / THERE[row[0]]
    own.parent.mkdir()
    own.write_text(
        (Path(PENDULUM) / "manifest.json").read_text() if row[0] == "generate" else "something else", encoding="utf-8"
    )
    before = own.read_bytes()
    assert "must be another folder: this one has" in refused(row, "own", monkeypatch)
    assert own.read_bytes() == before


@pytest.mark.soak
def test_a_report_of_something_else_is_not_replaced_by_default(place: Path) -> None:
    (place / "report").mkdir()
    (place / "report" / "index.html").write_text("the papers'")
    status, text = in_process("report", PENDULUM)
    assert (status, text.splitlines()[-1]) == (0, f"report: {Path(PENDULUM).name}-report/index.html"), text
    assert (place / "report" / "index.html").read_text() == "the papers'"
    assert in_process("report", PENDULUM)[0] == 0
    status, text = in_process("report", "triangle", "--out", f"{Path(PENDULUM).name}-report")
    assert (status, f"which `mehvar report {PENDULUM}` made" in text) == (2, True), text


@pytest.mark.parametrize("row", FILES, ids=" ".join)
def test_an_ending_of_no_kind_is_refused_before_the_work(
    row: tuple[str, str], place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for target in ("a.docx", "a"):
        assert "a file name that ends in" in refused(row, target, monkeypatch)
    assert [path.name for path in place.iterdir()] == ["file"]


@pytest.mark.parametrize("ending", [".nc", ".csv", ".parquet", ".arrow", ".mat"])
def test_a_store_is_not_called_like_a_file_of_results(ending: str, place: Path) -> None:
    line = ("batch", PENDULUM, "--controller", "pd", "-n", "2", "--out", f"a{ending}")
    status, text = in_process(*line)
    assert (status, "must be the folder of a store" in text) == (2, True), text


@pytest.mark.parametrize(
    "line",
    [
        ("batch", PENDULUM, "--controller", "pd", "-n", "1_0"),
        ("batch", PENDULUM, "--controller", "pd", "-n", "2", "--seed", "1_0"),
        ("batch", PENDULUM, "--controller", "pd", "-n", "2", "--threads", "1_0"),
        ("batch", PENDULUM, "--controller", "pd", "-n", "2", "--out", "s.zarr", "--vary", "k_p=normal(1_6, 0.1)"),
        ("batch", PENDULUM, "--controller", "pd", "-n", "2", "--out", "s.zarr", "--vary", "k_p=normal(0x10, 0.1)"),
        ("batch", PENDULUM, "--controller", "pd", "-n", "2", "--out", "s.zarr", "--success", "peak < 1_0"),
        ("simulate", "--from", "s.zarr", "--run", "1_0"),
        ("simulate", PENDULUM, "--controller", "pd", "--t-end", "1_0"),
        ("simulate", PENDULUM, "--controller", "pd", "--set", "m=1_0"),
        (*BOARD[:-1], "1_0"),
        (*EVIDENCE[:-4], "--disturbed", "1_0"),
        ("board", "tune", "triangle", "--controller", "path", "--journal", "a", "--at", "1_0"),
    ],
    ids=lambda line: " ".join(line[-2:]),
)
def test_digits_that_only_python_reads_are_no_number(line: tuple[str, ...], place: Path) -> None:
    status, text = in_process(*line)
    assert status == 2, text
    assert "1_" in text or "0x10" in text
    assert not (place / "s.zarr").exists()


def fill(folder: Path) -> None:
    """Put into a folder what a command that cleans before it looks would remove."""
    for name in ("records/1.json", "lock/inside", "a.tune/inside", "__pycache__/a.pyc", ".s.zarr.0123.new/lock"):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text("mine")
    for name in ("download.partial", "records/2.json.partial", "index.html.tmp", "zarr.json.txt", "end.json"):
        (folder / name).write_text("mine")
    (folder / "latest").symlink_to("records")
    os.mkfifo(folder / "pipe")


def contents(folder: Path) -> dict[str, str]:
    """Return the content of a folder: files with their text, links with their targets, pipes and folders."""
    return {
        str(path.relative_to(folder)): str(path.readlink())
        if path.is_symlink()
        else path.read_bytes().hex()
        if path.is_file()
        else str(path.lstat().st_mode)
        for path in folder.rglob("*")
    }


@pytest.mark.parametrize("row", LINES, ids=" ".join)
def test_nothing_that_is_there_is_touched_by_a_command_that_fails(
    row: tuple[str, str], place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever stands in the place of an output, or beside it, is somebody's until the output is written."""
    line, name, work = LINES[row]
    fill(place)
    (place / name).write_text("mine") if name else None

    def fails(*_: object, **__: object) -> NoReturn:
        raise InputError("the work fails")

    module, _, function = work.rpartition(".")
    monkeypatch.setattr(importlib.import_module(module), function, fails)
    before = contents(place)
    status, text = in_process(*line, f"--{row[1]}", name or ".")
    assert status == 2, text
    assert contents(place) == before


@pytest.mark.parametrize("resume", [(), ("--resume",)], ids=["new", "resume"])
@pytest.mark.parametrize("kind", ["records alone", "a Zarr group", "a store of another batch", "a store of no batch"])
def test_a_folder_that_is_no_store_to_go_on_with_is_not_touched(
    kind: str, resume: tuple[str, ...], place: Path
) -> None:
    line = ("batch", PENDULUM, "--controller", "pd", "-n", "2", "--t-end", "0.1", "--out", "s.zarr")
    store = place / "s.zarr"
    if kind == "a store of another batch":
        assert in_process(*line)[0] == 0
        line = (*line[:5], "3", *line[6:])
    store.mkdir(exist_ok=True)
    fill(store)
    if kind == "a Zarr group":
        (store / "zarr.json").write_text('{"zarr_format": 3, "node_type": "group", "attributes": {}}')
    if kind == "a store of no batch":
        (store / "zarr.json").write_text('{"attributes": {"mehvar_batch": 2}}')
    before = contents(store)
    status, text = in_process(*line, *resume)
    assert status == 2, text
    assert contents(store) == before
