# SPDX-License-Identifier: Apache-2.0
"""CasADi graphs of all generated functions of a system: right-hand side, Jacobians, laws, loops."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence, Set
from dataclasses import replace
from itertools import islice

import casadi as ca
import sympy as sp

from mehvar.base.manifest import Array
from mehvar.models.system import Expr, Group, System

from .derivatives import derivatives
from .function import LEAST, FunctionGraph, NamedSteps
from .requests import ROLES, Request, bindings, held_arguments, parameter_arguments, requests
from .shared import SharedDefinitions


def generate_functions(system: System) -> list[FunctionGraph]:
    """Build all functions of a system, derivatives last.

    Raises
    ------
    LoweringError
        If an expression cannot be converted or uses a symbol that its function does not receive.
    """
    listing = requests(system)
    named, expressions = _common_subexpressions(system, listing)
    functions, rest, shared = [], iter(expressions), SharedDefinitions(named)
    for request in listing:
        results = [
            (name, exprs if request.alone else list(islice(rest, len(exprs)))) for name, exprs in request.results
        ]
        functions.append(_build(system, request, results, shared))
    return [*functions, *derivatives(system, functions)]


def _common_subexpressions(system: System, listing: Sequence[Request]) -> tuple[dict[sp.Symbol, Expr], list[Expr]]:
    """Return additional definitions for subexpressions that several functions of the model share."""
    names = list(system.definitions)
    shared = [
        *system.definitions.values(),
        *(e for law in system.controllers for e in (*law.command, *law.update, *law.rates)),
    ]
    results = [e for request in listing if not request.alone for _, exprs in request.results for e in exprs]
    # SymPy orders terms by name: with numbers of one width in one order for all equal parts, which a loop needs
    width = 9 if any(q.index >= LEAST for q in system.states) else 1
    temporaries = (sp.Symbol(f"cse_{number:0{width}}") for number in itertools.count())
    pairs, reduced = sp.cse([*shared, *results], symbols=temporaries, order="none")
    return dict(pairs) | dict(zip(names, reduced, strict=False)), reduced[len(shared) :]


def _build(
    system: System,
    request: Request,
    results: Sequence[tuple[str, Sequence[Expr]]],
    shared: SharedDefinitions,
) -> FunctionGraph:
    """Return a request as a CasADi graph, with the definitions in it as named steps for the labels of the code."""
    vectors = [shared.vector(group)[0] for group in request.arguments]
    symbols = {
        symbol: element
        for group in request.arguments
        for symbol, element in zip(group.symbols, shared.vector(group)[1], strict=True)
    }
    bound = {symbol: expr for symbol, expr in bindings(system, request).items() if symbol not in symbols}
    wanted = [e for _, exprs in results for e in exprs]
    reached = shared.reached(wanted, bound)
    numbers = _numbers(system, bound, reached)
    convert = shared.converter(symbols, bound, reached)
    values = iter([convert(sp.sympify(value)) for value in (*wanted, *numbers)])
    outputs = [_vector(islice(values, len(exprs))) for _, exprs in results]
    steps = ca.Function("steps", vectors, [_vector(values)])
    lean = ca.cse(outputs)
    groups = {group.name: group for group in request.arguments if not _is_scalar(system, group)}
    signature = tuple(Array(g.name, len(g) if g.name in groups else None) for g in request.arguments)
    sizes = tuple(Array(name, None if request.scalars else len(exprs)) for name, exprs in results)
    argument_names = [f"arg_{group.name}" for group in request.arguments]
    graph = ca.Function(request.name, vectors, lean, argument_names, [f"res_{name}" for name, _ in results])
    function = FunctionGraph(
        request.name,
        request.description,
        signature,
        sizes,
        graph,
        request.part,
        elements={name: tuple(q.name for q in group) for name, group in groups.items()},
        families={name: tuple((q.family, q.index if q.family else 0) for q in group) for name, group in groups.items()},
        derivation=NamedSteps({s.name: number for s, number in numbers.items()}, steps),
    )
    if not request.repeated:
        return function
    return replace(function, parameters=parameter_arguments(system, request), held=held_arguments(request))


def _vector(values: Iterable[ca.SX]) -> ca.SX:
    entries = list(values)
    return ca.vertcat(*entries) if entries else ca.SX(0, 1)


def _numbers(system: System, bound: Iterable[sp.Symbol], reached: Set[sp.Symbol]) -> dict[sp.Symbol, str]:
    """Return the definitions that results need, and expressions for states and inputs that are no arguments.

    Each has its equation number; the order is that of the derivation.
    """
    numbers = {step.symbol: step.number for step in system.definitions_in_order} | dict.fromkeys(bound, "")
    return {symbol: number for symbol, number in numbers.items() if symbol in reached}


def _is_scalar(system: System, group: Group) -> bool:
    """Return True if an argument is a number; a vector with one element is not."""
    if len(group) != 1 or group.name != group.quantities[0].name or group.name in ROLES:
        return False
    own = (
        system.states, system.inputs, system.references, system.outputs, system.parameters,
        system.scenario_parameters, *(law.parameters for law in system.controllers),
    )  # fmt: skip
    return not any(group is vector for vector in own)
