# SPDX-License-Identifier: Apache-2.0
"""CasADi's instructions in static single assignment form, the source of printed C and Python.

Registers are renamed so that every value has one definition; divisions by a shared denominator become products with
its reciprocal; sine and cosine of one angle are fused; CasADi's pair of `if_else_zero` becomes one select.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain
from typing import NamedTuple

import casadi as ca

from mehvar.base.errors import MehvarError

from ..functions.function import NamedSteps, sx_instructions

MASKS = frozenset({"lt", "le", "eq", "ne", "not", "and", "or", "truth"})
"""Operations whose result is a truth value per lane."""

COMMUTATIVE = frozenset({"add", "mul", "min", "max", "eq", "ne", "and", "or", "hypot"})
"""Commutative operations."""

_NAMES = {
    ca.OP_ADD: "add", ca.OP_SUB: "sub", ca.OP_MUL: "mul", ca.OP_DIV: "div", ca.OP_NEG: "neg",
    ca.OP_SQ: "sq", ca.OP_TWICE: "twice", ca.OP_INV: "inv", ca.OP_SQRT: "sqrt", ca.OP_POW: "pow", ca.OP_CONSTPOW: "pow",
    ca.OP_FABS: "fabs", ca.OP_SIGN: "sign", ca.OP_COPYSIGN: "copysign", ca.OP_FMIN: "min", ca.OP_FMAX: "max",
    ca.OP_FLOOR: "floor", ca.OP_CEIL: "ceil", ca.OP_FMOD: "fmod", ca.OP_HYPOT: "hypot",
    ca.OP_SIN: "sin", ca.OP_COS: "cos", ca.OP_TAN: "tan", ca.OP_ASIN: "asin", ca.OP_ACOS: "acos", ca.OP_ATAN: "atan",
    ca.OP_ATAN2: "atan2", ca.OP_EXP: "exp", ca.OP_LOG: "log", ca.OP_LOG1P: "log1p", ca.OP_EXPM1: "expm1",
    ca.OP_SINH: "sinh", ca.OP_COSH: "cosh", ca.OP_TANH: "tanh", ca.OP_ASINH: "asinh", ca.OP_ACOSH: "acosh",
    ca.OP_ATANH: "atanh", ca.OP_ERF: "erf",
    ca.OP_LT: "lt", ca.OP_LE: "le", ca.OP_EQ: "eq", ca.OP_NE: "ne", ca.OP_NOT: "not", ca.OP_AND: "and", ca.OP_OR: "or",
    ca.OP_IF_ELSE_ZERO: "select0", ca.OP_ASSIGN: "assign",
}  # fmt: skip
OPERATIONS = frozenset(_NAMES.values())
"""Names of CasADi's operations on a tape."""
_SPECIAL = frozenset({"assign", "not", "and", "or", "select0", "lt", "sq", "twice", "inv"})
_PLAIN = {code: name for code, name in _NAMES.items() if name not in _SPECIAL}
"""Operations whose result depends on their operands in no special way."""
_FREE = frozenset({"input", "const", "neg", "truth", "num"})
_CALLS = frozenset({
    "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "exp", "log", "log1p", "expm1", "pow", "fmod", "hypot",
    "sinh", "cosh", "tanh", "asinh", "acosh", "atanh", "erf",
})  # fmt: skip
"""Functions that C calls lane by lane. Values that later code needs are then stored in memory (decision 0022)."""


class TapeError(MehvarError, ValueError):
    """A CasADi operation without counterpart in the generated code."""


class Instruction(NamedTuple):
    """A value, computed by an operation on earlier values.

    It is a tuple, because a model has up to a million of them and tuples are created four times as fast as dataclasses.

    Attributes
    ----------
    op : str
        Operation; "input" and "const" have no operands.
    args : tuple of int
        Positions of the operands in the tape; for "input" the argument and the element.
    value : float
        Value of a constant.
    name : str
        Name of the definition with this value.
    """

    op: str
    args: tuple[int, ...] = ()
    value: float = 0.0
    name: str = ""

    @property
    def operands(self) -> tuple[int, ...]:
        """Positions of the operation's operands."""
        return () if self.op in ("input", "const") else self.args


@dataclass(frozen=True)
class Tape:
    """A function as a list of assignments.

    Attributes
    ----------
    instructions : tuple of Instruction
        In order of evaluation.
    results : tuple of tuple of int
        For each result, the positions of its values.
    """

    instructions: tuple[Instruction, ...]
    results: tuple[tuple[int, ...], ...]

    @cached_property
    def operands(self) -> list[tuple[int, ...]]:
        """Positions of the operands of each value."""
        return [() if i.op == "input" else i.args for i in self.instructions]

    @cached_property
    def operations(self) -> int:
        """Number of arithmetic operations, comparisons and function calls."""
        return sum(i.op not in _FREE for i in self.instructions)

    @cached_property
    def chain(self) -> int:
        """Number of operations in the longest chain in which each needs the result of the one before."""
        lengths = list[int]()
        for instruction, operands in zip(self.instructions, self.operands, strict=True):
            before = max((lengths[k] for k in operands), default=0)
            lengths.append(before + (instruction.op not in _FREE))
        return max(lengths, default=0)

    def uses(self) -> Counter[int]:
        """Count the uses of each value, including results."""
        return Counter(chain(*self.operands, *self.results))


def tape(function: ca.Function, parameters: frozenset[int] = frozenset(), derivation: NamedSteps | None = None) -> Tape:
    """Convert a CasADi SX function to a list of instructions.

    Parameters
    ----------
    function : casadi.Function
        The function to convert.
    parameters : set of int
        Numbers of the arguments that do not change between calls. Divisors that depend only on them become
        reciprocals, which are computed once.
    derivation : NamedSteps, optional
        Definitions that give their names to values.

    Raises
    ------
    TapeError
        If the function uses an operation that cannot be printed.
    """
    builder = Builder()
    results = _read(function, builder)
    size = len(builder.instructions)
    if derivation is not None:
        _name(builder, derivation)
    _fuse_selects(builder)
    moved = _share_reciprocals(builder, size, parameters)
    results = [[moved.get(v, v) for v in result] for result in results]
    return arranged(Tape(tuple(builder.instructions), tuple(map(tuple, results))), derivation)


class Builder:
    """Builder of a tape, which adds equal instructions only once."""

    def __init__(self) -> None:
        self.instructions: list[Instruction] = []
        self.masks = set[int]()
        self._known: dict[tuple[str, object], int] = {}

    def add(self, op: str, *args: int, value: float = 0.0) -> int:
        """Return the position of an operation; append it if it is new."""
        # repr tells -0.0 from 0.0, which compare equal
        key = (op, repr(value) if op == "const" else args)
        position = self._known.get(key)
        if position is None:
            position = self._known[key] = len(self.instructions)
            self.instructions.append(Instruction._make((op, args, value, "")))
            if op in MASKS:
                self.masks.add(position)
        return position

    def mark(self, position: int, name: str) -> None:
        """Give a value a name unless it has one."""
        instruction = self.instructions[position]
        if name and not instruction.name:
            self.instructions[position] = instruction._replace(name=name)

    def mask(self, position: int) -> int:
        """Return a truth value: the value itself, or its comparison with zero."""
        return position if position in self.masks else self.add("truth", position)

    def number(self, position: int) -> int:
        """Return a number: the value itself, or 1 and 0 for a truth value."""
        return self.add("num", position) if position in self.masks else position

    def is_flag(self, bound: int, position: int) -> bool:
        """Return True if a number exceeds a bound exactly when its truth value is true."""
        low, flag = self.instructions[bound], self.instructions[position]
        if low.op != "const" or flag.op != "select0":
            return False
        high = self.instructions[flag.args[1]]
        return high.op == "const" and 0.0 <= low.value < high.value


def _read(function: ca.Function, builder: Builder) -> list[list[int]]:
    """Append a function's instructions, and return the positions of its results."""
    register = [0] * function.sz_w()
    results = [[0] * function.nnz_out(i) for i in range(function.n_out())]
    for k, (op, of, to) in enumerate(sx_instructions(function)):
        if op == ca.OP_OUTPUT:
            results[to[0]][to[1]] = builder.number(register[of[0]])
        elif op == ca.OP_CONST:
            register[to[0]] = builder.add("const", value=function.instruction_constant(k))
        elif op == ca.OP_INPUT:
            register[to[0]] = builder.add("input", *of)
        else:
            operands = [register[i] for i in of]
            if op in _PLAIN and builder.masks.isdisjoint(operands):
                register[to[0]] = builder.add(_PLAIN[op], *operands)
            else:
                register[to[0]] = _operation(builder, op, operands, function)
    return results


def _operation(builder: Builder, op: int, operands: list[int], function: ca.Function) -> int:
    """Append an operation of CasADi and return its position; operands become numbers or masks as it needs."""
    if op not in _NAMES:
        raise TapeError(f"{function.name()}: CasADi operation number {op} has no counterpart in generated code")
    name = _NAMES[op]
    if name == "assign":
        return operands[0]
    if name in ("not", "and", "or"):
        return builder.add(name, *map(builder.mask, operands))
    if name == "select0":
        return builder.add(name, builder.mask(operands[0]), builder.number(operands[1]))
    numbers = operands if builder.masks.isdisjoint(operands) else [builder.number(o) for o in operands]
    if name == "lt" and builder.is_flag(*numbers):
        return builder.instructions[numbers[1]].args[0]
    if name in ("sq", "twice"):
        return builder.add("mul" if name == "sq" else "add", numbers[0], numbers[0])
    if name == "inv":
        return builder.add("div", builder.add("const", value=1.0), numbers[0])
    return builder.add(name, *numbers)


def _name(builder: Builder, derivation: NamedSteps) -> None:
    """Name the values of definitions, which are identified by equal operations on equal values."""
    size = len(builder.instructions)
    (steps,) = _read(derivation.graph, builder)
    identities, names = _identities(builder.instructions), dict[int, str]()
    for name, position in zip(derivation.numbers, steps, strict=True):
        if builder.instructions[position].op not in ("input", "const"):
            names.setdefault(identities[position], name)
    for position, identity in enumerate(identities[:size]):
        if identity in names:
            builder.mark(position, names.pop(identity))


def _identities(instructions: Iterable[Instruction]) -> list[int]:
    """Return a number for each value, the same for values that differ only in operand order."""
    known: dict[tuple[object, ...], int] = {}
    numbers: list[int] = []
    for op, args, value, _ in instructions:
        if op == "input":
            content: tuple[object, ...] = (op, *args)
        elif op == "const":
            content = (op, repr(value))
        else:
            operands = [numbers[a] for a in args]
            if op in COMMUTATIVE:
                operands.sort()
            content = (op, *operands)
        numbers.append(known.setdefault(content, len(known)))
    return numbers


def _fuse_selects(builder: Builder) -> None:
    """Replace select0(c, a) + select0(not c, b) by select(c, a, b)."""
    instructions = builder.instructions
    if not any(i.op == "select0" for i in instructions):
        return
    for k, instruction in enumerate(instructions):
        if instruction.op != "add":
            continue
        first, second = (instructions[a] for a in instruction.args)
        if first.op == second.op == "select0":
            negated = instructions[second.args[0]]
            if negated.op == "not" and negated.args[0] == first.args[0]:
                args = (first.args[0], first.args[1], second.args[1])
                instructions[k] = instruction._replace(op="select", args=args)


def early(tape_: Tape, parameters: Collection[int]) -> list[bool]:
    """Return for each value True if it depends on parameters only."""
    constant: list[bool] = []
    for op, args, _, _ in tape_.instructions:
        constant.append(args[0] in parameters if op == "input" else all(map(constant.__getitem__, args)))
    return constant


def is_sum(instruction: Instruction) -> bool:
    """Return True if a value is a sum or a difference."""
    return instruction.op in ("add", "sub")


def keeps_place(instruction: Instruction) -> bool:
    """Return True if storing a value saves nothing, or if it is not a number."""
    return instruction.op in _FREE or instruction.op in MASKS


def _share_reciprocals(builder: Builder, size: int, parameters: frozenset[int]) -> dict[int, int]:
    """Replace repeated divisions, and those by constant denominators, by products with one reciprocal.

    Return the new positions of those of the first `size` values that the replacement changes; the others stay.
    """
    instructions = builder.instructions
    quotients = [i.args for i in instructions[:size] if i.op == "div"]
    divisors = Counter(below for _, below in quotients)
    constant = early(Tape(tuple(instructions[:size]), ()), parameters) if quotients else []
    divisors.update(
        below
        for above, below in quotients
        if constant[below] and not constant[above] and instructions[below].op != "const"
    )
    moved, inverse = dict[int, int](), dict[int, int]()
    for k in range(size):
        op, args, _, name = instructions[k]
        if op in ("input", "const"):
            continue
        shared = op == "div" and divisors[args[1]] > 1
        if not shared and moved.keys().isdisjoint(args):
            continue
        new = [moved.get(a, a) for a in args]
        if shared:
            divisor = args[1]
            if divisor not in inverse:
                inverse[divisor] = builder.add("div", builder.add("const", value=1.0), new[1])
            one = instructions[args[0]]
            unit = one.op == "const" and one.value == 1.0
            moved[k] = inverse[divisor] if unit else builder.add("mul", new[0], inverse[divisor])
        else:
            moved[k] = builder.add(op, *new)
        builder.mark(moved[k], name)
    return moved


def arranged(tape_: Tape, derivation: NamedSteps | None) -> Tape:
    """Move each value before its first use, and drop unused ones.

    Function calls come first, in the order of their use, then definitions in derivation order, then results. The
    position of a value thus depends on its uses, not on the number of other values.
    """
    place = {tape_.instructions[k].name: k for k in _needed(tape_)}
    names = derivation.numbers if derivation else ()
    order = _order(tape_, [*(place[name] for name in names if name in place), *chain(*tape_.results)])
    first = _order(tape_, [k for k in order if tape_.instructions[k].op in _CALLS])
    early_ones = set(first)
    return _reordered(tape_, [*first, *(k for k in order if k not in early_ones)])


def prune(tape_: Tape) -> Tape:
    """Drop unused values and renumber."""
    return _reordered(tape_, _needed(tape_))


def _needed(tape_: Tape) -> list[int]:
    """Return the values that results need, in order."""
    needed, operands = [False] * len(tape_.instructions), tape_.operands
    for v in chain(*tape_.results):
        needed[v] = True
    for k in range(len(needed) - 1, -1, -1):
        if needed[k]:
            for a in operands[k]:
                needed[a] = True
    return [k for k, wanted in enumerate(needed) if wanted]


def _reordered(tape_: Tape, order: Sequence[int]) -> Tape:
    """Return a tape with its instructions in this order of positions; others are dropped."""
    old, operands, position = tape_.instructions, tape_.operands, [0] * len(tape_.instructions)
    instructions = list[Instruction]()
    for new, k in enumerate(order):
        position[k] = new
        instruction = old[k]
        if operands[k]:
            args = tuple([position[a] for a in operands[k]])
            instruction = Instruction._make((instruction.op, args, instruction.value, instruction.name))
        instructions.append(instruction)
    return Tape(tuple(instructions), tuple(tuple(position[v] for v in result) for result in tape_.results))


def _order(tape_: Tape, roots: Sequence[int]) -> list[int]:
    """Return the values that others need, each after its operands, by depth-first search."""
    order: list[int] = []
    operands = tape_.operands
    entered = bytearray(len(operands))
    stack = list(reversed(roots))
    while stack:
        k = stack.pop()
        if k < 0:  # its operands precede it in the order
            order.append(~k)
        elif not entered[k]:
            entered[k] = True
            stack.append(~k)
            stack.extend(reversed(operands[k]))
    return order
