# SPDX-License-Identifier: Apache-2.0
"""equations.md: the derived equations as a page for people."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import jinja2
import sympy as sp

from codegen.equations import groups, outcomes, quantity_latex
from models.system import Definition, System

_TEMPLATES = Path(__file__).parent / "templates"


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
        {"left": outcome.latex, "right": _latex(outcome.expr, names), "kind": outcome.kind}
        for outcome in outcomes(system)
        if outcome.kind in ("rhs", "law")
    ]
    return environment.get_template("equations.md.j2").render(
        system=system,
        sections=sections,
        results=results,
        groups=groups(system),
        latex=quantity_latex,
    )


def _latex_names(system: System) -> dict[sp.Symbol, str]:
    names = {step.symbol: step.latex for step in system.steps if isinstance(step, Definition)}
    return names | {q.symbol: quantity_latex(q) for group in groups(system).values() for q in group}


def _latex(expr: sp.Basic, names: Mapping[sp.Symbol, str]) -> str:
    return str(sp.latex(expr, symbol_names=dict(names)))
