# SPDX-License-Identifier: Apache-2.0
"""Defaults of parameters that are formulas in other parameters."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import sympy as sp

from mehvar.base.errors import suggestion

from ..quantities import Group, ModelError, Parameter
from ..system import Expr

_NAMESPACE: dict[str, Any] = {"sqrt": sp.sqrt, "pi": sp.pi}


def formulas(group: Group) -> dict[str, Expr]:
    """Return the formula defaults of a group in an order in which they can be computed.

    Raises
    ------
    ModelError
        If a formula is not an expression in parameters of the group, or refers to itself.
    """
    symbols = {q.name: q.symbol for q in group}
    result = {
        parameter.name: _parse(parameter, symbols)
        for parameter in group
        if isinstance(parameter, Parameter) and isinstance(parameter.default, str)
    }
    _check_ends({name: {s.name for s in expr.free_symbols} for name, expr in result.items()})
    return result


def _check_ends(uses: Mapping[str, set[str]]) -> None:
    """Refuse circular formulas."""
    waiting = dict(uses)
    while waiting:
        ready = [name for name, names in waiting.items() if not names & waiting.keys()]
        if not ready:
            raise ModelError(f"the defaults of {', '.join(waiting)} are circular formulas")
        waiting = {name: names for name, names in waiting.items() if name not in ready}


def _parse(parameter: Parameter, symbols: Mapping[str, sp.Symbol]) -> Expr:
    """Return a default as an expression; refuse text that is no formula in the group's parameters."""
    where = f"default of {parameter.name} = {parameter.default!r}"
    try:
        expr = sp.sympify(parameter.default, locals={**_NAMESPACE, **symbols})
    except (sp.SympifyError, SyntaxError, TypeError, AttributeError) as error:
        raise ModelError(f"{where} is not a formula: {error}") from error
    if not isinstance(expr, sp.Expr):
        raise ModelError(f"{where} is not a formula: it is a {type(expr).__name__}")
    unknown = {s.name for s in expr.free_symbols} - set(symbols)
    if unknown:
        name = sorted(unknown)[0]
        raise ModelError(f"{where} uses {name!r}, which is not a parameter of this group{suggestion(name, symbols)}")
    return expr
