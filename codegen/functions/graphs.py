# SPDX-License-Identifier: Apache-2.0
"""The functions that are generated for a system, as CasADi graphs: right-hand side, Jacobians, laws, loops."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import casadi as ca
import sympy as sp

from mehvar.models.system import Expr, Group, System

from .lower import to_casadi
from .requests import Request, bindings, held_arguments, parameter_arguments, requests

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
    jacobian : bool
        Whether it is a derivative of the right-hand side and goes into a file of its own.
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
    jacobian: bool = False
    parameters: frozenset[int] = frozenset()
    held: frozenset[int] = frozenset()


def generate_functions(system: System) -> list[FunctionGraph]:
    """Build every function of a system, derivatives of the right-hand side last.

    Raises
    ------
    LoweringError
        If an expression cannot be converted or uses a symbol that its function does not receive.
    """
    listing = requests(system)
    named, expressions = _common_subexpressions(system, listing)
    functions, position = [], 0
    for request in listing:
        results = []
        for name, exprs in request.results:
            results.append((name, expressions[position : position + len(exprs)]))
            position += len(exprs)
        functions.append(_build(system, request, results, named))
    rhs = functions[0]
    return [*functions, _jacobian(rhs, "x"), _jacobian(rhs, "u"), _directional(rhs)]


def _common_subexpressions(system: System, listing: Sequence[Request]) -> tuple[dict[sp.Symbol, Expr], list[Expr]]:
    """Share subexpressions over the whole model; temporaries are definitions like any other."""
    names = list(system.definitions)
    shared = [*system.definitions.values(), *(e for law in system.controllers for e in (*law.command, *law.update))]
    results = [e for request in listing for _, exprs in request.results for e in exprs]
    temporaries = sp.numbered_symbols("cse_", cls=sp.Symbol)
    pairs, reduced = sp.cse([*shared, *results], symbols=temporaries, order="none")
    return dict(pairs) | dict(zip(names, reduced, strict=False)), reduced[len(shared) :]


def _build(
    system: System,
    request: Request,
    results: Sequence[tuple[str, Sequence[Expr]]],
    named: dict[sp.Symbol, Expr],
) -> FunctionGraph:
    vectors = [ca.SX.sym(group.name, max(len(group), 1)) for group in request.arguments]
    symbols = {
        symbol: vector[i]
        for group, vector in zip(request.arguments, vectors, strict=True)
        for i, symbol in enumerate(group.symbols)
    }
    bound = bindings(system, request)
    definitions = named | {symbol: expr for symbol, expr in bound.items() if symbol not in symbols}
    outputs = [ca.vertcat(*to_casadi(exprs, symbols, definitions)) if exprs else ca.SX(0, 1) for _, exprs in results]
    shared = ca.cse(outputs)
    signature = tuple((g.name, None if _is_scalar(g) else len(g)) for g in request.arguments)
    sizes = tuple((name, None if request.scalars else len(exprs)) for name, exprs in results)
    argument_names = [f"arg_{group.name}" for group in request.arguments]
    graph = ca.Function(request.name, vectors, shared, argument_names, [f"res_{name}" for name, _ in results])
    function = FunctionGraph(request.name, request.description, signature, sizes, graph)
    if not request.repeated:
        return function
    return replace(function, parameters=parameter_arguments(system, request), held=held_arguments(request))


def _is_scalar(group: Group) -> bool:
    return len(group) == 1 and group.name == group.quantities[0].name


def _jacobian(rhs: FunctionGraph, name: str) -> FunctionGraph:
    """Differentiate the right-hand side with respect to one argument; rows of the result follow each other."""
    position = [argument for argument, _ in rhs.arguments].index(name)
    arguments = rhs.graph.sx_in()
    result = rhs.graph(*arguments)
    matrix = ca.densify(ca.jacobian(result, arguments[position]))
    (flat,) = ca.cse([ca.vec(matrix.T)])
    graph = ca.Function(f"jac_{name}", arguments, [flat], rhs.graph.name_in(), ["res_J"])
    size = matrix.shape[0] * matrix.shape[1]
    return FunctionGraph(
        f"jac_{name}",
        f"Jacobian of rhs with respect to {name}, row by row",
        rhs.arguments,
        (("J", size),),
        graph,
        True,
    )


def _directional(rhs: FunctionGraph) -> FunctionGraph:
    """Differentiate the right-hand side along a change of state and input, at a few times its own cost."""
    arguments = rhs.graph.sx_in()
    x, u = arguments[:2]
    along_x, along_u = ca.SX.sym("along_x", x.shape[0]), ca.SX.sym("along_u", u.shape[0])
    value = rhs.graph(*arguments)
    (change,) = ca.cse([ca.jtimes(value, ca.vertcat(x, u), ca.vertcat(along_x, along_u))])
    names = [*rhs.graph.name_in(), "arg_along_x", "arg_along_u"]
    graph = ca.Function("jvp", [*arguments, along_x, along_u], [change], names, ["res_change"])
    signature = (*rhs.arguments, ("along_x", x.shape[0]), ("along_u", u.shape[0]))
    description = "change of rhs along a change of state and input: J_x along_x + J_u along_u"
    return FunctionGraph("jvp", description, signature, (("change", x.shape[0]),), graph, True)
