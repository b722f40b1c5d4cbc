# SPDX-License-Identifier: Apache-2.0
"""What makes a model's text wrong: unused parameters, unknown names, values out of bounds, branches on symbols."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import sympy as sp

from .system import Controller, Expr, Group, ModelError, Parameter, System, free_symbols
from .tables import check_names, check_values, suggestion

_FORMULA_NAMESPACE: dict[str, Any] = {"sqrt": sp.sqrt, "pi": sp.pi}


def check(system: System) -> None:
    """Refuse a system whose parts do not fit together.

    Raises
    ------
    ModelError
        Naming the parameter, scenario or metric and what would be right.
    """
    _check_names(system)
    _check_times(system)
    _check_parameters_used(system)
    _check_scenarios(system)
    _check_metrics(system)


def formulas(group: Group) -> dict[str, Expr]:
    """Return the defaults of a group that are formulas in its other parameters.

    Raises
    ------
    ModelError
        If a formula is not an expression in parameters of the group.
    """
    symbols = {q.name: q.symbol for q in group}
    return {
        parameter.name: _parse_formula(parameter, symbols)
        for parameter in group
        if isinstance(parameter, Parameter) and isinstance(parameter.default, str)
    }


@contextlib.contextmanager
def no_branching() -> Iterator[None]:
    """Make a Python `if` on a symbol an error while a model is derived.

    SymPy already refuses `if x > 0`. It lets `if x:` and `if x == 0:` pass and takes one branch silently, the second
    because the two differ in form; inside this context both raise `ModelError` when they stand in a model's own text.
    """
    plain_eq, plain_ne = sp.Expr.__eq__, sp.Expr.__ne__

    def truth(expr: Expr) -> bool:
        _refuse_outside_sympy(expr, "the truth of")
        return True

    def equal(expr: Expr, other: object) -> Any:
        same = plain_eq(expr, other)
        if same is not True and isinstance(other, int | float | sp.Expr) and (_symbolic(expr) or _symbolic(other)):
            _refuse_outside_sympy(expr, "equality with")
        return same

    def unequal(expr: Expr, other: object) -> Any:
        same = equal(expr, other)
        return same if same is NotImplemented else not same

    sp.Expr.__bool__ = truth
    sp.Expr.__eq__, sp.Expr.__ne__ = equal, unequal
    try:
        yield
    finally:
        del sp.Expr.__bool__
        sp.Expr.__eq__, sp.Expr.__ne__ = plain_eq, plain_ne


def _symbolic(value: object) -> bool:
    return isinstance(value, sp.Expr) and bool(value.free_symbols)


def _refuse_outside_sympy(expr: Expr, what: str) -> None:
    frame = sys._getframe(2)
    while frame.f_globals.get("__name__") == __name__ and frame.f_back:
        frame = frame.f_back
    if frame.f_globals.get("__name__", "").partition(".")[0] in ("sympy", "mpmath"):
        return
    if expr.free_symbols:
        raise ModelError(
            f"{frame.f_code.co_filename}:{frame.f_lineno}: a Python branch asks for {what} the symbolic expression "
            f"{expr}; use sympy.Piecewise so that both branches are kept"
        )


def _parse_formula(parameter: Parameter, symbols: Mapping[str, sp.Symbol]) -> Expr:
    where = f"default of {parameter.name} = {parameter.default!r}"
    try:
        expr = sp.sympify(parameter.default, locals={**_FORMULA_NAMESPACE, **symbols})
    except (sp.SympifyError, TypeError, AttributeError) as error:
        raise ModelError(f"{where} is not a formula: {error}") from error
    unknown = {s.name for s in expr.free_symbols} - set(symbols)
    if unknown:
        name = sorted(unknown)[0]
        raise ModelError(f"{where} uses {name!r}, which is no parameter of this group{suggestion(name, symbols)}")
    return expr


def _used_by(system: System, expressions: Iterable[Expr]) -> set[str]:
    return {s.name for s in free_symbols(expressions, system.definitions)}


def _system_expressions(system: System) -> list[Expr]:
    plants = [e for variant in system.variants for e in variant.rhs]
    loop = system.coordinates.rhs if system.coordinates else ()
    hardware = (
        *(system.actuator.applied if system.actuator else ()),
        *(system.sensor.measured if system.sensor else ()),
    )
    conditions = [c.margin for c in (*system.limits, *system.constraints)]
    own = [expr for function in system.functions for _, expr in function.results]
    ends = (*system.output, *system.initial, *system.reference)
    return [*system.rhs, *plants, *loop, *hardware, *ends, *conditions, *own]


def _law_expressions(controller: Controller) -> list[Expr]:
    margins = (c.margin for c in (*controller.constraints, *controller.warnings))
    reported = (output.value for output in controller.outputs)
    return [*controller.command, *controller.update, *controller.start, *margins, *reported]


def _check_names(system: System) -> None:
    """Refuse names of one vector that differ in case only: the constants of the generated header have capitals."""
    vectors = [system.states, system.inputs, system.references, system.outputs]
    vectors += [system.parameters, system.scenario_parameters]
    vectors += [group for law in system.controllers for group in (law.parameters, law.memory)]
    for group in vectors:
        names: dict[str, str] = {}
        for quantity in group:
            first = names.setdefault(quantity.name.upper(), quantity.name)
            if first != quantity.name:
                raise ModelError(
                    f"{first!r} and {quantity.name!r} of vector {group.name!r} differ in capitals only, and would be "
                    "one constant in the generated C; rename one of them"
                )


def _check_times(system: System) -> None:
    """Refuse a law whose period or delay is no parameter."""
    for law in system.controllers:
        for what, name, group in (("period", law.period, system.parameters), ("delay", law.delay, law.parameters)):
            if name and name not in _by_name(group):
                raise ModelError(
                    f"{what} = {name!r} of law {law.name!r} is no parameter of group {group.name!r}"
                    f"{suggestion(name, _by_name(group))}"
                )


def _check_parameters_used(system: System) -> None:
    loops = [e for variant in system.variants for loop in variant.loops.values() for e in loop]
    periods = {c.period for c in system.controllers}
    common = _used_by(system, [*_system_expressions(system), *loops]) | periods
    laws = {c.name: _used_by(system, _law_expressions(c)) for c in system.controllers}
    by_laws = common.union(*laws.values())
    for group in (system.parameters, system.scenario_parameters):
        _refuse_unused(group, by_laws, f"group {group.name!r} of {system.name}")
    for controller in system.controllers:
        inside = {s.name for f in formulas(controller.parameters).values() for s in f.free_symbols}
        used = common | laws[controller.name] | inside | {controller.delay}
        _refuse_unused(controller.parameters, used, f"law {controller.name!r}")


def _refuse_unused(group: Group, used: set[str], where: str) -> None:
    for quantity in group:
        if quantity.name not in used:
            raise ModelError(
                f"parameter {quantity.name!r} ({where}) is used by no right-hand side, output, law or scenario; "
                f"remove it or use it{suggestion(quantity.name, used)}"
            )


def _check_scenarios(system: System) -> None:
    laws = {c.name: _by_name(c.parameters) for c in system.controllers}
    shared = _by_name(system.parameters) | _by_name(system.scenario_parameters)
    metrics = {m.name for m in system.metrics}
    for scenario in system.scenarios:
        where = f"scenario {scenario.name!r} of {system.name}"
        check_values(scenario.values, shared, where)
        for table in (scenario.controllers, scenario.expect):
            check_names(table, laws, f"{where}: controller")
        for law, values in scenario.controllers.items():
            check_values(values, laws[law], f"{where}, law {law!r}")
        for expected in scenario.expect.values():
            check_names(expected, metrics, f"{where}: metric")


def _check_metrics(system: System) -> None:
    variables = {q.name for q in (*system.states, *system.outputs)} | {f"u_{q.name}" for q in system.inputs}
    memories = [
        {q.name for q in (*law.memory, *(output.quantity for output in law.outputs))} for law in system.controllers
    ]
    variables |= set.intersection(*memories) if memories else set()
    for metric in system.metrics:
        check_names(
            (part.strip() for of in metric.of for part in of.split(" - ")),
            variables,
            f"metric {metric.name!r} of {system.name}: variable",
        )


def _by_name(group: Group) -> dict[str, Parameter]:
    return {q.name: q for q in group if isinstance(q, Parameter)}
