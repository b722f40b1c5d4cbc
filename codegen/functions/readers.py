# SPDX-License-Identifier: Apache-2.0
"""Functions that read each parameter; a run refuses parameters that none of its functions reads."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import sympy as sp

from mehvar.base.names import identifier
from mehvar.models.check import formulas
from mehvar.models.derivation import free_symbols
from mehvar.models.system import Controller, Expr, Group, System

from .requests import Request, bindings, requests


@dataclass(frozen=True)
class Reader:
    """A function, or an element of an initial state or formula, with the symbols that it depends on.

    Its name is the function's; for an element, a dot and the element's name follow, as in "initial.rho".
    """

    name: str
    law: str
    symbols: frozenset[sp.Symbol]


def readers(system: System) -> list[Reader]:
    """Return all functions that affect a run; a reader of a reference also reads the reference's parameters.

    Runs use no margins except those of limits, and no public functions of the model.
    """
    reference = dict(zip(system.references.symbols, system.reference, strict=True))
    laws = {f"{identifier(law.name)}_defaults": law for law in system.controllers}
    own = {function.name for function in system.functions}
    result = []
    for request in requests(system):
        if request.name in own or (request.name != "limits" and request.results[0][0] == "margin"):
            continue
        law = request.law or laws.get(request.name)
        definitions = system.definitions | reference | bindings(system, request)
        for name, entries in _elements(system, request, laws.get(request.name)):
            result.append(Reader(name, law.name if law else "", frozenset(free_symbols(entries, definitions))))
    return result


def readers_of(group: Group, listing: Iterable[Reader], law: str = "") -> Mapping[str, tuple[str, ...]]:
    """Return the names of the readers of each parameter of a group; a law's parameter has readers of that law only."""
    rows = [reader for reader in listing if not law or reader.law == law]
    return {q.name: tuple(row.name for row in rows if q.symbol in row.symbols) for q in group}


def _elements(system: System, request: Request, law: Controller | None) -> list[tuple[str, tuple[Expr, ...]]]:
    """Return a function as a whole, or element by element if a user may set single elements."""
    entries = tuple(entry for _, results in request.results for entry in results)
    names = (
        [q.name for q in system.states] if request.name == "initial" else list(formulas(law.parameters)) if law else []
    )
    if not names:
        return [(request.name, entries)]
    return [(f"{request.name}.{name}", (entry,)) for name, entry in zip(names, entries, strict=True)]
