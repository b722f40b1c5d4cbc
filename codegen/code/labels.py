# SPDX-License-Identifier: Apache-2.0
"""Names of values in generated code, taken from the model or from a hash of the value's contents.

A name depends only on its function, and not on the number of preceding values. An edit of a model therefore keeps the
names of unaffected values. See decision 0022.
"""

from __future__ import annotations

import hashlib
import keyword
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

from mehvar.base.names import identifier

from .tape import COMMUTATIVE, MASKS, Instruction, Tape, is_sum

Element = tuple[int, int]
"""Position of an argument, and of an element in it."""
_Node: TypeAlias = "str | int | tuple[str, bool, list[_Node]]"
"""A description, a value with a statement, or an operation, True if its operands commute, and its operands."""
LEAVES = 8
"""Largest number of operands in a statement. Longer expressions are split into statements of about a hundred
characters, long sums into one line per term. Half the limit gives more statements, twice gives longer lines; results
do not change."""
_DEPTH = 2
"""Number of levels of operands that determine a value's name. For eight edits of the satellite, the median ratio of
changed to necessary lines was 2.8 with 1 level and 2.1 with 2, 3 or 8; with 0 it was 2.4, but more names needed
numbers."""
_LETTERS = 5
"""Number of letters in a name, 25 bits. An estimate: two of two hundred random names coincide in one of 1700 functions;
with one letter less, in one of 50. Coinciding names get numbers."""
_BASE32, _SHIFTS = "abcdefghijklmnopqrstuvwxyz234567", range(5 * (_LETTERS - 1), -1, -5)
_LONGEST = 200
"""Length of a description above which its digest of 64 letters replaces it; any larger limit is unique too."""
_SIGNS, _KINDS = ("neg", "num", "truth"), {"sub": "add"}
"""Operations that names ignore (signs, conversions of truth values) or merge (differences and sums)."""
_RESERVED = frozenset("""
    auto break case char const continue default do double else enum extern float for goto if inline int long register
    restrict return short signed sizeof static struct switch typedef union unsigned void volatile while linux unix
    real mask K SPLAT LT LE EQ NE NOT AND OR XOR NUM TRUTH SELECT SELECT0
    NAN INFINITY HUGE_VAL NULL EOF DOMAIN SING OVERFLOW UNDERFLOW PLOSS TLOSS I errno np
""".split()) | frozenset(keyword.kwlist)  # fmt: skip  # noqa: SIM905
"""Reserved words of C and Python, macros of the included headers, and names of the C library."""


@dataclass(frozen=True)
class Labels:
    """Names of a function's vectors, elements and steps.

    Attributes
    ----------
    elements : mapping of str to tuple of str
        Names of the elements of its vectors; elements of other vectors are named by position.
    constants : mapping of str to tuple of str
        C names of element positions, for vectors that it receives or returns.
    parts : set of str
        Vectors that other parts of the function compute, read element by element.
    numbers : mapping of str to str
        Equation numbers of definitions.
    """

    elements: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    constants: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    parts: frozenset[str] = frozenset()
    numbers: Mapping[str, str] = field(default_factory=dict)


PLAIN = Labels()
"""Names of elements by their position."""


@dataclass(frozen=True)
class Names:
    """Names of a function's values in every language.

    Attributes
    ----------
    elements : mapping of (int, int) to str
        Names of the elements of its arguments.
    lined : set of int
        The values with their own statements.
    values : mapping of int to str
        Names of these values.
    pairs : mapping of int to int
        Sines and cosines of the same angle, in both directions.
    long : set of int
        Additions that start a new line.
    """

    elements: Mapping[Element, str]
    lined: set[int]
    values: Mapping[int, str]
    pairs: Mapping[int, int]
    long: set[int]


def names_of(
    tape: Tape,
    arguments: Sequence[tuple[str, int | None]],
    labels: Labels = PLAIN,
    results: Sequence[str] = (),
    more: Iterable[int] = (),
) -> Names:
    """Name the elements and the values of a function.

    Parameters
    ----------
    tape : Tape
        The function.
    arguments : sequence of (name, size)
        Names of the arguments; size None for a scalar.
    labels : Labels
        Names of elements and of definitions.
    results : sequence of str
        Names of the results, which no value may have.
    more : iterable of int
        Further values to name, although they have no statement.
    """
    elements, pairs = element_names(arguments, results, labels), sincos_pairs(tape)
    lined = lines_of(tape, pairs) | set(more)
    values = value_names(tape, lined, elements, {*(name for name, _ in arguments), *results}, pairs)
    return Names(elements, lined, values, pairs, long_sums(tape, lined))


def lines_of(tape: Tape, pairs: Mapping[int, int]) -> set[int]:
    """Return the values that have their own statements.

    These are values that are used more than once or defined in the model, truth values, sines paired with cosines,
    and values that would make a statement longer than LEAVES operands, except the beginning of a sum.
    """
    uses, user = tape.uses(), {a: k for k, operands in enumerate(tape.operands) for a in operands}
    lined, weight = set[int](), list[int]()
    for k, ((op, _, _, name), operands) in enumerate(zip(tape.instructions, tape.operands, strict=True)):
        size = sum([weight[a] for a in operands]) if operands else 1
        if operands and (
            uses[k] > 1
            or name
            or op in MASKS
            or k in pairs
            or (size > LEAVES and k in user and not _begins(tape, k, user[k]))
        ):
            lined.add(k)
            size = 1
        weight.append(size)
    return lined


def _begins(tape: Tape, k: int, user: int) -> bool:
    """Return True if a value is a sum and the beginning of the sum that uses it."""
    sums = is_sum(tape.instructions[k]) and is_sum(tape.instructions[user])
    return sums and tape.instructions[user].args[0] == k


def long_sums(tape: Tape, lined: set[int]) -> set[int]:
    """Return the additions that start a new line in sums with more than LEAVES operands."""
    weight: list[int] = []
    for below in tape.operands:
        weight.append(sum([1 if a in lined else weight[a] for a in below]) or 1)
    long = set[int]()
    for k in range(len(tape.instructions) - 1, -1, -1):
        if (weight[k] > LEAVES or k in long) and is_sum(tape.instructions[k]):
            long.add(k)
            first = tape.instructions[k].args[0]
            if first not in lined and is_sum(tape.instructions[first]):
                long.add(first)
    return long


def sincos_pairs(tape: Tape) -> dict[int, int]:
    """Return pairs of sine and cosine of the same angle, as a mapping in both directions."""
    places: dict[tuple[str, int], int] = {}
    for k, i in enumerate(tape.instructions):
        if i.op in ("sin", "cos"):
            places[i.op, i.args[0]] = k
    other = {"sin": "cos", "cos": "sin"}
    return {k: places[other[op], a] for (op, a), k in places.items() if (other[op], a) in places}


def element_names(
    arguments: Sequence[tuple[str, int | None]], results: Iterable[str], labels: Labels
) -> dict[Element, str]:
    """Name the elements of a function's vectors; an ambiguous name is prefixed with its vector's."""
    names: dict[Element, str] = {}
    taken = {*(name for name, _ in arguments), *results, *_RESERVED}
    for place, (argument, size) in enumerate(arguments):
        for k, element in enumerate(labels.elements.get(argument, ()) if size is not None else ()):
            plain = identifier(element)
            names[place, k] = _free(plain if plain not in taken else f"{argument}_{plain}", taken)
            taken.add(names[place, k])
    return names


def value_names(
    tape: Tape, lined: set[int], elements: Mapping[Element, str], taken: set[str], pairs: Mapping[int, int]
) -> dict[int, str]:
    """Name the values that have statements.

    Parameters
    ----------
    tape : Tape
        The function.
    lined : set of int
        Values with statements.
    elements : mapping of (int, int) to str
        Names of the elements of arguments.
    taken : set of str
        Names of arguments and results.
    pairs : mapping of int to int
        As of `sincos_pairs`.
    """
    taken = {*taken, *elements.values(), *_RESERVED}
    names: dict[int, str] = {}
    for k in sorted(lined):
        if tape.instructions[k].name:
            names[k] = _free(identifier(tape.instructions[k].name), taken)
            taken.add(names[k])
    unnamed = sorted(lined - names.keys())
    contents = _contents(tape, unnamed, elements)
    seen: Counter[str] = Counter()
    for k in unnamed:
        i = tape.instructions[k]
        name = _hashed("m_" if i.op in MASKS else "t_", contents[k])
        if k in pairs:
            angle = i.args[0]
            source = tape.instructions[angle]
            known = elements.get(_element(source)) if source.op == "input" else names.get(angle)
            name = f"{i.op}_{known or _hashed('', contents.get(angle) or str(source.args))}"
        seen[name] += 1
        names[k] = _free(name if seen[name] == 1 else f"{name}_{seen[name]}", taken)
        taken.add(names[k])
    return names


def _element(instruction: Instruction) -> Element:
    argument, element = instruction.args
    return argument, element


def _free(name: str, taken: set[str]) -> str:
    while name in taken:
        name += "_"
    return name


def _hashed(kind: str, content: str) -> str:
    bits = int.from_bytes(hashlib.sha256(content.encode()).digest()[:4], "big") >> 32 - 5 * _LETTERS
    return kind + "".join([_BASE32[bits >> shift & 31] for shift in _SHIFTS])


def _contents(tape: Tape, unnamed: Sequence[int], elements: Mapping[Element, str]) -> dict[int, str]:
    """Describe values by their statements and the statements of their operands, without coefficients and signs.

    A definition is described by the elements it depends on. Neither its name nor an edit with the same elements then
    changes other names.
    """
    statements = _statements(tape, set(unnamed), elements)
    contents = {k: _kind(tape, k) for k in unnamed}
    for _ in range(_DEPTH + 1):
        contents = {k: _text(statements[k], contents) for k in unnamed}
    return contents


def _kind(tape: Tape, k: int) -> str:
    """Return the operation of a value, without sign and coefficient."""
    while True:
        i = tape.instructions[k]
        scaled = [a for a in i.args if tape.instructions[a].op != "const"] if i.op == "mul" else []
        if not _is_multiple(i) and len(scaled) != 1:
            return f".{_KINDS.get(i.op, i.op)}"
        k = scaled[0] if scaled else i.args[0]


def _statements(tape: Tape, unnamed: set[int], elements: Mapping[Element, str]) -> list[_Node]:
    """Return the statement of each value, without coefficients and signs, nested sums and products as one."""
    leaves, operands = _leaves(tape, elements), tape.operands
    own: list[_Node] = []
    shown: list[_Node] = []
    parts: list[tuple[str, list[_Node]]] = []
    for k, i in enumerate(tape.instructions):
        kind, members = _KINDS.get(i.op, i.op), list[_Node]()
        node: _Node = ""
        if i.op == "input":
            node = elements.get(_element(i)) or str(i.args)
        elif _is_multiple(i):
            node = shown[i.args[0]]
            if i.args[0] not in unnamed and not tape.instructions[i.args[0]].name:
                kind, members = parts[i.args[0]]
        elif kind in ("add", "mul"):
            for a in i.args:
                if a not in unnamed and parts[a][0] == kind and not tape.instructions[a].name:
                    members = [*members, *parts[a][1]] if members else parts[a][1]
                elif shown[a] != "":
                    members = [*members, shown[a]]
            node = members[0] if len(members) == 1 else (kind, True, members)
        elif i.op != "const":
            members = [shown[a] for a in operands[k]]
            node = (kind, i.op in COMMUTATIVE, members)
        own.append(node)
        shown.append(leaves[k] if i.name else k if k in unnamed else node)
        parts.append((kind, members))
    return own


def _text(node: _Node, contents: Mapping[int, str]) -> str:
    """Return a statement as text, with `contents` as the descriptions of other statements."""
    if isinstance(node, str):
        return node
    if isinstance(node, int):
        return contents[node]
    kind, sortable, members = node
    texts = [m if isinstance(m, str) else contents[m] if isinstance(m, int) else _text(m, contents) for m in members]
    return _short(kind, sorted(texts) if sortable else texts)


def _is_multiple(instruction: Instruction) -> bool:
    """Return True for a value that equals another up to its sign or a factor two, which CasADi writes as a sum."""
    return instruction.op in _SIGNS or (instruction.op == "add" and instruction.args[0] == instruction.args[1])


def _leaves(tape: Tape, elements: Mapping[Element, str]) -> dict[int, str]:
    """Return the elements of arguments in each definition, except those inside of other definitions.

    Sets are stored as bits of integers, because there is one set per value.
    """
    places = {"=": 0}
    names = ["="]
    sets: list[int] = []
    leaves: dict[int, str] = {}
    for k, (i, operands) in enumerate(zip(tape.instructions, tape.operands, strict=True)):
        own = 0
        if i.op == "input":
            name = elements.get(_element(i)) or str(i.args)
            if places.setdefault(name, len(names)) == len(names):
                names.append(name)
            own = 1 << places[name]
        for a in operands:
            own |= sets[a]
        sets.append(1 if i.name else own)
        if i.name:
            leaves[k] = _short("=", sorted(_chosen(names, own)))
    return leaves


def _chosen(names: Sequence[str], bits: int) -> Iterator[str]:
    """Yield the names whose bits are set, in time proportional to their number."""
    while bits:
        last = bits & -bits
        yield names[last.bit_length() - 1]
        bits ^= last


def _short(kind: str, members: Sequence[str]) -> str:
    """Return an operation as text, or its digest, so that descriptions stay short."""
    text = f"{kind}({','.join(members)})"
    return text if len(text) < _LONGEST else hashlib.sha256(text.encode()).hexdigest()
