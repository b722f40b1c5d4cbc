# SPDX-License-Identifier: Apache-2.0
"""Shared libraries, compiled once per sources, flags, compiler and machine."""

from __future__ import annotations

import ctypes
import functools
import os
import platform
import shlex
import sys
import tempfile
import threading
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path

from mehvar.base import cache
from mehvar.base.errors import BuildError, InputError

from .compiler import Compiler, require_compiler, run_compiler, write_sources

NATIVE = Path(__file__).parents[1] / "native"
INCLUDE = NATIVE / "include"
"""Folder of headers for generated C, for `cc -I`."""
_KIND = "libraries"
_BESIDE: list[threading.Thread] = []
"""Thread that compiles the native loop. A thread is used instead of a lock, which would stay locked in the child of a
fork.
"""
_BEGINNING = threading.Lock()
_UNITS = ("single.c", "journal.c", "tableaux.c", "map.c", "noise.c")

ENDING = {"win32": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")
"""Ending of shared libraries' names."""

# No flag here changes a result: no contraction, no reassociation, NaN and infinity as in IEEE 754.
FLAGS = (
    "-std=gnu11",
    *(() if sys.platform == "win32" else ("-fPIC",)),  # code for Windows can lie anywhere, and clang refuses the flag
    "-shared",
    "-ffp-contract=off",
    "-fno-math-errno",
    "-fno-trapping-math",
)


def compiled(name: str, sources: Mapping[str, str], units: Sequence[str], flags: Sequence[str] = ("-O2",)) -> Path:
    """Return a shared library's file; compile it unless the cache has it.

    Parameters
    ----------
    name : str
        Start of the file name in the cache.
    sources : mapping of str to str
        Path to text, headers included.
    units : sequence of str
        The names in `sources` that are compiled.
    flags : sequence of str
        Added to `FLAGS`.

    Raises
    ------
    InputError
        If there is no compiler, $CC does not work, or $MEHVAR_CACHE cannot be written.
    BuildError
        If compilation fails.
    """
    compiler = require_compiler()
    options, file = (*FLAGS, *flags, *compiler.flags, *units), f"{name}{ENDING}"
    command = [*compiler.command, *options, "-o", file, "-lm"]
    texts = (text for item in sorted(sources.items()) for text in item)
    machine = (sys.platform, platform.machine())
    entry = f"{name}-{cache.key(*machine, compiler.version, *compiler.command[1:], *options, *texts)}"

    return cache.entry(_KIND, entry, lambda folder: _compile(folder, file, sources, command, compiler)) / file


def load_library(
    name: str, sources: Mapping[str, str], units: Sequence[str], flags: Sequence[str] = ("-O2",)
) -> ctypes.CDLL:
    """Load the library that `compiled` makes from these sources, whose calls release Python's lock.

    Raises
    ------
    InputError, BuildError
        As `compiled`, or if loading fails.
    """
    path = compiled(name, sources, units, flags)
    with suppress(OSError):
        return ctypes.CDLL(str(path))
    cache.discard(path.parent)  # the file is intact but the loader refused it; a new one may load
    path = compiled(name, sources, units, flags)
    try:
        return ctypes.CDLL(str(path))
    except OSError as error:
        raise BuildError(
            f"cannot load {path}: {error}; if that folder forbids programs, set $MEHVAR_CACHE to another one"
        ) from error


def native_headers() -> dict[str, str]:
    """Return the headers that generated C includes, by path below `INCLUDE`."""
    paths = sorted(INCLUDE.rglob("*.h"))
    return {path.relative_to(INCLUDE).as_posix(): path.read_text(encoding="utf-8") for path in paths}


def native_sources(*patterns: str) -> dict[str, str]:
    """Return C files of `native` by file name, as a compilation has them in one folder."""
    paths = [path for pattern in patterns for path in sorted(NATIVE.glob(pattern))]
    return {path.name: path.read_text(encoding="utf-8") for path in paths}


def load_native() -> ctypes.CDLL:
    """Load the native loop of single runs, the methods, the noise and the array map, which no model affects."""
    for thread in _BESIDE:
        thread.join()
    return _native()


def begin_native() -> None:
    """Compile or load the native loop in the background; its errors come from `load_native`."""

    def begin() -> None:
        with suppress(BuildError, InputError, OSError):
            _native()

    with _BEGINNING:
        if not _BESIDE:
            thread = threading.Thread(target=begin)
            thread.start()
            _BESIDE.append(thread)


def _free() -> None:
    """Release the lock in the child of a fork, in which the thread that held it does not exist."""
    if _BEGINNING.locked():
        _BEGINNING.release()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_free)


@functools.cache
def _native() -> ctypes.CDLL:
    sources = native_sources("step/*.h", "single/*.[ch]", "methods/*.[ch]", "methods/*.inc", "random/*.[ch]", "map.c")
    return load_library("native", native_headers() | sources, _UNITS)


def _compile(folder: Path, file: str, sources: Mapping[str, str], command: Sequence[str], compiler: Compiler) -> None:
    """Compile in a temporary folder next to the library, and move only the result."""
    with tempfile.TemporaryDirectory(dir=folder) as name:
        scratch = Path(name)
        write_sources(scratch, sources)
        report = run_compiler(command, scratch, "the C compiler failed")
        if not (scratch / file).is_file():
            if compiler.origin == "$CC":
                cc = shlex.join(compiler.command)
                raise InputError(f"$CC = {cc!r}: must be a C compiler, but it wrote no file: {report}")
            raise BuildError(f"the C compiler wrote no file: {report}")
        (scratch / file).replace(folder / file)
