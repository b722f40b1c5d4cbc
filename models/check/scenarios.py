# SPDX-License-Identifier: Apache-2.0
"""Check that parameters are used, and that scenarios refer to existing names."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from pathlib import Path

from mehvar.base.errors import suggestion, value_text

from ..derivation import free_symbols
from ..quantities import Group, ModelError, Parameter
from ..system import Controller, Expr, System
from ..tables import check_names, check_scenario_numbers, check_values, place_of
from .formulas import formulas
from .names import check_distinct
from .vectors import Vector, located_groups

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]*")
"""Pattern for names of scenarios, which occur in commands and file names."""
_MAY_BE_IDLE = ("state", "parameter", "scenario parameter", "coordinate", "input of the chart")
"""Groups whose quantities need no reader, or are checked by name."""


def check_scenarios(system: System, vectors: Iterable[Vector], folder: Path | None = None) -> None:
    """Refuse unused parameters, and invalid names and values in scenarios."""
    _check_parameters(system)
    vectors = list(vectors)
    _check_parameters_used(system, vectors)
    _check_symbols_used(system, vectors)
    _check_scenarios(system, folder)


def _check_parameters(system: System) -> None:
    """Refuse parameters without bounds or default, and defaults that cannot be computed or are out of bounds."""
    shared = [(q, False) for group in (system.parameters, system.scenario_parameters) for q in group]
    for q, computed in (*shared, *((q, True) for law in system.controllers for q in law.parameters)):
        where = f"{system.origin}: parameter {q.name!r}"
        if not isinstance(q, Parameter):
            raise ModelError(
                f"{where} is a {type(q).__name__}: must be of the class Parameter, with default and bounds"
            )
        if isinstance(q.default, str) and not computed:
            raise ModelError(f"{where}: default = {value_text(q.default)} must be a number: only laws have formulas")
        if not isinstance(q.default, str) and not (math.isfinite(q.default) and q.default in q.bounds):
            raise ModelError(f"{where}: default = {q.default:g} is outside its bounds {q.bounds}")


def _check_parameters_used(system: System, vectors: list[Vector]) -> None:
    for group in (system.parameters, system.scenario_parameters):
        used = {s.name for s in free_symbols((e for v in vectors for e in v.entries), system.definitions)}
        used |= {law.period for law in system.controllers} | {*system.delays.values()}
        _refuse_unused(group, used, f"group {group.name!r} of {system.name}", system.origin)
    for law in system.controllers:
        own = [e for v in vectors if law.parameters in v.receives for e in v.entries]
        used = {s.name for s in free_symbols([*own, *_formulas(law)], system.definitions)}
        _refuse_unused(law.parameters, used | {law.delay, law.every}, f"law {law.name!r}", law.origin)


def _check_symbols_used(system: System, vectors: list[Vector]) -> None:
    """Refuse unused inputs, references and noise."""
    # A function that only passes a group on, such as an identity chart, does not read it; a rate or an output does.
    reading = [
        v for v in vectors if v.what in {"rhs", "output"} or not any(v.entries == group.symbols for group in v.receives)
    ]
    used = free_symbols((e for v in reading for e in v.entries), system.definitions)
    for kind, group, part in located_groups(system):
        for q in group if kind not in _MAY_BE_IDLE else ():
            if q.symbol not in used:
                raise ModelError(f"{part.origin}: {kind} {q.name!r} would be ignored: no expression contains it")
    for law in system.controllers:  # applied inputs come as a whole group, of which a law may need only one
        if len(law.applied) and not used.intersection(law.applied.symbols):
            raise ModelError(f"{law.origin}: applied of law {law.name!r} would be ignored: no expression contains it")


def _formulas(law: Controller) -> list[Expr]:
    try:
        return list(formulas(law.parameters).values())
    except ModelError as error:
        raise ModelError(f"{law.origin}: law {law.name!r}: {error}") from error


def _refuse_unused(group: Group, used: set[str], where: str, origin: str) -> None:
    for quantity in group:
        if quantity.name not in used:
            raise ModelError(
                f"{origin}: parameter {quantity.name!r} ({where}) is used by no right-hand side, output, law or "
                f"scenario; remove it or use it{suggestion(quantity.name, used)}"
            )


def _check_scenarios(system: System, folder: Path | None) -> None:
    """Refuse invalid names and numbers of scenarios, and unknown laws, parameters and metrics in them."""
    laws = {c.name: _by_name(c.parameters) for c in system.controllers}
    shared = _by_name(system.parameters) | _by_name(system.scenario_parameters)
    metrics = {m.name for m in system.metrics}
    check_distinct([scenario.name for scenario in system.scenarios], f"{system.origin}: scenario")
    for scenario in system.scenarios:
        place = place_of(folder, "scenarios", scenario.name, system.origin)
        where = f"{place}: scenario {scenario.name!r} of {system.name}"
        if not _NAME.fullmatch(scenario.name):
            raise ModelError(f"{where}: the name must be letters, digits and any of '_', '-', '.', without spaces")
        check_scenario_numbers(scenario, where)
        check_values(scenario.values, shared, where)
        for table in (scenario.controllers, scenario.expect):
            check_names(table, laws, f"{where}: controller")
        for law, values in scenario.controllers.items():
            check_values(values, laws[law], f"{where}, law {law!r}")
        for expected in scenario.expect.values():
            check_names(expected, metrics, f"{where}: metric")


def _by_name(group: Group) -> dict[str, Parameter]:
    return {q.name: q for q in group if isinstance(q, Parameter)}
