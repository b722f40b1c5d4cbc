# SPDX-License-Identifier: Apache-2.0
"""From C text to a loaded library, compiled once per content.

The key of a library is the hash of everything that decides its bytes: sources, flags, compiler, machine. A
digest beside each library tells a complete file from a damaged one before the loader maps it.
"""

from __future__ import annotations

import ctypes
import functools
import hashlib
import os
import platform
import shlex
import shutil
import stat
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

from mehvar.errors import BuildError, InputError

from ..files import write_atomic
from .compiler import Compiler, require_compiler

NATIVE = Path(__file__).parents[1] / "native"
_TRIES = 3
_UNITS = ("single.c", "tableaux.c", "map.c", "noise.c")

# No flag here changes a result: no contraction, no reassociation, NaN and infinity as IEEE 754 has them.
FLAGS = (
    "-std=gnu11",
    "-fPIC",
    "-shared",
    "-ffp-contract=off",
    "-fno-math-errno",
    "-fno-trapping-math",
)


def load_library(
    name: str, sources: Mapping[str, str], units: Sequence[str], flags: Sequence[str] = ("-O2",)
) -> ctypes.CDLL:
    """Compile C sources into a shared library unless the cache has it, and load it.

    Parameters
    ----------
    name : str
        Start of the file name in the cache.
    sources : mapping of str to str
        File name to text, headers included.
    units : sequence of str
        The names in `sources` that are compiled.
    flags : sequence of str
        Added to `FLAGS`.

    Returns
    -------
    ctypes.CDLL
        Its calls release the interpreter lock.

    Raises
    ------
    InputError
        If there is no compiler, $CC does not work, or $MEHVAR_CACHE cannot be written.
    BuildError
        If compilation or loading fails.
    """
    compiler = require_compiler()
    flags = (*FLAGS, *flags, *compiler.flags)
    file = f"{name}-{_key(sources, units, flags, compiler)}.so"
    for folder in filter(_is_ours, _cache_folders()):
        library = _load_cached(folder / file)
        if library is not None:
            return library
    command = [*compiler.command, *flags, *units, "-o", file, "-lm"]
    path = _compile(cache_folder() / file, sources, command, compiler)
    try:
        return ctypes.CDLL(str(path))
    except OSError as error:
        raise BuildError(
            f"cannot load {path}: {error}; if programs may not run there, set $MEHVAR_CACHE elsewhere"
        ) from error


def native_headers() -> dict[str, str]:
    """Return the headers that generated C includes, by file name."""
    return {path.name: path.read_text(encoding="utf-8") for path in sorted(NATIVE.glob("mehvar_*.h"))}


def native_sources(*patterns: str) -> dict[str, str]:
    """Return C files of `native` by file name: a compilation has them side by side."""
    paths = [path for pattern in patterns for path in sorted(NATIVE.glob(pattern))]
    return {path.name: path.read_text(encoding="utf-8") for path in paths}


@functools.cache
def load_native() -> ctypes.CDLL:
    """Load the loop of a single run, the methods, the noise and the array map, which know no model."""
    sources = native_sources("step/*.h", "single/*.[ch]", "methods/*.[ch]", "methods/*.inc", "random/*.[ch]", "map.c")
    return load_library("native", native_headers() | sources, _UNITS)


def cache_folder() -> Path:
    """Return the folder that new libraries go to, made if necessary.

    It is $MEHVAR_CACHE, or `mehvar` below $XDG_CACHE_HOME or ~/.cache, or else a private temporary folder.

    Raises
    ------
    InputError
        If $MEHVAR_CACHE is set and cannot be written.
    """
    reasons = []
    for folder in _cache_folders():
        try:
            folder.mkdir(parents=True, exist_ok=True, mode=0o700)
            tempfile.TemporaryFile(dir=folder).close()
        except OSError as error:
            reasons.append(f"{folder}: {error.strerror or error}")
            continue
        if _is_ours(folder):
            return folder
    if os.environ.get("MEHVAR_CACHE"):
        raise InputError(f"$MEHVAR_CACHE must be a folder that can be written: {reasons[0]}")
    return Path(tempfile.mkdtemp(prefix="mehvar-"))


def _key(sources: Mapping[str, str], units: Sequence[str], flags: Sequence[str], compiler: Compiler) -> str:
    digest = hashlib.sha256()
    parts = [sys.platform, platform.machine(), compiler.version, *compiler.command[1:], *flags, *units]
    for name in sorted(sources):
        parts += [name, sources[name]]
    for part in parts:
        text = part.encode()
        digest.update(len(text).to_bytes(8, "little") + text)
    return digest.hexdigest()[:32]


def _cache_folders() -> list[Path]:
    """Return the folders that may hold a library, the preferred one first."""
    chosen = os.environ.get("MEHVAR_CACHE")
    if chosen:
        return [Path(chosen).expanduser().absolute()]
    base = os.environ.get("XDG_CACHE_HOME")
    home = Path(base) if base and Path(base).is_absolute() else _home() / ".cache"
    return [home / "mehvar", _shared_temporary()]


def _home() -> Path:
    try:
        return Path.home()
    except RuntimeError:  # a user without a home
        return _shared_temporary()


def _shared_temporary() -> Path:
    user = str(os.getuid()) if hasattr(os, "getuid") else os.environ.get("USERNAME", "user")
    return Path(tempfile.gettempdir()) / f"mehvar-{user}"


def _is_ours(folder: Path) -> bool:
    """Whether nobody else can have put a library into a folder below a temporary folder that all share."""
    if folder != _shared_temporary() or not hasattr(os, "getuid"):
        return True
    try:
        status = folder.lstat()
    except OSError:
        return False
    return stat.S_ISDIR(status.st_mode) and status.st_uid == os.getuid() and not status.st_mode & 0o022


def _digest_path(library: Path) -> Path:
    return library.with_suffix(".sha256")


def _load_cached(path: Path) -> ctypes.CDLL | None:
    """Load a library whose digest fits; None when it is absent, damaged or refused by the loader."""
    try:
        expected = _digest_path(path).read_text(encoding="ascii", errors="replace")
        if hashlib.sha256(path.read_bytes()).hexdigest() != expected:
            return None
        return ctypes.CDLL(str(path))
    except OSError:
        return None


def _compile(path: Path, sources: Mapping[str, str], command: Sequence[str], compiler: Compiler) -> Path:
    """Compile in a folder of its own beside `path`, then rename into place; again if somebody empties the cache."""
    for _ in range(_TRIES):
        path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        folder = Path(tempfile.mkdtemp(prefix="build-", dir=path.parent))
        try:
            return _compile_in(folder, path, sources, command, compiler)
        except (BuildError, FileNotFoundError):
            if folder.is_dir():
                raise
        finally:
            shutil.rmtree(folder, ignore_errors=True)
    raise BuildError(f"the folder {path.parent} vanished during each of {_TRIES} compilations")


def _compile_in(
    folder: Path, path: Path, sources: Mapping[str, str], command: Sequence[str], compiler: Compiler
) -> Path:
    zig = {"ZIG_GLOBAL_CACHE_DIR": str(path.parent / "zig"), "ZIG_LOCAL_CACHE_DIR": str(folder)}
    for name, text in sources.items():
        (folder / name).write_text(text, encoding="utf-8")
    done = subprocess.run(
        command,
        cwd=folder,
        env={**zig, **os.environ},
        capture_output=True,
        text=True,
        errors="replace",
        check=False,
        stdin=subprocess.DEVNULL,
    )
    built = folder / path.name
    if done.returncode != 0 or not built.is_file():
        raise _failure(command, done, compiler)
    digest = hashlib.sha256(built.read_bytes()).hexdigest()
    built.replace(path)
    write_atomic(_digest_path(path), digest)
    return path


def _failure(
    command: Sequence[str], done: subprocess.CompletedProcess[str], compiler: Compiler
) -> InputError | BuildError:
    report = f"exit status {done.returncode}\n$ {shlex.join(command)}\n{done.stderr or done.stdout}".rstrip()
    if done.returncode == 0 and compiler.origin == "$CC":
        chosen = shlex.join(compiler.command)
        return InputError(f"$CC = {chosen!r}: must be a C compiler, but it wrote no file: {report}")
    return BuildError(f"the C compiler failed: {report}")
