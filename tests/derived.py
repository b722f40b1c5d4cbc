# SPDX-License-Identifier: Apache-2.0
"""What tests derive from the shipped models: each system once in a process, each variant's texts once in a run.

Nothing is derived while tests are collected: every process of a run collects all of them.
"""

from __future__ import annotations

import functools
import itertools
import json
from pathlib import Path

from pydantic import TypeAdapter

from mehvar import cache
from mehvar.codegen.generate import derive, installed_tree, system_of
from mehvar.codegen.ledger.ledger import Ledger
from mehvar.ledger.judging import judged
from mehvar.models.system import System

_FILE = "texts.json"


@functools.cache
def system(model: str, /, **structure: str) -> System:
    """Return a model's derived system."""
    return system_of(installed_tree(), model, structure)


def generated(model: str) -> Path:
    """Return the committed folder of a model, whose bytes tests/codegen/test_generate.py derives again."""
    return installed_tree().root / "generated" / model


def variant(model: str, /, **structure: str) -> dict[str, str]:
    """Return the texts of a structural variant."""
    tree = installed_tree()
    choices = itertools.chain(*sorted(structure.items()))
    key = cache.key(*choices, *itertools.chain(*tree.sources(model).items()))

    def fill(folder: Path) -> None:
        (folder / _FILE).write_text(json.dumps(derive(tree, model, structure)), encoding="utf-8")

    path = cache.entry("variants", f"{model}-{key}", fill) / _FILE
    texts: dict[str, str] = json.loads(path.read_text(encoding="utf-8"))
    return texts


@functools.cache
def ledger(model: str) -> Ledger:
    """Return the ledger of a model's paper, judged once for the tests and for the pages that show it."""
    (verdicts,) = judged(installed_tree(), model)
    return TypeAdapter(Ledger).validate_python(verdicts)
