# SPDX-License-Identifier: Apache-2.0
"""Generated folders of systems built in Python, without a folder of models."""

from __future__ import annotations

import hashlib
import runpy
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

import numpy as np

from mehvar.base import cache
from mehvar.base.errors import InputError, bad_value
from mehvar.base.versions import installed

from .generate import generated_files, prepared, write
from .workspace import installed_tree, own_text

if TYPE_CHECKING:
    from mehvar.models.system import System


_EQUATIONS = {"steps", "functions", "variants", "residual"}
"""Fields of a system that its equations contain completely. To print them again takes 2 s for eight pendulums."""


class Assembly(Protocol):
    """Object that builds a system, such as a `Spacecraft`."""

    def system(self) -> System:
        """Return the system."""


def built_folder(system: System | Assembly | Callable[[], System]) -> Path:
    """Return the cached generated folder of a system; generate the system if the cache lacks it.

    Parameters
    ----------
    system : System, Spacecraft or callable
        The system. A function that returns one may not branch on symbols: mehvar reports such a branch with file and
        line.

    Raises
    ------
    ModelError
        If the parts of the system do not fit together.
    """
    from mehvar.models.check import check, no_branching
    from mehvar.models.system import System as Kind

    with no_branching():
        maker = system if callable(system) else getattr(system, "system", lambda: system)
        made = maker()
    if not isinstance(made, Kind):
        raise bad_value("system", system, "a System, a Spacecraft, or a function that returns a System")
    check(made)
    ready = prepared(made)
    from .equations.graph import equations_json

    text = equations_json(ready) + repr([_declaration(getattr(ready, name)) for name in _declared(ready)])
    versions = installed("sympy", "casadi", "mehvar", "python")
    key = cache.key(text, versions, installed_tree().sources("parts"))

    def fill(folder: Path) -> None:
        write(folder, generated_files(ready, {"system": hashlib.sha256(text.encode()).hexdigest()}))

    return cache.entry("built", f"{ready.name}-{key}", fill)


def file_folder(path: Path) -> Path:
    """Return the cached generated folder of the system or spacecraft in a Python file.

    Parameters
    ----------
    path : Path
        The file has a function `system()` or `craft()`, or one `System` or `Spacecraft`.

    Raises
    ------
    ModelError
        If the code of the file has an error.
    InputError
        If the file has none of these.
    """
    from mehvar.models.parts import Spacecraft
    from mehvar.models.system import System as Kind

    with own_text(path.parent):
        names = runpy.run_path(str(path))
        made = [names[name]() for name in ("system", "craft") if callable(names.get(name))]
        made += [value for value in names.values() if isinstance(value, Kind | Spacecraft)]
        if made:
            return built_folder(made[0])
    raise InputError(f"{path} has no function system() or craft(), and no System or Spacecraft: add one")


def _declared(system: System) -> list[str]:
    """Return the fields of a system that its equations do not contain completely, such as laws with defaults."""
    return [entry.name for entry in fields(system) if entry.compare and entry.name not in _EQUATIONS]


def _declaration(value: object) -> object:
    """Return all fields of a part of a system except its source line."""
    import sympy as sp

    if is_dataclass(value):
        declared = {entry.name: _declaration(getattr(value, entry.name)) for entry in fields(value) if entry.compare}
        return type(value).__name__, declared
    if isinstance(value, Mapping):
        return [(_declaration(key), _declaration(entry)) for key, entry in value.items()]
    if isinstance(value, list | tuple):
        return [_declaration(entry) for entry in value]
    if isinstance(value, np.ndarray):  # whose text leaves out the middle of a long one
        return value.tolist()
    return sp.srepr(value) if isinstance(value, sp.Basic) else repr(value)
