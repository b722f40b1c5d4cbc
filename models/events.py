# SPDX-License-Identifier: Apache-2.0
"""Events: zero crossings of guards, with resets of states.

A mode is a state whose rate is zero and which resets assign, so that modes need nothing of their own. An event that
resets nothing is a switching surface: a step ends on it, so that none crosses a kink.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import sympy as sp
from sympy.core.relational import Relational

from . import arguments
from .derivation import Derivation, Expr
from .quantities import Located


@dataclass(frozen=True)
class Event(Located):
    """Zero crossing of a guard.

    Parameters
    ----------
    name : str
        Identifier, in results and messages.
    guard : Expr
        A function of x, u, p and time; of a law's events of x, r, p and c.
    direction : {"either", "rising", "falling"}
        Which crossings count.
    reset : mapping of sympy.Symbol to Expr
        The value that a state has after the event, as a function of x, u, p and time before it; the others keep
        theirs. An event without resets is a switching surface.
    ends : bool or {"failure", "success"}
        Whether the run ends there, and what that is. A run that a failure ends never succeeds in a batch; one that
        `True` or a success ends came to its end, and succeeds if it fulfils the condition. An event of one direction
        that ends runs has a side on which none is: what is past it at the start, or gets there by a reset or a jump of
        the input, ends there. Past it at the start, a run failed unless the event is a success.
    title : str
        One line for people.
    """

    name: str
    guard: Expr
    direction: str = "either"
    reset: Mapping[sp.Symbol, Expr] = field(default_factory=dict)
    ends: bool | str = False
    title: str = ""

    @property
    def outcome(self) -> str:
        """Effect of the event on the run, one of `mehvar.base.manifest.ENDS`."""
        return self.ends if isinstance(self.ends, str) else "run" if self.ends else ""


def surfaces(name: str, expressions: Expr | Sequence[Expr], derivation: Derivation | None = None) -> tuple[Event, ...]:
    """Return events at kinks and jumps of expressions, so that no integration step crosses one.

    Parameters
    ----------
    name : str
        What the events are called, with a number each.
    expressions : Expr, or sequence or matrix of Expr
        Rates, or the command of a continuous law. Every `Min`, `Max`, `sign`, `Abs` and `Piecewise` in them counts.
    derivation : Derivation, optional
        Where the definitions stand that the expressions use; they are looked through.

    Raises
    ------
    ModelError
        For an argument of another kind.
    """
    arguments.instance("name", name, str, "an identifier")
    several = isinstance(expressions, tuple | list | sp.MatrixBase)
    roots = arguments.expressions("expressions", expressions if several else (expressions,))
    definitions: Mapping[sp.Symbol, Expr] = {}
    if derivation is not None:
        definitions = arguments.instance("derivation", derivation, Derivation, "a Derivation").definitions
    guards: dict[str, Expr] = {}  # by their texts: while a model is derived, equality of expressions is refused
    for node in _parts(roots, definitions):
        for guard in _kinks(node):
            if guard.free_symbols and sp.srepr(-guard) not in guards:
                guards[sp.srepr(guard)] = guard
    return tuple(Event(f"{name}_{k}", guard, title=f"kink of {name}") for k, guard in enumerate(guards.values(), 1))


def _parts(roots: Iterable[sp.Basic], definitions: Mapping[sp.Symbol, Expr]) -> Iterator[sp.Basic]:
    """Yield all parts of expressions; each definition once."""
    stack, seen = list(roots)[::-1], set[str]()
    while stack:
        for node in sp.preorder_traversal(stack.pop()):
            yield node
            if isinstance(node, sp.Symbol) and node in definitions and node.name not in seen:
                seen.add(node.name)
                stack.append(definitions[node])


def _kinks(node: sp.Basic) -> Iterator[Expr]:
    """Yield guards that are zero where a part of an expression has a kink or jump."""
    if isinstance(node, sp.Min | sp.Max):
        for a, b in itertools.combinations(sorted(node.args, key=sp.default_sort_key), 2):
            yield a - b
    elif isinstance(node, sp.sign | sp.Abs):
        yield node.args[0]
    elif isinstance(node, Relational):
        yield node.lhs - node.rhs
