# SPDX-License-Identifier: Apache-2.0
"""Cache of generated folders of structural variants."""

from __future__ import annotations

import contextlib
import itertools
import math
from collections.abc import Mapping
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

from mehvar.base import cache
from mehvar.base.versions import installed

from .generate import derive, write
from .processes import in_processes
from .workspace import Tree, load_model

_MOST = 16
"""Largest number of structures that are all compared; each takes about ten seconds per side. Slosh and satellite have
768 and 192, so that twice the limit would not include them either.
"""
_TRIES = 1000
"""Largest number of combinations that are tried; a model refuses an invalid one within microseconds."""


def structure_folders(tree: Tree, structures: Mapping[str, Mapping[str, str]]) -> dict[str, Path]:
    """Return a generated folder for each model, derived if the cache has none.

    Parameters
    ----------
    tree : Tree
        Project of the models.
    structures : mapping of str to mapping
        For each model the structural choices that differ from the defaults.

    Raises
    ------
    GenerateError
        If a model or a choice is not known.
    """

    def folder(model: str, processes: ProcessPoolExecutor) -> Path:
        return structure_folder(tree, model, structures[model], processes)

    return dict(zip(structures, in_processes(folder, structures), strict=True))


def structure_folder(
    tree: Tree, model: str, structure: Mapping[str, str], processes: ProcessPoolExecutor | None = None
) -> Path:
    """Return the generated folder of one structure, derived in a process if a pool is given."""
    key = cache.key(structure, tree.sources(model), installed("sympy", "casadi", "mehvar", "python"))

    def fill(folder: Path) -> None:
        given = (tree, model, dict(structure))
        texts = processes.submit(derive, *given).result() if processes else derive(*given)
        write(folder, texts)

    return cache.entry("structures", f"{model}-{key}", fill)


def choices_of(tree: Tree, model: str) -> Mapping[str, tuple[str, ...]]:
    """Return the values of each structural choice, default first; for a law, those of its plant."""
    choices: Mapping[str, tuple[str, ...]] = load_model(*(tree.plant(model) or (tree, model))).STRUCTURE
    return choices


def all_structures(choices: Mapping[str, tuple[str, ...]]) -> tuple[list[dict[str, str]], bool]:
    """Return structures other than the default, and True if these are all.

    If there are too many combinations, each value of each choice occurs once with all others at their defaults.
    """
    defaults = {name: values[0] for name, values in choices.items()}
    complete = math.prod(map(len, choices.values())) <= _MOST
    if complete:
        every = [dict(zip(choices, values, strict=True)) for values in itertools.product(*choices.values())]
    else:
        every = [defaults | {name: value} for name, values in choices.items() for value in values[1:]]
    others = [{name: v for name, v in each.items() if v != defaults[name]} for each in every]
    return [each for each in others if each], complete


def valid_structure(tree: Tree, model: str, structure: Mapping[str, str]) -> dict[str, str] | None:
    """Return the structure with the fewest additional choices that make it valid, or None."""
    where = tree.plant(model) or (tree, model)
    package, choices = load_model(*where), choices_of(*where)
    from mehvar.models.quantities import ModelError  # of the vocabulary that the model has imported

    free = {name: values[1:] for name, values in choices.items() if name not in structure}
    tries = (
        {**structure, **dict(zip(names, values, strict=True))}
        for count in range(len(free) + 1)
        for names in itertools.combinations(free, count)
        for values in itertools.product(*(free[name] for name in names))
    )
    for wider in itertools.islice(tries, _TRIES):
        with contextlib.suppress(ModelError):
            package.system(**wider)
            return wider
    return None
