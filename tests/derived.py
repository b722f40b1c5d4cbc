# SPDX-License-Identifier: Apache-2.0
"""Derivations of the shipped models for tests: each system and each variant's files once per run.

Nothing is derived while tests are collected: every process of a run collects all of them.
"""

from __future__ import annotations

import functools
import itertools
import pickle
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

from mehvar.base import cache
from mehvar.codegen.generate import generated_files, installed_tree, system_of, write
from mehvar.codegen.ledger.ledger import Ledger
from mehvar.models.system import System
from mehvar.reproduction.ledgers import paper_ledgers
from mehvar.reproduction.paper import paper_models

REPRODUCED = tuple(paper_models(installed_tree()))
"""Models with a paper to reproduce."""


@functools.cache
def system(model: str, /, **structure: str) -> System:
    """Return a model's derived system; to read what another process has derived takes a tenth of the time."""

    def fill(folder: Path) -> None:
        (folder / "system").write_bytes(pickle.dumps(system_of(installed_tree(), model, structure)))

    derived: System = pickle.loads((cache.entry("systems", _name(model, structure), fill) / "system").read_bytes())
    return derived


def _name(model: str, structure: Mapping[str, str]) -> str:
    inputs = itertools.chain(*installed_tree().sources(model).items(), *sorted(structure.items()))
    return f"{model}-{cache.key(*inputs)}"


def generated(model: str) -> Path:
    """Return the committed folder of a model, whose bytes tests/codegen/test_generate.py derives again."""
    return installed_tree().root / "generated" / model


def variant(model: str, /, **structure: str) -> dict[str, str]:
    """Return the files of a structural variant, of the system that other tests take."""

    def fill(folder: Path) -> None:
        tree = installed_tree()
        tables = tree.root / "models" / model
        write(folder, generated_files(system(model, **structure), tree.sources(model), tables=tables))

    folder = cache.entry("variants", _name(model, structure), fill)
    return {path.name: path.read_text(encoding="utf-8") for path in folder.iterdir() if not path.name.startswith(".")}


@functools.cache
def verdicts(model: str) -> list[dict[str, Any]]:
    """Return the judged ledger of a model's paper as its page takes it, computed once for tests and pages."""
    return paper_ledgers(installed_tree(), model)


@functools.cache
def ledger(model: str) -> Ledger:
    """Return the checked ledger of a model's paper."""
    (judged,) = verdicts(model)
    return TypeAdapter(Ledger).validate_python(judged)
