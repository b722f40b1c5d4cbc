# SPDX-License-Identifier: Apache-2.0
"""Checks of an installed package from another folder that has folders named like the package's."""

from __future__ import annotations

import json
import os
import subprocess
from collections.abc import Sequence
from pathlib import Path

FOLDER = "my محور work"
NAMED_ALIKE = ("models", "runtime", "codegen", "generated", "papers")
ALONE: tuple[tuple[str, int], ...] = (
    ("mehvar --version", 0),
    ("python -m mehvar list", 0),
)
"""Commands in separate processes, with their exit status."""
STEPS: tuple[tuple[str, int], ...] = (
    ("mehvar simulate triangle --controller path --t-end 1 --out run.nc", 0),
    ("mehvar new wheel", 0),
)
FURTHER: tuple[tuple[str, int], ...] = (
    ("mehvar batch triangle --controller path -n 100 --t-end 1 --vary theta_0=uniform(0.9,1.1) --out runs.zarr", 0),
    ("mehvar stats runs.zarr", 0),
    ("mehvar show triangle", 0),
    ("mehvar batch triangle --controller path -n 100 --t-end 1 --vary m1=uniform(0.9,1.1) --out runs.zarr", 2),
    ("mehvar simulate --from runs.zarr --run 7", 0),
    ("mehvar simulate triangle --controller path --t-end 1 --set backend=casadi", 0),
    ("mehvar generate triangle --structure masses=general --out general", 0),
    ("mehvar diff general general", 0),
    ("mehvar diff --paper", 2),
    ("mehvar reproduce", 2),
)
"""Further steps on the files of `STEPS`."""
OWN: tuple[tuple[str, int], ...] = (
    ("mehvar generate --check", 0),
    ("mehvar generate", 0),
    ("mehvar simulate generated/wheel --controller balance", 0),
    ("mehvar batch generated/wheel --controller balance -n 10 --out wheels.zarr", 0),
)


PROGRAM = """
import importlib, json, os, sys, tempfile
for name in ("casadi", "pandas", "pydantic", "rich.console", "scipy.integrate", "sympy", "xarray", "zarr"):
    importlib.import_module(name)
answers = []
for words, place in json.load(sys.stdin):
    said = tempfile.TemporaryFile()
    if not (child := os.fork()):
        break
    status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    said.seek(0)
    answers.append((status, said.read().decode(errors="replace")))
else:
    print(json.dumps(answers))
    sys.exit()
os.chdir(place)
os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
os.dup2(said.fileno(), 1)
os.dup2(said.fileno(), 2)
sys.argv, sys.path = words, [folder for folder in sys.path if folder]
from mehvar.__main__ import main
main()
"""
"""Each command as a fork of a process that has imported the libraries: a second each."""


def walk(programs: Path, place: Path, further: Sequence[tuple[str, int]] = FURTHER) -> list[str]:
    """Run steps with the programs of an environment; return the failures."""
    folder = place / FOLDER
    for name in NAMED_ALIKE:
        (folder / name).mkdir(parents=True)
        (folder / name / "__init__.py").write_text("raise RuntimeError('the wrong package')\n")
    home = place / "home"
    home.mkdir()
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "MEHVAR", "XDG"))}
    # the libraries' own folders may be read-only
    kept["PYTHONPYCACHEPREFIX"] = os.environ.get("PYTHONPYCACHEPREFIX") or str(home / "bytecode")
    environment = {**kept, "HOME": str(home), "PATH": f"{programs}{os.pathsep}{os.environ['PATH']}"}

    def done(words: list[str], text: str = "") -> tuple[int, str]:
        run = subprocess.run(
            words, cwd=folder, env=environment, input=text, capture_output=True, text=True, check=False, timeout=900
        )
        return run.returncode, run.stdout + run.stderr

    alone = [done(command.split()) for command, _ in ALONE]
    here = (*STEPS, *further)
    steps = [*((command, folder) for command, _ in here), *((command, folder / "wheel") for command, _ in OWN)]
    program = ["python", "-W", "ignore:This process:DeprecationWarning", "-c", PROGRAM]  # of forks, from Python 3.12 on
    status, text = done(program, json.dumps([(words.split(), str(at)) for words, at in steps]))
    if status:
        return [text]
    return [
        f"{command}: exit {status}, not {wanted}\n{text}"
        for (command, wanted), (status, text) in zip((*ALONE, *here, *OWN), (*alone, *json.loads(text)), strict=True)
        if status != wanted or "Traceback" in text
    ]
