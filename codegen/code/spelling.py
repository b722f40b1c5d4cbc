# SPDX-License-Identifier: Apache-2.0
"""Print a tape as C or Python: what differs between the two is one table of spellings each."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from .tape import MASKS, Instruction, Tape

_INFIX = {"add": "+", "sub": "-", "mul": "*", "div": "/"}
_PRECEDENCE = {"add": 1, "sub": 1, "mul": 2, "div": 2, "neg": 3}
_ATOM = 4
_LONGEST = 72


@dataclass(frozen=True)
class Language:
    """How a language spells a tape.

    Attributes
    ----------
    functions : mapping
        Format of each operation that is not infix, with {0}, {1}, ... for the operands.
    constant : callable
        Spells a number so that it re-parses to the same bits.
    element, scalar : str
        Formats of an element of a vector argument, with {name} and {index}, and of a scalar argument.
    declare : str
        Format of an assignment, with {kind}, {name} and {value}.
    sincos : str
        Format of the fused sine and cosine, with {angle}, {sine} and {cosine}.
    splat : str
        Format that makes a constant a value of full width, where a result is a plain number.
    """

    functions: Mapping[str, str]
    constant: Callable[[float], str]
    element: str
    scalar: str
    declare: str
    sincos: str
    splat: str


def _c_constant(value: float) -> str:
    return f"K({value!r})"


def _python_constant(value: float) -> str:
    return repr(value)


_MATH = [
    "sqrt",
    "fabs",
    "sign",
    "copysign",
    "min",
    "max",
    "floor",
    "ceil",
    "fmod",
    "hypot",
    "sin",
    "cos",
    "tan",
    "asin",
    "acos",
    "atan",
    "atan2",
    "exp",
    "log",
    "log1p",
    "expm1",
    "sinh",
    "cosh",
    "tanh",
    "asinh",
    "acosh",
    "atanh",
    "erf",
    "pow",
]
_BINARY = {"copysign", "min", "max", "fmod", "hypot", "atan2", "pow"}

C = Language(
    functions={name: f"mv_{name}({{0}}, {{1}})" if name in _BINARY else f"mv_{name}({{0}})" for name in _MATH}
    | {
        "neg": "-{0}", "lt": "LT({0}, {1})", "le": "LE({0}, {1})", "eq": "EQ({0}, {1})", "ne": "NE({0}, {1})",
        "not": "NOT({0})", "and": "AND({0}, {1})", "or": "OR({0}, {1})", "truth": "TRUTH({0})", "num": "NUM({0})",
        "select0": "SELECT0({0}, {1})", "select": "SELECT({0}, {1}, {2})",
    },
    constant=_c_constant,
    element="{name}[{index}]",
    scalar="{name}[0]",
    declare="const {kind} {name} = {value};",
    sincos="real {sine}, {cosine}; mv_sincos({angle}, &{sine}, &{cosine});",
    splat="SPLAT({0})",
)  # fmt: skip

_NUMPY = {
    "fabs": "abs", "min": "fmin", "max": "fmax", "asin": "arcsin", "acos": "arccos", "atan": "arctan",
    "atan2": "arctan2", "asinh": "arcsinh", "acosh": "arccosh", "atanh": "arctanh", "pow": "power",
}  # fmt: skip
PYTHON = Language(
    functions={
        name: f"np.{_NUMPY.get(name, name)}({{0}}, {{1}})" if name in _BINARY else f"np.{_NUMPY.get(name, name)}({{0}})"
        for name in _MATH
        if name != "erf"
    }
    | {
        "erf": "_erf({0})", "neg": "-{0}", "lt": "({0} < {1})", "le": "({0} <= {1})", "eq": "({0} == {1})",
        "ne": "({0} != {1})", "not": "np.logical_not({0})", "and": "np.logical_and({0}, {1})",
        "or": "np.logical_or({0}, {1})", "truth": "({0} != 0.0)", "num": "np.where({0}, 1.0, 0.0)",
        "select0": "np.where({0}, {1}, 0.0)", "select": "np.where({0}, {1}, {2})",
    },
    constant=_python_constant,
    element="{name}[..., {index}]",
    scalar="{name}",
    declare="{name} = {value}",
    sincos="{sine}, {cosine} = np.sin({angle}), np.cos({angle})",
    splat="{0}",
)  # fmt: skip


def statements(
    tape: Tape, arguments: Sequence[tuple[str, int | None]], language: Language
) -> tuple[list[str], list[list[str]]]:
    """Print a tape.

    Parameters
    ----------
    tape : Tape
        What to print.
    arguments : sequence of (name, size)
        Names of the arguments; size None for a scalar.
    language : Language
        `C` or `PYTHON`.

    Returns
    -------
    lines : list of str
        Assignments, one value a line; values used once stand inside the line that uses them.
    results : list of list of str
        An expression for each element of each result.
    """
    return _Printer(tape, arguments, language).print()


class _Printer:
    def __init__(self, tape: Tape, arguments: Sequence[tuple[str, int | None]], language: Language) -> None:
        self._tape, self._arguments, self._language = tape, arguments, language
        self._text: dict[int, str] = {}
        self._precedence: dict[int, int] = {}
        self._lines: list[str] = []
        self._uses = tape.uses()
        self._partner = self._sincos_pairs()

    def print(self) -> tuple[list[str], list[list[str]]]:
        for k, instruction in enumerate(self._tape.instructions):
            if k not in self._text:
                self._place(k, instruction)
        return self._lines, [[self._result(v) for v in result] for result in self._tape.results]

    def _sincos_pairs(self) -> dict[int, int]:
        places: dict[tuple[str, int], int] = {}
        for k, i in enumerate(self._tape.instructions):
            if i.op in ("sin", "cos"):
                places[i.op, i.args[0]] = k
        return {places["sin", a]: places["cos", a] for op, a in places if op == "sin" and ("cos", a) in places} | {
            places["cos", a]: places["sin", a] for op, a in places if op == "cos" and ("sin", a) in places
        }

    def _place(self, k: int, instruction: Instruction) -> None:
        if instruction.op == "const":
            self._text[k] = self._language.constant(instruction.value)
            if self._text[k].startswith("-"):
                self._precedence[k] = _PRECEDENCE["neg"]
        elif instruction.op == "input":
            self._text[k] = self._input(*instruction.args)
        elif k in self._partner:
            self._fused(k, instruction)
        else:
            self._value(k, instruction)

    def _input(self, argument: int, element: int) -> str:
        name, size = self._arguments[argument]
        return (self._language.scalar if size is None else self._language.element).format(name=name, index=element)

    def _fused(self, k: int, instruction: Instruction) -> None:
        other = self._partner[k]
        sine, cosine = (k, other) if instruction.op == "sin" else (other, k)
        self._text[sine], self._text[cosine] = f"s{min(k, other)}", f"c{min(k, other)}"
        angle = self._text[instruction.args[0]]
        self._lines.append(self._language.sincos.format(angle=angle, sine=self._text[sine], cosine=self._text[cosine]))

    def _value(self, k: int, instruction: Instruction) -> None:
        text = self._expression(instruction)
        if self._uses[k] == 1 and len(text) <= _LONGEST and instruction.op not in MASKS:
            self._text[k] = text
            self._precedence[k] = _PRECEDENCE.get(instruction.op, _ATOM)
            return
        kind, letter = ("mask", "m") if instruction.op in MASKS else ("real", "v")
        self._text[k] = f"{letter}{k}"
        self._lines.append(self._language.declare.format(kind=kind, name=self._text[k], value=text))

    def _expression(self, instruction: Instruction) -> str:
        if instruction.op in _INFIX:
            own = _PRECEDENCE[instruction.op]
            left, right = instruction.args
            return f"{self._operand(left, own)} {_INFIX[instruction.op]} {self._operand(right, own + 1)}"
        if instruction.op == "neg":
            return f"-{self._operand(instruction.args[0], _ATOM)}"
        return self._language.functions[instruction.op].format(
            *(self._argument(instruction.op, a) for a in instruction.args)
        )

    def _operand(self, k: int, least: int) -> str:
        """Spell an operand, in brackets when it binds less tightly than needed; rounding follows the tape's order."""
        return self._text[k] if self._precedence.get(k, _ATOM) >= least else f"({self._text[k]})"

    def _argument(self, op: str, k: int) -> str:
        constant = self._tape.instructions[k].op == "const" and op not in MASKS
        return self._language.splat.format(self._text[k]) if constant else self._text[k]

    def _result(self, k: int) -> str:
        constant = self._tape.instructions[k].op == "const"
        return self._language.splat.format(self._text[k]) if constant else self._text[k]
