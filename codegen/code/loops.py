# SPDX-License-Identifier: Apache-2.0
"""Loops over equal parts, such as pendulums, that share instructions, and the statements between the loops."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from .labels import sincos_pairs
from .members import Members, Tags, members
from .tape import Tape


@dataclass(frozen=True)
class Sum:
    """A sum over equal parts; each pass of the loop adds the terms of one part.

    Attributes
    ----------
    root, base : int
        The sum, and its start value.
    terms : list of (bool, int)
        Terms of the first member: True if subtracted, and the value.
    """

    root: int
    base: int
    terms: list[tuple[bool, int]]


@dataclass(frozen=True)
class Store:
    """Elements of a result that a loop computes.

    Attributes
    ----------
    result : int
        Number of the result.
    elements : list of int
        Element of each member.
    value : int
        Value of the first member.
    """

    result: int
    elements: list[int]
    value: int


@dataclass(frozen=True)
class Block:
    """Statements and the loop that follows them.

    Attributes
    ----------
    values : list of int
        Values that all members share, in order.
    own : list of int
        Values of the first member, which represent those of every member.
    sums : list of Sum
        Sums of values that the loop computes.
    """

    values: list[int]
    own: list[int]
    sums: list[Sum]


@dataclass(frozen=True)
class Loops:
    """A function as statements and loops.

    Attributes
    ----------
    members : Members
        Equal parts whose values the loops compute.
    blocks : list of Block
        In order.
    stores : list of list of Store
        Results that the loop of each block computes.
    apart : list of (int, int)
        Elements of results that no loop computes.
    kept : set of int
        Values of the first member that later code needs; they are stored in arrays.
    read : set of int
        The inputs that the code names.
    """

    members: Members
    blocks: list[Block]
    stores: list[list[Store]]
    apart: list[tuple[int, int]]
    kept: set[int]
    read: set[int]


def loops(tape: Tape, tags: Tags) -> Loops | None:
    """Return the loops of a list of instructions; None if there are too few equal parts."""
    found = members(tape, tags)
    if found is None:
        return None
    sums, hidden = _sums(tape, found)
    phase = _phases(tape, found, sums, hidden)
    blocks = [Block([], [], []) for _ in range(max(phase) + 1)]
    for k, i in enumerate(tape.instructions):
        if k in sums:
            blocks[phase[k] - 1].sums.append(sums[k])
        elif k in found.kind:
            if found.first(k) == k and i.op != "input":
                blocks[phase[k]].own.append(k)
        elif k not in hidden:
            blocks[phase[k]].values.append(k)
    stores, apart = _stores(tape, found, phase)
    used = _used(tape, found, sums, hidden, phase) | {tape.results[r][e] for r, e in apart}
    inputs = {k for k, i in enumerate(tape.instructions) if i.op == "input"}
    kept = {found.first(k) for k in used if k in found.kind} - inputs
    pairs = sincos_pairs(tape)
    kept |= {pairs[k] for k in kept if k in pairs and pairs[k] in found.kind}
    read = {k for k in inputs if k in used or k not in found.kind or found.first(k) == k}
    return Loops(found, blocks, stores, apart, kept, read)


def _stores(tape: Tape, found: Members, phase: Sequence[int]) -> tuple[list[list[Store]], list[tuple[int, int]]]:
    """Return the results that loops compute, and the others."""
    stores: list[list[Store]] = [[] for _ in range(max(phase) + 1)]
    apart: list[tuple[int, int]] = []
    for r, result in enumerate(tape.results):
        places: dict[int, dict[int, int]] = {}
        for e, k in enumerate(result):
            if k in found.kind and found.owner[k] not in places.setdefault(found.kind[k], {}):
                places[found.kind[k]][found.owner[k]] = e
            else:
                apart.append((r, e))
        for kind, elements in places.items():
            value = found.kinds[kind][0]
            if len(elements) == len(found.numbers):
                stores[phase[value]].append(Store(r, [elements[number] for number in found.numbers], value))
            else:
                apart += [(r, e) for e in elements.values()]
    return stores, sorted(apart)


def _sums(tape: Tape, found: Members) -> tuple[dict[int, Sum], set[int]]:
    """Return the sums that a loop can compute, with their partial sums."""
    sums: dict[int, Sum] = {}
    hidden = set[int]()
    roots = list(found.sums)
    while roots:
        root = roots.pop()
        terms, nodes, node = list[tuple[bool, int]](), list[int](), root
        while node == root or node in found.inside:
            i = tape.instructions[node]
            term = i.args[1]
            if term not in found.kind or (terms and found.owner[term] > found.owner[terms[-1][1]]):
                break
            terms.append((i.op == "sub", term))
            nodes.append(node)
            node = i.args[0]
        terms.reverse()
        if terms and node not in found.kind and found.alike(terms):
            sums[root] = Sum(root, node, terms[: len(terms) // len(found.numbers)])
            hidden.update(nodes[1:])
        node = node if terms else tape.instructions[root].args[0]
        if node in found.inside:
            roots.append(node)
    return sums, hidden


def _phases(tape: Tape, found: Members, sums: dict[int, Sum], hidden: set[int]) -> list[int]:
    """Return the block of each value; for a sum over equal parts, the block after the loop."""
    phase: list[int] = []
    for k, i in enumerate(tape.instructions):
        if k in sums:
            terms = [*(a for _, a in sums[k].terms), sums[k].base]
            phase.append(max(phase[a] for a in terms) + 1)
        elif k in hidden:
            phase.append(0)
        elif k in found.kind:
            phase.append(max((phase[a] for a in i.operands), default=0))
        else:
            phase.append(max((phase[a] + (a in found.kind and _made(tape, a)) for a in i.operands), default=0))
    return phase


def _made(tape: Tape, k: int) -> bool:
    return tape.instructions[k].op != "input"


def _used(tape: Tape, found: Members, sums: dict[int, Sum], hidden: set[int], phase: Sequence[int]) -> set[int]:
    """Return the loop's values that a statement or another loop uses."""
    used = set[int]()
    for k, i in enumerate(tape.instructions):
        if k in sums:
            used |= {a for _, a in sums[k].terms if _made(tape, a) and phase[a] != phase[k] - 1}
        elif k in found.kind:
            used |= {a for a in i.operands if a in found.kind and _made(tape, a) and phase[k] != phase[a]}
        elif k not in hidden:
            used |= {a for a in i.operands if a in found.kind}
    return used
