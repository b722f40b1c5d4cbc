# SPDX-License-Identifier: Apache-2.0
"""Each line of docs/known-limits.md says in a comment how one knows that it still is so."""

from __future__ import annotations

import json
import re
import shlex
from collections.abc import Callable
from datetime import date
from pathlib import Path

import numpy as np
import pytest
import xarray

import mehvar
from mehvar.base.errors import MehvarError
from mehvar.base.manifest import SHAPE_KINDS
from mehvar.cli.new import scaffold
from mehvar.runtime.model.model import load
from tests.fuzz.campaign import in_process

ROOT = Path(__file__).parents[2]
LINES = re.findall(r"^- .*\n(?:  .*\n)*", (ROOT / "docs" / "known-limits.md").read_text(encoding="utf-8"), re.MULTILINE)
HOW = re.compile(r"^  <!-- (test|try|not tried): (.+) -->\n", re.MULTILINE)
TRIED = [match[2] for line in LINES for match in HOW.finditer(line) if match[1] == "try"]


def cli(line: str) -> str:
    """Return the output of a command."""
    return in_process(*shlex.split(line))[1]


def refusal(call: Callable[[], object]) -> str:
    """Return why a call is refused, or nothing."""
    try:
        call()
    except MehvarError as error:
        return str(error)
    return ""


def page(name: str) -> str:
    """Return the text of a file of the checkout."""
    return (ROOT / name).read_text(encoding="utf-8")


def steps(method: str, k_phi: float) -> int:
    """Return the steps of the triangle's run under the path law at a tolerance of 1e-6."""
    run = mehvar.simulate("triangle", "path", method=method, rtol=1e-6, atol=1e-6, k_phi=k_phi)
    return int(json.loads(run.attrs["statistics"])["steps"])


def value(run: xarray.Dataset, name: str) -> float:
    """Return a parameter of a run."""
    return float(json.loads(run.attrs["parameters"])[name])


NAMES = {
    "cli": cli, "date": date, "load": load, "mehvar": mehvar, "np": np, "page": page, "refusal": refusal,
    "scaffold": scaffold, "steps": steps, "value": value, "Path": Path, "SHAPE_KINDS": SHAPE_KINDS,
}  # fmt: skip


@pytest.mark.parametrize("line", LINES, ids=lambda line: line[2:42])
def test_a_line_says_how_one_knows(line: str) -> None:
    ((how, what),) = HOW.findall(line)
    if how == "test":
        file, _, name = what.partition("::")
        assert f"def {name}" in page(file), what
    elif how == "try":
        compile(what, "known-limits.md", "eval")


@pytest.mark.soak
@pytest.mark.parametrize("expression", TRIED)
def test_a_line_still_is_so(expression: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert eval(expression, dict(NAMES))
