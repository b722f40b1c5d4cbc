# SPDX-License-Identifier: Apache-2.0
"""Writer of equations.md: the derived equations as a page with LaTeX for GitHub and GitLab."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

import sympy as sp

from mehvar.models.system import Definition, Equation, System

from ..templates import text_environment
from .formula import Printer, SymbolNames, aligned, broken, rank_of, width
from .graph import Graph, Outcome, groups, outcomes, quantity_latex
from .spelling import LATEX

_TEMPLATES = Path(__file__).parent / "templates"
_LINE, _CELL = 88, 64
"""Approximate largest width of a formula's line and of a table's cell, in printed characters."""
_RUN = 3
"""Number of consecutive definitions without equation number from which a table is used."""
_TITLES = {
    "rhs": "Rates of the states",
    "output": "Outputs",
    "reference": "References",
    "initial": "Initial state",
    "law": "Commands of the laws",
    "memory at start": "Memory of the laws before the first sample",
    "memory update": "Memory of the laws after a sample",
    "memory rate": "Rates of the continuous laws' own states",
    "law output": "Reports of the laws",
    "actuator": "Inputs after the actuator",
    "sensor": "Measurement",
    "delay": "Delays of the inputs, in samples",
    "diffusion": "Process noise",
    "random step": "State after a random step",
    "coordinate": "Rates of the regular coordinates",
    "from state": "Regular coordinates from the state",
    "from input": "Regular inputs from the inputs",
    "to state": "State from the regular coordinates",
    "to input": "Inputs from the regular inputs",
    "projection": "Projection after each step",
    "limit": "Limits along a run",
    "guard": "Guards of the events",
    "reset": "State after an event",
    "constraint": "Constraints on the parameters",
    "warning": "Warnings about the parameters",
    "function": "Functions",
    "geometry": "Points of a picture",
    "variant": "Variants",
}
"""Headings of results by kind; equations of motion are shown within their derivation."""


@dataclass(frozen=True)
class Formula:
    """A formula with its text.

    Attributes
    ----------
    label : str
        "(12)", the name of a result, or nothing.
    title, unit : str
        Its subject and unit.
    left, right, block : str
        Its sides on one line, and both together on several lines.
    wide : bool
        True if one line is too long for a table.
    where : tuple of str
        Names that appear for the first time, with their meaning.
    """

    label: str
    title: str
    unit: str
    left: str
    right: str
    block: str
    wide: bool
    where: tuple[str, ...] = ()


@dataclass(frozen=True)
class Section:
    """A heading and groups of formulas, each printed as a table or one by one."""

    title: str
    runs: tuple[tuple[bool, tuple[Formula, ...]], ...]

    @property
    def anchor(self) -> str:
        """Anchor of the heading on GitHub and GitLab."""
        return re.sub(r"[^\w\- ]", "", self.title.lower()).replace(" ", "-")


def equations_markdown(system: System) -> str:
    """Return the page: derivation, evaluated results, and a table of all symbols."""
    writer = _Writer(system)
    return (
        text_environment(_TEMPLATES)
        .get_template("equations.md.j2")
        .render(
            system=system,
            sections=list(writer.derivation()),
            results=list(writer.results()),
            groups={role: list(group) for role, group in groups(system).items() if list(group)},
            latex=quantity_latex,
        )
    )


class _Writer:
    """Converter of a system's expressions to LaTeX, which records the names that it has explained."""

    def __init__(self, system: System) -> None:
        self.system = system
        self._graph = Graph()
        self._quantities = {q.symbol: q for group in groups(system).values() for q in group}
        self._printer = Printer(self._graph.nodes, self._names(), LATEX, line=_LINE)
        self._explained: set[sp.Symbol] = set()

    def _names(self) -> SymbolNames:
        """Return LaTeX and rank of all names; the rank sorts the factors of a product."""
        latex = {symbol.name: quantity_latex(q) for symbol, q in self._quantities.items()}
        rank = {q.name: rank_of(role) for role, group in groups(self.system).items() for q in group}
        for step in self.system.steps:
            if isinstance(step, Definition):
                latex[step.symbol.name] = step.latex
                rank[step.symbol.name] = rank_of("definition")
            else:
                for symbol in sorted(step.expr.free_symbols - self._quantities.keys(), key=str):
                    spelled = "\\" in symbol.name or "^" in symbol.name
                    latex.setdefault(symbol.name, symbol.name if spelled else sp.latex(symbol))
                    rank.setdefault(symbol.name, rank_of("rate" if "dot" in symbol.name else "parameter"))
        return SymbolNames(latex, rank)

    def derivation(self) -> Iterator[Section]:
        """Yield the sections of the derivation."""
        for title, steps in groupby(self.system.steps, key=lambda step: step.section):
            yield Section(title or "Derivation", _runs([self._step(step) for step in steps]))

    def _step(self, step: Definition | Equation) -> Formula:
        left = step.latex if isinstance(step, Definition) else step.left
        return self._formula(step.number, step.title, step.unit or "1", left, step.expr)

    def results(self) -> Iterator[Section]:
        """Yield the evaluated results by kind."""
        for kind, results in groupby(self._shown(), key=lambda outcome: outcome.kind):
            yield Section(_TITLES[kind], ((True, tuple(self._result(outcome) for outcome in results)),))

    def _shown(self) -> Iterator[Outcome]:
        """Yield the results by kind; for variants, only differences from the default."""
        plain = {outcome.name: outcome.expr for outcome in outcomes(self.system) if outcome.kind == "rhs"}
        kinds = list(_TITLES)
        shown = [outcome for outcome in outcomes(self.system) if outcome.kind in _TITLES]
        for outcome in sorted(shown, key=lambda outcome: kinds.index(outcome.kind)):
            if outcome.kind != "variant" or plain[outcome.name.rpartition(": ")[2]] != outcome.expr:
                yield outcome

    def _result(self, outcome: Outcome) -> Formula:
        title = "" if outcome.title == outcome.name else outcome.title
        return self._formula(outcome.name, title, outcome.unit, outcome.latex, sp.sympify(outcome.expr))

    def _formula(self, label: str, title: str, unit: str, left: str, expr: sp.Basic) -> Formula:
        node = self._graph.add(expr)
        terms, sign = self._printer.terms(node), "" if left.endswith("<") else "="
        right, lines = "".join(terms), _block(left, sign, terms)
        wide = width(right) > _CELL or r"\begin" in right
        return Formula(label, title, unit, _in_cell(left), _in_cell(right), lines, wide, self._where(expr))

    def _where(self, expr: sp.Basic) -> tuple[str, ...]:
        explanations = []
        for symbol in sorted(expr.free_symbols - self._explained, key=lambda s: s.name):
            quantity = self._quantities.get(symbol)
            self._explained.add(symbol)
            if quantity is not None and quantity.description:
                unit = f" [{quantity.unit}]" if quantity.unit != "1" else ""
                explanations.append(f"$`{quantity_latex(quantity)}`$ {quantity.description}{unit}")
        return tuple(explanations)


def _runs(formulas: Sequence[Formula]) -> tuple[tuple[bool, tuple[Formula, ...]], ...]:
    """Group formulas; True for a group that fits a table."""
    runs = [
        (plain, tuple(run))
        for plain, run in groupby(formulas, key=lambda f: not f.wide and not f.label and not f.where)
    ]
    return tuple((plain and len(run) >= _RUN, run) for plain, run in runs)


def _in_cell(latex: str) -> str:
    """Replace the vertical bar, which would end a table cell."""
    return latex.replace("|", r"\vert ")


def _block(left: str, sign: str, terms: Sequence[str]) -> str:
    """Return a formula as a block, on several lines if it is long."""
    lines = broken(terms, _LINE, width(left))
    if len(lines) == 1:
        return f"{left} {sign} {lines[0]}".replace("  ", " ").strip()
    return aligned(f"{left} {sign}", lines)
