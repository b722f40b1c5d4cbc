# SPDX-License-Identifier: Apache-2.0
"""`--json`: one object on standard output and nothing else there, with the fields of the reference."""

from __future__ import annotations

import json
import re
import subprocess
from pathlib import Path

import pytest

import mehvar
from tests import commands

REFERENCE = Path(__file__).parents[3] / "docs" / "reference" / "command-line.md"


def facts(*words: str) -> dict[str, object]:
    done = subprocess.run([*commands.mehvar(), *words, "--json"], capture_output=True, text=True, check=False)
    assert done.returncode in (0, 1), done.stderr
    result = json.loads(done.stdout, parse_constant=pytest.fail)
    assert isinstance(result, dict)
    return result


def documented(verb: str) -> set[str]:
    """Return the fields that the reference's table has for a command."""
    section = REFERENCE.read_text(encoding="utf-8").partition("## --json")[2]
    row = re.search(rf"^\| `{verb}` \| (.*) \|$", section, re.MULTILINE)
    assert row is not None
    return set(re.findall(r"`(\w+)`", re.split(r":| by name", row[1])[0]))


def test_list():
    result = facts("list")
    assert result.keys() == documented("list")
    assert {model["model"] for model in result["models"]} >= {"triangle", "slosh", "satellite"}


def test_show_is_the_manifest():
    manifest = json.loads((mehvar.load("triangle").manifest.folder / "manifest.json").read_text())
    assert facts("show", "triangle") == manifest


def test_simulate_and_stats(tmp_path):
    result = facts("simulate", "triangle", "--controller", "path", "--t-end", "1", "--out", str(tmp_path / "run.nc"))
    assert result.keys() == documented("simulate")
    assert result["status"] == "done"
    run = mehvar.open_result(tmp_path / "run.nc")
    for name, about in result["metrics"].items():
        assert float(about["value"]) == pytest.approx(float(run[name]), nan_ok=True)
    mehvar.batch("triangle", "path", 3, t_end=1.0, out=tmp_path / "runs.zarr")
    statistics = facts("stats", str(tmp_path / "runs.zarr"))
    assert statistics.keys() == documented("stats")
    assert statistics["stored"] == 3


def test_doctor():
    result = facts("doctor")
    assert result.keys() == documented("doctor")
    assert {"python", "numpy", "C compiler"} <= {part["part"] for part in result["parts"]}
