# SPDX-License-Identifier: Apache-2.0
"""Write docs/reference/mistakes.md: commands that newcomers get wrong, with the answers of this version."""

from __future__ import annotations

import contextlib
import io
import os
import re
import shlex
import sys
import tempfile
from pathlib import Path

from mehvar import __main__

PAGE = Path(__file__).parents[1] / "reference" / "mistakes.md"
_HEAD = """# Answers to mistakes

Commands that people get wrong in their first hour. Each ends with exit status 2 and writes nothing; several mistakes in
one command are named together. `python -m docs.site.mistakes` writes this page.

| command | answer |
|---|---|
"""
COMMANDS = """\
mehvar simulat triangle
mehvar simulate
mehvar simulate triangel --controller path
mehvar simulate triangle
mehvar simulate triangle --set foo=1
mehvar simulate triangle --controler path
mehvar simulate triangle --controller pat
mehvar simulate triangle --controller path --scenario papr
mehvar simulate triangle --controller path --set R
mehvar simulate triangle --controller path --set R =0.5
mehvar simulate triangle --controller path --set R=0,5
mehvar simulate triangle --controller path --set R=9
mehvar simulate triangle --controller path --set R=nan
mehvar simulate triangle --controller path --set theta_0=30kg
mehvar simulate triangle --controller path --set theta0=1
mehvar simulate triangle --controller path --set R=0.6 --set R=0.5
mehvar simulate triangle --controller path --t-end ten
mehvar simulate triangle --controller path --set t_end=0
mehvar simulate triangle --controller path --set method=rk45
mehvar simulate triangle --controller path --set step=0.01
mehvar simulate triangle --controller path --set delay=1
mehvar simulate triangle --controller path --set backend=gpu
mehvar simulate triangle --controller path --out /no/where/run.nc
mehvar simulate triangle --controller path --out run.xlsx
mehvar simulate triangle --controller path --plot run.bmp
mehvar simulate triangle --controller path --input w1=1
mehvar simulate triangle --controller none --input q=1
mehvar simulate triangle --controller none --inputs no.csv
mehvar simulate --from runs.zarr
mehvar batch triangle
mehvar batch triangle --controller path -n 0 --out a.zarr
mehvar batch triangle --controller path -n 10 --out a.zarr --vary theta_0
mehvar batch triangle --controller path -n 10 --out a.zarr --vary "theta_0=normal(1)"
mehvar batch triangle --controller path -n 10 --out a.zarr --vary "theta_0=gaussian(0, 1)"
mehvar batch triangle --controller path -n 10 --out a.zarr --success "T_theta"
mehvar batch no.toml
mehvar stats runs.zarr
mehvar convert run.nc --to excel --out run.xlsx
mehvar export fmu triangle
mehvar new triangle
mehvar new 2wheels
mehvar generate
mehvar board run triangle
mehvar -v
mehvar simulate triangle --controller path --scenario papr --set R --out /no/where/run.nc
""".splitlines()
_LONGEST = 160
"""Largest number of characters of an answer; a list of all parameters would fill the page."""


def page() -> str:
    """Return the text of the page."""
    return _HEAD + "".join(f"{row(command)}\n" for command in COMMANDS)


def row(command: str) -> str:
    """Return a command and its answer as a row of the table."""
    lines = "<br>".join(f"`{line}`" for line in answer(command))
    return f"| `{command}` | {lines} |"


def answer(command: str) -> list[str]:
    """Return the lines of the refusal, without usage and program name."""
    status, printed = _refused(command)
    if status != 2:
        raise AssertionError(f"{command}: exit status {status}\n{printed}")
    lines = [re.sub(r"^(mehvar|Error): ", "", line.strip()) for line in printed.splitlines()]
    shown = [line for line in lines if line and not line.startswith(("Usage: ", "Try "))]
    return [line if len(line) <= _LONGEST else f"{line[:_LONGEST].rpartition(' ')[0]} ..." for line in shown]


def _refused(command: str) -> tuple[object, str]:
    """Run a command in this process, in an empty folder, and return its exit status and its messages."""
    printed, place, arguments = io.StringIO(), Path.cwd(), sys.argv
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        sys.argv = shlex.split(command)
        try:
            with contextlib.redirect_stderr(printed):
                __main__._run()
            status: object = 0
        except SystemExit as end:
            status = end.code
        finally:
            os.chdir(place)
            sys.argv = arguments
        written = sorted(Path(folder).iterdir())
    return (f"wrote {written}" if written else status), printed.getvalue()


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
