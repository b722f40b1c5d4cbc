# SPDX-License-Identifier: Apache-2.0
"""Python of the pages passes a type checker."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from .test_docs import PAGES, ROOT, blocks, said

NOT_OURS = ("arg-type", "operator", "assignment", "no-redef", "call-overload", "list-item", "call-arg", "union-attr")
"""Pages are scripts: they give a name anew, or options out of a dictionary; defaults may be formulas; others' stubs."""


def script(page: Path) -> str:
    """Return the Python of a page, each line where it stands there."""
    lines: list[str] = []
    for block in blocks(page.read_text(encoding="utf-8")):
        if block.language == "python" and not said(block, "not run") and not said(block, "file"):
            lines += [""] * (block.start - len(lines))
            lines += block.lines
    return "\n".join([*lines, ""])


@pytest.fixture(scope="module")
def farm(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the package alone."""
    folder = tmp_path_factory.mktemp("farm")
    (folder / "mehvar").symlink_to(ROOT / "mehvar")
    return folder


def errors(farm: Path, scripts: dict[str, str]) -> list[str]:
    """Return the complaints of mypy about scripts, by their names."""
    for name, text in scripts.items():
        (farm / f"{name}.py").write_text(text, encoding="utf-8")
    flags = ["--config-file=", "--ignore-missing-imports", "--check-untyped-defs", "--follow-imports=silent"]
    flags += [f"--disable-error-code={code}" for code in NOT_OURS]
    command = [sys.executable, "-m", "mypy", *flags, "--scripts-are-modules", *(f"{name}.py" for name in scripts)]
    done = subprocess.run(command, cwd=farm, capture_output=True, text=True, check=False)
    assert done.returncode in (0, 1), done.stdout + done.stderr
    return [line for line in done.stdout.splitlines() if ": error: " in line]


@pytest.mark.soak
def test_the_python_of_the_pages_passes_a_type_checker(farm: Path) -> None:
    scripts = {re.sub(r"\W", "_", str(page.relative_to(ROOT))): script(page) for page in PAGES}
    scripts = {name: text for name, text in scripts.items() if text.strip()}
    assert len(scripts) > 30
    wrong = "import mehvar\nx, u, residual = mehvar.simulate\n"  # the checker checks
    found = errors(farm, {**scripts, "wrong": wrong})
    assert len([line for line in found if line.startswith("wrong.py")]) == 1
    assert [line for line in found if not line.startswith("wrong.py")] == []
