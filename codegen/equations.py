# SPDX-License-Identifier: Apache-2.0
"""The derived equations as a product of their own: equations.json for machines, equations.md for people."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import jinja2
import sympy as sp

from models.system import Definition, Equation, Group, Parameter, Quantity, System

SCHEMA = 1
_COMMUTATIVE = (sp.Add, sp.Mul, sp.Min, sp.Max, sp.And, sp.Or)
_TEMPLATES = Path(__file__).parent / "templates"


class _Graph:
    """Expressions as shared nodes; commutative operands are sorted by content, not by SymPy's order."""

    def __init__(self) -> None:
        self.nodes: list[list[Any]] = []
        self._position: dict[str, int] = {}
        self._memo: dict[sp.Basic, int] = {}
        self._digest: list[str] = []

    def add(self, expr: sp.Basic) -> int:
        """Store an expression and return the number of its node."""
        if expr not in self._memo:
            self._memo[expr] = self._store(*self._parts(expr))
        return self._memo[expr]

    def _parts(self, expr: sp.Basic) -> tuple[str, list[int | str]]:
        if isinstance(expr, sp.Symbol):
            return "sym", [expr.name]
        if isinstance(expr, sp.Rational):
            return "num", [str(expr)]
        if isinstance(expr, sp.Float):
            return "num", [str(sp.Rational(str(expr)))]
        if expr in (sp.true, sp.false) or (expr.is_number and not expr.args):
            return "const", [str(expr)]
        operands = [self.add(argument) for argument in expr.args]
        if isinstance(expr, _COMMUTATIVE):
            operands.sort(key=self._digest.__getitem__)
        return type(expr).__name__.lower(), list(operands)

    def _store(self, op: str, operands: list[int | str]) -> int:
        named = [self._digest[o] if isinstance(o, int) else o for o in operands]
        digest = hashlib.sha256(json.dumps([op, named]).encode()).hexdigest()
        if digest not in self._position:
            self._position[digest] = len(self.nodes)
            self.nodes.append([op, *operands])
            self._digest.append(digest)
        return self._position[digest]


def equations_json(system: System) -> str:
    """Write the system's equations in a canonical form: same physics and naming, same text."""
    graph = _Graph()
    steps = [_step(graph, step) for step in system.steps]
    outcomes = [
        {"name": name, "node": graph.add(sp.sympify(expr)), "kind": kind} for name, kind, expr in _outcomes(system)
    ]
    document = {
        "schema": SCHEMA,
        "model": system.name,
        "structure": dict(system.structure),
        "symbols": _symbols(system),
        "definitions": steps,
        "results": outcomes,
        "nodes": graph.nodes,
    }
    lines = (f"{json.dumps(key)}: {_rows(value)}" for key, value in document.items())
    return "{\n" + ",\n".join(lines) + "\n}\n"


def _rows(value: object) -> str:
    """Print lists and tables one entry a line, so that a text diff is readable."""
    if isinstance(value, list):
        return "[\n" + ",\n".join("  " + json.dumps(v, ensure_ascii=False) for v in value) + "\n]"
    if isinstance(value, dict):
        return (
            "{\n"
            + ",\n".join(f"  {json.dumps(k)}: {json.dumps(v, ensure_ascii=False)}" for k, v in value.items())
            + "\n}"
        )
    return json.dumps(value, ensure_ascii=False)


def _step(graph: _Graph, step: Definition | Equation) -> dict[str, Any]:
    name = step.symbol.name if isinstance(step, Definition) else step.left
    return {
        "name": name,
        "node": graph.add(step.expr),
        "kind": "definition" if isinstance(step, Definition) else "equation",
        "section": step.section,
        "number": step.number,
        "title": step.title,
        "unit": step.unit,
    }


def _outcomes(system: System) -> Iterable[tuple[str, str, sp.Expr]]:
    for quantity, expr in zip(system.states, system.rhs, strict=True):
        yield f"{quantity.name}'", "rhs", expr
    for quantity, expr in zip(system.outputs, system.output, strict=True):
        yield quantity.name, "output", expr
    for quantity, expr in zip(system.references, system.reference, strict=True):
        yield quantity.name, "reference", expr
    for quantity, expr in zip(system.states, system.initial, strict=True):
        yield f"{quantity.name}(0)", "initial", expr
    inputs = system.coordinates.inputs if system.coordinates else system.inputs
    for law in system.controllers:
        for quantity, expr in zip(inputs, law.command, strict=True):
            yield f"{law.name}.{quantity.name}", "law", expr


def _groups(system: System) -> dict[str, Group]:
    groups = {
        "state": system.states, "input": system.inputs, "reference": system.references, "output": system.outputs,
        "parameter": system.parameters, "scenario": system.scenario_parameters,
    }  # fmt: skip
    if system.coordinates:
        groups |= {"coordinate": system.coordinates.states, "command": system.coordinates.inputs}
    return groups | {f"law {law.name}": law.parameters for law in system.controllers}


def _symbols(system: System) -> list[dict[str, Any]]:
    rows = []
    for role, group in _groups(system).items():
        for q in group:
            row: dict[str, Any] = {
                "name": q.name,
                "role": role,
                "unit": q.unit,
                "sign": "positive" if q.positive else "real",
            }
            if isinstance(q, Parameter):
                row |= {"bounds": str(q.bounds), "source": q.source}
            rows.append(row)
    return rows


def equations_markdown(system: System) -> str:
    """Write the derivation as a page with LaTeX that a forge renders."""
    names = _latex_names(system)
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(_TEMPLATES),
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    sections: dict[str, list[dict[str, str]]] = {}
    for step in system.steps:
        left = step.latex if isinstance(step, Definition) else step.left
        sections.setdefault(step.section, []).append(
            {
                "left": left,
                "right": _latex(step.expr, names),
                "number": step.number,
                "title": step.title,
                "unit": step.unit,
            }
        )
    results = [
        {"left": _left(name, kind, names), "right": _latex(expr, names), "kind": kind}
        for name, kind, expr in _outcomes(system)
        if kind in ("rhs", "law")
    ]
    return environment.get_template("equations.md.j2").render(
        system=system,
        sections=sections,
        results=results,
        groups=_groups(system),
        latex=lambda q: _quantity_latex(q),
    )


def _latex_names(system: System) -> dict[sp.Symbol, str]:
    names = {step.symbol: step.latex for step in system.steps if isinstance(step, Definition)}
    return names | {q.symbol: _quantity_latex(q) for group in _groups(system).values() for q in group}


def _quantity_latex(quantity: Quantity) -> str:
    return quantity.latex or (
        sp.latex(quantity.symbol) if len(quantity.name) < 3 else rf"\mathrm{{{quantity.name}}}".replace("_", r"\_")
    )


def _latex(expr: sp.Basic, names: Mapping[sp.Symbol, str]) -> str:
    return str(sp.latex(expr, symbol_names=dict(names)))


def _left(name: str, kind: str, names: Mapping[sp.Symbol, str]) -> str:
    base = name.split(".")[-1].removesuffix("'")
    spelled = next((latex for symbol, latex in names.items() if symbol.name == base), base)
    return rf"\dot{{{spelled}}}" if kind == "rhs" else rf"{spelled}\quad\text{{({name.split('.')[0]})}}"
