# SPDX-License-Identifier: Apache-2.0
"""Statements of the reference that no command of theirs shows."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

import mehvar
from mehvar.codegen.diff.report import EquationVerdict
from mehvar.runtime.batch.evaluation.conditions import Criterion
from mehvar.runtime.model.catalogue import shipped_models
from mehvar.runtime.model.model import load
from mehvar.runtime.run.formats import open_result, save
from tests.fuzz.campaign import in_process
from tests.mehvar.test_effects import BATCH

REFERENCE = Path(__file__).parents[2] / "docs" / "reference"


def text(page: str) -> str:
    """Return a page of the reference on one line."""
    return " ".join((REFERENCE / page).read_text(encoding="utf-8").split())


def names(row: str) -> set[str]:
    """Return the names between backticks."""
    return set(re.findall(r"`(\w+)`", row))


def test_the_attributes_of_a_result_are_those_of_the_page() -> None:
    table = (REFERENCE / "results.md").read_text(encoding="utf-8").split("## Attributes")[1].split("\n\n")[1]
    listed = set().union(*(names(row.split("|")[1]) for row in table.splitlines()[2:]))
    runs = [
        mehvar.simulate("triangle", "path", t_end=1.0),
        mehvar.simulate("triangle", "path", t_end=1.0, method="auto"),
    ]
    assert listed == set().union(*(run.attrs for run in runs)) | {"events"}


def test_backends_are_those_of_the_page() -> None:
    backends = {mehvar.load("triangle", backend=name).backend for name in ("c", "python", "casadi")}
    assert "`backend` | `c`, `python` or `casadi`" in text("results.md")
    assert backends == {"c", "python", "casadi"}


def test_a_changed_bit_of_any_part_of_a_result_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "run.nc"
    save(mehvar.simulate("triangle", "path", t_end=1.0), path)
    whole = path.read_bytes()
    for place in range(0, len(whole), len(whole) // 50):
        path.write_bytes(whole[:place] + bytes([whole[place] ^ 1]) + whole[place + 1 :])
        with pytest.raises(mehvar.InputError, match=r"is damaged|not a result file"):
            open_result(path)


def test_a_derivative_costs_what_the_page_says() -> None:
    match = re.search(
        r"such as `jvp` and `LAW_jvp`, costs ([\d.]+) to ([\d.]+) times the function", text("generated-c.md")
    )
    assert match is not None
    least, most = map(float, match.groups())
    for model in shipped_models():
        functions = load(model).manifest.functions
        for name in functions:
            base = "rhs" if name == "jvp" else name.removesuffix("_jvp")
            if base != name and base in functions:
                assert least <= functions[name].operations / functions[base].operations <= most


def test_verdicts_of_a_comparison_are_those_of_the_page() -> None:
    row = re.search(r"\| `verdict` \| ([^|]+)\|", text("diff-json.md"))
    assert row is not None
    assert names(row[1]) == {str(fate) for fate in EquationVerdict}


def test_keys_of_verify_are_those_of_the_page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert in_process(*BATCH, "--out", "s.zarr")[0] == 0
    status, printed = in_process("verify", "s.zarr", "--json")
    assert status == 0
    row = re.search(r"\| `verify` \| ([^|]+)\|", text("command-line.md"))
    assert row is not None
    assert set(json.loads(printed)) - {"store"} <= names(row[1])


@pytest.mark.parametrize("condition", ["a / 2 < 20", "a * 2 - b + 1 >= -3", "not abs(a) > 20 and b <= 1 or 0 < a < 3"])
def test_a_condition_takes_what_the_page_lists(condition: str) -> None:
    assert "sums, products and quotients of numbers" in text("batch-store.md")
    assert Criterion(condition, "success").names <= {"a", "b"}


@pytest.mark.parametrize(
    ("condition", "allowed"),
    [
        ("a ** 2 < 4", "a condition"),
        ("a % 2 < 1", "a condition"),
        ("a", "a condition"),
        ("a == 3", "a condition in which == and != compare only the status"),
    ],
)
def test_a_condition_takes_nothing_else(condition: str, allowed: str) -> None:
    with pytest.raises(mehvar.InputError, match=f"must be {allowed}"):
        Criterion(condition, "success")
