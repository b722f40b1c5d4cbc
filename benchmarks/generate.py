# SPDX-License-Identifier: Apache-2.0
"""Times of derivation, of a generation without changes, and of imports.

Run: python -m benchmarks.generate
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from functools import partial
from pathlib import Path

from benchmarks.machine import command_line, interleaved, machine, table, write

REPEATS = 9
COLD_REPEATS = 3


def main() -> None:
    """Measure, and write the page."""
    with tempfile.TemporaryDirectory() as scratch:
        outs = iter(range(COLD_REPEATS))
        cold = interleaved(
            {"cold": lambda: _mehvar(scratch, "generate", "triangle", "--out", f"cold{next(outs)}")}, COLD_REPEATS
        )
        warm = interleaved(
            {
                "python": partial(_python, scratch, "pass"),
                "import": partial(_python, scratch, "import mehvar"),
                "version": partial(_mehvar, scratch, "--version"),
                "unchanged": partial(_mehvar, scratch, "generate", "triangle", "--out", "cold0"),
            },
            REPEATS,
        )
        _require_unchanged(Path(scratch) / "cold0", scratch)
    rows = [
        ["`mehvar generate triangle`, nothing there yet", f"{cold['cold']:.2f}"],
        ["`mehvar generate triangle`, nothing changed", f"{warm['unchanged']:.2f}"],
        ["`mehvar --version`", f"{warm['version']:.2f}"],
        ["difference of the two lines above", f"{warm['unchanged'] - warm['version']:.2f}"],
        ["`import mehvar`, less starting Python", f"{warm['import'] - warm['python']:.2f}"],
    ]
    lines = [
        "# Derivation and code generation",
        "",
        "Written by `python -m benchmarks.generate`. Each time is that of a fresh process: the median of "
        f"{COLD_REPEATS} cold",
        f"ones and of {REPEATS} others, which take turns. The files of the packages are in the page cache.",
        "",
        "## Machine",
        "",
        *machine(),
        "",
        "## Times",
        "",
        *table(["command", "s"], rows),
    ]
    write("generate.md", lines)


def _mehvar(folder: str, *arguments: str) -> str:
    return _run(folder, "-m", "mehvar", *arguments)


def _python(folder: str, text: str) -> str:
    return _run(folder, "-c", text)


def _run(folder: str, *arguments: str) -> str:
    done = subprocess.run([sys.executable, *arguments], cwd=folder, capture_output=True, text=True, check=True)
    return done.stdout


def _require_unchanged(out: Path, scratch: str) -> None:
    """Refuse to report a time if the run without changes wrote files."""
    said = _mehvar(scratch, "generate", "triangle", "--out", str(out))
    if "up to date" not in said:
        raise SystemExit(f"expected 'up to date', got: {said}")


if __name__ == "__main__":
    command_line(__doc__).parse_args()
    main()
