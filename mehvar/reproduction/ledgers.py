# SPDX-License-Identifier: Apache-2.0
"""Verdicts on all papers of a project, each computed in its own process and cached by its sources.

Checking needs SymPy and takes up to a minute for a paper.
"""

from __future__ import annotations

import itertools
import json
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

from mehvar.base import cache
from mehvar.base.errors import InputError, unknown_name
from mehvar.codegen.generate import Tree, system_of
from mehvar.codegen.processes import in_processes
from mehvar.codegen.workspace import load_paper, own_text

Ledger = dict[str, Any]
"""A checked ledger as plain data, from `mehvar.codegen.ledger.ledger.Ledger.to_json`."""

_FILE = "ledger.json"


def paper_ledgers(tree: Tree, model: str | None = None) -> list[Ledger]:
    """Return the checked ledgers of a project's models, or of one model, as plain data.

    Raises
    ------
    InputError
        If there is no such model, or it has no ledger.
    """
    if model is not None and model not in tree.models:
        raise unknown_name("model", model, tree.models, str(tree.root / "models"))
    with_ledger = [name for name in tree.models if _has_ledger(tree, name)]
    chosen = [name for name in with_ledger if model in (None, name)]
    if not chosen:
        raise _no_ledger(tree, model or "MODEL", with_ledger)
    return in_processes(lambda name, processes: _ledger(tree, name, processes), chosen)


def _has_ledger(tree: Tree, model: str) -> bool:
    folder = tree.root / "papers" / model
    return (folder / "ledger.py").is_file() or (folder / "ledger" / "__init__.py").is_file()


def _no_ledger(tree: Tree, model: str, others: Sequence[str]) -> InputError:
    """Return the error for a model without a ledger."""
    place = tree.root / "papers" / model / "ledger.py"
    known = f"there are ledgers of {', '.join(others)}" if others else "those of mehvar's papers come with its checkout"
    return InputError(f"no published equations: {place} does not exist; {known}")


def _ledger(tree: Tree, model: str, processes: ProcessPoolExecutor) -> Ledger:
    """Return the checked ledger of a model from the cache; check it in another process if it is missing."""
    key = cache.key(*itertools.chain(*tree.sources(model, papers=True).items()))

    def fill(folder: Path) -> None:
        text = processes.submit(_check, tree.root, model).result()
        (folder / _FILE).write_text(text, encoding="utf-8")

    path = cache.entry("ledgers", f"{model}-{key}", fill) / _FILE
    ledger: Ledger = json.loads(path.read_text(encoding="utf-8"))
    return ledger


def _check(root: Path, model: str) -> str:
    """Derive a model and check its paper; the caller uses a process for each model."""
    system = system_of(Tree(root), model, {})
    # after the model, so that both use the models package of its tree
    from mehvar.codegen.ledger.ledger import check_paper

    with own_text(root / "papers" / model):
        paper = load_paper(Tree(root), model, "ledger").paper(system)
    verdicts = check_paper(paper, model)
    return json.dumps(verdicts.to_json(), indent=1, ensure_ascii=False) + "\n"
