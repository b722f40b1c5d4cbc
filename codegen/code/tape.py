# SPDX-License-Identifier: Apache-2.0
"""CasADi's instructions in static single assignment form, the source of printed C and Python.

Registers are renamed so that every value has one definition; divisions by a shared denominator become products with
its reciprocal; sine and cosine of one angle are fused; CasADi's pair of `if_else_zero` becomes one select.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import casadi as ca

from mehvar.base.errors import MehvarError

from ..functions.function import NamedSteps

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

    @property
    def operations(self) -> int:
        """Number of arithmetic operations, comparisons and function calls."""
        return sum(i.op not in _FREE for i in self.instructions)

    def uses(self) -> Counter[int]:
        """Count the uses of each value, including results."""
        counts = Counter(a for i in self.instructions for a in i.operands)
        counts.update(v for result in self.results for v in result)
        return counts


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
    plain = _read(function)
    named = plain if derivation is None else _named(plain, derivation)
    return arranged(_share_reciprocals(_fuse_selects(named), parameters), derivation)


class Builder:
    """Builder of a tape, which adds equal instructions only once."""

    def __init__(self) -> None:
        self.instructions: list[Instruction] = []
        self._known: dict[tuple[str, tuple[int, ...], str], int] = {}

    def add(self, op: str, *args: int, value: float = 0.0) -> int:
        """Return the position of an operation; append it if it is new."""
        # repr tells -0.0 from 0.0, which compare equal
        position = self._known.setdefault((op, args, repr(value) if op == "const" else ""), len(self.instructions))
        if position == len(self.instructions):
            self.instructions.append(Instruction(op, args, value))
        return position

    def mark(self, position: int, name: str) -> None:
        """Give a value a name unless it has one."""
        instruction = self.instructions[position]
        self.instructions[position] = instruction._replace(name=instruction.name or name)

    def mask(self, position: int) -> int:
        """Return a truth value: the value itself, or its comparison with zero."""
        if self.instructions[position].op in MASKS:
            return position
        return self.add("truth", position)

    def number(self, position: int) -> int:
        """Return a number: the value itself, or 1 and 0 for a truth value."""
        return self.add("num", position) if self.instructions[position].op in MASKS else position

    def is_flag(self, bound: int, position: int) -> bool:
        """Return True if a number exceeds a bound exactly when its truth value is true."""
        low, flag = self.instructions[bound], self.instructions[position]
        if low.op != "const" or flag.op != "select0":
            return False
        high = self.instructions[flag.args[1]]
        return high.op == "const" and 0.0 <= low.value < high.value


def _read(function: ca.Function) -> Tape:
    builder, register = Builder(), dict[int, int]()
    results = [[0] * function.nnz_out(i) for i in range(function.n_out())]
    for k in range(function.n_instructions()):
        op = function.instruction_id(k)
        if op == ca.OP_OUTPUT:
            result, element = function.instruction_output(k)
            results[result][element] = builder.number(register[function.instruction_input(k)[0]])
            continue
        target = function.instruction_output(k)[0]
        if op == ca.OP_CONST:
            register[target] = builder.add("const", value=function.instruction_constant(k))
        elif op == ca.OP_INPUT:
            argument, element = function.instruction_input(k)
            register[target] = builder.add("input", argument, element)
        else:
            register[target] = _operation(builder, op, [register[i] for i in function.instruction_input(k)], function)
    return Tape(tuple(builder.instructions), tuple(tuple(r) for r in results))


def _operation(builder: Builder, op: int, operands: list[int], function: ca.Function) -> int:
    if op not in _NAMES:
        raise TapeError(f"{function.name()}: CasADi operation number {op} has no counterpart in generated code")
    name = _NAMES[op]
    if name == "assign":
        return operands[0]
    if name in ("not", "and", "or"):
        return builder.add(name, *map(builder.mask, operands))
    if name == "select0":
        return builder.add(name, builder.mask(operands[0]), builder.number(operands[1]))
    numbers = [builder.number(o) for o in operands]
    if name == "lt" and builder.is_flag(*numbers):
        return builder.instructions[numbers[1]].args[0]
    if name in ("sq", "twice"):
        return builder.add("mul" if name == "sq" else "add", numbers[0], numbers[0])
    if name == "inv":
        return builder.add("div", builder.add("const", value=1.0), numbers[0])
    return builder.add(name, *numbers)


def _named(tape_: Tape, derivation: NamedSteps) -> Tape:
    """Name the values of definitions, which are identified by equal operations on equal values."""
    known: dict[tuple[object, ...], int] = {}
    steps = _read(derivation.graph)
    own, others = _identities(tape_, known), _identities(steps, known)
    names: dict[int, str] = {}
    for name, position in zip(derivation.numbers, steps.results[0], strict=True):
        if steps.instructions[position].op not in ("input", "const"):
            names.setdefault(others[position], name)
    marked: list[Instruction] = []
    for identity, instruction in zip(own, tape_.instructions, strict=True):
        marked.append(instruction._replace(name=names.pop(identity)) if identity in names else instruction)
    return Tape(tuple(marked), tape_.results)


def _identities(tape_: Tape, known: dict[tuple[object, ...], int]) -> list[int]:
    """Return numbers for the values of several functions; values with equal operations and operands share a number."""
    numbers: list[int] = []
    for i in tape_.instructions:
        if i.op == "input":
            content: tuple[object, ...] = (i.op, *i.args)
        elif i.op == "const":
            content = (i.op, repr(i.value))
        else:
            operands = [numbers[a] for a in i.args]
            content = (i.op, *(sorted(operands) if i.op in COMMUTATIVE else operands))
        numbers.append(known.setdefault(content, len(known)))
    return numbers


def _rewrite(tape_: Tape, change: dict[int, Instruction]) -> Tape:
    instructions = tuple(
        change[k]._replace(name=i.name) if k in change else i for k, i in enumerate(tape_.instructions)
    )
    return Tape(instructions, tape_.results)


def _fuse_selects(tape_: Tape) -> Tape:
    """Replace select0(c, a) + select0(not c, b) by select(c, a, b)."""
    instructions, change = tape_.instructions, {}
    for k, instruction in enumerate(instructions):
        if instruction.op != "add":
            continue
        first, second = (instructions[a] for a in instruction.args)
        if first.op == second.op == "select0":
            negated = instructions[second.args[0]]
            if negated.op == "not" and negated.args[0] == first.args[0]:
                change[k] = Instruction("select", (first.args[0], first.args[1], second.args[1]))
    return _rewrite(tape_, change)


def early(tape_: Tape, parameters: Collection[int]) -> list[bool]:
    """Return for each value True if it depends on parameters only."""
    constant: list[bool] = []
    for i in tape_.instructions:
        constant.append(i.args[0] in parameters if i.op == "input" else all(constant[a] for a in i.operands))
    return constant


def is_sum(instruction: Instruction) -> bool:
    """Return True if a value is a sum or a difference."""
    return instruction.op in ("add", "sub")


def keeps_place(instruction: Instruction) -> bool:
    """Return True if storing a value saves nothing, or if it is not a number."""
    return instruction.op in _FREE or instruction.op in MASKS


def _share_reciprocals(tape_: Tape, parameters: frozenset[int]) -> Tape:
    """Replace repeated divisions, and those by constant denominators, by products with one reciprocal."""
    constant = early(tape_, parameters)
    quotients = [i.args for i in tape_.instructions if i.op == "div"]
    divisors = Counter(below for _, below in quotients)
    divisors.update(
        below
        for above, below in quotients
        if constant[below] and not constant[above] and tape_.instructions[below].op != "const"
    )
    builder, moved, inverse = Builder(), {}, {}
    for k, instruction in enumerate(tape_.instructions):
        if instruction.op in ("input", "const"):
            moved[k] = builder.add(instruction.op, *instruction.args, value=instruction.value)
            continue
        args = tuple(moved[a] for a in instruction.args)
        if instruction.op == "div" and divisors[instruction.args[1]] > 1:
            divisor = instruction.args[1]
            if divisor not in inverse:
                inverse[divisor] = builder.add("div", builder.add("const", value=1.0), args[1])
            one = tape_.instructions[instruction.args[0]]
            unit = one.op == "const" and one.value == 1.0
            moved[k] = inverse[divisor] if unit else builder.add("mul", args[0], inverse[divisor])
        else:
            moved[k] = builder.add(instruction.op, *args)
        builder.mark(moved[k], instruction.name)
    results = tuple(tuple(moved[v] for v in result) for result in tape_.results)
    return Tape(tuple(builder.instructions), results)


def arranged(tape_: Tape, derivation: NamedSteps | None) -> Tape:
    """Move each value before its first use, and drop unused ones.

    Function calls come first, in the order of their use, then definitions in derivation order, then results. The
    position of a value thus depends on its uses, not on the number of other values.
    """
    results = [v for result in tape_.results for v in result]
    place = {tape_.instructions[k].name: k for k in _needed(tape_)}
    names = derivation.numbers if derivation else ()
    roots = [*(place[name] for name in names if name in place), *results]
    calls = [k for k in _order(tape_, roots) if tape_.instructions[k].op in _CALLS]
    return _reordered(tape_, _order(tape_, [*calls, *roots]))


def prune(tape_: Tape) -> Tape:
    """Drop unused values and renumber."""
    return _reordered(tape_, _needed(tape_))


def _needed(tape_: Tape) -> list[int]:
    """Return the values that results need, in order."""
    needed = [False] * len(tape_.instructions)
    for result in tape_.results:
        for v in result:
            needed[v] = True
    for k in range(len(needed) - 1, -1, -1):
        if needed[k]:
            for a in tape_.instructions[k].operands:
                needed[a] = True
    return [k for k, wanted in enumerate(needed) if wanted]


def _reordered(tape_: Tape, order: Sequence[int]) -> Tape:
    position = {old: new for new, old in enumerate(order)}
    instructions = tuple(
        Instruction(i.op, tuple([position[a] for a in i.args]), i.value, i.name) if i.operands else i
        for i in (tape_.instructions[k] for k in order)
    )
    return Tape(instructions, tuple(tuple(position[v] for v in result) for result in tape_.results))


def _order(tape_: Tape, roots: Sequence[int]) -> list[int]:
    """Return the values that others need, each after its operands, by depth-first search."""
    order: list[int] = []
    entered, seen = set[int](), set[int]()
    stack = list(reversed(roots))
    while stack:
        k = stack[-1]
        if k in seen or k in entered:
            stack.pop()
            if k not in seen:
                seen.add(k)
                order.append(k)
            continue
        entered.add(k)
        stack.extend(a for a in reversed(tape_.instructions[k].operands) if a not in seen)
    return order
