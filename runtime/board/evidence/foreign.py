# SPDX-License-Identifier: Apache-2.0
"""Evidence about a law in another project's image, without running it."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path

from elftools.common.exceptions import ELFError
from elftools.elf.elffile import ELFFile

from mehvar.base.errors import bad_value

from ..emulator.profile import STEP
from ..image.elf import Elf, read_elf
from ..image.instructions import UnboundedError, instructions
from ..stack import deepest
from .flow import Flow
from .linkmap import LinkMap, Member


@dataclass(frozen=True)
class Inspected:
    """Function of the law, or function that it calls.

    Attributes
    ----------
    size, own : int
        Size in bytes, and number of its own instructions.
    loops : int or None
        Number of outermost loops; None if undecided.
    indirect : int
        Number of calls through a register.
    calls : tuple of str
        The functions that it calls, directly or indirectly.
    depth : int or None
        Number of functions in its longest chain of calls, including itself; None if recursive.
    origin : str or None
        Its object file, if a map of the image was given.
    recursive : bool
        True if it calls itself, directly or indirectly.
    bound, stack : int or None
        Largest number of instructions of a call, and of bytes of stack; None if undecided.
    reasons : tuple of str
        Reasons for undecided values.
    """

    function: str
    size: int
    own: int
    loops: int | None
    indirect: int
    calls: tuple[str, ...]
    depth: int | None
    origin: str | None
    recursive: bool
    bound: int | None
    stack: int | None
    reasons: tuple[str, ...]


@dataclass(frozen=True)
class Inspection:
    """Evidence about a law in another project's image.

    Attributes
    ----------
    flash, ram : int
        Bytes of the image.
    doubles : list of str
        Double-precision routines in the image.
    functions : list of Inspected
        The law, its step, then all functions that they call.
    members : tuple of Member, optional
        Members of libraries in the image, if a map was given.
    """

    path: Path
    sha256: str
    flash: int
    ram: int
    doubles: list[str]
    functions: list[Inspected]
    members: tuple[Member, ...] | None = None


def inspect(path: Path, symbol: str, linked: LinkMap | None = None) -> Inspection:
    """Return the evidence about a law in an image for Cortex-M or 64-bit RISC-V.

    Parameters
    ----------
    symbol : str
        The law's function.
    linked : LinkMap, optional
        Map of the image.

    Raises
    ------
    InputError
        If the file is not such an image, or lacks the law's function.
    """
    _check(path)
    elf = read_elf(path, stack=False)
    if symbol not in elf.functions:
        allowed = f"an image with the function {symbol}: link the law, without link-time optimization or strip"
        raise bad_value("elf", str(path), allowed, "--elf")
    flow = Flow(elf)
    roots = [name for name in (symbol, f"{symbol}_step", STEP) if name in elf.functions]
    called = sorted(set().union(*map(flow.callees, roots)) - set(roots))
    return Inspection(
        path, hashlib.sha256(path.read_bytes()).hexdigest(), elf.flash, elf.ram, elf.doubles(),
        [_inspected(elf, flow, name, linked) for name in (*roots, *called)], linked.members if linked else None,
    )  # fmt: skip


def _check(path: Path) -> None:
    """Refuse files that are not linked images for Cortex-M or RISC-V with symbols."""
    with path.open("rb") as file:
        try:
            elf = ELFFile(file)
        except ELFError:
            raise bad_value("elf", str(path), "an ELF file", "--elf") from None
        kind = (elf["e_machine"], elf.elfclass, elf["e_type"])
        if kind not in (("EM_ARM", 32, "ET_EXEC"), ("EM_RISCV", 64, "ET_EXEC")):
            raise bad_value("elf", str(path), "a linked image for a Cortex-M, or for RISC-V of 64 bits", "--elf")
        if elf.get_section_by_name(".symtab") is None:
            raise bad_value("elf", str(path), "an image with its symbols: do not strip it", "--elf")


def _depth(flow: Flow, name: str) -> int:
    """Return the length of the longest chain of calls of a function without recursion."""
    return 1 + max((_depth(flow, called) for called in flow.called(name)), default=0)


def _inspected(elf: Elf, flow: Flow, name: str, linked: LinkMap | None) -> Inspected:
    """Return the evidence about a function; bounds without proof are None, with a reason."""
    text = instructions(elf, name)
    calls = flow.callees(name)
    recursive = any(called in flow.callees(called) for called in (name, *calls))
    loops, bound, stack, reasons = None, None, None, []
    try:
        loops = flow.loops(name)
        bound = flow.worst(name)
    except UnboundedError as error:
        reasons.append(str(error))
    try:
        stack = sum(size for _, size in deepest(elf, name))
    except UnboundedError as error:
        reasons.append(str(error))
    return Inspected(
        name, sum(size for _, size in elf.functions[name]), len(text), loops,
        sum(i.call and i.target is None for i in text), tuple(sorted(calls - {name})),
        None if recursive else _depth(flow, name), linked.origin(elf.functions[name][0][0]) if linked else None,
        name in calls, bound, stack, tuple(reasons),
    )  # fmt: skip
