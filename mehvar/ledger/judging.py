# SPDX-License-Identifier: Apache-2.0
"""Judging the papers of a tree, each in a process of its own; verdicts stay in the cache under a hash of the sources.

Judging needs SymPy and takes up to a minute for a paper.
"""

from __future__ import annotations

import hashlib
import json
import os
import signal
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from mehvar.codegen.generate import Tree, system_of
from mehvar.errors import InputError, unknown_name
from mehvar.runtime.compiling.library import cache_folder
from mehvar.runtime.files import write_atomic

Ledger = dict[str, Any]
"""A ledger as plain data, as `mehvar.codegen.ledger.ledger.Ledger.to_json` returns it."""


def judged(tree: Tree, model: str | None = None) -> list[Ledger]:
    """Return the ledger of every model of a tree that has one, or of one model, as plain data.

    Raises
    ------
    InputError
        If there is no such model, or it has no ledger.
    """
    if model is not None and model not in tree.models:
        raise unknown_name("model", model, tree.models, str(tree.root / "models"))
    with_paper = [name for name in tree.models if _has_paper(tree, name)]
    chosen = [name for name in with_paper if model in (None, name)]
    if not chosen:
        raise InputError(f"no published equations for {model or tree.root}: there are some for {', '.join(with_paper)}")
    missing = [name for name in chosen if not _cached(tree, name).is_file()]
    if missing:
        workers = min(len(missing), os.cpu_count() or 1)
        ended_by_ctrl_c = (signal.SIGINT, signal.SIG_DFL)
        with ProcessPoolExecutor(workers, get_context("spawn"), signal.signal, ended_by_ctrl_c) as pool:
            texts = list(pool.map(_judge, [tree.root] * len(missing), missing))
        for name, text in zip(missing, texts, strict=True):
            write_atomic(_cached(tree, name), text)
    return [json.loads(_cached(tree, name).read_text(encoding="utf-8")) for name in chosen]


def _has_paper(tree: Tree, model: str) -> bool:
    folder = tree.root / "models" / model
    return (folder / "paper.py").is_file() or (folder / "paper" / "__init__.py").is_file()


def _cached(tree: Tree, model: str) -> Path:
    key = hashlib.sha256(json.dumps(tree.sources(model, papers=True), sort_keys=True).encode()).hexdigest()[:32]
    folder = cache_folder() / "ledgers"
    folder.mkdir(exist_ok=True)
    return folder / f"{model}-{key}.json"


def _judge(root: Path, model: str) -> str:
    """Derive a model and judge its paper; runs in a process of its own."""
    system = system_of(Tree(root), model, {})
    # after the model, so that both use the models package of its tree
    from mehvar.codegen.ledger.ledger import ledger_json

    return ledger_json(system)
