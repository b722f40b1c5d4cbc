# SPDX-License-Identifier: Apache-2.0
"""Generated functions as graphs with named arguments and results."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial

import casadi as ca

from mehvar.base.manifest import Part, Signature

LEAST = 8
"""Smallest number of equal parts, such as pendulums, for a loop in generated C."""
MANY = 16
"""Smallest number of equal parts for Jacobians by columns.

With 8 pendulums a Jacobian with all elements is ten times as fast. With 16 it takes 1.5 times as long to compile and
run once, and its text grows with the square of the number.
"""


@dataclass(frozen=True)
class NamedSteps:
    """Definitions that a function evaluates, in derivation order.

    Attributes
    ----------
    numbers : mapping of str to str
        Equation number of each name in the paper; may be empty.
    graph : casadi.Function
        Function that computes the values of all definitions from the first arguments.
    """

    numbers: Mapping[str, str]
    graph: ca.Function


@dataclass(frozen=True)
class FunctionGraph:
    """One function of a generated model.

    Attributes
    ----------
    name, description : str
        Name in C and Python, and a one-line description.
    arguments, results : tuple of (name, size)
        Vectors; the size of a scalar is None.
    graph : casadi.Function
        The SX function to print.
    part : str
        The C file that contains it; files that runs do not need are compiled on first use.
    of : str
        For a derivative, the differentiated function.
    change : str
        For a Jacobian, the directional derivative that gives its columns, if there is one.
    parameters : set of int
        Arguments that are constant in a run; empty for a function that a run calls only once.
    held : set of int
        Arguments that are constant between samples of a law.
    elements : mapping of str to tuple of str
        Names of the elements of each argument.
    families : mapping of str to tuple of (str, int)
        For each vector, the family and number of each element; an empty family name for others.
    derivation : NamedSteps, optional
        The named steps between arguments and results.
    """

    name: str
    description: str
    arguments: Signature
    results: Signature
    graph: ca.Function
    part: Part = ""
    of: str = ""
    change: str = ""
    parameters: frozenset[int] = frozenset()
    held: frozenset[int] = frozenset()
    elements: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    families: Mapping[str, tuple[tuple[str, int], ...]] = field(default_factory=dict)
    derivation: NamedSteps | None = None


def sx_instructions(function: ca.Function) -> Iterator[tuple[int, list[int], list[int]]]:
    """Return operation, places of the operands and places of the result of each instruction of an SX function.

    The methods get the pointer in the Python object, because a search for it takes six times as long as the call.
    """
    pointer, numbers = function.this, range(function.n_instructions())  # type: ignore[attr-defined]
    methods = ca.Function.instruction_id, ca.Function.instruction_input, ca.Function.instruction_output
    return zip(*(map(partial(method, pointer), numbers) for method in methods), strict=True)
