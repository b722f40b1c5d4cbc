# SPDX-License-Identifier: Apache-2.0
"""Printer of instructions as C with loops over equal parts."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

from .labels import Element, Labels, names_of
from .loops import Block, Loops
from .spelling import C, Printer
from .tape import MASKS, Instruction, Tape

_INDEX = "i"
Vectors = Sequence[tuple[str, int | None]]


class RolledPrinter(Printer):
    """Printer of loops, in which names of the first part stand for those of all equal parts.

    Parameters
    ----------
    tape : Tape
        The function.
    arguments, results : sequence of (name, size)
        Its vectors; the size of a scalar is None.
    labels : Labels
        Names of elements and of definitions.
    loops : Loops
        Loops of the tape.
    """

    def __init__(self, tape: Tape, arguments: Vectors, results: Vectors, labels: Labels, loops: Loops) -> None:
        alone = loops.kept | {s.root for block in loops.blocks for s in block.sums}
        names = names_of(tape, arguments, labels, [_INDEX, *(name for name, _ in results)], alone)
        super().__init__(tape, arguments, C, labels, names)
        self._loops, self._results = loops, results
        kind = loops.members.kind
        self._partner = {k: other for k, other in self._partner.items() if (k in kind) == (other in kind)}
        self._declared: list[str] = []
        self._within: dict[int, str] = {}
        self._without: dict[int, str] = {}

    def body(self) -> list[str]:
        """Return the lines of the function."""
        for k, i in enumerate(self._tape.instructions):
            if i.op in ("input", "const"):
                self._place(k, i)
        self._strides()
        for number, block in enumerate(self._loops.blocks):
            self._block(number, block)
        for r, e in self._loops.apart:
            self._add(f"{self._place_of(r, e)}] = {self._result(self._tape.results[r][e])};")
        lines, self._lines = self._lines, []
        self._load()
        return [*self._lines, *self._declared, *lines]

    def _strides(self) -> None:
        """Replace inputs of equal parts by elements with the loop's index."""
        for values in self._loops.members.kinds.values():
            if self._tape.instructions[values[0]].op == "input":
                elements = [self._tape.instructions[k].args[1] for k in values]
                start = self._text[values[0]].removesuffix("]")
                self._within[values[0]] = self._along(start, elements)
                self._without[values[0]] = self._text[values[0]]

    def _along(self, start: str, elements: Sequence[int]) -> str:
        """Return the element of a vector at the loop's index; `start` is the first element without its bracket."""
        step = elements[1] - elements[0]
        if all(b - a == step for a, b in itertools.pairwise(elements)):
            return f"{start} + {step} * {_INDEX}]" if step != 1 else f"{start} + {_INDEX}]"
        table = f"places_{len(self._declared)}"
        shifts = ", ".join(str(e - elements[0]) for e in elements)
        self._declared.append(f"static const short {table}[] = {{{shifts}}};")
        return f"{start} + {table}[{_INDEX}]]"

    def _place_of(self, result: int, element: int) -> str:
        name = self._results[result][0]
        constants = self._labels.constants.get(name)
        return f"{name}[{constants[element] if constants else element}"

    def _block(self, number: int, block: Block) -> None:
        """Add the lines of a block: common values, then a loop over the equal parts with their sums and results."""
        for k in block.values:
            if k not in self._text:
                self._place(k, self._tape.instructions[k])
        for s in block.sums:
            self._text[s.root] = self._names[s.root]
            self._add(f"real {self._names[s.root]} = {self._result(s.base)};")
        stores = self._loops.stores[number]
        if not (block.own or block.sums or stores):
            return
        before, self._lines = self._lines, []
        self._text |= self._within
        for k in block.own:
            if k not in self._text:
                self._place(k, self._tape.instructions[k])
        for s in block.sums:
            name = self._names[s.root]
            terms = "".join(f" {'-' if negative else '+'} {self._operand(a, 2)}" for negative, a in s.terms)
            self._add(f"{name} = {name}{terms};{self._remark(self._tape.instructions[s.root])}")
        for store in stores:
            place = self._along(self._place_of(store.result, store.elements[0]), store.elements)
            self._add(f"{place} = {self._result(store.value)};")
        body = ["    " + line for line in self._lines]
        count = len(self._loops.members.numbers)
        self._lines = [*before, f"for (int {_INDEX} = 0; {_INDEX} < {count}; {_INDEX}++) {{", *body, "}"]
        self._text |= self._without

    def _value(self, k: int, instruction: Instruction) -> None:
        if k not in self._loops.kept:
            super()._value(k, instruction)
            return
        text = self._expression(k, instruction)
        self._keep(k, "mask" if instruction.op in MASKS else "real")
        self._add(f"{self._text[k]} = {text};{self._remark(instruction)}")

    def _fused(self, k: int, instruction: Instruction) -> None:
        pair = (k, self._partner[k]) if instruction.op == "sin" else (self._partner[k], k)
        if k not in self._loops.kept:
            super()._fused(k, instruction)
            return
        for value in pair:
            self._keep(value, "real")
        sine, cosine = (self._text[value] for value in pair)
        self._add(f"mv_sincos({self._text[instruction.args[0]]}, &{sine}, &{cosine});")

    def _keep(self, k: int, kind: str) -> None:
        """Store a value of an equal part in an array."""
        values = self._loops.members.kinds[self._loops.members.kind[k]]
        self._declared.append(f"{kind} {self._names[k]}[{len(values)}];")
        self._text[k] = self._within[k] = f"{self._names[k]}[{_INDEX}]"
        self._without |= {value: f"{self._names[k]}[{n}]" for n, value in enumerate(values)}

    def _read(self) -> set[Element]:
        """Return the elements that are read outside of loops or at the start of a loop."""
        read = (self._tape.instructions[k].args for k in self._loops.read)
        return {(argument, element) for argument, element in read}
