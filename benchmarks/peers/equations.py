# SPDX-License-Identifier: Apache-2.0
"""The generated functions for other integrators, translated from the instructions from which mehvar's C is printed.

Nothing is typed by hand: a peer gets the instructions of `rhs_prepared` (what is left of the right-hand side after all
that depends on parameters and held input alone has been computed once per run), as text or as its own expressions.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from types import ModuleType
from typing import Any

import numpy as np

from mehvar.codegen.code.files import PrintedFunction, printed_functions
from mehvar.codegen.code.spelling import PYTHON, Language, Printer
from mehvar.codegen.code.tape import Tape
from mehvar.codegen.functions.graphs import generate_functions
from mehvar.codegen.generate import installed_tree, system_of

Operations = Mapping[str, Callable[..., Any]]


class Equations:
    """The tapes of a model with a structure, by function name."""

    def __init__(self, model: str, structure: Mapping[str, str]) -> None:
        functions = printed_functions(generate_functions(system_of(installed_tree(), model, structure)))
        self._functions = {f.name: f for f in functions}

    def best(self, name: str) -> PrintedFunction:
        """Return the function of every stage: the prepared form if there is one."""
        return self._functions.get(f"{name}_prepared") or self._functions[name]

    def parts(self, name: str) -> list[PrintedFunction]:
        """Return the preparations in order."""
        names = [f"{name}_{step}" for step in ("prepare", "hold")]
        return [self._functions[n] for n in names if n in self._functions]

    def __getitem__(self, name: str) -> PrintedFunction:
        return self._functions[name]

    def __contains__(self, name: str) -> bool:
        return name in self._functions


def packed(function: PrintedFunction, state: str) -> tuple[PrintedFunction, list[tuple[str, int]]]:
    """Return a function of (x, k), and the argument and element of each number in k."""
    names = [name for name, _ in function.arguments]
    read = sorted({i.args for i in function.tape.instructions if i.op == "input" and names[i.args[0]] != state})
    place = {args: (1, k) for k, args in enumerate(read)}
    instructions = tuple(
        i._replace(args=place.get(i.args, (0, i.args[1]))) if i.op == "input" else i for i in function.tape.instructions
    )
    arguments = (("x", dict(function.arguments)[state]), ("k", len(read)))
    tape = Tape(instructions, function.tape.results)
    return dataclasses.replace(function, arguments=arguments, tape=tape), [(names[a], e) for a, e in read]


def walk(tape: Tape, arguments: Sequence[Sequence[Any]], operations: Operations) -> list[list[Any]]:
    """Evaluate a tape with numbers or expressions of another library."""
    values: list[Any] = []
    for i in tape.instructions:
        if i.op == "const":
            values.append(i.value)
        elif i.op == "input":
            values.append(arguments[i.args[0]][i.args[1]])
        else:
            values.append(operations[i.op](*(values[a] for a in i.args)))
    return [[values[v] for v in result] for result in tape.results]


ARITHMETIC: Operations = {
    "add": lambda a, b: a + b,
    "sub": lambda a, b: a - b,
    "mul": lambda a, b: a * b,
    "div": lambda a, b: a / b,
    "neg": lambda a: -a,
}


def array_operations(xp: ModuleType) -> Operations:
    """Return the operations of a module with NumPy's names."""
    names = {"asin": "arcsin", "acos": "arccos", "atan": "arctan", "atan2": "arctan2", "min": "minimum",
             "max": "maximum", "fabs": "abs", "pow": "power"}  # fmt: skip
    same = ("sin", "cos", "tan", "sqrt", "sign", "floor", "exp", "log", "hypot", "copysign")
    found = {op: getattr(xp, names.get(op, op)) for op in (*names, *same)}
    return {
        **ARITHMETIC,
        **found,
        "lt": lambda a, b: a < b,
        "le": lambda a, b: a <= b,
        "eq": lambda a, b: a == b,
        "ne": lambda a, b: a != b,
        "not": xp.logical_not,
        "and": xp.logical_and,
        "or": xp.logical_or,
        "truth": lambda a: a != 0.0,
        "num": lambda m: xp.where(m, 1.0, 0.0),
        "select0": lambda m, a: xp.where(m, a, 0.0),
        "select": xp.where,
    }


_SCALAR = {"fmod": "np.fmod", "fabs": "abs", "min": "min", "max": "max", "sign": "_sign"}


def _scalar_name(op: str) -> str:
    return _SCALAR.get(op, f"math.{op}")


SCALAR: Language = dataclasses.replace(
    PYTHON,
    functions={
        **{op: text.replace(text.split("(")[0], _scalar_name(op), 1) for op, text in PYTHON.functions.items()},
        **{
            "erf": "math.erf({0})", "neg": "-{0}", "lt": "({0} < {1})", "le": "({0} <= {1})", "eq": "({0} == {1})",
            "ne": "({0} != {1})", "not": "(not {0})", "and": "({0} and {1})", "or": "({0} or {1})",
            "truth": "({0} != 0.0)", "num": "(1.0 if {0} else 0.0)", "select0": "({1} if {0} else 0.0)",
            "select": "({1} if {0} else {2})",
        },
    },
    element="{name}[{index}]",
    sincos="{sine}, {cosine} = math.sin({angle}), math.cos({angle})",
)  # fmt: skip
"""Python code on plain numbers, for compilers such as numba."""


def scalar_source(function: PrintedFunction, name: str) -> str:
    """Print a function of vectors that writes its results into its last arguments."""
    lines, results = Printer(function.tape, function.arguments, SCALAR).print()
    names = [argument for argument, _ in function.arguments]
    stores = [
        f"{target}[{k}] = ({value})"  # a long sum has several lines
        for (target, _), values in zip(function.results, results, strict=True)
        for k, value in enumerate(values)
    ]
    header = f"def {name}({', '.join([*names, *(target for target, _ in function.results)])}):"
    return "\n    ".join([header, *lines, *(stores or ["pass"])]) + "\n"


class Compiled:
    """Functions printed by `scalar_source` and compiled by numba, sharing one namespace."""

    def __init__(self, numba: Any) -> None:
        self._numba = numba

    @cached_property
    def _namespace(self) -> dict[str, Any]:
        namespace: dict[str, Any] = {"math": math, "np": np}
        exec("def _sign(x):\n    return 1.0 if x > 0.0 else (-1.0 if x < 0.0 else x)\n", namespace)
        namespace["_sign"] = self._numba.njit(namespace["_sign"])
        return namespace

    def add(self, function: PrintedFunction) -> Any:
        """Compile a function."""
        name = function.name.replace("-", "_")
        exec(scalar_source(function, name), self._namespace)
        return self._numba.njit(fastmath=True, error_model="numpy")(self._namespace[name])
