# SPDX-License-Identifier: Apache-2.0
"""Run a fuzzing campaign part by part; a stopped campaign continues.

python -m tests.fuzz commands|edits|sanitizers SEED COUNT JOURNAL

The journal has a line for each part: what became of its inputs, which are drawn from the seed and the part's number,
and each finding. Exits 1 if there is one.
"""

from __future__ import annotations

import contextlib
import gc
import importlib
import json
import os
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Mapping
from pathlib import Path

from mehvar.models.system import System
from tests.models.campaign import edited, sanitized
from tests.models.edits import cart, turner

from .campaign import Outcome, commands, forked, furnish, in_process
from .inputs import PENDULUM

_Take = Callable[[str, int, Path], Outcome]
_ONE_OF_EACH = (
    ("generate", "--check", str(PENDULUM)),
    *(("simulate", str(PENDULUM), "--controller", "p-sum", "--t-end", "0.1", "--out", f"a.{e}") for e in ("nc", "mat")),
    ("stats", "s.zarr"),
    ("verify", "s.zarr"),
    ("convert", "s.zarr", "--to", "csv", "--out", "b.csv"),
    ("diff", str(PENDULUM), str(PENDULUM)),
    ("show", str(PENDULUM)),
    ("board", "run", str(PENDULUM), "--controller", "nonsense"),
    ("export", "fmu", "nonsense", "--out", "a.fmu"),
    ("new", "mine"),
)


def main(kind: str, seed: str, count: str, journal: str) -> int:
    """Run the parts that the journal lacks, and print the sum."""
    path, (size, prepared) = Path(journal), _KINDS[kind]
    lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
    rows = {row["part"]: row for row in map(json.loads, lines) if (row["kind"], row["seed"]) == (kind, seed)}
    take = prepared()
    for part in sorted(set(range(-(-int(count) // size))) - rows.keys()):
        with tempfile.TemporaryDirectory() as folder:
            outcome = take(f"{seed} {part}", min(size, int(count) - part * size), Path(folder))
        rows[part] = {"kind": kind, "seed": seed, "part": part, **vars(outcome)}
        with path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(rows[part]) + "\n")
    counts: Counter[str] = sum((Counter(row["counts"]) for row in rows.values()), Counter())
    findings = [text for row in rows.values() for text in row["findings"]]
    print(f"{kind}, seed {seed}: {counts.total()}, of these {dict(counts.most_common())}; {len(findings)} findings")
    print(*findings, sep="\n")
    return int(bool(findings))


def _commands() -> _Take:
    """Import the modules of commands, in a process without threads, which a fork would lack."""
    with tempfile.TemporaryDirectory() as folder:
        names = Path(folder, "names")
        if not (child := os.fork()):
            furnish(Path(folder), in_process)
            os.chdir(folder)
            for arguments in _ONE_OF_EACH:
                in_process(*arguments)
            names.write_text("\n".join(sys.modules))
            os._exit(0)
        os.waitpid(child, 0)
        for name in names.read_text().splitlines():
            with contextlib.suppress(ImportError):  # made by another module, without a file
                importlib.import_module(name)
    gc.freeze()  # a collection in a child would copy all of it

    def take(seed: str, count: int, folder: Path) -> Outcome:
        furnish(folder, forked)
        return commands(seed, count, folder, forked)

    return take


def _base(seed: str) -> System:
    """Return one of two systems, alternating."""
    return (cart, turner)[int(seed.split()[-1]) % 2]()


_KINDS: Mapping[str, tuple[int, Callable[[], _Take]]] = {
    "commands": (100, _commands),
    "edits": (20, lambda: lambda seed, count, folder: edited(_base(seed), seed, count, folder)),
    "sanitizers": (5, lambda: lambda seed, count, folder: sanitized(_base(seed), seed, count, folder)),
}
"""Inputs in one part, and the function that prepares a runner of a seed and a count in a folder."""

if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
