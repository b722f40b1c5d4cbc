# SPDX-License-Identifier: Apache-2.0
"""Processors that run the firmware as a Linux process, foreign ones under QEMU's user mode."""

from __future__ import annotations

import shutil
from dataclasses import dataclass

from mehvar.base.errors import MissingError, unknown_name

from ...compiling.compiler import version_of
from .toolchains import Toolchain, host_toolchain, toolchain


@dataclass(frozen=True)
class Processor:
    """A processor under Linux.

    Attributes
    ----------
    name, title : str
        Identifier and full name.
    gcc : str or None
        Debian's name of its gcc; None without a C library for it.
    zig : tuple of str
        Options of zig to build for it.
    emulator : str
        QEMU's name of it.
    """

    name: str
    title: str
    gcc: str | None
    zig: tuple[str, ...]
    emulator: str


PROCESSORS = {
    processor.name: processor
    for processor in (
        Processor("aarch64", "Armv8-A", "aarch64-linux-gnu-gcc", ("-target", "aarch64-linux-musl"), "qemu-aarch64"),
        Processor(
            "riscv64", "RISC-V, RV64GC", "riscv64-linux-gnu-gcc", ("-target", "riscv64-linux-musl"), "qemu-riscv64",
        ),
        Processor(
            "riscv64-soft", "RISC-V, RV64IMAC: without FPU", None,
            ("-target", "riscv64-linux-musl", "-mcpu=generic_rv64+m+a+c", "-mabi=lp64"), "qemu-riscv64",
        ),
        Processor(
            "powerpc", "PowerPC, 32 bits, big-endian", "powerpc-linux-gnu-gcc",
            ("-target", "powerpc-linux-musleabihf"), "qemu-ppc",
        ),
        Processor("s390x", "IBM Z, big-endian", "s390x-linux-gnu-gcc", ("-target", "s390x-linux-musl"), "qemu-s390x"),
    )
}  # fmt: skip
_OWN_PRECISION = "-fexcess-precision=fast"
"""Flags for s390x. With -std=c99, gcc computes float in double there, and `operations.h` refuses this."""


def process_toolchain(name: str | None, compiler: str | None = None) -> Toolchain:
    """Return the compiler of a firmware that runs as a process.

    Parameters
    ----------
    name : str or None
        Name of a processor; default: this machine's.
    compiler : {"gcc", "zig"}, optional
        Default: for another processor gcc if installed, else zig; for this machine the compiler of models.

    Raises
    ------
    InputError
        If the processor or the compiler is not known.
    MissingError
        If compiler or emulator are not installed; the message says how to install them.
    """
    if name is None:
        return host_toolchain(compiler)
    if name not in PROCESSORS:
        raise unknown_name("board of software in the loop", name, PROCESSORS)
    if compiler not in (None, "zig", "gcc"):
        raise unknown_name("compiler", compiler, ("zig", "gcc"))
    processor = PROCESSORS[name]
    emulator = _emulator(processor)
    for candidate in ("gcc", "zig") if compiler is None else (compiler,):
        if candidate == "zig":
            zig = toolchain("zig")
            command = (*zig.command, *processor.zig, "-static", "-fno-sanitize=all")
            return Toolchain("zig", command, zig.version, (emulator,))
        path = shutil.which(processor.gcc) if processor.gcc else None
        if path and (version := version_of((path,))):
            return Toolchain("gcc", (path, "-static", _OWN_PRECISION), version, (emulator,))
    if processor.gcc is None:
        raise MissingError(f"gcc has no C library for {name}: use --compiler zig")
    raise MissingError(f"{processor.gcc} is not installed: apt-get install gcc-{processor.gcc.removesuffix('-gcc')}")


def _emulator(processor: Processor) -> str:
    for name in (processor.emulator, f"{processor.emulator}-static"):
        if path := shutil.which(name):
            return path
    raise MissingError(f"{processor.emulator} is not installed: apt-get install qemu-user-static")
