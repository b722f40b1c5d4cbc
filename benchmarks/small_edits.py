# SPDX-License-Identifier: Apache-2.0
"""Twenty small edits of the models: how many lines of generated text each changes, and how many it must change.

Run: python benchmarks/small_edits.py

With the folder of an earlier checkout, `python benchmarks/small_edits.py EARLIER`, that one's generator is asked.
A line must change when it reads otherwise even with the names of temporaries masked, wherever it stands; what is
counted is what `git diff` removes and adds. CasADi's own C is not counted: its names are CasADi's.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from statistics import median

from machine import table

ROOT = Path(__file__).parents[1]
DERIVE = (
    "import json, sys; from pathlib import Path; from mehvar.codegen.generate import Tree, derive\n"
    "print(json.dumps(derive(Tree(Path.cwd()), sys.argv[1])))"
)
_TEMPORARY = re.compile(
    r"\b(?:[vmsc]\d+\b|(?:(?:sin|cos)_)?[tm]_[a-z2-7]{5}(?:_\d+)?_*|(?:sin|cos)_[a-z2-7]{5}\b|h\[\w+\]"
    r"|h\[\.\.\., \d+\]|\w+_[hw]_\w+)"
)
_NODE = re.compile(r'(?<![\w"])\d+(?![\w"])|"[0-9a-f]{10}"')


@dataclass(frozen=True)
class Edit:
    """One edit of a model's text.

    Attributes
    ----------
    model, kind : str
        Whose it is, and what it is an example of.
    file, old, new : str
        Below models/MODEL: `new` takes the place of the first `old`.
    """

    model: str
    kind: str
    file: str
    old: str
    new: str


EDITS = (
    Edit(
        "satellite",
        "coefficient: gravity gradient 3 to 2",
        "dynamics.py",
        "return 3 * omega0**2",
        "return 2 * omega0**2",
    ),
    Edit(
        "satellite",
        "coefficient: magnetic field 2 to 3",
        "environment.py",
        "2 * sp.sin(latitude)",
        "3 * sp.sin(latitude)",
    ),
    Edit("satellite", "sign: wheel speed", "dynamics.py", "[k] - rates[k]", "[k] + rates[k]"),
    Edit("satellite", "sign: reflectance", "environment.py", "(1 + plant.reflectance)", "(1 - plant.reflectance)"),
    Edit("satellite", "term: momentum of the wheels", "dynamics.py", "inertia * rate + momentum)", "inertia * rate)"),
    Edit(
        "satellite",
        "term: offset in the retaining law",
        "controllers.py",
        "(1 + first + last) * offset",
        "(1 + last) * offset",
    ),
    Edit(
        "satellite",
        "gain: damping of pd doubled",
        "controllers.py",
        '- getattr(law, f"Kd_{i}")',
        '- 2 * getattr(law, f"Kd_{i}")',
    ),
    Edit("satellite", "law's line: reference model", "controllers.py", "(w[0] + w[1]) / 2", "(3 * w[0] + w[1]) / 4"),
    Edit("satellite", "rename: F_air", "environment.py", '"F_air"', '"F_drag"'),
    Edit("satellite", "title: drag", "environment.py", '"drag"', '"force of the air"'),
    Edit("triangle", "coefficient: turn of the direction doubled", "controllers.py", "-sigma * f", "-2 * sigma * f"),
    Edit("triangle", "coefficient: rates of the rods", "dynamics.py", "/ (2 * length)", "/ (3 * length)"),
    Edit(
        "triangle",
        "sign: approach to the surface",
        "controllers.py",
        "along_surface - law.eta_rho",
        "along_surface + law.eta_rho",
    ),
    Edit(
        "triangle", "term: the ratio in the speed of the turn", "controllers.py", "(closeness + ratio**2)", "closeness"
    ),
    Edit("triangle", "gain: size", "controllers.py", "rate = law.mu_gain * (", "rate = 2 * law.mu_gain * ("),
    Edit(
        "triangle",
        "law's line: distance of escape",
        "controllers.py",
        "sp.sqrt(sp.Abs(shifted.theta)), law.R",
        "sp.Abs(shifted.theta), law.R",
    ),
    Edit("triangle", "rename: tau", "controllers.py", '"tau", sp.Abs', '"closeness", sp.Abs'),
    Edit("slosh", "gain: u1 doubled", "laws/controllers.py", "-c.w1 * b", "-2 * c.w1 * b"),
    Edit("slosh", "term: product of rates", "fast/hull.py", 'd.define("W12", w1 * w2,', 'd.define("W12", w1,'),
    Edit("slosh", "title: roll inertia", "fast/hull.py", 'title="roll inertia"', 'title="inertia in roll"'),
)


def main(earlier: Path | None, models: frozenset[str], kept: Path | None) -> None:
    """Count, and print a table."""
    edits = [edit for edit in EDITS if not models or edit.model in models]
    counts = _counts(earlier or ROOT, edits, kept)
    rows = [[e.model, e.kind, str(changed), str(must)] for e, (changed, must) in zip(edits, counts, strict=True)]
    print("\n".join(table(["model", "edit", "lines changed", "must change"], rows)))
    print("median of the ratios:", round(median(changed / max(must, 1) for changed, must in counts), 2))


def _counts(side: Path, edits: list[Edit], kept: Path | None) -> list[tuple[int, int]]:
    with ThreadPoolExecutor(2) as pool:
        models = list(dict.fromkeys(edit.model for edit in edits))
        plain = dict(zip(models, pool.map(lambda model: _texts(side, model, None, kept), models), strict=True))
        edited = list(pool.map(lambda edit: _texts(side, edit.model, edit, kept), edits))
    return [lines(plain[edit.model], texts) for edit, texts in zip(edits, edited, strict=True)]


def _texts(side: Path, model: str, edit: Edit | None, kept: Path | None) -> dict[str, str]:
    """Derive a model, edited or not, in a process of its own."""
    store = (
        None
        if kept is None
        else kept / f"{side.name}-{model}-{re.sub('[^a-z0-9]+', '-', edit.kind) if edit else 'plain'}.json"
    )
    if store is not None and store.is_file():
        return json.loads(store.read_text())
    with tempfile.TemporaryDirectory() as folder:
        shutil.copytree(side / "models", Path(folder) / "models", ignore=shutil.ignore_patterns("__pycache__"))
        if edit is not None:
            file = Path(folder) / "models" / model / edit.file
            text = file.read_text(encoding="utf-8")
            if edit.old not in text:
                raise SystemExit(f"{file}: lacks {edit.old!r}")
            file.write_text(text.replace(edit.old, edit.new, 1), encoding="utf-8")
        path = os.pathsep.join((folder, str(side)))
        done = subprocess.run(
            [sys.executable, "-c", DERIVE, model],
            cwd=folder, env={**os.environ, "PYTHONPATH": path}, capture_output=True, text=True, check=False,
        )  # fmt: skip
        if done.returncode:
            raise SystemExit(f"{edit}: {done.stderr[-2000:]}")
    if store is not None:
        store.write_text(done.stdout)
    return json.loads(done.stdout)


def lines(before: Mapping[str, str], after: Mapping[str, str]) -> tuple[int, int]:
    """Return how many lines a diff of two versions' C, header, Python and equations removes and adds, and must."""
    changed = must = 0
    for name in before:
        if name.endswith((".c", ".h", ".py", ".json")) and name != "manifest.json":
            changed += _diff(before[name], after[name])
            names = _NODE if name.endswith(".json") else _TEMPORARY
            one, other = (Counter(names.sub("_", line) for line in text[name].splitlines()) for text in (before, after))
            must += (one - other).total() + (other - one).total()
    return changed, must


def _diff(before: str, after: str) -> int:
    with tempfile.TemporaryDirectory() as folder:
        for name, text in (("before", before), ("after", after)):
            (Path(folder) / name).write_text(text, encoding="utf-8")
        command = ["git", "diff", "--no-index", "--numstat", "before", "after"]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    return sum(int(field) for field in done.stdout.split()[:2])


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("earlier", nargs="?", type=Path)
    parser.add_argument("--models", nargs="*", default=())
    parser.add_argument("--kept", type=Path)
    given = parser.parse_args()
    main(given.earlier, frozenset(given.models), given.kept)
