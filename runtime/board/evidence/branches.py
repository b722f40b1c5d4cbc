# SPDX-License-Identifier: Apache-2.0
"""Outcomes of each conditional instruction of an emulated law.

A compiler converts each condition of the source into a conditional branch or an IT block. Both outcomes of all give
decision and condition coverage. They do not give MC/DC, which requires that each condition decides independently.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from ..emulator.machine import EmulatedBoard
from ..image.elf import Elf
from ..image.instructions import Instruction, instructions

_N, _Z, _C, _V = (1 << bit for bit in (31, 30, 29, 28))
_HOLDS: dict[str, Callable[[int], bool]] = {
    "eq": lambda f: bool(f & _Z),
    "hs": lambda f: bool(f & _C),
    "mi": lambda f: bool(f & _N),
    "vs": lambda f: bool(f & _V),
    "hi": lambda f: bool(f & _C) and not f & _Z,
    "ge": lambda f: bool(f & _N) == bool(f & _V),
    "gt": lambda f: not f & _Z and bool(f & _N) == bool(f & _V),
}
_OPPOSITE = {"ne": "eq", "lo": "hs", "pl": "mi", "vc": "vs", "ls": "hi", "lt": "ge", "le": "gt"}
_SAME = {"cs": "hs", "cc": "lo"}


@dataclass
class Condition:
    """A conditional instruction.

    Attributes
    ----------
    function : str
        Name of the function.
    address : int
        Address of the branch or the IT.
    outcomes : set of bool
        Observed outcomes.
    """

    function: str
    address: int
    text: str
    outcomes: set[bool] = field(default_factory=set)


@dataclass
class _Call:
    """An unfinished call: function, return address, instructions so far."""

    function: str
    back: int
    instructions: int = 0


class Outcomes:
    """Observer of a machine that records branch outcomes.

    Parameters
    ----------
    functions : sequence of str
        Functions to watch, a sample's evaluation first.

    Attributes
    ----------
    conditions : list of Condition
        Conditional instructions of the functions.
    addresses : set of int
        Half-words of instructions that ran.
    most : dict of str to int
        Instructions of the longest call of each function within a sample, from entry to return.
    """

    def __init__(self, machine: EmulatedBoard, elf: Elf, functions: Sequence[str]) -> None:
        self.conditions: list[Condition] = []
        self.addresses: set[int] = set()
        self.most: dict[str, int] = {}
        self.instructions: dict[str, list[Instruction]] = {name: instructions(elf, name) for name in functions}
        self._machine, self._step = machine, functions[0]
        self._entries = elf.starts
        self._places = sorted({i.address for name in elf.functions for i in instructions(elf, name)})
        self._lengths: dict[tuple[int, int], int] = {}
        self._calls: list[_Call] = []
        for name, text in self.instructions.items():
            for i in text:
                if i.conditional or i.name.startswith("it"):
                    condition = Condition(name, i.address, f"{i.mnemonic} {i.operands}")
                    self.conditions.append(condition)
                    machine.on_instruction(i.address, self._watcher(condition, i))
        for address, content in elf.segments:
            machine.on_range(address, address + len(content) - 1, self._ran)

    def _ran(self, address: int, size: int) -> None:
        """Count the instructions of an executed block for the law's function that is running."""
        while self._calls and address == self._calls[-1].back:
            self._return()
        name = self._entries.get(address)
        if name is not None and (self._calls or name == self._step):
            self._calls.append(_Call(name, self._machine.link_register()))
        if not self._calls:
            return
        if (address, size) not in self._lengths:
            first, last = bisect_left(self._places, address), bisect_left(self._places, address + size)
            self._lengths[address, size] = last - first
            self.addresses.update(self._places[first:last])
        self._calls[-1].instructions += self._lengths[address, size]

    def _return(self) -> None:
        call = self._calls.pop()
        self.most[call.function] = max(self.most.get(call.function, 0), call.instructions)
        if self._calls:
            self._calls[-1].instructions += call.instructions

    def _watcher(self, condition: Condition, i: Instruction) -> Callable[[], None]:
        """Return the function that records a condition's outcome; call it before the instruction runs."""
        if i.name in ("cbz", "cbnz"):
            register = i.operands.split(",")[0]

            def look() -> None:
                condition.outcomes.add((self._machine.register(register) == 0) == (i.name == "cbz"))

            return look
        suffix = i.condition or i.operands.strip()
        suffix = _SAME.get(suffix, suffix)
        holds, opposite = _HOLDS[_OPPOSITE.get(suffix, suffix)], suffix in _OPPOSITE

        def watch() -> None:
            condition.outcomes.add(holds(self._machine.flags()) != opposite)

        return watch
