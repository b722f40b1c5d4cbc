# SPDX-License-Identifier: Apache-2.0
"""Parser of equations.json: symbols, definitions and results over a graph of shared nodes."""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from mehvar.base.errors import MehvarError
from mehvar.base.intervals import REALS, Interval
from mehvar.base.manifest import FILE, Manifest, read_manifest
from mehvar.base.schema import SchemaError, parse

from . import SCHEMA

Node = tuple[Any, ...]
LEAVES = ("sym", "num", "const")
"""Operations whose operand is a text; operands of all other operations are nodes."""


class DocumentError(MehvarError, ValueError):
    """Error for a text that is not a consistent equations.json of this schema."""


@dataclass(frozen=True)
class Symbol:
    """A declared name in expressions."""

    name: str
    role: str
    unit: str = ""
    sign: str = "real"
    latex: str = ""
    description: str = ""
    bounds: str = ""
    source: str = ""
    family: str = ""
    index: int = 0
    array: str = ""

    @property
    def interval(self) -> Interval:
        """Values that the bounds allow; every number without bounds."""
        return Interval.parse(self.bounds) if self.bounds else REALS


@dataclass(frozen=True)
class Row:
    """A definition, a shown equation or a result."""

    name: str
    kind: str
    node: int
    latex: str = ""
    unit: str = ""
    title: str = ""
    section: str = ""
    number: str = ""
    family: str = ""
    index: int = 0

    @property
    def named(self) -> bool:
        """True if other expressions refer to the row by its name."""
        return self.kind == "definition"

    @property
    def implicit(self) -> bool:
        """True for an equation 0 = ..., for which only the zeros of its right side matter."""
        return self.kind == "motion" or (self.kind == "equation" and self.latex == "0")


@dataclass(frozen=True)
class Document:
    """The derived equations of one version of a model.

    Attributes
    ----------
    model : str
        Its name.
    symbols : tuple of Symbol
        Every declared name; a name may have several roles, such as a parameter of two laws.
    definitions, results : tuple of Row
        Definitions and shown equations; evaluated results; both in order.
    nodes : tuple of Node
        The graph: an operation and its operands, which come earlier.
    structure : mapping of str to str
        Structural choices.
    rates : mapping of str to str
        For each state of the implicit equations, the symbol of its rate.
    manifest : Manifest or None
        The manifest in the same folder, with the numbers, or None.
    """

    model: str
    symbols: tuple[Symbol, ...]
    definitions: tuple[Row, ...]
    results: tuple[Row, ...]
    nodes: tuple[Node, ...]
    structure: Mapping[str, str] = field(default_factory=dict)
    rates: Mapping[str, str] = field(default_factory=dict)
    manifest: Manifest | None = None

    @classmethod
    def read(cls, path: str | Path) -> Document:
        """Read a generated folder, or an equations.json with the manifest in its folder, if any.

        Raises
        ------
        DocumentError, InputError
            If a file is damaged or has another schema.
        OSError
            If it cannot be read.
        """
        path = Path(path)
        path = path / "equations.json" if path.is_dir() else path
        manifest = read_manifest(path.parent, any_age=True) if path.with_name(FILE).is_file() else None
        return cls.parse(path.read_text(encoding="utf-8"), manifest, str(path))

    @classmethod
    def parse(cls, text: str, manifest: Manifest | None = None, where: str = "equations.json") -> Document:
        """Parse the text of an equations.json.

        Raises
        ------
        DocumentError
            If it is damaged, has another schema, or refers to an undeclared name.
        """
        data = _loaded(text, where)
        if data.get("schema") != SCHEMA:
            raise DocumentError(f"{where} has schema {data.get('schema')!r}; this version reads schema {SCHEMA}")
        try:
            place = {name: k for k, name in enumerate(data["nodes"])}
            document = cls(
                data["model"],
                tuple(Symbol(**row) for row in data["symbols"]),
                tuple(_row(row, place) for row in data["definitions"]),
                tuple(_row(row, place) for row in data["results"]),
                tuple(_node(row, place) for row in data["nodes"].values()),
                data["structure"],
                data["rates"],
                manifest,
            )
        except (AttributeError, KeyError, TypeError) as error:
            raise DocumentError(f"{where} is damaged: {error}") from None
        document._check(where)
        return document

    @property
    def rows(self) -> tuple[Row, ...]:
        """Definitions and results."""
        return self.definitions + self.results

    @functools.cached_property
    def named(self) -> dict[str, Row]:
        """The definitions by name."""
        return {row.name: row for row in self.definitions if row.named}

    @functools.cached_property
    def declared(self) -> dict[str, Symbol]:
        """The symbols by name; for several roles, the first."""
        return {symbol.name: symbol for symbol in reversed(self.symbols)}

    @functools.cached_property
    def latex(self) -> dict[str, str]:
        """LaTeX of all names in expressions."""
        names = {name: symbol.latex for name, symbol in self.declared.items() if symbol.latex}
        return names | {row.name: row.latex for row in self.named.values() if row.latex}

    def reached(self, root: int) -> list[int]:
        """Return the nodes of an expression, operands first."""
        return reached(self.nodes, [root])

    def names_in(self, root: int) -> set[str]:
        """Return the names that an expression uses directly."""
        return {self.nodes[k][1] for k in self.reached(root) if self.nodes[k][0] == "sym"}

    def _check(self, where: str) -> None:
        """Refuse nodes that refer to later ones, and rows that use names before their definition."""
        for number, (_, *operands) in enumerate(self.nodes):
            if any(isinstance(o, int) and o >= number for o in operands):
                raise DocumentError(f"{where}: node {number} refers to a later node")
        defined: set[str] = set()
        for row in self.rows:
            if not 0 <= row.node < len(self.nodes):
                raise DocumentError(f"{where}: {row.name} refers to a node that does not exist")
            missing = sorted(self.names_in(row.node) - defined - self.declared.keys())
            if missing:
                reason = "before it is defined" if missing[0] in self.named else "which is not declared"
                raise DocumentError(f"{where}: {row.name} uses {missing[0]!r}, {reason}")
            if row.named:
                defined.add(row.name)


def _row(row: dict[str, Any], place: Mapping[str, int]) -> Row:
    return Row(**row | {"node": place.get(row["node"], -1)})


def _node(row: list[str], place: Mapping[str, int]) -> Node:
    operation, *operands = row
    return (operation, *(operands if operation in LEAVES else (place.get(o, len(place)) for o in operands)))


def reached(nodes: Sequence[Node], roots: Sequence[int]) -> list[int]:
    """Return the nodes of expressions in the graph's order, operands first."""
    seen: set[int] = set()
    stack = list(roots)
    while stack:
        node = stack.pop()
        if node not in seen:
            seen.add(node)
            stack.extend(o for o in nodes[node][1:] if isinstance(o, int))
    return sorted(seen)


def _loaded(text: str, where: str) -> dict[str, Any]:
    try:
        data = parse(text)
    except SchemaError as error:
        raise DocumentError(f"{where} is damaged: {error}") from None
    if not isinstance(data, dict):
        raise DocumentError(f"{where} is damaged: it holds no table")
    return data
