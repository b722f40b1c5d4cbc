# SPDX-License-Identifier: Apache-2.0
"""Split of a function into a part that depends only on parameters, computed once per run, and the rest."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

from mehvar.base.manifest import Array, Signature

from .tape import Instruction, Tape, early, keeps_place, prune


@dataclass(frozen=True)
class Split:
    """A function in two parts.

    Attributes
    ----------
    prepare, prepared : Tape
        The first part returns a vector, which is the last argument of the second part.
    first, second : Signature
        Arguments of both parts: those that each reads; the second part keeps all that are not parameters.
    """

    prepare: Tape
    first: Signature
    prepared: Tape
    second: Signature

    @property
    def size(self) -> int:
        """Length of the vector between the parts."""
        return len(self.prepare.results[0])


def split(tape: Tape, arguments: Signature, parameters: Collection[int], name: str) -> Split | None:
    """Split a function; return None if no operation depends on parameters only.

    Parameters
    ----------
    tape : Tape
        The function.
    arguments : sequence of (name, size)
        Its arguments.
    parameters : set of int
        Numbers of the arguments that do not change between calls.
    name : str
        Name of the vector between the parts.
    """
    constant = early(tape, parameters)
    hoisted = _frontier(tape, constant)
    if not hoisted:
        return None
    place = {k: i for i, k in enumerate(hoisted)}
    instructions = [
        Instruction("input", (len(arguments), place[k])) if k in place else i for k, i in enumerate(tape.instructions)
    ]
    run = prune(Tape(tuple(instructions), tape.results))
    setup = prune(Tape(tape.instructions, (tuple(hoisted),)))
    first = sorted(_read(setup))
    second = [a for a in range(len(arguments)) if a not in parameters or a in _read(run)]
    return Split(
        prepare=_renumbered(setup, first),
        first=tuple(arguments[a] for a in first),
        prepared=_renumbered(run, [*second, len(arguments)]),
        second=(*(arguments[a] for a in second), Array(name, len(hoisted))),
    )


def _frontier(tape: Tape, constant: Sequence[bool]) -> list[int]:
    """Return the values that depend only on parameters and that the rest needs, except values without cost."""
    stack, seen, frontier = [v for result in tape.results for v in result], set[int](), set[int]()
    while stack:
        k = stack.pop()
        if k in seen:
            continue
        seen.add(k)
        if constant[k] and not keeps_place(tape.instructions[k]):
            frontier.add(k)
        else:
            stack.extend(tape.instructions[k].operands)
    return sorted(frontier)


def _read(tape: Tape) -> set[int]:
    return {i.args[0] for i in tape.instructions if i.op == "input"}


def _renumbered(tape: Tape, arguments: Sequence[int]) -> Tape:
    place = {a: i for i, a in enumerate(arguments)}
    instructions = tuple(
        Instruction("input", (place[i.args[0]], i.args[1])) if i.op == "input" else i for i in tape.instructions
    )
    return Tape(instructions, tape.results)
