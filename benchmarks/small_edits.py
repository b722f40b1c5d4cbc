# SPDX-License-Identifier: Apache-2.0
"""Effect of small edits of the models: changed lines of generated code, and lines of changed meaning.

Run: python -m benchmarks.small_edits

Each edited model is derived and compared with generated/.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from statistics import median

from benchmarks.machine import command_line, machine, table, write

ROOT = Path(__file__).parents[1]
DERIVE = (
    "import json, sys; from pathlib import Path; from mehvar.codegen.generate import Tree, derive\n"
    "print(json.dumps(derive(Tree(Path.cwd()), sys.argv[1], whole=False)))"
)
"""Program that prints the committed files of a model."""
GOAL = 3
"""Changed lines per line of changed meaning."""
_TEMPORARY = re.compile(
    r"(?<!\[)\b[vmsc]\d+\b|\bh\[(?:\.\.\., )?\d+\]"
    r"|\b(?:\w+_[hw]_)?(?:(?:sin_|cos_)?[tm]_[a-z2-7]{5}|(?:sin|cos)_[a-z2-7]{5})(?:_\d+)?_*\b"
)
"""Names of temporaries: v12 and h[12] by place, t_abcde by content, after h_ or w_ where another function makes it."""
_NODE = re.compile(r'(?<![\w"])\d+(?![\w"])|"[0-9a-f]{10}"')
"""Names of nodes of equations.json: the place, or ten digits of a hash of the content."""
_REGISTER = re.compile(r"\ba\d+\b")
"""Names of temporaries in CasADi's own C."""
_NONE = re.compile(r"(?!)")
_WORD = re.compile(r"[\w.]+|\S")


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
        "return 3 * pull",
        "return 2 * pull",
    ),
    Edit(
        "satellite",
        "coefficient: magnetic field 2 to 3",
        "orbit.py",
        "2 * sp.sin(latitude)",
        "3 * sp.sin(latitude)",
    ),
    Edit("satellite", "sign: wheel speed", "dynamics.py", "momentum / inertia - along", "momentum / inertia + along"),
    Edit("satellite", "sign: reflectance", "environment.py", "(1 + plant.reflectance)", "(1 - plant.reflectance)"),
    Edit("satellite", "term: momentum of the wheels", "wheels.py", "angular=self.momentum * self.axis, ", ""),
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
    Edit("slosh", "sign: u2", "laws/controllers.py", "-c.w2 * cc", "c.w2 * cc"),
    Edit(
        "slosh",
        "term: gyroscopic one of the reduced model",
        "plant/reduced.py",
        "*inputs[:2]]) - rate.cross(velocity)",
        "*inputs[:2]])",
    ),
    Edit("slosh", "title: D", "bobs.py", '"inertia about the pivot"', '"moment of inertia about the pivot"'),
)


def main() -> None:
    """Count, and write the page."""
    counts = [count(edit) for edit in EDITS]
    rows = [
        [edit.model, edit.kind, str(changed), str(meaning), f"{_ratio(changed, meaning):.1f}"]
        for edit, (changed, meaning) in zip(EDITS, counts, strict=True)
    ]
    ratios = [_ratio(*pair) for pair in counts]
    lines = [
        "# Small edits",
        "",
        "Written by `python -m benchmarks.small_edits`.",
        "",
        "- changed: lines that `git diff` removes and adds in all files of generated/MODEL.",
        "- meaning: of these, the lines that no choice of names avoids. Each line is taken without the names of its",
        "  temporaries and of its nodes, and with its words sorted; those in only one version count. A sum in another",
        "  order or another temporary in the same place does not count: the number is rather too small.",
        "- ratio: the first over the second, of which at least one is taken.",
        "",
        "## Machine",
        "",
        *machine(),
        "",
        "## Lines",
        "",
        *table(["model", "edit", "changed", "meaning", "ratio"], rows),
        "",
        f"All lines changed: {sum(changed for changed, _ in counts)}. Median of the ratios: {median(ratios):.1f}; "
        f"{sum(ratio > GOAL for ratio in ratios)} of {len(ratios)} edits are above {GOAL}.",
    ]
    write("small_edits.md", lines)


def _ratio(changed: int, meaning: int) -> float:
    return changed / max(meaning, 1)


def count(edit: Edit) -> tuple[int, int]:
    """Count changed lines and lines of changed meaning."""
    folder = ROOT / "generated" / edit.model
    committed = {path.name: path.read_text(encoding="utf-8") for path in folder.iterdir() if path.is_file()}
    return lines(committed, derived(edit))


def derived(edit: Edit) -> dict[str, str]:
    """Derive an edited model in a separate process."""
    with tempfile.TemporaryDirectory() as folder:
        shutil.copytree(ROOT / "models", Path(folder) / "models", ignore=shutil.ignore_patterns("__pycache__"))
        file = Path(folder) / "models" / edit.model / edit.file
        text = file.read_text(encoding="utf-8")
        if edit.old not in text:
            raise SystemExit(f"{file}: lacks {edit.old!r}")
        file.write_text(text.replace(edit.old, edit.new, 1), encoding="utf-8")
        path = os.pathsep.join((folder, str(ROOT)))
        done = subprocess.run(
            [sys.executable, "-c", DERIVE, edit.model],
            cwd=folder, env={**os.environ, "PYTHONPATH": path}, capture_output=True, text=True, check=False,
        )  # fmt: skip
    if done.returncode:
        raise SystemExit(f"{edit}: {done.stderr[-2000:]}")
    texts: dict[str, str] = json.loads(done.stdout)
    return texts


def lines(before: Mapping[str, str], after: Mapping[str, str]) -> tuple[int, int]:
    """Return the numbers of removed, added and changed-in-meaning lines between two versions."""
    changed = meaning = 0
    for name in before.keys() & after.keys():
        changed += _diff(before[name], after[name])
        names = _names_in(name)
        one, other = (Counter(_meaning(line, names) for line in text[name].splitlines()) for text in (before, after))
        meaning += (one - other).total() + (other - one).total()
    return changed, meaning


def _names_in(file: str) -> re.Pattern[str]:
    """Return the pattern of names of temporaries or nodes in a file."""
    if file.endswith(".json"):
        return _NODE if file == "equations.json" else _NONE
    if "_casadi." in file:
        return _REGISTER
    return _NONE if file.endswith(".md") else _TEMPORARY


def _meaning(line: str, names: re.Pattern[str]) -> str:
    """Return the words of a line in order of the alphabet, without some names."""
    return " ".join(sorted(_WORD.findall(names.sub("_", line))))


def _diff(before: str, after: str) -> int:
    with tempfile.TemporaryDirectory() as folder:
        for name, text in (("before", before), ("after", after)):
            (Path(folder) / name).write_text(text, encoding="utf-8")
        command = ["git", "diff", "--no-index", "--numstat", "before", "after"]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    return sum(int(field) for field in done.stdout.split()[:2])


if __name__ == "__main__":
    command_line(__doc__).parse_args()
    main()
