# SPDX-License-Identifier: Apache-2.0
"""Generated functions: graphs with names for their arguments and results."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import casadi as ca

from mehvar.base.manifest import Part

Signature = tuple[tuple[str, int | None], ...]


@dataclass(frozen=True)
class NamedSteps:
    """Definitions that a function evaluates, in derivation order.

    Attributes
    ----------
    numbers : mapping of str to str
        Of each name the paper's equation number, which may be empty.
    graph : casadi.Function
        From the first arguments of the function to a vector of their values.
    """

    numbers: Mapping[str, str]
    graph: ca.Function


@dataclass(frozen=True)
class FunctionGraph:
    """One function of a generated model.

    Attributes
    ----------
    name, description : str
        Its name in C and Python, and one line for people.
    arguments, results : tuple of (name, size)
        Vectors; the size of a scalar is None.
    graph : casadi.Function
        The SX function that the text is printed from.
    part : str
        Which C file of the model it goes into: what a run does not call is compiled on first use.
    of : str
        The function that it is a derivative of.
    parameters : set of int
        The arguments that stay the same along a run; empty for a function that a run does not call again and again.
    held : set of int
        The arguments that stay the same from one sample of a law to the next.
    elements : mapping of str to tuple of str
        Names of the elements of each vector that it receives.
    families : mapping of str to tuple of (str, int)
        Of each vector the family of every element and its number there; an empty name where it is of none.
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
    parameters: frozenset[int] = frozenset()
    held: frozenset[int] = frozenset()
    elements: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    families: Mapping[str, tuple[tuple[str, int], ...]] = field(default_factory=dict)
    derivation: NamedSteps | None = None
