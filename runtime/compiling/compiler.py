# SPDX-License-Identifier: Apache-2.0
"""Search for the installed C compiler."""

from __future__ import annotations

import functools
import importlib.util
import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from mehvar.base.cache import cache_folder
from mehvar.base.errors import BuildError, InputError, MissingError

_PATH_NAMES = ("cc", "clang", "gcc")
_VERSION_TIMEOUT = 60.0
"""Seconds to wait for a compiler's version; the first start of zig unpacks files."""


@dataclass(frozen=True)
class Compiler:
    """A C compiler: its start command and the first line of its version.

    Parameters
    ----------
    command : tuple of str
        Program and leading arguments.
    version : str
        Part of the key of every compiled file.
    origin : str
        Its origin: "$CC", "PATH" or "the ziglang package".
    """

    command: tuple[str, ...]
    version: str
    origin: str

    @property
    def flags(self) -> tuple[str, ...]:
        """Flags that make this compiler behave like the others."""
        zig = [Path(word).stem for word in self.command[-2:-1]] in (["ziglang"], ["zig"])
        return ("-mcpu=baseline", "-fno-sanitize=undefined") if zig else ()

    @property
    def scheduling(self) -> tuple[str, ...]:
        """Flags with which gcc orders long straight-line code so that values stay in registers."""
        return () if self._clang else ("-fschedule-insns", "-fsched-pressure")

    @property
    def copies_registers(self) -> bool:
        """True for gcc from 12 on, which can copy vectors of several registers one register at a time."""
        version = re.search(r"(\d+)\.\d+\.\d+", self.version)
        return not self._clang and version is not None and int(version[1]) >= 12

    @property
    def _clang(self) -> bool:
        return "clang" in self.version.lower() or bool(self.flags)


def find_compiler() -> Compiler | None:
    """Return the compiler: $CC, else cc, clang or gcc on the path, else the package ziglang, else None.

    Raises
    ------
    InputError
        If $CC is set but cannot be started.
    """
    return _find(os.environ.get("CC", ""), os.environ.get("PATH", ""))


def require_compiler() -> Compiler:
    """Return the compiler, or raise MissingError with instructions to install one."""
    compiler = find_compiler()
    if compiler is None:
        raise MissingError(
            'no C compiler found: set $CC, install gcc or clang, or run: pip install "mehvar[cc]". '
            "Functions work without one: load(..., backend='python')"
        )
    return compiler


def environment(scratch: Path) -> dict[str, str]:
    """Return environment variables for compiling, which put zig's caches into mehvar's unless the user has set them."""
    zig = {"ZIG_GLOBAL_CACHE_DIR": str(cache_folder() / "zig"), "ZIG_LOCAL_CACHE_DIR": str(scratch / "zig")}
    return {**zig, **os.environ}


def write_sources(folder: Path, texts: Mapping[str, str]) -> None:
    """Write files into a folder, by their paths."""
    for name, text in texts.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8", newline="\n")


def run_compiler(command: Sequence[str], folder: Path, failure: str) -> str:
    """Run a compiler in a folder that is removed afterwards, and return its report.

    Raises
    ------
    BuildError
        If it fails; the message is `failure` with the report.
    """
    process = subprocess.run(
        command, cwd=folder, env=environment(folder), capture_output=True, text=True, errors="replace",
        check=False, stdin=subprocess.DEVNULL,
    )  # fmt: skip
    output = process.stderr or process.stdout
    report = f"exit status {process.returncode}\n$ {shlex.join(command)}\n{output}".rstrip()
    if process.returncode != 0:
        raise BuildError(f"{failure}: {report}")
    return report


@functools.cache
def _find(cc: str, _path: str) -> Compiler | None:
    """Return the compiler of $CC, else the first that starts of PATH and the ziglang package."""
    if cc.strip():
        command = _words(cc)
        version = version_of(command)
        if version is None:
            raise InputError(f"$CC = {cc!r}: must start a C compiler, but it does not start")
        return Compiler(command, version, "$CC")
    commands: list[tuple[tuple[str, ...], str]]
    commands = [((program,), "PATH") for program in filter(None, map(shutil.which, _PATH_NAMES))]
    if importlib.util.find_spec("ziglang"):
        commands.append(((sys.executable, "-m", "ziglang", "cc"), "the ziglang package"))
    versions = ((version_of(command), command, origin) for command, origin in commands)
    return next((Compiler(command, version, origin) for version, command, origin in versions if version), None)


def _words(command: str) -> tuple[str, ...]:
    try:
        return tuple(shlex.split(command))
    except ValueError as error:
        raise InputError(f"$CC = {command!r}: must be a command line ({error})") from error


def version_of(command: tuple[str, ...]) -> str | None:
    """Return the first line of a compiler's `--version`; None if it does not start, fails or prints nothing."""
    try:
        process = subprocess.run(
            [*command, "--version"],
            capture_output=True,
            text=True,
            timeout=_VERSION_TIMEOUT,
            check=False,
            stdin=subprocess.DEVNULL,
        )
    except (OSError, subprocess.TimeoutExpired, ValueError):
        return None
    lines = process.stdout.strip().splitlines()
    return lines[0] if process.returncode == 0 and lines else None
