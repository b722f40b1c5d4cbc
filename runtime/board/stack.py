# SPDX-License-Identifier: Apache-2.0
"""Upper bound on an image's stack for all runs, derived from its instructions.

A function needs the sum of its decrements of the stack pointer, each counted once. A program needs its deepest chain
of calls plus one fault at its end. Recursion and frames of variable size are errors.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass

from .image.elf import Elf
from .image.instructions import UnboundedError, instructions

_START, _FAULT = "Reset_Handler", "Default_Handler"
_EXCEPTION = {"m3": 32 + 4, "m4f": 104 + 4, "m7": 104 + 4}
"""Number of bytes that a fault pushes: registers, FPU registers, padding to a multiple of 8."""


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
    return StackBound(_total(chain) + _total(fault) + _EXCEPTION[cpu], chain)


def deepest(elf: Elf, name: str) -> tuple[tuple[str, int], ...]:
    """Return a function's chain of calls with the largest stack, and each one's bytes.

    Raises
    ------
    UnboundedError
        As `stack_bound`.
    """
    return _Graph(elf).deepest(name)


def _total(chain: tuple[tuple[str, int], ...]) -> int:
    return sum(size for _, size in chain)


class _Graph:
    """Call graph, in which a call through a register may reach any function whose address the image stores."""

    def __init__(self, elf: Elf) -> None:
        self._elf = elf
        self._chains: dict[str, tuple[tuple[str, int], ...]] = {}

    def deepest(self, name: str, callers: tuple[str, ...] = ()) -> tuple[tuple[str, int], ...]:
        """Return a function's chain of calls with the largest stack."""
        if name in callers:
            raise UnboundedError(f"the program is recursive: {' calls '.join((*callers[callers.index(name) :], name))}")
        if name not in self._chains:
            frame, calls = self._read(name)
            below = [self.deepest(called, (*callers, name)) for called in sorted(calls)]
            self._chains[name] = ((name, frame), *max(below, key=_total, default=()))
        return self._chains[name]

    def _read(self, name: str) -> tuple[int, set[str]]:
        """Return the frame and calls of a function; refuse it if its stack has no bound."""
        frame, calls = 0, set[str]()
        for i in instructions(self._elf, name):
            if i.descent is None:
                text = f"{i.mnemonic} {i.operands} at {i.address:#010x}"
                raise UnboundedError(f"{name} has a stack frame of variable size: {text}")
            frame += i.descent
            if i.indirect and self._elf.riscv:
                raise UnboundedError(f"{name} calls through a register at {i.address:#010x}")
            calls |= self._stored - {name} if i.indirect else set()
            if i.target is not None and (i.call or self._owner(i.target, name) != name):
                calls.add(self._owner(i.target, name))
        return frame, calls

    def _owner(self, address: int, caller: str) -> str:
        """Return the function that contains an address."""
        functions = self._elf.functions
        for name in (caller, *filter(None, [self._elf.starts.get(address)]), *functions):
            if any(a <= address < a + n for a, n in functions[name]):
                return name
        raise UnboundedError(f"{caller} jumps to {address:#010x}, which is in no function")

    @functools.cached_property
    def _stored(self) -> set[str]:
        words = set()
        for _, content in self._elf.segments:
            words |= {int.from_bytes(content[i : i + 4], "little") for i in range(0, len(content) - 3, 4)}
        return {name for address, name in self._elf.starts.items() if address | 1 in words} - {_START, _FAULT}
