# SPDX-License-Identifier: Apache-2.0
"""Generated folders of structural variants, derived once: who asks again finds them in the cache."""

from __future__ import annotations

import itertools
import json
import sys
from collections.abc import Mapping
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

from mehvar import cache
from mehvar.versions import installed

from .generate import derive, write
from .processes import in_processes
from .workspace import Tree


def structure_folders(tree: Tree, structures: Mapping[str, Mapping[str, str]]) -> dict[str, Path]:
    """Return a generated folder for each model, derived now where the cache has none.

    Parameters
    ----------
    tree : Tree
        Where the models live.
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
    """Return the generated folder of one structure, derived in a process if there are some."""
    versions = {**installed("sympy", "casadi", "mehvar"), "python": sys.version}
    parts = itertools.chain(sorted(structure.items()), tree.sources(model).items(), versions.items())

    def fill(folder: Path) -> None:
        given = (tree, model, dict(structure))
        texts = processes.submit(derive, *given).result() if processes else derive(*given)
        write(folder, texts)

    return cache.entry("structures", f"{model}-{cache.key(json.dumps(list(parts)))}", fill)
