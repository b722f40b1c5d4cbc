# SPDX-License-Identifier: Apache-2.0
"""Writer of equations.json: the derived equations as a graph of shared nodes, unique for equal physics and names."""

from __future__ import annotations

import hashlib
import json
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from typing import Any, NamedTuple

import sympy as sp

from mehvar.base.errors import MehvarError
from mehvar.base.names import typeset
from mehvar.models.geometry import shape_coordinates
from mehvar.models.system import TIME, Condition, Controller, Definition, Equation, Expr, Parameter, Quantity, System

from . import SCHEMA

_COMMUTATIVE = (sp.Add, sp.Mul, sp.Min, sp.Max, sp.And, sp.Or, sp.Equality, sp.Unequality)
_DOUBLE = 53
_DIGITS = 10
"""Number of digits in a node's name. Two of ten thousand nodes coincide in one of 20 000 models; with half the
digits, in every model.
"""


class Outcome(NamedTuple):
    """An expression that the system evaluates: a rate, output, command or margin.

    Attributes
    ----------
    name, kind : str
        Its name, unique within its kind, and its kind.
    expr : Expr
        Its expression.
    latex, unit, title : str
        LaTeX of its left side, SI unit, and a description.
    """

    name: str
    kind: str
    expr: Expr
    latex: str
    unit: str
    title: str


class EquationsError(MehvarError, ValueError):
    """An expression that cannot be written exactly."""


class Graph:
    """Expressions as shared nodes; commutative operands are sorted by content, independently of SymPy."""

    def __init__(self) -> None:
        self.nodes: list[list[Any]] = []
        self._position: dict[str, int] = {}
        self._memo: dict[sp.Basic, int] = {}
        self._digest: list[str] = []

    def add(self, expr: sp.Basic) -> int:
        """Store an expression and return its node number."""
        if expr not in self._memo:
            self._memo[expr] = self._store(*self._parts(expr))
        return self._memo[expr]

    def _parts(self, expr: sp.Basic) -> tuple[str, list[int | str]]:
        """Return operation and operands of an expression; the operands of commutative ones are sorted by content."""
        if isinstance(expr, sp.Symbol):
            return "sym", [expr.name]
        if isinstance(expr, sp.Rational | sp.Float):
            return "num", [str(exact(expr))]
        if expr in (sp.true, sp.false) or (expr.is_number and not expr.args):
            return "const", [str(expr)]
        if isinstance(expr, sp.Add | sp.Mul):
            return self._collected(expr)
        if isinstance(expr, sp.ITE | sp.Xor):  # SymPy's form of a condition on a case distinction
            return self._parts(expr.to_nnf(simplify=False))
        operands = [self.add(argument) for argument in expr.args]
        if isinstance(expr, _COMMUTATIVE):
            operands.sort(key=self._digest.__getitem__)
        return type(expr).__name__.lower(), list(operands)

    def _collected(self, expr: sp.Add | sp.Mul) -> tuple[str, list[int | str]]:
        """Return a sum or product, flattened and with one number."""
        kind = type(expr)
        number, others = kind.identity, []
        for part in _flat(expr, kind):
            if isinstance(part, sp.Rational | sp.Float):
                number = kind(number, exact(part))
            else:
                others.append(self.add(part))
        if number != kind.identity:
            others.append(self.add(number))
        if len(others) == 1:
            return str(self.nodes[others[0]][0]), list(self.nodes[others[0]][1:])
        others.sort(key=self._digest.__getitem__)
        return kind.__name__.lower(), list(others)

    def _store(self, op: str, operands: list[int | str]) -> int:
        named = [self._digest[o] if isinstance(o, int) else o for o in operands]
        digest = hashlib.sha256(json.dumps([op, named]).encode()).hexdigest()
        if digest not in self._position:
            self._position[digest] = len(self.nodes)
            self.nodes.append([op, *operands])
            self._digest.append(digest)
        return self._position[digest]

    def names(self) -> list[str]:
        """Return short unique names of nodes by their contents."""
        for digits in (_DIGITS, 64):
            names = [digest[:digits] for digest in self._digest]
            if len(set(names)) == len(names):
                break
        return names


def _flat(expr: sp.Basic, kind: type) -> Iterator[sp.Basic]:
    for part in expr.args:
        if isinstance(part, kind):
            yield from _flat(part, kind)
        else:
            yield part


def exact(number: sp.Rational | sp.Float) -> sp.Rational:
    """Return a number as a fraction; a double is read as its shortest decimal, which is unique.

    Raises
    ------
    EquationsError
        If a float is not a double or not finite.
    """
    if isinstance(number, sp.Rational):
        return number
    if number._prec != _DOUBLE or not number.is_finite:
        raise EquationsError(f"{number} is neither a finite double nor a fraction: write sympy.Rational('...') instead")
    value = Fraction(repr(float(number)))
    return sp.Rational(value.numerator, value.denominator)


def equations_json(system: System) -> str:
    """Return a system's equations in canonical form: equal physics and names give equal texts.

    Raises
    ------
    EquationsError
        If a number is not exact, or a symbol has two meanings.
    """
    graph = Graph()
    steps = [_step(graph, step) for step in system.steps]
    results = [_result(graph, outcome) for outcome in outcomes(system)]
    rows = _with_families(system, steps)
    document = {
        "schema": SCHEMA,
        "model": system.name,
        "structure": dict(system.structure),
        "symbols": _symbols(system),
        "definitions": rows,
        "results": results,
        "rates": {state: symbol.name for state, symbol in system.rates.items()},
        "nodes": _identified(graph, [*rows, *results]),
    }
    _refuse_undeclared(document)
    lines = (f"{json.dumps(key)}: {_rows(value)}" for key, value in document.items())
    return "{\n" + ",\n".join(lines) + "\n}\n"


def _identified(graph: Graph, rows: Iterable[dict[str, Any]]) -> dict[str, list[Any]]:
    """Return the nodes in the order in which rows use them, named by contents."""
    names = graph.names()
    identified: dict[str, list[Any]] = {}

    def visit(node: int) -> str:
        if names[node] not in identified:
            operation, *operands = graph.nodes[node]
            row = [operation, *(visit(o) if isinstance(o, int) else o for o in operands)]
            identified[names[node]] = row
        return names[node]

    for row in rows:
        row["node"] = visit(row["node"])
    return identified


def _rows(value: object) -> str:
    """Return JSON with one line per entry, so that text diffs are readable."""
    if isinstance(value, list):
        return "[\n" + ",\n".join("  " + json.dumps(v, ensure_ascii=False) for v in value) + "\n]"
    if isinstance(value, dict):
        rows = (f"  {json.dumps(k, ensure_ascii=False)}: {json.dumps(v, ensure_ascii=False)}" for k, v in value.items())
        return "{\n" + ",\n".join(rows) + "\n}"
    return json.dumps(value, ensure_ascii=False)


def _step(graph: Graph, step: Definition | Equation) -> dict[str, Any]:
    """Return the row of a definition, or of an equation that is only shown."""
    named = isinstance(step, Definition)
    return {
        "name": step.symbol.name if isinstance(step, Definition) else step.left,
        "kind": "definition" if named else "equation",
        "node": graph.add(step.expr),
        "section": step.section,
        "number": step.number,
        "title": step.title,
        "unit": step.unit or "1",
        "latex": step.latex if isinstance(step, Definition) else step.left,
    }


def _result(graph: Graph, outcome: Outcome) -> dict[str, Any]:
    row = outcome._asdict()
    row["node"] = graph.add(sp.sympify(row.pop("expr")))
    return row


def outcomes(system: System) -> Iterator[Outcome]:
    """Yield all physical expressions that a system evaluates, in reading order."""
    yield from _rates(system.states, system.rhs, "rhs")
    yield from _named(system.outputs, system.output, "output")
    yield from _named(system.references, system.reference, "reference")
    yield from _named(system.states, system.initial, "initial", "{}(0)", "{}(0)")
    for law in system.controllers:
        yield from _law(system, law)
    if system.actuator:
        yield from _named(system.inputs, system.actuator.applied, "actuator")
    if system.sensor:
        yield from _named(system.seen, system.sensor.measured, "sensor")
    if diffusion := system.diffusion:
        yield from _named(system.states, diffusion.change, "diffusion", "d{}", r"\mathrm{{d}}{}")
    for name, count in system.delays.items():
        quantity = next(q for q in system.parameters if q.name == count)
        yield Outcome(name, "delay", quantity.symbol, f"k_{{{name}}}", "1", f"samples from command to action of {name}")
    if step := system.random_step:
        yield from _named(system.states, step.after, "random step", "{}+", "{}^{{+}}")
    if system.coordinates:
        yield from _coordinates(system)
    integrated = system.coordinates.states if system.coordinates else system.states
    yield from _named(integrated, system.projection, "projection")
    yield from _conditions(system.limits, "limit")
    yield from _conditions(system.constraints, "constraint")
    yield from _events(system)
    for function in system.functions:
        for q, expr in function.results:
            yield Outcome(f"{function.name}.{q.name}", "function", expr, quantity_latex(q), q.unit, q.description)
    for shape, name, expr in shape_coordinates(system.geometry):
        axis = name[-1]
        yield Outcome(name, "geometry", expr, axis, "m", f"{axis} of a point of the {shape.kind} {shape.name}")
    for variant in system.variants:
        title = " ".join(variant.values)
        yield from _rates(system.states, variant.rhs, "variant", f"{title}: ")
        for name, loop in variant.loops.items():
            yield from _rates(system.states, loop, "variant", f"{title}, {name}: ")
    for state, expr in zip(system.rates, system.residual, strict=True):
        yield Outcome(state, "motion", expr, "0", "", f"equation of motion that gives the rate of {state}")


def _events(system: System) -> Iterator[Outcome]:
    """Yield guards, named by event and direction, and the states after events."""
    for law, events in (
        ("", system.events),
        *((f"{c.name}: ", c.events) for c in system.controllers),
    ):
        for event in events:
            name, title = f"{law}{event.name}", event.title or "switching surface"
            yield Outcome(
                f"{name}: {event.direction}{event.outcome and f' ends {event.outcome}'}",
                *("guard", event.guard, "0 =", "", title),
            )
            for q in system.states:
                if event.reset.get(q.symbol, q.symbol) != q.symbol:
                    title = f"{q.name} after {event.name}"
                    yield Outcome(
                        f"{name}: {q.name}+",
                        "reset",
                        event.reset[q.symbol],
                        f"{quantity_latex(q)}^{{+}}",
                        q.unit,
                        title,
                    )


def _named(
    group: Iterable[Quantity], expressions: Sequence[Expr], kind: str, name: str = "{}", latex: str = "{}"
) -> Iterator[Outcome]:
    for q, expr in zip(group, expressions, strict=False):
        yield Outcome(name.format(q.name), kind, expr, latex.format(quantity_latex(q)), q.unit, q.description)


def _rates(group: Iterable[Quantity], expressions: Sequence[Expr], kind: str, prefix: str = "") -> Iterator[Outcome]:
    for q, expr in zip(group, expressions, strict=False):
        unit = f"{q.unit}^2" if q.unit.endswith("/s") else f"{q.unit}/s"
        yield Outcome(f"{prefix}{q.name}'", kind, expr, rate_latex(q), unit, f"rate of {q.name}")


def rate_latex(quantity: Quantity) -> str:
    """Return the printed time derivative of a quantity."""
    plain = quantity_latex(quantity)
    return plain.replace(r"\dot", r"\ddot", 1) if plain.startswith(r"\dot") else rf"\dot{{{plain}}}"


def _law(system: System, law: Controller) -> Iterator[Outcome]:
    """Yield commands, memory, outputs, constraints and warnings of a law."""
    inputs = system.coordinates.inputs if system.coordinates else system.inputs
    yield from _named(inputs, law.command, "law", f"{law.name}.{{}}")
    yield from _named(law.memory, law.start, "memory at start", f"{law.name}.{{}}(0)", "{}(0)")
    yield from _named(law.memory, law.update, "memory update", f"{law.name}.{{}}+", "{}^{{+}}")
    yield from _rates(law.memory, law.rates, "memory rate", f"{law.name}: ")
    for output in law.outputs:
        q = output.quantity
        yield Outcome(f"{law.name}.{q.name}", "law output", output.value, quantity_latex(q), q.unit, q.description)
    yield from _conditions(law.constraints, "constraint", f"{law.name}: ")
    yield from _conditions(law.warnings, "warning", f"{law.name}: ")


def _coordinates(system: System) -> Iterator[Outcome]:
    chart = system.coordinates
    assert chart is not None
    yield from _rates(chart.states, chart.rhs, "coordinate")
    yield from _named(chart.states, chart.from_state, "from state")
    yield from _named(chart.inputs, chart.from_input, "from input")
    yield from _named(system.states, chart.to_state, "to state")
    yield from _named(system.inputs, chart.to_input, "to input")


def _conditions(conditions: Sequence[Condition], kind: str, prefix: str = "") -> Iterator[Outcome]:
    seen: Counter[str] = Counter()
    for condition in conditions:
        seen[condition.message] += 1
        again = f" ({seen[condition.message]})" if seen[condition.message] > 1 else ""
        name = f"{prefix}{condition.message}{again}"
        yield Outcome(name, kind, condition.margin, "0 <", "", condition.message)


def groups(system: System) -> dict[str, Iterable[Quantity]]:
    """Return the quantities in expressions by role."""
    roles: dict[str, Iterable[Quantity]] = {
        "state": system.states, "input": system.inputs, "reference": system.references, "output": system.outputs,
        "parameter": system.parameters, "scenario": system.scenario_parameters,
    }  # fmt: skip
    if system.coordinates:
        roles |= {"coordinate": system.coordinates.states, "command": system.coordinates.inputs}
    if system.actuator:
        roles["commanded"] = system.actuator.commanded
    if system.sensor:
        roles["noise"] = system.sensor.noise
        roles["measured"] = system.sensor.seen
    if diffusion := system.diffusion:
        roles["wiener"] = diffusion.wiener
    if step := system.random_step:
        roles["noise of steps"] = step.noise
    for law in system.controllers:
        roles[f"law {law.name}"] = law.parameters
        roles[f"memory {law.name}"] = law.memory
        roles[f"applied {law.name}"] = law.applied
    arguments = (q for function in system.functions for group in function.arguments for q in group)
    names = {q.name for group in roles.values() for q in group}
    roles["argument"] = [q for q in dict.fromkeys(arguments) if q.name not in names]
    return roles


def _symbols(system: System) -> list[dict[str, Any]]:
    """Return the rows of all symbols; the time has one only if an expression uses it."""
    rows = [_symbol(role, q) for role, group in groups(system).items() for q in group]
    rows += [_bare(symbol, "rate") for symbol in system.rates.values()]
    names = {row["name"] for row in rows} | {symbol.name for symbol in system.definitions}
    shown = {s for step in system.steps if isinstance(step, Equation) for s in step.expr.free_symbols}
    used = {s for outcome in outcomes(system) for s in sp.sympify(outcome.expr).free_symbols} | shown
    if TIME.name not in names and TIME.symbol in _reached(system, used):
        rows.append(_symbol("time", TIME))
        names.add(TIME.name)
    rows += [_bare(s, "shown") for s in sorted(shown, key=lambda s: s.name) if s.name not in names]
    _refuse_ambiguous(rows)
    return rows


def _reached(system: System, symbols: Iterable[sp.Symbol]) -> set[sp.Symbol]:
    return {s for expr in system.definitions.values() for s in expr.free_symbols} | set(symbols)


def _symbol(role: str, q: Quantity) -> dict[str, Any]:
    """Return the row of a quantity; a parameter has bounds and source, too."""
    row: dict[str, Any] = {
        "name": q.name,
        "role": role,
        "unit": q.unit,
        "sign": "positive" if q.positive else "real",
        "latex": quantity_latex(q),
        "description": q.description,
    }
    if q.family:
        row |= {"family": q.family, "index": q.index}
    if isinstance(q, Parameter):
        row |= {"bounds": str(q.bounds), "source": q.source} | ({} if q.array is None else {"array": q.array.name})
    return row


def _bare(symbol: sp.Symbol, role: str) -> dict[str, Any]:
    """Describe a symbol that occurs only in shown or implicit equations and is not a quantity."""
    sign = "positive" if symbol.is_positive else "real"
    latex = symbol.name if "\\" in symbol.name or "^" in symbol.name else sp.latex(symbol)
    return {"name": symbol.name, "role": role, "unit": "", "sign": sign, "latex": latex, "description": ""}


def quantity_latex(quantity: Quantity) -> str:
    """Return the LaTeX of a quantity: the paper's, else its name."""
    return quantity.latex or typeset(quantity.name)


def _with_families(system: System, steps: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Mark definitions that each of several equal parts, such as pendulums, has.

    A definition belongs to part i if its name contains i and all its indexed quantities have index i.
    """
    index = {q.symbol: q.index for group in groups(system).values() for q in group if q.family}
    members: dict[str, list[tuple[int, dict[str, Any]]]] = {}
    for step, row in zip(system.steps, steps, strict=True):
        indices = {index[s] for s in step.expr.free_symbols if s in index}
        if len(indices) != 1 or not isinstance(step, Definition):
            continue
        (number,) = indices
        index[step.symbol] = number
        parts = re.split(rf"(?<!\d){number}(?!\d)", step.symbol.name)
        if len(parts) == 2:
            members.setdefault("".join(parts), []).append((number, row))
    for family, rows in members.items():
        if len(rows) > 1:
            for number, row in rows:
                row |= {"family": family, "index": number}
    return steps


def _refuse_ambiguous(rows: Iterable[Mapping[str, Any]]) -> None:
    signs: dict[str, str] = {}
    for row in rows:
        if signs.setdefault(row["name"], row["sign"]) != row["sign"]:
            raise EquationsError(f"{row['name']} is declared positive in one role and real in another: use two names")


def _refuse_undeclared(document: Mapping[str, Any]) -> None:
    declared = {row["name"] for row in (*document["symbols"], *document["definitions"])}
    for operation, *operands in document["nodes"].values():
        if operation == "sym" and operands[0] not in declared:
            raise EquationsError(f"the symbol {operands[0]!r} is neither a quantity of the system nor a definition")
