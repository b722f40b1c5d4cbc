# SPDX-License-Identifier: Apache-2.0
"""Writer of equations.md: the derived equations as a page with LaTeX for GitHub and GitLab."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

from mehvar.base.manifest import Manifest

from ..templates import text_environment
from .document import Document, Row, Symbol
from .formula import Printer, SymbolNames, aligned, broken, rank_of, width
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
_BARE = ("rate", "shown", "time")
"""Roles of names that are not quantities of the model's vectors."""


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


def equations_markdown(document: Document, manifest: Manifest) -> str:
    """Return the page: derivation, evaluated results, and a table of all symbols."""
    writer = _Writer(document)
    groups: dict[str, list[Symbol]] = {}
    for symbol in writer.quantities:
        groups.setdefault(symbol.role, []).append(symbol)
    template = text_environment(_TEMPLATES).get_template("equations.md.j2")
    sections, results = list(writer.derivation()), list(writer.results())
    return template.render(manifest=manifest, sections=sections, results=results, groups=groups)


class _Writer:
    """Converter of a document's rows to LaTeX, which records the names that it has explained."""

    def __init__(self, document: Document) -> None:
        self.quantities = [symbol for symbol in document.symbols if symbol.role not in _BARE]
        self._document = document
        self._quantities = {symbol.name: symbol for symbol in self.quantities}
        self._printer = Printer(document.nodes, self._names(), LATEX, line=_LINE)
        self._explained: set[str] = set()

    def _names(self) -> SymbolNames:
        """Return LaTeX and rank of all names; the rank sorts the factors of a product."""
        symbols, steps = self._document.symbols, self._document.named.values()
        latex = {symbol.name: symbol.latex for symbol in symbols} | {row.name: row.latex for row in steps}
        rank = {symbol.name: rank_of(symbol.role) for symbol in symbols}
        rank |= {s.name: rank_of("rate" if "dot" in s.name else "parameter") for s in symbols if s.role in _BARE}
        return SymbolNames(latex, rank | dict.fromkeys(self._document.named, rank_of("definition")))

    def derivation(self) -> Iterator[Section]:
        """Yield the sections of the derivation."""
        for title, steps in groupby(self._document.definitions, key=lambda row: row.section):
            yield Section(title or "Derivation", _runs([self._formula(row, row.number) for row in steps]))

    def results(self) -> Iterator[Section]:
        """Yield the evaluated results by kind; of variants, only differences from the default."""
        plain = {row.name: row.node for row in self._document.results if row.kind == "rhs"}
        for kind, title in _TITLES.items():
            rows = [row for row in self._document.results if row.kind == kind]
            rows = [row for row in rows if kind != "variant" or plain[row.name.rpartition(": ")[2]] != row.node]
            if rows:
                yield Section(title, ((True, tuple(self._formula(row, row.name) for row in rows)),))

    def _formula(self, row: Row, label: str) -> Formula:
        terms, sign = self._printer.terms(row.node), "" if row.latex.endswith("<") else "="
        right, lines = "".join(terms), _block(row.latex, sign, terms)
        wide, title = width(right) > _CELL or r"\begin" in right, "" if row.title == label else row.title
        left, right = _in_cell(row.latex), _in_cell(right)
        return Formula(label, title, row.unit, left, right, lines, wide, self._where(row.node))

    def _where(self, node: int) -> tuple[str, ...]:
        explanations = []
        for name in sorted(self._document.names_in(node) - self._explained):
            quantity = self._quantities.get(name)
            self._explained.add(name)
            if quantity is not None and quantity.description:
                unit = f" [{quantity.unit}]" if quantity.unit != "1" else ""
                explanations.append(f"$`{quantity.latex}`$ {quantity.description}{unit}")
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
