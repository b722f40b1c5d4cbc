# SPDX-License-Identifier: Apache-2.0
"""Boards and their compilers."""

from __future__ import annotations

import functools
import importlib.util
import shutil
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field

from mehvar.base.errors import MissingError, bad_value, unknown_name

from ...compiling.compiler import require_compiler, version_of

KIB = 1024


@dataclass(frozen=True)
class Board:
    """A board: processor, memory, and available emulators.

    Attributes
    ----------
    name, title : str
        Identifier and full name.
    source : str
        Its file in firmware/boards.
    cpu : {"m3", "m4f", "m7"}
        Processor; the M3 computes floats in software.
    flash, ram : (int, int)
        First address and size, bytes.
    machine : str
        QEMU's name of it.
    hertz : int
        Clock of the processor.
    defines : mapping
        Macros that its file needs.
    """

    name: str
    title: str
    source: str
    cpu: str
    flash: tuple[int, int]
    ram: tuple[int, int]
    machine: str
    hertz: int
    defines: Mapping[str, int] = field(default_factory=dict)


_STM32 = {"source": "stm32f4.c", "cpu": "m4f", "flash": (0x08000000, 1024 * KIB), "ram": (0x20000000, 128 * KIB)}
_MPS2 = {"source": "mps2.c", "flash": (0, 4096 * KIB), "ram": (0x20000000, 4096 * KIB), "hertz": 25_000_000}
BOARDS = {
    board.name: board
    for board in (
        Board("stm32f4", "STM32F405, USART1", machine="netduinoplus2", hertz=168_000_000, **_STM32),  # type: ignore[arg-type]
        Board(
            "stm32f4-usart2", "STM32F405, USART2 (ST-Link of Nucleo boards)", machine="netduinoplus2",
            hertz=168_000_000, defines={"BOARD_USART": 2}, **_STM32,  # type: ignore[arg-type]
        ),
        Board("mps2-m3", "MPS2 AN385, Cortex-M3", cpu="m3", machine="mps2-an385", **_MPS2),  # type: ignore[arg-type]
        Board("mps2-m4f", "MPS2 AN386, Cortex-M4F", cpu="m4f", machine="mps2-an386", **_MPS2),  # type: ignore[arg-type]
        Board("mps2-m7", "MPS2 AN500, Cortex-M7", cpu="m7", machine="mps2-an500", **_MPS2),  # type: ignore[arg-type]
    )
}  # fmt: skip

# clang avoids vmla on the M4F unless told that it is not slow; a*b + c must round twice, as vmla does. It takes three
# cycles against two for vmul and vadd, but without it clang's images exceed 14 KiB, and gcc's do not.
_GCC_CPU = {
    "m3": ("-mcpu=cortex-m3", "-mfloat-abi=soft"),
    "m4f": ("-mcpu=cortex-m4", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"),
    "m7": ("-mcpu=cortex-m7", "-mfloat-abi=hard", "-mfpu=fpv5-sp-d16"),
}
_GCC_SMALL = (
    "-fno-trapping-math", "-fno-tree-pre", "-fno-if-conversion", "-fno-schedule-insns2", "-fno-inline-small-functions",
)  # fmt: skip
"""Flags for gcc that make a law's image smaller without slowing a step."""
_GCC_FOLDING = {"m4f": ("-mtune=cortex-a5",)}
"""Flag for a law with constant parameters. With it, gcc uses vmla as clang does.

Results are bit-identical, because vmla rounds twice. The adaptive law has 164 instructions and 644 bytes less but 313
estimated cycles more; the estimate ignores instruction fetches."""
_ZIG_CPU = {
    "m3": ("-target", "thumb-freestanding-eabi", "-mcpu=cortex_m3"),
    "m4f": ("-target", "thumb-freestanding-eabihf", "-mcpu=cortex_m4+vfp4d16sp-slowfpvmlx"),
    "m7": ("-target", "thumb-freestanding-eabihf", "-mcpu=cortex_m7+fp_armv8d16sp"),
}


@dataclass(frozen=True)
class Toolchain:
    """A compiler: "gcc" or "zig" (Python package ziglang) for another processor, or "host".

    `emulator` is the command that runs its programs on this machine; empty for this machine's own, and for boards.
    """

    name: str
    command: tuple[str, ...]
    version: str
    emulator: tuple[str, ...] = ()

    def flags(self, board: Board) -> tuple[str, ...]:
        """Return this compiler's options for a board."""
        if self.name == "gcc":
            return (*_GCC_CPU[board.cpu], "-mthumb", "-nostdlib", *_GCC_SMALL)
        return (*_ZIG_CPU[board.cpu], "-fno-sanitize=all", "-Xclang", "-Oz")  # zig makes -Os of a plain -Oz

    def folding(self, board: Board) -> tuple[str, ...]:
        """Return the compiler's additional options for a law with constant parameters."""
        return _GCC_FOLDING.get(board.cpu, ()) if self.name == "gcc" else ()

    @property
    def libraries(self) -> tuple[str, ...]:
        """Libraries to link: the compiler's arithmetic."""
        return ("-lgcc",) if self.name == "gcc" else ()


def board(name: str) -> Board:
    """Return a board by name, or raise InputError with the known ones."""
    if name not in BOARDS:
        raise unknown_name("board", name, BOARDS)
    return BOARDS[name]


def toolchain(name: str | None = None) -> Toolchain:
    """Return a cross compiler: the requested one, else gcc (smaller and faster code), else zig.

    Raises
    ------
    InputError
        If it is not known.
    MissingError
        If it is not installed; the message says how to install it.
    """
    if name not in (None, "zig", "gcc"):
        raise unknown_name("compiler", name, ("zig", "gcc"))
    for candidate in ("gcc", "zig") if name is None else (name,):
        compiler = _zig() if candidate == "zig" else _gcc()
        if compiler:
            return compiler
    if name == "gcc":
        raise MissingError("arm-none-eabi-gcc is not installed: apt-get install gcc-arm-none-eabi")
    raise MissingError('no compiler for ARM: pip install "mehvar[board]", or apt-get install gcc-arm-none-eabi')


def host_toolchain(name: str | None = None) -> Toolchain:
    """Return the compiler for software in the loop: zig on request, else that of models."""
    if name not in (None, "zig"):
        raise bad_value("compiler", name, "zig, or left out for the compiler of this machine, with --target sil")
    if name == "zig":
        zig = toolchain("zig")
        return Toolchain("zig", zig.command, zig.version)
    compiler = require_compiler()
    return Toolchain("host", (*compiler.command, *compiler.flags), compiler.version)


@functools.cache
def _zig() -> Toolchain | None:
    if importlib.util.find_spec("ziglang") is None:
        return None
    from importlib.metadata import version

    return Toolchain("zig", (sys.executable, "-m", "ziglang", "cc"), f"zig {version('ziglang')}")


@functools.cache
def _gcc() -> Toolchain | None:
    path = shutil.which("arm-none-eabi-gcc")
    version = version_of((path,)) if path else None
    return Toolchain("gcc", (path,), version) if path and version else None
