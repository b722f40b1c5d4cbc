# SPDX-License-Identifier: Apache-2.0
"""The models that pages of the documentation write, generated in a folder of their own."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

from mehvar.codegen.generate import generate
from mehvar.codegen.workspace import Tree

ROOT = Path(__file__).parents[2]
_FILE = re.compile(r"<!-- file: (\S+) -->\n```\w+\n(.*?)```", re.DOTALL)


def model_of_page(page: str, name: str, folder: Path) -> Path:
    """Write the files of a page and return the generated folder of the model in it."""
    for path, text in _FILE.findall((ROOT / "docs" / page).read_text(encoding="utf-8")):
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_text(text, encoding="utf-8")
    return generated(name, folder)


def model_here(name: str, folder: Path) -> Path:
    """Copy a model of docs/examples and return its generated folder."""
    shutil.copytree(ROOT / "docs" / "examples" / "models" / name, folder / "models" / name)
    return generated(name, folder)


def generated(name: str, folder: Path) -> Path:
    """Generate a model of a project and return the folder."""
    (folder / "generated").mkdir(exist_ok=True)
    generate(Tree(folder), name)
    return folder / "generated" / name


def lines(folder: Path) -> int:
    """Return the lines of Python and TOML that a model takes."""
    return sum(len(path.read_text(encoding="utf-8").splitlines()) for path in folder.glob("*.[pt]*"))
