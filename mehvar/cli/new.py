# SPDX-License-Identifier: Apache-2.0
"""`mehvar new`: a small system, or a law on a plant, ready to generate, simulate and test."""

from __future__ import annotations

import importlib.util
import keyword
import re
import shutil
import tempfile
from pathlib import Path
from typing import Annotated

import typer

from mehvar.base.errors import InputError, bad_value, unknown_name
from mehvar.base.manifest import OPEN_LOOP, Manifest
from mehvar.base.names import WORK
from mehvar.base.versions import project_root
from mehvar.runtime.batch.plan import CAMPAIGN_OPTIONS
from mehvar.runtime.board.image.build import FIRMWARE
from mehvar.runtime.compiling.library import NATIVE
from mehvar.runtime.model.catalogue import find_model, known_models, project_models, shipped_models
from mehvar.runtime.run.options import OPTIONS
from mehvar.settings import complete_models

PARTS = "parts"
"""Value of `--from` for a craft from parts instead of a plant."""
_TEMPLATES = Path(__file__).parents[1] / "templates"
_NAME = re.compile(r"[a-z][a-z0-9_]*")
_LONGEST = 40
"""Largest length of a name. C distinguishes 63 characters, and generated functions append to the name."""
_ROOMS = ("models", "codegen", "generated", "runtime", "tests")
_WRITTEN = {"calls", "kernel"}  # C files that the runtime writes beside a model's
_C_HEADERS = frozenset(
    (
        *("assert", "complex", "ctype", "errno", "fenv", "float", "inttypes", "iso646", "limits", "locale", "math"),
        *("setjmp", "signal", "stdalign", "stdarg", "stdatomic", "stdbool", "stddef", "stdint", "stdio", "stdlib"),
        *("stdnoreturn", "string", "tgmath", "threads", "time", "uchar", "wchar", "wctype"),
    )
)
"""Names of the headers of C11, clause 7.1.2."""


def command(
    name: Annotated[str, typer.Argument(metavar="NAME", help="Name of the system, such as reaction_wheel.")],
    plant: Annotated[
        str | None,
        typer.Option(
            "--from",
            metavar="MODEL",
            help="A new law on this plant; parts: a spacecraft from parts.",
            autocompletion=complete_models,
        ),
    ] = None,
) -> None:
    """Write the new folder and print the next steps."""
    if plant not in (None, PARTS):
        folder = scaffold_law(name, plant, Path.cwd())
        typer.echo(f"wrote {folder}; the law is in {folder / 'models' / name / 'law.py'}")
        typer.echo(f"in {folder}: mehvar generate, then mehvar simulate {name} --controller {name}")
        return
    folder = scaffold(name, Path.cwd(), "system" if plant is None else "craft")
    typer.echo(f"wrote {folder}; {folder.name}/README.md explains the files and the next commands")


def scaffold(name: str, into: Path, kind: str = "system") -> Path:
    """Write and generate a new system; after an error no folder remains.

    Parameters
    ----------
    name : str
        Name of the system, of lower-case letters, digits and underscores.
    into : Path
        Parent of the new folder NAME.
    kind : {"system", "craft"}
        Derived step by step, or assembled from parts.

    Returns
    -------
    Path
        The new folder: models/NAME, generated/NAME, tests, README.md.

    Raises
    ------
    InputError
        If the name is invalid or the folder exists.
    """
    target = _free(name, into)
    with tempfile.TemporaryDirectory(prefix=f".{name}-", dir=into) as scratch:
        whole = Path(scratch) / name
        (whole / "generated").mkdir(parents=True)
        _write(whole, name, kind, title=name.replace("_", " "))
        _generate(whole, name)
        whole.rename(target)
    return target


def scaffold_law(name: str, plant: str, into: Path) -> Path:
    """Write and generate a user's law on a plant; after an error no file remains.

    Parameters
    ----------
    name : str
        Name of the law, of lower-case letters, digits and underscores.
    plant : str
        A model of mehvar or of the project around `into`.
    into : Path
        Folder in the project to which the law is added; outside of a project, parent of the new folder NAME.

    Returns
    -------
    Path
        The folder with models/NAME, generated/NAME and tests.

    Raises
    ------
    InputError
        If the name is invalid or taken, or the plant is not a model.
    """
    manifest = find_model(plant)
    if manifest.model not in known_models():
        raise unknown_name("plant", plant, known_models(), "--from")
    project = project_root(into) if project_models() else None
    target = _free(name, into) if project is None else project
    parts = (f"models/{name}", f"tests/test_{name}.py")
    if project is not None:
        _free(name, project / "models")
        for part in (*parts, f"generated/{name}"):
            if (project / part).exists():
                raise InputError(f"{project / part} exists; choose another name")
    values = {"plant": manifest.model, **_example(manifest)}
    with tempfile.TemporaryDirectory(prefix=f".{name}-", dir=into) as scratch:
        whole = Path(scratch) / name
        (whole / "generated").mkdir(parents=True)
        _write(whole, name, "law", **values)
        if project is None:
            _generate(whole, name)
            whole.rename(target)
            return target
        for part in parts:
            (project / part).parent.mkdir(exist_ok=True)
            (whole / part).rename(project / part)
    _generate(project, name)
    return project


def _example(manifest: Manifest) -> dict[str, object]:
    """Return the parts of the example law on a plant: for each input a gain on a different state."""
    from mehvar.base.units import dimension, product, unit_text

    gains = []
    for i, u in enumerate(manifest.inputs):
        state = manifest.states[i] if i < len(manifest.states) else None
        unit = "1" if state is None else unit_text(product((dimension(u.unit), 1), (dimension(state.unit), -1)))
        gains.append({"name": f"gain_{u.name}", "input": u.name, "state": state and state.name, "unit": unit})
    period = next((law.period for law in manifest.controllers.values() if law.period), None)
    return {
        "gains": gains,
        "period": f', period="{period}"' if period else "",
        **{group: [q.name for q in getattr(manifest, group)] for group in ("states", "inputs", "references")},
    }


def _free(name: str, into: Path) -> Path:
    """Return the folder of a new name, or raise InputError for a name that is invalid or taken."""
    if keyword.iskeyword(name):
        raise bad_value("NAME", name, "another name: this is a reserved word of Python")
    if not _NAME.fullmatch(name):
        raise bad_value("NAME", name, "lower-case letters, digits and underscores, beginning with a letter")
    if len(name) > _LONGEST:
        raise bad_value("NAME", name, f"at most {_LONGEST} characters long")
    target = into / name
    if target.exists():
        raise InputError(f"{target} exists; choose another name or folder")
    if (holder := _holder(name)) is not None:
        raise bad_value("NAME", name, f"another name: this one is taken by {holder}")
    return target


def _holder(name: str) -> str | None:
    """Return the owner of a name that a new system must not have, in words; an empty text for a free name."""
    if name in shipped_models():
        return "a model that comes with mehvar"
    if name in project_models():
        return "a model of the project that this folder is in"
    if name in (*OPTIONS, *CAMPAIGN_OPTIONS):
        return "an option of a run"
    if name in (OPEN_LOOP, WORK):
        return "a word of the command line"
    if name in _C_HEADERS:
        return f"the C header {name}.h"
    if name in _own_c_files():
        return f"a C file of mehvar that is compiled beside {name}.c"
    if name in _ROOMS or importlib.util.find_spec(name) is not None:
        return f"the Python package {name}"
    return None


def _own_c_files() -> set[str]:
    """Return the stems of our C file names that are compiled in one folder with a model."""
    files = (path for folder in (NATIVE, FIRMWARE) for path in folder.rglob("*.[ch]"))
    return {path.stem for path in files} | _WRITTEN


def _write(folder: Path, name: str, kind: str, **values: object) -> None:
    """Write the templates of a kind: tests and README at the top of the folder, all others with the model."""
    from mehvar.codegen.templates import text_environment

    environment = text_environment(_TEMPLATES / kind)
    model = folder / "models" / name
    elsewhere = {
        "init.py.j2": model / "__init__.py",
        "test.py.j2": folder / "tests" / f"test_{name}.py",
        "README.md.j2": folder / "README.md",
    }
    for template in environment.list_templates():
        path = elsewhere.get(template, model / template.removesuffix(".j2"))
        path.parent.mkdir(parents=True, exist_ok=True)
        text = environment.get_template(template).render(name=name, **values)
        path.write_text(text, encoding="utf-8", newline="\n")


def _generate(folder: Path, name: str) -> None:
    from mehvar.codegen.generate import Tree, generate

    generate(Tree(folder), name)
    shutil.rmtree(folder / "models" / name / "__pycache__", ignore_errors=True)
