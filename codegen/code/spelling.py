# SPDX-License-Identifier: Apache-2.0
"""Printer of instructions as C or Python, with a table of notations for each."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from .labels import PLAIN, Element, Labels, Names, names_of
from .tape import MASKS, OPERATIONS, Instruction, Tape

_INFIX = {"add": "+", "sub": "-", "mul": "*", "div": "/"}
_PRECEDENCE = {"add": 1, "sub": 1, "mul": 2, "div": 2, "neg": 3}
_ATOM = 4
_WIDTH = 110
"""Largest number of characters in a line of element names: 120 minus indentation."""
_BESIDE = 4
"""Number of elements named on one line, grouped by position, so that a new element changes only one line."""
_Load = tuple[str, object, int]


@dataclass(frozen=True)
class Language:
    """Notation of a language for instructions.

    Attributes
    ----------
    functions : mapping
        Format of each operation that is not infix, with {0}, {1}, ... for the operands.
    constant : callable
        Spells a number so that it re-parses to the same bits.
    element, scalar : str
        Formats of an element of a vector argument, with {name} and {index}, and of a scalar argument.
    declare : callable
        Function that returns the assignment to a value, given its kind, name and expression.
    sincos : str
        Format of the fused sine and cosine, with {angle}, {sine} and {cosine}.
    splat : str
        Format that broadcasts a constant result to all lanes.
    load : callable
        Function that returns the statement that names elements of a vector, given their names, places and indices.
    named : str
        Format of an element with a name.
    comment : str
        Format of a comment after a statement.
    broken : str
        Format of a value that takes several lines.
    """

    functions: Mapping[str, str]
    constant: Callable[[float], str]
    element: str
    scalar: str
    declare: Callable[[str, str, str], str]
    sincos: str
    splat: str
    load: Callable[[str, Sequence[_Load]], str]
    named: str
    comment: str
    broken: str


def _c_load(_: str, elements: Sequence[_Load]) -> str:
    return f"enum {{ {', '.join(f'{name} = {place}' for name, place, _ in elements)} }};"


def _python_load(vector: str, elements: Sequence[_Load]) -> str:
    names, values = zip(*((name, f"{vector}[..., {index}]") for name, _, index in elements), strict=True)
    return f"{', '.join(names)} = {', '.join(values)}"


_MATH = sorted(OPERATIONS - _INFIX.keys() - MASKS - {"neg", "sq", "twice", "inv", "assign", "select0"})
"""Operations that are functions of C's library, and of NumPy except for `erf`."""
_BINARY = {"copysign", "min", "max", "fmod", "hypot", "atan2", "pow"}

C = Language(
    functions={name: f"mv_{name}({{0}}, {{1}})" if name in _BINARY else f"mv_{name}({{0}})" for name in _MATH}
    | {
        "neg": "-{0}", "lt": "LT({0}, {1})", "le": "LE({0}, {1})", "eq": "EQ({0}, {1})", "ne": "NE({0}, {1})",
        "not": "NOT({0})", "and": "AND({0}, {1})", "or": "OR({0}, {1})", "truth": "TRUTH({0})", "num": "NUM({0})",
        "select0": "SELECT0({0}, {1})", "select": "SELECT({0}, {1}, {2})",
    },
    constant=lambda value: f"K({value!r})",
    element="{name}[{index}]",
    scalar="{name}[0]",
    declare=lambda kind, name, value: f"const {kind} {name} = {value};",
    sincos="real {sine}, {cosine}; mv_sincos({angle}, &{sine}, &{cosine});",
    splat="SPLAT({0})",
    load=_c_load,
    named="{vector}[{name}]",
    comment="  /* {} */",
    broken="{}",
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
    constant=repr,
    element="{name}[..., {index}]",
    scalar="{name}",
    declare=lambda _, name, value: f"{name} = {value}",
    sincos="{sine}, {cosine} = np.sin({angle}), np.cos({angle})",
    splat="{0}",
    load=_python_load,
    named="{name}",
    comment="  # {}",
    broken="(\n    {}\n)",
)  # fmt: skip


class Printer:
    """Prints instructions value by value.

    Parameters
    ----------
    tape : Tape
        Instructions to print.
    arguments : sequence of (name, size)
        Names of the arguments; size None for a scalar.
    language : Language
        `C` or `PYTHON`.
    labels : Labels
        Names of elements and of definitions.
    names : Names, optional
        Names of elements and values, if already computed.
    """

    def __init__(
        self,
        tape: Tape,
        arguments: Sequence[tuple[str, int | None]],
        language: Language,
        labels: Labels = PLAIN,
        names: Names | None = None,
    ) -> None:
        names = names or names_of(tape, arguments, labels)
        self._tape, self._arguments, self._language, self._labels = tape, arguments, language, labels
        self._text: dict[int, str] = {}
        self._precedence: dict[int, int] = {}
        self._lines: list[str] = []
        self._elements, self._lined, self._names = names.elements, names.lined, names.values
        self._partner, self._long = names.pairs, names.long

    def print(self) -> tuple[list[str], list[list[str]]]:
        """Return assignments, and an expression for each element of each result; a long sum has several lines.

        Values that are used once are inserted at their use.
        """
        self._load()
        for k, instruction in enumerate(self._tape.instructions):
            if k not in self._text:
                self._place(k, instruction)
        return self._lines, [[self._result(v) for v in result] for result in self._tape.results]

    def _load(self) -> None:
        """Name the elements of vectors that the code reads."""
        read = self._read()
        for place, (vector, _) in enumerate(self._arguments):
            constants = self._labels.constants.get(vector)
            # the places in a part follow from the parts before it
            beside = 1 if vector in self._labels.parts else _BESIDE
            lines: dict[int, list[_Load]] = {}
            for k in sorted(k for a, k in read if a == place and (a, k) in self._elements):
                element = (self._elements[place, k], constants[k] if constants else k, k)
                lines.setdefault(k // beside, []).append(element)
            for elements in lines.values():
                self._add_load(vector, elements)

    def _add_load(self, vector: str, elements: Sequence[_Load]) -> None:
        """Add a statement that names elements, or two shorter ones."""
        statement, half = self._language.load(vector, elements), len(elements) // 2
        if half and len(statement) > _WIDTH:
            self._add_load(vector, elements[:half])
            self._add_load(vector, elements[half:])
        else:
            self._add(statement)

    def _read(self) -> set[Element]:
        """Return the elements that the code reads."""
        return {(i.args[0], i.args[1]) for i in self._tape.instructions if i.op == "input"}

    def _add(self, statement: str) -> None:
        self._lines += statement.split("\n")

    def _place(self, k: int, instruction: Instruction) -> None:
        """Store the text of an instruction's value, and its precedence if it is no atom."""
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
        if (argument, element) in self._elements:
            vector = self._arguments[argument][0]
            return self._language.named.format(vector=vector, name=self._elements[argument, element])
        name, size = self._arguments[argument]
        return (self._language.scalar if size is None else self._language.element).format(name=name, index=element)

    def _fused(self, k: int, instruction: Instruction) -> None:
        other = self._partner[k]
        sine, cosine = (k, other) if instruction.op == "sin" else (other, k)
        self._text[sine], self._text[cosine] = self._names[sine], self._names[cosine]
        angle = self._text[instruction.args[0]]
        self._add(self._language.sincos.format(angle=angle, sine=self._text[sine], cosine=self._text[cosine]))

    def _value(self, k: int, instruction: Instruction) -> None:
        """Store an instruction's text if one line uses it, else assign it to a name."""
        text = self._expression(k, instruction)
        if k not in self._lined:
            self._text[k] = text
            self._precedence[k] = _PRECEDENCE.get(instruction.op, _ATOM)
            return
        kind = "mask" if instruction.op in MASKS else "real"
        self._text[k] = self._names[k]
        value = self._language.broken.format(text) if "\n" in text else text
        self._add(self._language.declare(kind, self._text[k], value) + self._remark(instruction))

    def _remark(self, instruction: Instruction) -> str:
        """Return a comment with the equation number of a definition."""
        number = self._labels.numbers.get(instruction.name, "")
        return self._language.comment.format(number) if number else ""

    def _expression(self, k: int, instruction: Instruction) -> str:
        """Return an instruction as text, in parentheses only where the order of operations needs them."""
        if instruction.op in _INFIX:
            own = _PRECEDENCE[instruction.op]
            left, right = instruction.args
            between = "\n    " if k in self._long else " "
            return f"{self._operand(left, own)}{between}{_INFIX[instruction.op]} {self._operand(right, own + 1)}"
        if instruction.op == "neg":
            return f"-{self._operand(instruction.args[0], _ATOM)}"
        return self._language.functions[instruction.op].format(
            *(self._argument(instruction.op, a) for a in instruction.args)
        )

    def _operand(self, k: int, least: int) -> str:
        """Return an operand, in parentheses if needed to preserve the order of operations and thus the rounding."""
        return self._text[k] if self._precedence.get(k, _ATOM) >= least else f"({self._text[k]})"

    def _argument(self, op: str, k: int) -> str:
        constant = self._tape.instructions[k].op == "const" and op not in MASKS
        return self._language.splat.format(self._text[k]) if constant else self._text[k]

    def _result(self, k: int) -> str:
        constant = self._tape.instructions[k].op == "const"
        return self._language.splat.format(self._text[k]) if constant else self._text[k]
