# SPDX-License-Identifier: Apache-2.0
"""`mehvar new`: a folder with a small system that generates, simulates and passes its physics gates at once."""

from __future__ import annotations

import importlib.util
import keyword
import re
import shutil
import tempfile
from pathlib import Path
from typing import Annotated

import typer

from mehvar.errors import InputError, bad_value
from mehvar.runtime.batch.plan import CAMPAIGN_OPTIONS
from mehvar.runtime.board.image.build import FIRMWARE
from mehvar.runtime.compiling.library import NATIVE
from mehvar.runtime.model.catalogue import project_models, shipped_models
from mehvar.runtime.run.options import OPTIONS

_TEMPLATES = Path(__file__).parents[1] / "templates" / "system"
_NAME = re.compile(r"[a-z][a-z0-9_]*")
_LONGEST = 40
"""Characters: names of functions in the generated C begin with the name, and C promises to tell 63 apart."""
_ROOMS = ("models", "codegen", "generated", "runtime", "tests")
_WRITTEN = {"calls", "kernel"}  # C files that the runtime writes beside a model's
_C_HEADERS = frozenset(
    (
        *("assert", "complex", "ctype", "errno", "fenv", "float", "inttypes", "iso646", "limits", "locale", "math"),
        *("setjmp", "signal", "stdalign", "stdarg", "stdatomic", "stdbool", "stddef", "stdint", "stdio", "stdlib"),
        *("stdnoreturn", "string", "tgmath", "threads", "time", "uchar", "wchar", "wctype"),
    )
)
"""C11, 7.1.2."""


def command(
    name: Annotated[str, typer.Argument(metavar="NAME", help="Name of the system, such as reaction_wheel.")],
) -> None:
    """Write the folder and say what to do next."""
    folder = scaffold(name, Path.cwd())
    typer.echo(f"wrote {folder}; {folder.name}/README.md says what is where and what to type next")


def scaffold(name: str, into: Path) -> Path:
    """Write a new system and generate it; the folder is complete or absent.

    Parameters
    ----------
    name : str
        Of the system: lower-case letters, digits and underscores.
    into : Path
        The folder NAME is made in this folder.

    Returns
    -------
    Path
        The new folder: models/NAME, generated/NAME, tests, README.md.

    Raises
    ------
    InputError
        If the name cannot name a system or the folder exists.
    """
    if not _NAME.fullmatch(name) or keyword.iskeyword(name):
        raise bad_value("NAME", name, "lower-case letters, digits and underscores, beginning with a letter")
    if len(name) > _LONGEST:
        raise bad_value("NAME", name, f"at most {_LONGEST} characters long")
    target = into / name
    if target.exists():
        raise InputError(f"{target} exists; choose another name or folder")
    if (holder := _holder(name)) is not None:
        raise bad_value("NAME", name, f"another name: this one is taken by {holder}")
    with tempfile.TemporaryDirectory(prefix=f".{name}-", dir=into) as scratch:
        whole = Path(scratch) / name
        _write(whole, name)
        _generate(whole, name)
        shutil.rmtree(whole / "models" / name / "__pycache__", ignore_errors=True)
        whole.rename(target)
    return target


def _holder(name: str) -> str | None:
    """Return what a name belongs to already, so that a system called so would hide it or be hidden by it."""
    if name in shipped_models():
        return "a model that comes with mehvar"
    if name in project_models():
        return "a model of the project that this folder is in"
    if name in (*OPTIONS, *CAMPAIGN_OPTIONS):
        return "an option of a run"
    if name in _C_HEADERS:
        return f"the C header {name}.h"
    if name in _own_c_files():
        return f"a C file of mehvar that is compiled beside {name}.c"
    if name in _ROOMS or importlib.util.find_spec(name) is not None:
        return f"the Python package {name}"
    return None


def _own_c_files() -> set[str]:
    """Return the names, without ending, of the C that may be compiled in one folder with a model."""
    files = (path for folder in (NATIVE, FIRMWARE) for path in folder.rglob("*.[ch]"))
    return {path.stem for path in files} | _WRITTEN


def _write(folder: Path, name: str) -> None:
    from mehvar.codegen.templates import text_environment

    environment = text_environment(_TEMPLATES)
    model = folder / "models" / name
    places = {
        "init.py.j2": model / "__init__.py",
        "system.py.j2": model / "system.py",
        "parameters.toml.j2": model / "parameters.toml",
        "scenarios.toml.j2": model / "scenarios.toml",
        "test.py.j2": folder / "tests" / f"test_{name}.py",
        "README.md.j2": folder / "README.md",
    }
    for template, path in places.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        text = environment.get_template(template).render(name=name, title=name.replace("_", " "))
        path.write_text(text, encoding="utf-8", newline="\n")


def _generate(folder: Path, name: str) -> None:
    from mehvar.codegen.generate import Tree, generate

    (folder / "generated").mkdir()
    generate(Tree(folder), name)
