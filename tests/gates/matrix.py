# SPDX-License-Identifier: Apache-2.0
"""The wheel with the oldest and the newest libraries, on every supported Python; `make matrix` writes its page.

Needs the package index. Interpreters are looked for on $PATH and in the folders of $MEHVAR_PYTHONS.
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
import time
import tomllib
from pathlib import Path

from elsewhere import walk

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "benchmarks" / "results" / "matrix.md"
CASES = (
    ("3.11", "oldest"),
    ("3.12", "oldest"),
    ("3.11", "newest"),
    ("3.12", "newest"),
    ("3.13", "newest"),
    ("3.14", "newest"),
)
MODELS = ("triangle", "slosh", "satellite")
SHOWN = ("numpy", "scipy", "sympy", "casadi")
TESTS = (
    "tests/runtime/model/test_model.py",
    "tests/runtime/run/test_simulate.py",
    "tests/runtime/run/test_results.py",
    "tests/runtime/batch/store/test_store.py",
    "tests/codegen/functions/test_lower.py",
    "tests/codegen/code/test_tape.py",
    "tests/models/test_tables.py",
    "tests/mehvar/test_package.py",
)


def main() -> None:
    with tempfile.TemporaryDirectory() as scratch:
        rows = [row(python, libraries, Path(scratch)) for python, libraries in CASES]
    revision = output(ROOT, "git", "describe", "--always", "--dirty")
    lines = [
        "# Pythons and libraries",
        "",
        f"Written by `make matrix` on {time.strftime('%Y-%m-%d')}, revision {revision}.",
        "",
        "Oldest libraries are the lowest versions that `pyproject.toml` declares, newest those of the package index",
        "that day. The wheel is installed into an empty environment and used from another folder",
        "(`tests/gates/elsewhere.py`). Then every model is derived again: `mehvar diff` compares its equations with",
        "the committed ones, and every function is evaluated on both sides at random points; the difference is",
        "relative to the largest result of a function where above 1.",
        "",
        "| Python | libraries | " + " | ".join(SHOWN) + " | elsewhere | equations | difference | tests |",
        "|---|---|" + "---|" * (len(SHOWN) + 4),
        *rows,
    ]
    PAGE.write_text("\n".join(lines) + "\n", encoding="utf-8")
    sys.exit(any("fail" in line or "differ" in line for line in rows))


def row(version: str, libraries: str, scratch: Path) -> str:
    """Return the line of one case."""
    interpreter = find(version)
    if interpreter is None:
        return f"| {version} | {libraries} | " + "- | " * len(SHOWN) + "not run: no such Python here | - | - | - |"
    place = scratch / f"{version}-{libraries}"
    programs = installed(interpreter, libraries, place)
    shown = f"from importlib.metadata import version\nfor name in {SHOWN}: print(version(name))"
    versions = output(place, programs / "python", "-c", shown).split()
    wrong = walk(programs, place)
    print(*wrong, sep="\n")
    equations, difference = regenerated(programs, place)
    cells = (*versions, "fails" if wrong else "works", equations, difference, tests(programs))
    line = f"| {version} | {libraries} | {' | '.join(cells)} |"
    print(line, flush=True)
    return line


def find(version: str) -> str | None:
    folders = os.pathsep.join([os.environ.get("MEHVAR_PYTHONS", ""), os.environ["PATH"]])
    found = shutil.which(f"python{version}", path=folders)
    works = found and subprocess.run([found, "--version"], capture_output=True, check=False).returncode == 0
    return found if works else None


def installed(interpreter: str, libraries: str, place: Path) -> Path:
    """Install the wheel with its extras into a new environment; return the folder of its programs."""
    place.mkdir()
    subprocess.run([interpreter, "-m", "venv", place / "env"], check=True)
    pip = [place / "env" / "bin" / "python", "-m", "pip", "--quiet", "--disable-pip-version-check"]
    subprocess.run([*pip, "wheel", "--no-deps", "-w", place, ROOT], check=True)
    (wheel,) = place.glob("*.whl")
    lowest = place / "lowest.txt"
    lowest.write_text("\n".join(floors()) + "\n")
    bounds = ["-c", lowest] if libraries == "oldest" else []
    wanted = [f"mehvar[all,cc] @ {wheel.as_uri()}", "hypothesis", "pytest", "pytest-xdist"]
    subprocess.run([*pip, "install", "--only-binary", ":all:", *bounds, *wanted], check=True)
    return place / "env" / "bin"


def floors() -> list[str]:
    """Return the lowest declared version of each requirement."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    declared = [*project["dependencies"], *(r for rs in project["optional-dependencies"].values() for r in rs)]
    found = (re.fullmatch(r"([\w-]+)>=([\d.]+)", requirement) for requirement in declared)
    return sorted({f"{match[1]}=={match[2]}" for match in found if match})


def regenerated(programs: Path, place: Path) -> tuple[str, str]:
    """Derive every model again; return the verdict on the equations and the largest difference of a number."""
    verdicts, largest = [], 0.0
    for model in MODELS:
        new = place / "derived" / model
        new.parent.mkdir(exist_ok=True)
        subprocess.run([programs / "mehvar", "generate", model, "--out", new], cwd=place, check=True)
        old = ROOT / "generated" / model
        if subprocess.run([programs / "mehvar", "diff", old, new], cwd=place, check=False).returncode:
            verdicts.append(model)
        numbers = output(place, programs / "python", Path(__file__).with_name("numbers_of.py"), old, new)
        largest = max(largest, json.loads(numbers))
    too_far = " differ" if not largest <= 1e-12 else ""
    return ("differ: " + ", ".join(verdicts) if verdicts else "equal"), f"{largest:.1e}{too_far}"


def tests(programs: Path) -> str:
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "PATH": f"{programs}{os.pathsep}{os.environ['PATH']}"}
    command = [programs / "python", "-m", "pytest", "-p", "no:cacheprovider", "-n", "0", *TESTS]
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
    if done.returncode:
        print(done.stdout[-8000:], done.stderr[-2000:])
    return re.sub(r" in .*", "", done.stdout.strip().splitlines()[-1])


def output(folder: Path, *command: str | Path) -> str:
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True).stdout.strip()


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__).parse_args()
    main()
