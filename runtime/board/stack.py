# SPDX-License-Identifier: Apache-2.0
"""Upper bound on an image's stack for all runs, derived from its instructions.

A function needs the sum of its decrements of the stack pointer, each counted once. A program needs its deepest chain
of calls plus one fault at its end. Recursion and frames of variable size are errors.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import NoReturn

from .emulator.profile import disassemble, registers
from .image.elf import Elf
from .image.instructions import UnboundedError, instructions

_START, _FAULT = "Reset_Handler", "Default_Handler"
_EXCEPTION = {"m3": 32 + 4, "m4f": 104 + 4, "m7": 104 + 4}
"""Number of bytes that a fault pushes: registers, FPU registers, padding to a multiple of 8."""
_PUSHES = ("push", "vpush", "stmdb", "vstmdb")
_BRANCH = re.compile(r"(b|bl|cbn?z|b(eq|ne|cs|hs|cc|lo|mi|pl|vs|vc|hi|ls|ge|lt|gt|le))")
_TARGET = re.compile(r"#(0x[0-9a-f]+)$")
_PREDECREMENT = re.compile(r"\[sp, #-(0x[0-9a-f]+|\d+)\]!")
_DESCENT = re.compile(r"sp, (?:sp, )?#(0x[0-9a-f]+|\d+)$")
_RISCV_DESCENT = re.compile(r"(?:addi|addi16sp) sp, (?:sp, )?(-?(?:0x[0-9a-f]+|\d+))")
_RISCV_FRAME = re.compile(r"(add|addi|sub|mv|andi?|l[dw]) sp,")
_RAISES = ("add", "addw", "pop", "vpop", "ldm", "vldm", "vldmia")


@dataclass(frozen=True)
class StackBound:
    """Largest depth of the stack with its chain of calls.

    Attributes
    ----------
    bytes : int
        Largest depth, including the frame of a fault in the deepest function and the fault handler.
    chain : tuple of (str, int)
        The functions of the deepest chain of calls, from the start, with the bytes that each takes.
    """

    bytes: int
    chain: tuple[tuple[str, int], ...]


@dataclass(frozen=True)
class _Function:
    frame: int
    calls: frozenset[str]
    indirect: bool


def stack_bound(elf: Elf, cpu: str) -> StackBound:
    """Return the largest depth of an image's stack.

    Parameters
    ----------
    elf : Elf
        Image with symbols.
    cpu : {"m3", "m4f", "m7"}
        Processor, on which the fault frame depends.

    Raises
    ------
    UnboundedError
        For recursion, a frame of variable size, or a jump outside all functions.
    """
    graph = _Graph(elf)
    chain, fault = graph.deepest(_START), graph.deepest(_FAULT)
    total = sum(size for _, size in (*chain, *fault))
    return StackBound(total + _EXCEPTION[cpu], chain)


def deepest(elf: Elf, name: str) -> tuple[tuple[str, int], ...]:
    """Return a function's chain of calls with the largest stack, and each one's bytes.

    Raises
    ------
    UnboundedError
        As `stack_bound`.
    """
    return _Graph(elf).deepest(name)


class _Graph:
    """Call graph, in which a call through a register may reach any function whose address the image stores."""

    def __init__(self, elf: Elf) -> None:
        self._elf = elf
        self._names: dict[int, str] = {}
        for name, parts in elf.functions.items():
            self._names.setdefault(parts[0][0], name)
        self._functions: dict[str, _Function] = {}
        self._chains: dict[str, tuple[tuple[str, int], ...]] = {}

    def deepest(self, name: str, callers: tuple[str, ...] = ()) -> tuple[tuple[str, int], ...]:
        """Return a function's chain of calls with the largest stack."""
        if name in callers:
            raise UnboundedError(f"the program is recursive: {' calls '.join((*callers[callers.index(name) :], name))}")
        if name not in self._chains:
            function = self._function(name)
            calls = function.calls | (self._stored() - {name} if function.indirect else set())
            below = [self.deepest(called, (*callers, name)) for called in sorted(calls)]
            longest = max(below, key=lambda chain: sum(size for _, size in chain), default=())
            self._chains[name] = ((name, function.frame), *longest)
        return self._chains[name]

    def _function(self, name: str) -> _Function:
        if name not in self._functions:
            self._functions[name] = self._read(name)
        return self._functions[name]

    def _read(self, name: str) -> _Function:
        """Return the frame and calls of a function of Cortex-M; refuse it if its stack has no bound."""
        if self._elf.riscv:
            return self._read_riscv(name)
        frame, indirect, calls = 0, False, set()
        for address, size in self._elf.functions[name]:
            for at, mnemonic, operands in disassemble(self._elf.stored(address, size), address):
                frame += _descent(name, at, mnemonic, operands)
                indirect |= _through_register(mnemonic, operands)
                target = _TARGET.search(operands) if _BRANCH.fullmatch(mnemonic) else None
                owner = self._owner(int(target[1], 16), name) if target else name
                if owner != name or (target and mnemonic == "bl"):
                    calls.add(owner)
        return _Function(frame, frozenset(calls), indirect)

    def _read_riscv(self, name: str) -> _Function:
        """Return the frame and calls of a function of RISC-V; refuse it if its stack has no bound."""
        frame, calls = 0, set()
        for i in instructions(self._elf, name):
            if match := _RISCV_DESCENT.fullmatch(f"{i.mnemonic.removeprefix('c.')} {i.operands}"):
                frame += max(0, -int(match[1], 0))
            elif _RISCV_FRAME.match(f"{i.mnemonic.removeprefix('c.')} {i.operands}"):
                _refuse(name, i.address, i.mnemonic, i.operands)
            if (i.call and i.target is None) or (i.leaves and i.target is None and not i.returns):
                raise UnboundedError(f"{name} calls through a register at {i.address:#010x}")
            if i.target is not None and (i.call or self._owner(i.target, name) != name):
                calls.add(self._owner(i.target, name))
        return _Function(frame, frozenset(calls), False)

    def _owner(self, address: int, caller: str) -> str:
        """Return the function that contains an address."""
        if any(a <= address < a + n for a, n in self._elf.functions[caller]):
            return caller
        if address in self._names:
            return self._names[address]
        for name, parts in self._elf.functions.items():
            if any(a <= address < a + n for a, n in parts):
                return name
        raise UnboundedError(f"{caller} jumps to {address:#010x}, which is in no function")

    def _stored(self) -> set[str]:
        words = set()
        for _, content in self._elf.segments:
            words |= {int.from_bytes(content[i : i + 4], "little") for i in range(0, len(content) - 3, 4)}
        handlers = {_START, _FAULT}
        return {name for address, name in self._names.items() if address | 1 in words} - handlers


def _descent(name: str, at: int, mnemonic: str, operands: str) -> int:
    """Return the bytes by which an instruction lowers the stack pointer."""
    if mnemonic in _PUSHES and (mnemonic.endswith("push") or operands.startswith("sp!")):
        return (8 if "{d" in operands else 4) * registers(operands)
    if match := _PREDECREMENT.search(operands):
        return int(match[1], 0)
    if not operands.startswith("sp, ") and not operands.startswith("sp!"):
        return 0
    if mnemonic in ("sub", "subw"):
        size = _DESCENT.search(operands)
        return int(size[1], 0) if size else _refuse(name, at, mnemonic, operands)
    return 0 if mnemonic in (*_RAISES, "cmp", "tst") else _refuse(name, at, mnemonic, operands)


def _refuse(name: str, at: int, mnemonic: str, operands: str) -> NoReturn:
    raise UnboundedError(f"{name} has a stack frame of variable size: {mnemonic} {operands} at {at:#010x}")


def _through_register(mnemonic: str, operands: str) -> bool:
    if mnemonic in ("blx", "bx"):
        return operands != "lr" and not operands.startswith("#")
    return (mnemonic == "mov" and operands.startswith("pc,")) or (
        mnemonic == "ldr" and operands.startswith("pc,") and "[sp]" not in operands and "[pc" not in operands
    )
