# SPDX-License-Identifier: Apache-2.0
"""The house: folders of a size that one can survey, imports without a circle at any level, one import name."""

from __future__ import annotations

import ast
import functools
import re
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
BESIDE = ("models", "codegen", "generated", "runtime")
"""Rooms of `mehvar` that stand at the top of the repository."""
MOST_MODULES = 13
"""In one folder: what a reader surveys at a glance, "about a dozen"."""


def name_of(path: Path) -> str:
    """Return the import name of a module or a folder."""
    parts = path.relative_to(ROOT).with_suffix("").parts
    parts = parts[:-1] if parts[-1] == "__init__" else parts
    return ".".join(("mehvar", *parts) if parts[0] in BESIDE else parts)


MODULES = {name_of(path): path for room in ("mehvar", *BESIDE, "papers") for path in (ROOT / room).rglob("*.py")}
FOLDERS = sorted({path.parent for path in MODULES.values()})


def imports(name: str) -> Iterator[str]:
    """Yield every module of the house that a module imports, wherever in its text."""
    path = MODULES[name]
    package = name if path.stem == "__init__" else name.rpartition(".")[0]
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name in MODULES)
        elif isinstance(node, ast.ImportFrom):
            above = ".".join(package.split(".")[: len(package.split(".")) - node.level + 1])
            base = ".".join(filter(None, (above if node.level else "", node.module)))
            for alias in node.names:
                full = f"{base}.{alias.name}"
                yield from (found for found in (full if full in MODULES else base,) if found in MODULES)


@functools.cache
def arrows_of_all() -> dict[str, set[str]]:
    """Return the imports of each module."""
    return {name: set(imports(name)) for name in MODULES}


@pytest.mark.parametrize("folder", FOLDERS, ids=name_of)
def test_a_folder_can_be_surveyed(folder):
    modules = [path.name for path in folder.glob("*.py") if path.stem not in ("__init__", "__main__")]
    assert len(modules) <= MOST_MODULES, modules


@pytest.mark.parametrize("folder", FOLDERS, ids=name_of)
def test_no_folder_has_a_circle(folder):
    """Its modules and folders, each with all that is in it, import one another one way."""
    inside = name_of(folder) + "."
    arrows: dict[str, set[str]] = {}
    for name, targets in arrows_of_all().items():
        if name.startswith(inside):
            room = name.removeprefix(inside).split(".")[0]
            others = {target.removeprefix(inside).split(".")[0] for target in targets if target.startswith(inside)}
            arrows.setdefault(room, set()).update(others - {room})
    try:
        TopologicalSorter(arrows).prepare()
    except CycleError as error:
        pytest.fail(f"{name_of(folder)}: {' <- '.join(error.args[1])}")


def test_tests_stand_where_their_subject_stands():
    """A folder of tests has the name and the place of what it tests, but for fixtures, which hold no test."""
    rooms = ("mehvar", *BESIDE, "papers")
    folders = {path.parent for room in rooms for path in (ROOT / "tests" / room).rglob("test_*.py")}
    assert not [str(folder) for folder in folders if not (ROOT / folder.relative_to(ROOT / "tests")).is_dir()]


def test_rooms_are_imported_under_one_name():
    """A checkout's root is on the path when it is installed in place: `import models` would give every class twice."""
    statement = rf"(from|import) ({'|'.join(BESIDE)})\b"
    code, page = re.compile(rf"^\s*{statement}", re.MULTILINE), re.compile(rf"(^\s*|['\";] *){statement}", re.MULTILINE)
    modules = [
        *MODULES.values(),
        *(path for top in ("tests", "benchmarks", "docs") for path in (ROOT / top).rglob("*.py")),
    ]
    pages = [ROOT / "README.md", *(ROOT / "docs").rglob("*.md")]
    banned = [path for path in modules if code.search(path.read_text(encoding="utf-8"))]
    banned += [path for path in pages if page.search(path.read_text(encoding="utf-8"))]
    assert not [str(path) for path in banned]


def test_no_room_is_named_like_a_function():
    """`import mehvar.NAME` would hide what people call."""
    import mehvar

    assert not set(mehvar.__all__) & {name.split(".")[1] for name in MODULES if name.count(".")}
