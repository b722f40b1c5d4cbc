# SPDX-License-Identifier: Apache-2.0
"""Test of every combination of a model's structures: derived and checked, or refused by a rule of the model.

`python -m tests.models.structures build/structures.jsonl` goes through all of them and goes on where it was;
`make soak` runs it.
"""

from __future__ import annotations

import itertools
import json
import sys
import time
import traceback
from collections.abc import Iterator, Mapping
from pathlib import Path

from mehvar.codegen.generate import derive, installed_tree, load_model, system_of
from mehvar.models.system import ModelError

MODELS = ("triangle", "satellite", "slosh")
FEW = 3
"""Largest number of values of a choice whose combinations are generated with all files."""

Structure = Mapping[str, str]


def structures(model: str) -> Iterator[Structure]:
    """Yield each combination, in the order of the choices' values."""
    choices = load_model(installed_tree(), model).STRUCTURE
    places = itertools.product(*(range(len(values)) for values in choices.values()))
    for place in sorted(places, key=max):
        yield {name: values[k] for (name, values), k in zip(choices.items(), place, strict=True)}


def outcome(model: str, structure: Structure, *, whole: bool = False) -> str:
    """Derive and check a structure, or generate all its files; return the message of a refusal."""
    tree = installed_tree()
    try:
        (derive if whole else system_of)(tree, model, structure)
    except ModelError as refusal:
        frames = traceback.extract_tb(refusal.__traceback__)
        folder = (tree.root / "models" / model).resolve()  # the package reaches it by a link
        if Path(frames[-1].filename).resolve().is_relative_to(folder):
            return str(refusal)
        raise
    return ""


def main(record: Path) -> int:
    """Test all structures, and record each in a file; return the number of failures."""
    record.parent.mkdir(parents=True, exist_ok=True)
    known = [json.loads(line) for line in record.read_text().splitlines()] if record.exists() else []
    done = {(entry["model"], json.dumps(entry["structure"])) for entry in known}
    pairs = [(model, structure) for model in MODELS for structure in structures(model)]
    for model, structure in pairs:
        if (model, json.dumps(structure)) in done:
            continue
        small, started, text = all(_place(model, structure, name) < FEW for name in structure), time.monotonic(), ""
        try:
            text, kind = outcome(model, structure, whole=small), "generated" if small else "checked"
            kind = "refused" if text else kind
        except Exception as error:
            kind, text = "failed", f"{type(error).__name__}: {error}"
        entry = {"model": model, "structure": structure, "outcome": kind, "text": text}
        known.append(entry | {"seconds": round(time.monotonic() - started, 1)})
        with record.open("a") as file:
            file.write(json.dumps(known[-1]) + "\n")
    failed = [entry for entry in known if entry["outcome"] == "failed"]
    for entry in failed:
        print(entry["model"], entry["structure"], entry["text"])
    print(f"{len(known)} structures, {len(failed)} failed")
    return len(failed)


def _place(model: str, structure: Structure, name: str) -> int:
    choices: Mapping[str, tuple[str, ...]] = load_model(installed_tree(), model).STRUCTURE
    return choices[name].index(structure[name])


if __name__ == "__main__":
    raise SystemExit(bool(main(Path(sys.argv[1]))))
