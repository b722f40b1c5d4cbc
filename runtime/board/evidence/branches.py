# SPDX-License-Identifier: Apache-2.0
"""Which way each conditional instruction of a law went, as an emulator sees it.

A compiler turns every condition of the source into a conditional branch or an IT block, one a condition: both outcomes
of each are decision and condition coverage of the code. That is no MC/DC, which wants each condition to decide alone.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field

from ..emulator.machine import EmulatedBoard
from ..image.elf import Elf
from .flow import Instruction, instructions

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
        Where it stands.
    address : int
        Of the branch or the IT.
    outcomes : set of bool
        Those that were seen.
    """

    function: str
    address: int
    text: str
    outcomes: set[bool] = field(default_factory=set)


class Outcomes:
    """Watches a machine evaluate steps.

    Parameters
    ----------
    callees : mapping of str to set of str
        The functions to watch, a sample's evaluation first, with those that each calls.

    Attributes
    ----------
    conditions : list of Condition
        Of the functions.
    addresses : set of int
        Half-words of instructions that ran.
    most : dict of str to int
        Instructions of the longest call of each function, with those that it calls.
    """

    def __init__(self, machine: EmulatedBoard, elf: Elf, callees: Mapping[str, set[str]]) -> None:
        self.conditions: list[Condition] = []
        self.addresses: set[int] = set()
        self.most: dict[str, int] = {}
        self.instructions: dict[str, list[Instruction]] = {name: instructions(elf, name) for name in callees}
        self._machine, self._callees = machine, callees
        self._step = next(iter(callees))
        self._entries = {text[0].address: name for name, text in self.instructions.items()}
        self._owner = {i.address: name for name, text in self.instructions.items() for i in text}
        self._places = sorted(self._owner)
        self._lengths: dict[tuple[int, int], int] = {}
        self._active: dict[str, int] = {}
        self._return: int | None = None
        for name, text in self.instructions.items():
            for i in text:
                if i.conditional or i.mnemonic.startswith("it"):
                    condition = Condition(name, i.address, f"{i.mnemonic} {i.operands}")
                    self.conditions.append(condition)
                    machine.on_instruction(i.address, self._watcher(condition, i))
        for address, content in elf.segments:
            machine.on_range(address, address + len(content) - 1, self._ran)

    def _ran(self, address: int, size: int) -> None:
        if address == self._return:
            self._end(list(self._active))
            self._return = None
        name = self._entries.get(address)
        if name == self._step:
            self._return = self._machine.link_register()
        if self._return is None:
            return
        if (address, size) not in self._lengths:
            first, last = bisect_left(self._places, address), bisect_left(self._places, address + size)
            self._lengths[address, size] = last - first
            self.addresses.update(self._places[first:last])
        owner = self._owner.get(address)
        self._end([f for f in self._active if f == name or (owner != f and owner not in self._callees[f])])
        if name is not None:
            self._active[name] = 0
        for f in self._active:
            self._active[f] += self._lengths[address, size]

    def _end(self, names: Iterable[str]) -> None:
        for name in names:
            self.most[name] = max(self.most.get(name, 0), self._active.pop(name))

    def _watcher(self, condition: Condition, i: Instruction) -> Callable[[], None]:
        name = i.mnemonic.split(".")[0]
        if name in ("cbz", "cbnz"):
            register = i.operands.split(",")[0]

            def look() -> None:
                condition.outcomes.add((self._machine.register(register) == 0) == (name == "cbz"))

            return look
        suffix = i.operands.strip() if name.startswith("it") else name[1:]
        suffix = _SAME.get(suffix, suffix)
        holds, opposite = _HOLDS[_OPPOSITE.get(suffix, suffix)], suffix in _OPPOSITE

        def watch() -> None:
            condition.outcomes.add(holds(self._machine.flags()) != opposite)

        return watch
