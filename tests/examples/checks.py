# SPDX-License-Identifier: Apache-2.0
"""Checks of every example: backends, repeated runs of a batch, a diff of an edit, the board."""

from __future__ import annotations

import shutil
import subprocess
import zlib
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

import mehvar
from mehvar.codegen.diff import compare
from mehvar.codegen.equations.document import Document
from mehvar.codegen.generate import system_of as derived
from mehvar.codegen.workspace import Tree
from mehvar.models.system import System
from mehvar.runtime import load
from mehvar.runtime.batch.repeat import difference, plan_of, repeat_run
from mehvar.runtime.batch.store.store import open_store
from mehvar.runtime.board.run import BoardRequest, run_on_board
from tests import commands
from tests.examples.pages import generated
from tests.reference.scipy_loop import by_scipy


def system_of(folder: Path) -> System:
    """Return the system that a generated folder of a project was written from."""
    return derived(Tree(folder.parents[1]), folder.name, {})


def backends_agree(folder: Path, law: str, state: str, tolerance: float, **options: object) -> None:
    """Run by the native loop and by SciPy."""
    compiled = mehvar.simulate(folder, law, **options)
    with by_scipy():
        plain = mehvar.simulate(folder, law, **options)
    np.testing.assert_allclose(compiled[state], plain[state], atol=tolerance)


def runs_repeat(folder: Path, laws: Sequence[str], vary: Mapping[str, str], out: Path, **options: object) -> None:
    """Check that runs of a batch are bit-identical to single runs."""
    for law in laws:
        mehvar.batch(folder, law, n=9, seed=1, vary=dict(vary), out=out / f"{law}.zarr", **options)
        store = open_store(out / f"{law}.zarr")
        plan = plan_of(store, folder)
        assert {difference(repeat_run(plan, store, k), plan, store, k) for k in range(9)} == {""}


def diff_tells(folder: Path, old: str, new: str, name: str) -> None:
    """Check that `mehvar diff` shows an edit of a model at the edited entry of the mass matrix."""
    edited = generated(folder.name, _edited(folder, old, new))
    sides = (Document.parse((f / "equations.json").read_text(), load(f, "python").manifest) for f in (folder, edited))
    assert name in {row.name for row in compare(*sides).sources}


def command_shows(folder: Path, old: str, new: str, *rows: str) -> None:
    """Check the rows that `mehvar diff` prints for an edit of a model."""
    shown = subprocess.run(
        [*commands.mehvar(), "diff", str(folder), "work"],
        cwd=_edited(folder, old, new), capture_output=True, text=True,
    )  # fmt: skip
    assert shown.returncode == 1, shown.stdout + shown.stderr
    for row in rows:
        assert row in shown.stdout


def _edited(folder: Path, old: str, new: str) -> Path:
    """Copy the project of a generated folder, with an edit of the model's text."""
    project = folder.parents[1]
    other = project.with_name(f"{project.name}-{zlib.crc32(new.encode())}")
    shutil.copytree(project / "models", other / "models")
    (other / "generated").mkdir()
    text = other / "models" / folder.name / "__init__.py"
    source = text.read_text(encoding="utf-8")
    assert source.count(old) == 1
    text.write_text(source.replace(old, new), encoding="utf-8")
    return other


def board_agrees(folder: Path, law: str) -> None:
    """Check that the firmware's law and self-test on this machine are bit-identical to the host's."""
    assert run_on_board(load(folder, backend="c"), BoardRequest(law, "sil", samples=50)).max_ulp == 0
