# SPDX-License-Identifier: Apache-2.0
"""`mehvar doctor`: installed and missing tools, with the commands that install them."""

from __future__ import annotations

import platform
import re
import shutil
import sys
from collections.abc import Sequence

import typer

from mehvar.base.cache import cache_folder
from mehvar.base.errors import InputError
from mehvar.base.versions import extra_of, installed
from mehvar.runtime.compiling.compiler import find_compiler
from mehvar.runtime.compiling.library import INCLUDE
from mehvar.settings import AsJson
from mehvar.terminal import print_json, print_table

_PACKAGES = {
    "numpy": "every run",
    "scipy": "designs of batches, statistics, trim, fits, stiff runs under a law in Python",
    "xarray": "results",
    "h5netcdf": "result files",
    "sympy": "derivation",
    "casadi": "code generation",
    "zarr": "batches",
    "pandas": "result files as CSV",
    "pint": "units in values, as in --set theta_0=30deg",
    "pyarrow": "result files as Parquet",
    "matplotlib": "pictures and the report",
    "distributed": "batches on many machines",
    "ziglang": "the board: a cross-compiler",
    "control": "linear systems in python-control",
    "jax": "right-hand sides in JAX",
    "numba": "right-hand sides in Numba",
    "unicorn": "the board: an emulator",
    "pyserial": "the board: a serial port",
}
_EXTRA = re.compile(r'pip install "mehvar\[(\w+)\]"')
_COLUMNS = ("part", "found", "used_for", "install_with")
_PROGRAMS = {
    "arm-none-eabi-gcc": ("the board: a second toolchain", "apt install gcc-arm-none-eabi"),
    "qemu-system-arm": ("the board: a second emulator", "apt install qemu-system-arm"),
}


def command(as_json: AsJson = False) -> int:
    """Print the state of this installation; return 1 if a run lacks something."""
    rows = [["python", platform.python_version(), sys.executable, ""], _compiler_row()]
    rows += [_package_row(name, use) for name, use in _PACKAGES.items()]
    rows += [_program_row(name, *about) for name, about in _PROGRAMS.items()]
    rows.append(["C headers", str(INCLUDE), "for generated C in other projects: cc -I", ""])
    rows.append(["cache", str(cache_folder()), "compiled models; safe to delete", ""])
    if as_json:
        print_json({"parts": [dict(zip(_COLUMNS, row, strict=True)) for row in rows]})
    else:
        print_table("", [name.replace("_", " ") for name in _COLUMNS], rows)
        _print_summary(rows)
    missing = [row[0] for row in rows if row[1] in ("missing", "does not work")]
    return int(bool(missing))


def _print_summary(rows: Sequence[Sequence[str]]) -> None:
    """Print the available features, and one install command per package manager for the rest."""
    uses = {name: row[2] for row in rows if (name := row[0]) in (*_PACKAGES, *_PROGRAMS) and not row[3]}
    typer.echo(f"\nworks: {'; '.join(dict.fromkeys(uses.values()))}")
    extras = {match[1] for row in rows if (match := _EXTRA.fullmatch(row[3]))}
    others = [row[3] for row in rows if row[3] and not _EXTRA.fullmatch(row[3])]
    ours = [f'pip install "mehvar[{",".join(sorted(extras))}]"'] if extras else []
    for command in (*ours, *others):
        typer.echo(f"for the rest: {command}")


def _compiler_row() -> list[str]:
    """Return the row of the C compiler: tool, version or state, command or use, and what installs it."""
    try:
        compiler = find_compiler()
    except InputError as error:
        return ["C compiler", "does not work", str(error), ""]
    if compiler is None:
        return [
            "C compiler",
            "missing",
            "runs; without a compiler only functions can be evaluated, by the Python module",
            'pip install "mehvar[cc]"',
        ]
    return ["C compiler", compiler.version, " ".join(compiler.command), ""]


def _program_row(name: str, use: str, install: str) -> list[str]:
    path = shutil.which(name)
    return [name, path or "not installed", use, "" if path else install]


def _package_row(name: str, use: str) -> list[str]:
    if number := installed(name).get(name):
        return [name, number, use, ""]
    if extra := extra_of(name):
        return [name, "not installed", use, f'pip install "mehvar[{extra}]"']
    return [name, "missing", use, f"pip install {name}"]
