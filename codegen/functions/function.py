# SPDX-License-Identifier: Apache-2.0
"""What a generated function is: a graph with names for its arguments and results."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca

from mehvar.manifest import Part

Signature = tuple[tuple[str, int | None], ...]


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
