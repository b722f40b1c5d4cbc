# SPDX-License-Identifier: Apache-2.0
"""Exact derivatives of the generated functions by CasADi's algorithmic differentiation.

Rates, outputs and closed loops get Jacobians with all elements. Laws get directional derivatives, which cost two to
three times the law: the Jacobian of an estimator's memory would cost seventeen times. Directional derivatives along
unit vectors give the same numbers.
"""

from __future__ import annotations

from collections.abc import Sequence

import casadi as ca

from mehvar.base.manifest import Part
from mehvar.base.names import identifier
from mehvar.models.system import System

from .function import FunctionGraph
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
    derived = [
        jacobian(rhs, ["x"], "jac_x", "jac"),
        jacobian(rhs, ["u"], "jac_u", "jac"),
        directional(rhs, "xu", "jac"),
    ]
    if system.outputs:
        derived.append(jacobian(outputs, _present(outputs, "xur"), "outputs_jac", "outputs_jac"))
    for function, name in ((rhs, "jac_p"), (outputs, "outputs_jac_p")):
        if system.parameters and _rows(function):
            derived.append(jacobian(function, ["p"], name, "parameters_jac"))
    if system.actuator:
        derived.append(directional(by_name["actuate"], ["x", "u_cmd"], "loops_jac"))
    if system.seen is not system.states:
        derived.append(directional(by_name["measure"], ["x"], "loops_jac"))
    for law in system.controllers:
        name = identifier(law.name)
        derived.append(directional(by_name[name], _present(by_name[name], ("x", "seen", *"rvz")), "loops_jac"))
        if not law.period:
            loop = by_name[f"{name}_loop"]
            derived.append(jacobian(loop, _present(loop, "qr"), f"{name}_loop_jac", "loops_jac"))
    return derived


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
    names = ["J" if name.startswith("jac_") else f"J_{argument}" for argument in by]
    graph = ca.Function(name, arguments, flat, function.graph.name_in(), [f"res_{result}" for result in names])
    return FunctionGraph(
        name,
        f"Jacobian of {function.name} with respect to {_and(by)}, row by row",
        function.arguments,
        tuple((result, matrix.numel()) for result, matrix in zip(names, matrices, strict=True)),
        graph,
        part,
        function.name,
        elements=function.elements,
        derivation=function.derivation,
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
        (*function.arguments, *((f"along_{name}", v.shape[0]) for name, v in zip(by, along, strict=True))),
        tuple((result, size) for result, (_, size) in zip(names, function.results, strict=True)),
        graph,
        part,
        function.name,
        elements={**function.elements, **_changes(function, by)},
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
