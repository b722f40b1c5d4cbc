# SPDX-License-Identifier: Apache-2.0
"""Cache of derived plants for users' laws."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from mehvar.base import cache
from mehvar.base.versions import installed

if TYPE_CHECKING:
    from mehvar.models.system import System

_FILE = "system.pickle"


def kept_plant(sources: Mapping[str, str], structure: Mapping[str, str], derive: Callable[[], System]) -> System:
    """Return a plant from the cache; derive and store a missing one.

    Parameters
    ----------
    sources : mapping of str to str
        SHA-256 of each source file of the plant.
    structure : mapping of str to str
        Structural choices that differ from the defaults.
    derive : callable
        Derives the plant.
    """
    name = cache.key(sources, structure, installed("sympy", "mehvar", "python"))
    entry = cache.find("plants", name)
    if entry is not None and (plant := _read(entry)) is not None:
        return plant
    plant = derive()
    text = _text(plant)
    if text is not None:
        cache.entry("plants", name, lambda folder: (folder / _FILE).write_bytes(text))
    return plant


def _text(plant: System) -> bytes | None:
    """Return a pickled plant; None if unpickling does not restore it, as with functions of a user's module."""
    try:
        text = pickle.dumps(plant)
        return text if pickle.loads(text) == plant else None
    except Exception:  # a user's class may raise anything when it is pickled
        return None


def _read(entry: Path) -> System | None:
    try:
        plant: System = pickle.loads((entry / _FILE).read_bytes())
    except Exception:  # as above; it is derived again
        cache.discard(entry)
        return None
    return plant
