# SPDX-License-Identifier: Apache-2.0
"""Models of the documentation, and of the tests with laws and scenarios of their own, each generated in a folder."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

from mehvar.codegen.generate import generate
from mehvar.codegen.workspace import Tree

ROOT = Path(__file__).parents[2]


def model_here(name: str, folder: Path, of: str = "docs") -> Path:
    """Copy a model of docs/examples or tests/examples and return its generated folder."""
    shutil.copytree(ROOT / of / "examples" / "models" / name, folder / "models" / name)
    return generated(name, folder)


def model_of_page(name: str, page: str, folder: Path) -> Path:
    """Write the files of a model that a page shows and return its generated folder."""
    text = (ROOT / "docs" / page).read_text(encoding="utf-8")
    for place, content in re.findall(
        r"^<!-- file: (models/\S+) -->\n```\w+\n(.*?)^```$", text, re.DOTALL | re.MULTILINE
    ):
        (folder / place).parent.mkdir(parents=True, exist_ok=True)
        (folder / place).write_text(content, encoding="utf-8")
    return generated(name, folder)


def generated(name: str, folder: Path) -> Path:
    """Generate a model of a project and return the folder."""
    (folder / "generated").mkdir(exist_ok=True)
    generate(Tree(folder), name)
    return folder / "generated" / name


def lines(folder: Path) -> int:
    """Count the lines of Python and TOML of a model."""
    return sum(len(path.read_text(encoding="utf-8").splitlines()) for path in folder.glob("*.[pt]*"))
