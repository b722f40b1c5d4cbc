# SPDX-License-Identifier: Apache-2.0
"""What cannot be written is refused before the work, by every command that writes."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from pathlib import Path
from typing import NoReturn

import pytest

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
    ("stats", "plot"): (("stats", "s.zarr"), "a.png", "mehvar.cli.stats.open_store"),
    ("diff", "out"): (("diff",), "a.html", "mehvar.cli.diff.diff_versions"),
    ("diff", "plot"): (("diff",), "a.png", "mehvar.cli.diff.diff_versions"),
    ("convert", "out"): (("convert", "r.nc", "--to", "csv"), "a.csv", "mehvar.formats.conversion.open_result"),
    ("generate", "out"): (("generate", "triangle"), "", "mehvar.codegen.generate.generate"),
    ("report", "out"): (("report", PENDULUM), "", "mehvar.cli.report._page"),
    ("reproduce", "out"): (("reproduce",), "", "mehvar.cli.reproduce.judged"),
    ("board run", "journal"): (BOARD, "a", "mehvar.cli.board.run.outcome_of"),
    ("board build", "out"): (BUILD, "", "mehvar.cli.board.build.build_image"),
    ("board report", "out"): (REPORT[:-2], "", "mehvar.cli.board.report.outcome_of"),
    ("board evidence", "out"): (EVIDENCE[:-2], "", "mehvar.cli.board.evidence.collect"),
    ("board emit", "out"): (EMIT[:-2], "", "mehvar.cli.board.emit.program"),
    ("export fmu", "out"): (FMU[:-2], "a.fmu", "mehvar.fmu.export.load"),
    ("export web", "out"): (("export", "web", PENDULUM), "", "mehvar.web.export.cases_of"),
}
"""Of each option that names an output: a line without it, a name of its kind, empty for a folder, and the work."""
ELSEWHERE = {("batch", "out"): "a store takes its place before its first run: tests/mehvar/cli/test_batch.py"}
READ = {("board tune", "journal"), ("board replay", "journal")}
FILES = [row for row, (_, name, _) in LINES.items() if name and row != ("board run", "journal")]
"""Those whose ending says what they are."""


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
"""What a command would replace in a folder, by its name."""


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


@pytest.mark.parametrize("ending", [".nc", ".csv", ".parquet", ".mat"])
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
