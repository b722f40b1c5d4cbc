# SPDX-License-Identifier: Apache-2.0
"""A small model in a git repository, derived by the tests."""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import subprocess
from pathlib import Path

import pytest
from typer.testing import CliRunner

import mehvar
from mehvar.base.errors import InputError
from mehvar.cli.app import app
from mehvar.codegen.workspace import ROOMS
from mehvar.comparison.result import ModelDiff
from tests import commands

ROOT = Path(__file__).parents[3]
CART = Path(__file__).parents[1] / "cart"
SIGN = ("-p.k * x - p.d * v", "-p.k * x + p.d * v")
"""An edit that turns the sign of the damper."""


class Project:
    """A tree with models/ and generated/ in a git repository."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.source = root / "models" / "cart" / "__init__.py"

    def diff(self, *arguments: str) -> tuple[int, str]:
        """Call the command in this process; return its exit status and output, or raise what it raises."""
        with contextlib.chdir(self.root):
            process = CliRunner().invoke(app, ["diff", *arguments], catch_exceptions=False)
        return process.exit_code, process.output

    def compared(self) -> ModelDiff:
        """Compare the cart in this process."""
        with contextlib.chdir(self.root):
            return mehvar.diff("cart")

    def mehvar(self, *arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
        """Call the command as a process."""
        return subprocess.run(
            [*commands.mehvar(), *arguments],
            capture_output=True,
            text=True,
            cwd=self.root,
            env={**os.environ, "PYTHONPATH": str(ROOT), **environment},
            timeout=120,
        )

    def git(self, *arguments: str, **environment: str) -> str:
        identity = ("-c", "user.name=Test", "-c", "user.email=test@example.org")
        process = subprocess.run(
            ["git", *identity, *arguments],
            capture_output=True,
            text=True,
            cwd=self.root,
            env={**os.environ, "PYTHONPATH": str(ROOT), **environment},
            timeout=120,
        )
        assert process.returncode == 0, process.stdout + process.stderr
        return process.stdout

    def commit(self, message: str) -> None:
        self.git("add", "--all")
        self.git("commit", "--quiet", "--message", message)

    def edit(self, old: str, new: str, file: str = "models/cart/__init__.py") -> None:
        path = self.root / file
        text = path.read_text()
        assert old in text
        path.write_text(text.replace(old, new))

    def generate(self) -> None:
        process = self.mehvar("generate")
        assert process.returncode == 0, process.stderr

    def json(self, *arguments: str, status: int) -> dict:
        """Return the comparison of the cart as JSON."""
        code, text = self.diff(*arguments, "--format", "json")
        assert code == status, text
        (model,) = json.loads(text)["models"]
        return model

    def refused(self, *arguments: str) -> str:
        with pytest.raises(InputError) as error:
            self.diff(*arguments)
        return str(error.value)


def made(root: Path) -> Project:
    """Write the cart into a folder, generate and commit it."""
    project = Project(root)
    (project.root / "models").mkdir()
    for path in (ROOT / "models").glob("*.py"):
        shutil.copy(path, project.root / "models")
    for room in ROOMS:
        shutil.copytree(ROOT / "models" / room, project.root / "models" / room, ignore=shutil.ignore_patterns("__py*"))
    shutil.copytree(CART, project.root / "models" / "cart", ignore=shutil.ignore_patterns("__pycache__", "ledger.py"))
    (project.root / "generated").mkdir()
    (project.root / ".gitignore").write_text("__pycache__/\n")
    project.generate()
    project.git("init", "--quiet", "--initial-branch", "main")
    project.commit("a cart")
    return project
