# SPDX-License-Identifier: Apache-2.0
"""Exact derivatives of the generated functions by CasADi's algorithmic differentiation.

Rates, outputs and closed loops get Jacobians with all elements. Laws get directional derivatives, which cost two to
three times the law: the Jacobian of an estimator's memory would cost seventeen times. Directional derivatives along
unit vectors give the same numbers.

The text of a Jacobian grows with the square of the number of equal parts, such as pendulums. From `MANY` parts on its
columns are directional derivatives, whose text is a loop over the parts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import casadi as ca

from mehvar.base.manifest import Array, Part
from mehvar.base.names import identifier
from mehvar.models.system import System

from .function import MANY, FunctionGraph
from .plateaus import plateaus


def derivatives(system: System, functions: Sequence[FunctionGraph]) -> list[FunctionGraph]:
    """Return derivatives of a system's functions: rates, outputs, actuator, laws, continuous loops.

    Parameters
    ----------
    system : System
        System with the laws.
    functions : sequence of FunctionGraph
        Its functions.
    """
    by_name = {function.name: function for function in functions}
    rhs, outputs = by_name["rhs"], by_name["outputs"]
    change = directional(rhs, "xu", "jac")
    derived = [_jacobian_of_rates(rhs, change, "x"), _jacobian_of_rates(rhs, change, "u"), change]
    if system.outputs:
        derived += _jacobian(outputs, _present(outputs, "xur"), "outputs_jac", "outputs_jac")
    for function, name in ((rhs, "jac_p"), (outputs, "outputs_jac_p")):
        if system.parameters and _rows(function):
            derived += _jacobian(function, ["p"], name, "parameters_jac")
    if system.actuator:
        derived.append(directional(by_name["actuate"], ["x", "u_cmd"], "loops_jac"))
    if system.seen is not system.states:
        derived.append(directional(by_name["measure"], ["x"], "loops_jac"))
    for law in system.controllers:
        name = identifier(law.name)
        derived.append(directional(by_name[name], _present(by_name[name], ("x", "seen", *"rvz")), "loops_jac"))
        if not law.period:
            loop = by_name[f"{name}_loop"]
            derived += _jacobian(loop, _present(loop, "qr"), f"{name}_loop_jac", "loops_jac")
    return derived


def _jacobian_of_rates(rhs: FunctionGraph, change: FunctionGraph, by: str) -> FunctionGraph:
    name = f"jac_{by}"
    if _many(rhs) and dict(rhs.arguments)[by]:
        return columns(rhs, change, [by], name)
    return replace(jacobian(rhs, [by], name, "jac"), change=change.name)


def _jacobian(function: FunctionGraph, by: Sequence[str], name: str, part: Part) -> list[FunctionGraph]:
    """Return a Jacobian, for many equal parts with the directional derivative that gives its columns."""
    if not _many(function):
        return [jacobian(function, by, name, part)]
    change = replace(directional(function, by, part), name=name.replace("jac", "jvp"))
    return [columns(function, change, by, name), change]


def _many(function: FunctionGraph) -> bool:
    return any(number >= MANY for tags in function.families.values() for _, number in tags)


def jacobian(function: FunctionGraph, by: Sequence[str], name: str, part: Part) -> FunctionGraph:
    """Differentiate the single result of a function by some arguments, one matrix each, row by row.

    Parameters
    ----------
    function : FunctionGraph
        Function to differentiate.
    by : sequence of str
        Names of arguments.
    name : str
        Name of the derivative. A name that begins with `jac_` names its argument; its result is J instead of
        J_ARGUMENT.
    part : str
        The file it goes into.
    """
    arguments, places = function.graph.sx_in(), _places(function, by)
    flats = plateaus(function.graph, arguments, places)
    (value,) = flats.values
    sizes = [function.arguments[place][1] for place in places]  # an empty vector has one element in the graph
    matrices = [
        ca.densify(ca.jacobian(value, arguments[place]))[:, : 1 if size is None else size]
        for place, size in zip(places, sizes, strict=True)
    ]
    flat = ca.cse(flats.filled([ca.vec(matrix.T) for matrix in matrices]))
    return replace(_by_rows(function, by, name, arguments, flat, part), derivation=function.derivation)


def columns(function: FunctionGraph, change: FunctionGraph, by: Sequence[str], name: str) -> FunctionGraph:
    """Return the Jacobian of a function with directional derivatives along unit vectors as its columns.

    Parameters
    ----------
    function : FunctionGraph
        Function with a single result.
    change : FunctionGraph
        Its directional derivative along `by` and perhaps other arguments.
    by : sequence of str
        Names of arguments, one matrix each.
    name : str
        As for `jacobian`.
    """
    arguments, directions = function.graph.mx_in(), change.arguments[len(function.arguments) :]
    matrices = []
    for argument in by:
        count = dict(function.arguments)[argument] or 0
        along = [ca.DM.eye(count) if n == f"along_{argument}" else ca.DM(size or 0, count) for n, size in directions]
        point = [ca.repmat(vector, 1, count) for vector in arguments]
        matrices.append(ca.densify(change.graph.map(count)(*point, *along)))
    flat = [ca.vec(matrix.T) for matrix in matrices]
    return replace(_by_rows(function, by, name, arguments, flat, change.part), change=change.name)


def _by_rows(
    function: FunctionGraph, by: Sequence[str], name: str, arguments: Sequence[Any], flat: Sequence[Any], part: Part
) -> FunctionGraph:
    """Return a Jacobian with its matrices as vectors."""
    names = ["J" if name.startswith("jac_") else f"J_{argument}" for argument in by]
    graph = ca.Function(name, arguments, flat, function.graph.name_in(), [f"res_{result}" for result in names])
    results = tuple(Array(result, vector.numel()) for result, vector in zip(names, flat, strict=True))
    description = f"Jacobian of {function.name} with respect to {_and(by)}, row by row"
    return FunctionGraph(
        name, description, function.arguments, results, graph, part, function.name, elements=function.elements
    )


def directional(function: FunctionGraph, by: Sequence[str], part: Part) -> FunctionGraph:
    """Return the directional derivative of a function, at a few times the cost of the function.

    Parameters
    ----------
    function : FunctionGraph
        Function to differentiate; the derivative is named `jvp` for the right-hand side and `NAME_jvp` otherwise.
    by : sequence of str
        Names of the arguments that change.
    part : str
        The file it goes into.
    """
    arguments, places = function.graph.sx_in(), _places(function, by)
    along = [ca.SX.sym(f"along_{name}", arguments[place].shape[0]) for name, place in zip(by, places, strict=True)]
    flats, point = plateaus(function.graph, arguments, places), ca.vertcat(*(arguments[place] for place in places))
    values = flats.values
    change = ca.cse(flats.filled([ca.densify(ca.jtimes(value, point, ca.vertcat(*along))) for value in values]))
    name = "jvp" if function.name == "rhs" else f"{function.name}_jvp"
    names = ["change" if len(values) == 1 else f"change_{result}" for result, _ in function.results]
    graph = ca.Function(
        name,
        [*arguments, *along],
        change,
        [*function.graph.name_in(), *(f"arg_along_{argument}" for argument in by)],
        [f"res_{result}" for result in names],
    )
    return FunctionGraph(
        name,
        f"change of {function.name} along a change of {_and(by)}",
        (*function.arguments, *(Array(f"along_{name}", v.shape[0]) for name, v in zip(by, along, strict=True))),
        tuple(Array(result, size) for result, (_, size) in zip(names, function.results, strict=True)),
        graph,
        part,
        function.name,
        elements={**function.elements, **_changes(function, by)},
        families={**function.families, **{f"along_{name}": function.families.get(name, ()) for name in by}},
        derivation=function.derivation,
    )


def _changes(function: FunctionGraph, names: Sequence[str]) -> dict[str, tuple[str, ...]]:
    """Return names for the elements of a direction, derived from the names of its arguments."""
    return {f"along_{name}": tuple(f"along_{e}" for e in function.elements.get(name, ())) for name in names}


def _present(function: FunctionGraph, names: Sequence[str]) -> list[str]:
    """Return the arguments that have elements."""
    sizes = dict(function.arguments)
    return [name for name in names if sizes.get(name)]


def _places(function: FunctionGraph, names: Sequence[str]) -> list[int]:
    everything = [name for name, _ in function.arguments]
    return [everything.index(name) for name in names]


def _rows(function: FunctionGraph) -> int:
    return sum(size or 0 for _, size in function.results)


def _and(names: Sequence[str]) -> str:
    return " and ".join(filter(None, (", ".join(names[:-1]), names[-1])))
