# SPDX-License-Identifier: Apache-2.0
"""Events: zero crossings of guards, with optional resets of states.

A mode is a state with rate zero that only resets change. An event without resets is a switching surface: an
integration step ends on it, so that no step crosses a kink.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import sympy as sp
from sympy.core.relational import Relational

from mehvar.base.manifest import Direction

from . import arguments
from .derivation import Derivation, Expr
from .quantities import Located


@dataclass(frozen=True)
class Event(Located):
    """Zero crossing of a guard.

    Parameters
    ----------
    name : str
        Identifier in results and messages.
    guard : Expr
        A function of x, u, p and time; for a law's event, of x, r, p and c.
    direction : {"either", "rising", "falling"}
        Crossings that count as events.
    reset : mapping of sympy.Symbol to Expr
        New value of a state as a function of x, u, p and time before the event; other states keep their values. An
        event without resets is a switching surface.
    ends : bool or {"failure", "success"}
        Effect on the run. A failure ends the run, which never succeeds in a batch. `True` or a success ends it
        regularly: it succeeds if it fulfils the success condition. An event with one direction that ends runs has a
        forbidden side: a run also ends if it starts there, or if a reset or a jump of the input moves it there. A run
        that starts there has failed, unless the event is a success.
    title : str
        A one-line description.
    """

    name: str
    guard: Expr
    direction: Direction = "either"
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
        Name of the events, to which a number is added.
    expressions : Expr, or sequence or matrix of Expr
        Rates, or the command of a continuous law. Each `Min`, `Max`, `sign`, `Abs` and `Piecewise` in them gives an
        event.
    derivation : Derivation, optional
        Definitions that the expressions use; they are searched too.

    Raises
    ------
    ModelError
        If an argument has the wrong type.
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
    """Yield all parts of expressions and of the definitions that they use, each definition once."""
    stack, seen = list(roots)[::-1], set[str]()
    while stack:
        for node in sp.preorder_traversal(stack.pop()):
            yield node
            if isinstance(node, sp.Symbol) and node in definitions and node.name not in seen:
                seen.add(node.name)
                stack.append(definitions[node])


def _kinks(node: sp.Basic) -> Iterator[Expr]:
    """Yield guards whose zeros are the kinks and jumps of an expression's parts."""
    if isinstance(node, sp.Min | sp.Max):
        for a, b in itertools.combinations(sorted(node.args, key=sp.default_sort_key), 2):
            yield a - b
    elif isinstance(node, sp.sign | sp.Abs):
        yield node.args[0]
    elif isinstance(node, Relational):
        yield node.lhs - node.rhs
