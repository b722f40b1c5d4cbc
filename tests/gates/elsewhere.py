# SPDX-License-Identifier: Apache-2.0
"""Checks of an installed package from another folder, beside folders named like its packages."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

FOLDER = "my محور work"
NAMED_ALIKE = ("models", "runtime", "codegen", "generated", "papers")
STEPS: tuple[tuple[str, int], ...] = (  # command and exit status
    ("mehvar --version", 0),
    ("mehvar list", 0),
    ("mehvar show triangle", 0),
    ("mehvar simulate triangle --controller path --t-end 1 --out run.nc", 0),
    ("python -m mehvar list", 0),
    ("mehvar batch triangle --controller path -n 100 --t-end 1 --vary m1=uniform(0.9,1.1) --out runs.zarr", 2),
    ("mehvar batch triangle --controller path -n 100 --t-end 1 --vary theta_0=uniform(0.9,1.1) --out runs.zarr", 0),
    ("mehvar stats runs.zarr", 0),
    ("mehvar simulate --from runs.zarr --run 7", 0),
    ("mehvar simulate triangle --controller path --t-end 1 --set backend=casadi", 0),
    ("mehvar generate triangle --structure masses=general --out general", 0),
    ("mehvar diff general general", 0),
    ("mehvar diff --paper", 2),
    ("mehvar reproduce", 2),
    ("mehvar new wheel", 0),
)
OWN: tuple[tuple[str, int], ...] = (
    ("mehvar generate --check", 0),
    ("mehvar generate", 0),
    ("mehvar simulate generated/wheel --controller balance", 0),
    ("mehvar batch generated/wheel --controller balance -n 10 --out wheels.zarr", 0),
)


def walk(programs: Path, place: Path) -> list[str]:
    """Run all steps with the programs of an environment; return what went wrong."""
    folder = place / FOLDER
    for name in NAMED_ALIKE:
        (folder / name).mkdir(parents=True)
        (folder / name / "__init__.py").write_text("raise RuntimeError('the wrong package')\n")
    home = place / "home"
    home.mkdir()
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "MEHVAR", "XDG"))}
    kept["PYTHONPYCACHEPREFIX"] = str(home / "bytecode")  # the libraries' own folders may be read-only
    environment = {**kept, "HOME": str(home), "PATH": f"{programs}{os.pathsep}{os.environ['PATH']}"}
    wrong = []
    for steps, where in ((STEPS, folder), (OWN, folder / "wheel")):
        for command, status in steps:
            done = subprocess.run(
                command.split(), cwd=where, env=environment, capture_output=True, text=True, check=False, timeout=300
            )
            if done.returncode != status or "Traceback" in done.stderr:
                wrong.append(f"{command}: exit {done.returncode}, not {status}\n{done.stdout}{done.stderr}")
    return wrong
