# SPDX-License-Identifier: Apache-2.0
"""Values that each of several equal parts, such as pendulums, has.

A value belongs to a member if it follows from that member's quantities and shared ones. Values of two members have
the same kind if the same operations compute them. Sums over all members are ordered by member, so that a member's
values are no longer needed once its terms are added.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass

from ..functions.function import LEAST
from .tape import COMMUTATIVE, Builder, Instruction, Tape, early, is_sum

Tags = Mapping[tuple[int, int], tuple[Hashable, int]]
"""For each element that belongs to an equal part, its name in the part and the part's number."""


@dataclass(frozen=True)
class Members:
    """Values of equal parts in a list of instructions.

    Attributes
    ----------
    numbers : tuple of int
        Numbers of the members.
    owner : list of int
        For each value, the number of its member, or zero.
    kinds : mapping of int to list of int
        Values of a kind, one per member.
    kind : mapping of int to int
        Kind of each of these values.
    sums : mapping of int to list of (bool, int)
        Terms of each sum over all members, by the sum's root, with True for subtracted terms.
    inside : set of int
        Partial sums of these sums.
    """

    numbers: tuple[int, ...]
    owner: list[int]
    kinds: Mapping[int, list[int]]
    kind: Mapping[int, int]
    sums: Mapping[int, list[tuple[bool, int]]]
    inside: set[int]

    def first(self, k: int) -> int:
        """Return the counterpart of a value in the first of the equal parts."""
        return self.kinds[self.kind[k]][0]

    def alike(self, terms: Sequence[tuple[bool, int]]) -> bool:
        """Return True if terms, sorted by part, are equal for all parts."""
        each: dict[int, list[tuple[bool, int]]] = {number: [] for number in self.numbers}
        for negative, k in terms:
            if k not in self.kind:
                return False
            each[self.owner[k]].append((negative, self.kind[k]))
        return all(own == each[self.numbers[0]] for own in each.values())


def members(tape: Tape, tags: Tags) -> Members | None:
    """Separate the values of equal parts from the others; None if there are too few parts."""
    numbers = _numbers(tags)
    if len(numbers) < LEAST:
        return None
    dropped = set[int]()
    partial = _partial(tape)
    while True:
        owner, kind, mixed = _owned(tape, tags, set(numbers), dropped, partial)
        inside = _inside(tape, mixed, partial)
        kinds: dict[int, list[int]] = {}
        for k, number in enumerate(owner):
            if number and k not in inside:
                kinds.setdefault(kind[k], []).append(k)
        lonely = {k for values in kinds.values() if len(values) != len(numbers) for k in values}
        if not lonely:
            break
        dropped |= lonely
    if not kinds:
        return None
    by_kind = {name: sorted(values, key=lambda k: owner[k]) for name, values in kinds.items()}
    of = {k: name for name, values in kinds.items() for k in values}
    return Members(numbers, owner, by_kind, of, {k: _leaves(tape, k, inside) for k in mixed - inside}, inside)


def _numbers(tags: Tags) -> tuple[int, ...]:
    """Return the numbers of the largest group of equal parts, and of groups with the same numbers."""
    families: dict[Hashable, set[int]] = {}
    for name, number in tags.values():
        families.setdefault(name, set()).add(number)
    return tuple(sorted(max(families.values(), key=lambda numbers: (len(numbers), sorted(numbers)), default=())))


def _partial(tape: Tape) -> set[int]:
    """Return the sums that only another sum uses."""
    uses = tape.uses()
    return {
        a
        for i in tape.instructions
        if is_sum(i)
        for a in i.args
        if uses[a] == 1 and is_sum(tape.instructions[a]) and not tape.instructions[a].name
    }


def _owned(
    tape: Tape, tags: Tags, numbers: set[int], dropped: set[int], partial: set[int]
) -> tuple[list[int], list[int], set[int]]:
    """Return part and kind of each value, and the sums over several parts."""
    owner, kind, spread = list[int](), list[int](), list[int]()
    known: dict[Hashable, int] = {}
    mixed = set[int]()
    for k, i in enumerate(tape.instructions):
        family, number = tags.get((i.args[0], i.args[1]), ("", 0)) if i.op == "input" else ("", 0)
        bits, shape = 0, tuple[Hashable, ...]()
        if i.op == "input":
            bits, shape = (1 << number if number in numbers else 0), ("input", i.args[0], family)
        elif i.op != "const" and k not in dropped:
            for a in i.args:
                bits |= spread[a] if a in partial else 1 << owner[a] if owner[a] else 0
            operands = [kind[a] for a in i.args]
            shape = (i.op, *(sorted(operands) if i.op in COMMUTATIVE else operands))
        if k in dropped or bits & (bits - 1) or not bits:
            if bits & (bits - 1) and is_sum(i):
                mixed.add(k)
            owner.append(0)
            kind.append(-k - 1)
        else:
            owner.append(bits.bit_length() - 1)
            kind.append(known.setdefault(shape, len(known)))
        spread.append(bits)
    return owner, kind, mixed


def _inside(tape: Tape, mixed: set[int], partial: set[int]) -> set[int]:
    """Return the partial sums within sums over several equal parts."""
    inside = set[int]()
    for k in range(len(tape.instructions) - 1, -1, -1):
        if k in mixed or k in inside:
            inside |= partial.intersection(tape.instructions[k].args)
    return inside


def _leaves(tape: Tape, root: int, inside: set[int]) -> list[tuple[bool, int]]:
    """Return the terms of a sum in order with their signs."""
    leaves, stack = list[tuple[bool, int]](), [(False, root)]
    while stack:
        negative, k = stack.pop()
        i = tape.instructions[k]
        if k != root and k not in inside:
            leaves.append((negative, k))
            continue
        stack += [(negative != (i.op == "sub"), i.args[1]), (negative, i.args[0])]
    return leaves


def in_order(tape: Tape, tags: Tags, parameters: frozenset[int]) -> Tape:
    """Reorder sums over equal parts by part, after the terms that depend only on parameters.

    Reordering a sum changes its last bits, equally in every language that the tape is printed in. Values that only the
    old sums needed stay in the tape, unused.
    """
    if len(_numbers(tags)) < LEAST:
        return tape
    tape = _merged(tape)
    found = members(tape, tags)
    if found is None:
        return tape
    constant, deep = early(tape, parameters), _deep(tape, found)
    builder, moved, known = Builder(), dict[int, int](), dict[Hashable, int]()
    for k, i in enumerate(tape.instructions):
        runs = _runs(found, found.sums[k], constant, deep) if k in found.sums else None
        if i.op in ("input", "const"):
            moved[k] = builder.add(i.op, *i.args, value=i.value)
        elif runs is None:
            moved[k] = builder.add(i.op, *(moved[a] for a in i.args))
        else:
            terms = [[(negative, moved[a]) for negative, a in run] for run in runs]
            moved[k] = _chain(builder, terms, not deep[runs[0][0][1]], known)
        builder.mark(moved[k], i.name)
    return Tape(tuple(builder.instructions), tuple(tuple(moved[v] for v in result) for result in tape.results))


def _merged(tape: Tape) -> Tape:
    """Merge values that differ only in operand order of a commutative operation; results stay bit-identical."""
    builder, moved, known = Builder(), list[int](), dict[Hashable, int]()
    for i in tape.instructions:
        args = tuple(moved[a] for a in i.operands) or i.args
        content = (i.op, *sorted(args)) if i.op in COMMUTATIVE else None
        position = known.get(content) if content else None
        moved.append(builder.add(i.op, *args, value=i.value) if position is None else position)
        if content:
            known.setdefault(content, moved[-1])
        builder.mark(moved[-1], i.name)
    return Tape(tuple(builder.instructions), tuple(tuple(moved[v] for v in result) for result in tape.results))


def _runs(
    found: Members, terms: Sequence[tuple[bool, int]], constant: Sequence[bool], deep: Sequence[bool]
) -> list[list[tuple[bool, int]]] | None:
    """Split a sum's terms into shared ones and one sequence per part; None if the parts' sequences differ.

    Shared terms that depend on members, such as another sum over them, come last, so that no loop waits for them.
    """
    runs = []
    for now in ([term for term in terms if constant[term[1]]], [term for term in terms if not constant[term[1]]]):
        own = [term for term in now if found.owner[term[1]]]
        own.sort(key=lambda term: (found.owner[term[1]], found.kind.get(term[1], 0), term[0]))
        if own and not found.alike(own):
            return None
        shared = sorted((term for term in now if not found.owner[term[1]]), key=lambda term: term[0])
        runs += [[t for t in shared if not deep[t[1]]], own, [t for t in shared if deep[t[1]]]]
    return [run for run in runs if run]


def _deep(tape: Tape, found: Members) -> list[bool]:
    """Return for each value True if it depends on a value of an equal part."""
    deep: list[bool] = []
    for k, i in enumerate(tape.instructions):
        deep.append(bool(found.owner[k]) or any(deep[a] for a in i.operands))
    return deep


def _chain(
    builder: Builder, runs: Sequence[Sequence[tuple[bool, int]]], shared: bool, known: dict[Hashable, int]
) -> int:
    """Append a sum's terms in order; sums that start with the same terms share these additions."""
    if shared and not runs[0][0][0]:
        (_, total), *first = runs[0]
    else:
        total, first = builder.add("const", value=0.0), list(runs[0])
    for run in (first, *runs[1:]):
        content = (total, tuple(run))
        if content not in known:
            for negative, term in run:
                builder.instructions.append(Instruction("sub" if negative else "add", (total, term)))
                total = len(builder.instructions) - 1
            known[content] = total
        total = known[content]
    return total
