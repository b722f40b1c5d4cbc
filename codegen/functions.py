# SPDX-License-Identifier: Apache-2.0
"""The functions that are generated for a system, as CasADi graphs: right-hand side, Jacobians, laws, loops."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import casadi as ca
import sympy as sp

from codegen.lower import to_casadi
from models.check import formulas
from models.system import TIME, Controller, Expr, Group, System, scalar

Signature = tuple[tuple[str, int], ...]


@dataclass(frozen=True)
class GeneratedFunction:
    """One function of a generated model.

    Attributes
    ----------
    name, description : str
        Its name in C and Python, and one line for people.
    arguments, results : tuple of (name, size)
        Vectors; scalars have size 0.
    graph : casadi.Function
        The SX function that the text is printed from.
    jacobian : bool
        Whether it goes into the Jacobian file.
    """

    name: str
    description: str
    arguments: Signature
    results: Signature
    graph: ca.Function
    jacobian: bool = False


@dataclass(frozen=True)
class Request:
    """A function to generate, still in SymPy."""

    name: str
    description: str
    arguments: tuple[Group, ...]
    results: tuple[tuple[str, tuple[Expr, ...]], ...]
    scalars: bool = False
    law: Controller | None = None


def generate_functions(system: System) -> list[GeneratedFunction]:
    """Build every function of a system, Jacobians last.

    Raises
    ------
    LoweringError
        If an expression cannot be converted or uses a symbol that its function does not receive.
    """
    wanted = requests(system)
    named, expressions = _common_subexpressions(system, wanted)
    functions, position = [], 0
    for request in wanted:
        results = []
        for name, exprs in request.results:
            results.append((name, expressions[position : position + len(exprs)]))
            position += len(exprs)
        functions.append(_build(system, request, results, named))
    rhs = functions[0]
    return [*functions, _jacobian(rhs, "x"), _jacobian(rhs, "u")]


def requests(system: System) -> list[Request]:
    """List the functions of a system, Jacobians excepted."""
    x, u, r, p, s = system.states, system.inputs, system.references, system.parameters, system.scenario_parameters
    margins = tuple(c.margin for c in system.limits)
    plant = [
        Request("rhs", "state derivative", (x, u, p), (("dx", system.rhs),)),
        Request("outputs", "outputs of a run", (x, u, r, p), (("y", system.output),)),
        Request("limits", "margins that stay positive along a run", (x, p), (("margin", margins),)),
        Request("initial", "initial state of a scenario", (p, s), (("x", system.initial),)),
        Request("reference", "reference of a scenario", (scalar(TIME), s), (("r", system.reference),)),
        Request("constraints", "margins that stay positive for a feasible scenario", (p, s),
                 (("margin", tuple(c.margin for c in system.constraints)),)),
    ]  # fmt: skip
    if system.coordinates:
        q = system.coordinates.states
        plant += [
            Request("to_coordinates", "regular coordinates of a state", (x,), (("q", q.symbols),)),
            Request("from_coordinates", "state at regular coordinates", (q,), (("x", x.symbols),)),
        ]
    own = [
        Request(f.name, f.description, f.arguments,
                 ((f.vector, tuple(e for _, e in f.results)),) if f.vector
                 else tuple((quantity.name, (expr,)) for quantity, expr in f.results), not f.vector)
        for f in system.functions
    ]  # fmt: skip
    return plant + own + [request for law in system.controllers for request in _law_requests(system, law)]


def _law_requests(system: System, law: Controller) -> list[Request]:
    x, u, r, p, s, c = (
        system.states, system.inputs, system.references, system.parameters, system.scenario_parameters, law.parameters,
    )  # fmt: skip
    name = law.name.replace("-", "_")
    q, rhs = (system.coordinates.states, system.coordinates.rhs) if system.coordinates else (x, system.rhs)
    margins = tuple(condition.margin for condition in law.constraints)
    derived = tuple(formulas(c).values())
    found = [
        Request(name, law.title, (x, r, p, c), (("u", u.symbols),), law=law),
        Request(f"{name}_loop", f"closed loop of {law.name}", (q, r, p, c), (("dq", rhs),), law=law),
        Request(f"{name}_observe", f"state and input in the loop of {law.name}", (q, r, p, c),
                 (("x", x.symbols), ("u", u.symbols)), law=law),
        Request(f"{name}_constraints", f"margins that stay positive for a feasible {law.name}", (p, c, s),
                 (("margin", margins),), law=law),
    ]  # fmt: skip
    if derived:
        found.append(Request(f"{name}_defaults", f"formula defaults of {law.name}", (c,), (("derived", derived),)))
    return found


def _common_subexpressions(system: System, wanted: Sequence[Request]) -> tuple[dict[sp.Symbol, Expr], list[Expr]]:
    """Share subexpressions over the whole model; temporaries are definitions like any other."""
    names = list(system.definitions)
    coordinates = system.coordinates
    maps = (*coordinates.from_state, *coordinates.from_input, *coordinates.to_state, *coordinates.to_input) if coordinates else ()
    commands = [e for law in system.controllers for e in law.command]
    results = [e for request in wanted for _, exprs in request.results for e in exprs]
    temporaries = sp.numbered_symbols("cse_", cls=sp.Symbol)
    pairs, reduced = sp.cse([*system.definitions.values(), *maps, *commands, *results], symbols=temporaries, order="none")
    named = dict(pairs) | dict(zip(names, reduced, strict=False))
    return named, reduced[len(names) + len(maps) + len(commands) :]


def _build(
    system: System, request: Request, results: Sequence[tuple[str, Sequence[Expr]]], named: dict[sp.Symbol, Expr]
) -> GeneratedFunction:
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
    signature = tuple((g.name, 0 if _is_scalar(g) else len(g)) for g in request.arguments)
    sizes = tuple((name, 0 if request.scalars else len(exprs)) for name, exprs in results)
    argument_names = [f"arg_{group.name}" for group in request.arguments]
    graph = ca.Function(request.name, vectors, shared, argument_names, [f"res_{name}" for name, _ in results])
    return GeneratedFunction(request.name, request.description, signature, sizes, graph)


def _is_scalar(group: Group) -> bool:
    return len(group) == 1 and group.name == group.quantities[0].name


def bindings(system: System, request: Request) -> dict[sp.Symbol, Expr]:
    """Return what the symbols stand for that a function does not receive: another chart, the law's input, the reference."""
    x, u, r = system.states.symbols, system.inputs.symbols, system.references.symbols
    received = {group.name for group in request.arguments}
    bound = _pairs(r, system.reference) if "s" in received else {}
    coordinates, law = system.coordinates, request.law
    if coordinates is None:
        return bound | (_pairs(u, law.command) if law else {})
    command = coordinates.inputs.symbols
    bound |= _pairs(command, law.command if law else coordinates.from_input)
    bound |= _pairs(u, coordinates.to_input) if law else {}
    return bound | (_pairs(x, coordinates.to_state) if "q" in received else _pairs(coordinates.states.symbols, coordinates.from_state))


def _pairs(symbols: Iterable[sp.Symbol], expressions: Iterable[Expr]) -> dict[sp.Symbol, Expr]:
    """Pair symbols with what they stand for; a symbol that is the same in both charts stands for itself."""
    return {s: e for s, e in zip(symbols, expressions, strict=True) if s is not e}


def _jacobian(rhs: GeneratedFunction, name: str) -> GeneratedFunction:
    """Differentiate the right-hand side with respect to one argument; rows of the result follow each other."""
    position = [argument for argument, _ in rhs.arguments].index(name)
    arguments = rhs.graph.sx_in()
    result = rhs.graph(*arguments)
    matrix = ca.densify(ca.jacobian(result, arguments[position]))
    (flat,) = ca.cse([ca.vec(matrix.T)])
    graph = ca.Function(f"jac_{name}", arguments, [flat], rhs.graph.name_in(), ["res_J"])
    size = matrix.shape[0] * matrix.shape[1]
    return GeneratedFunction(f"jac_{name}", f"Jacobian of rhs with respect to {name}, row by row", rhs.arguments, (("J", size),), graph, True)
