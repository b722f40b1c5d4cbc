# SPDX-License-Identifier: Apache-2.0
"""Small documents written down as text, for comparisons with known answers.

A line `name = expression` is a definition, `name: expression` a result, `0: expression` an equation that is shown.
"""

from __future__ import annotations

import dataclasses
import functools
import json
import re
from collections.abc import Callable, Sequence

import sympy as sp

from mehvar.codegen.diff import Document
from mehvar.codegen.diff.changes import Change, replaced
from mehvar.codegen.diff.report import Kind, Path
from mehvar.codegen.equal.pool import Pool
from mehvar.codegen.equations import SCHEMA
from mehvar.codegen.equations.document import Node, Row
from mehvar.codegen.equations.graph import Graph

Version = Callable[[], Document]
PARAMETERS = {"m", "l", "k", "J", "r", "m1", "m2", "m3", "l1", "l2", "l3"}
STATES = {"x", "y", "z", "v", "w", "a", "b", "c", "phi", "theta", "q1", "q2", "q3", "w1", "w2", "w3"}
POSITIVE = PARAMETERS
ANGLES = {"a", "b", "phi", "theta", "q1", "q2", "q3"}
FAMILIES = {"m": "m", "l": "l", "q": "q", "w": "w"}


def document(text: str, **declared: dict[str, str]) -> Document:
    """Write a document; keyword arguments declare or change symbols."""
    graph = Graph()
    symbols = {name: _symbol(name) for name in sorted(PARAMETERS | STATES)}
    for name, row in declared.items():
        symbols[name] = {**_symbol(name), **row}
    local = {
        name: sp.Symbol(name, positive=True) if row["sign"] == "positive" else sp.Symbol(name, real=True)
        for name, row in symbols.items()
    }
    definitions, results = [], []
    for line in filter(None, map(str.strip, text.splitlines())):
        match = re.match(r"([A-Za-z_0-9']+)\s*([=:])\s*(.*)", line)
        assert match, line
        name, mark, right = match.groups()
        node = str(graph.add(sp.sympify(right, locals=local)))
        row = {"name": name, "node": node, "latex": name, "unit": "", "title": ""}
        if mark == "=":
            local[name] = sp.Symbol(name, real=True)
            definitions.append({**row, "kind": "definition", "section": "", "number": "", **_member(name)})
        elif name == "0":
            definitions.append({**row, "kind": "equation", "section": "", "number": str(len(definitions))})
        else:
            results.append({**row, "kind": "rhs"})
    return Document.parse(
        json.dumps(
            {
                "schema": SCHEMA, "model": "made", "structure": {}, "symbols": list(symbols.values()),
                "definitions": definitions, "results": results, "rates": {}, "nodes": _nodes(graph),
            }
        )
    )  # fmt: skip


def _nodes(graph: Graph) -> dict[str, list[str]]:
    return {str(k): [op, *map(str, operands)] for k, (op, *operands) in enumerate(graph.nodes)}


def edited(old: Document, row: Row, edit: Callable[[Pool, int], Change]) -> Document:
    """Return a document with an edited row; the function gets the pool and the row's expression."""
    pool = Pool()
    numbers = pool.copy(old.nodes)
    root = numbers[row.node]
    node = replaced(pool, root, [edit(pool, root)])
    rows = [dataclasses.replace(r, node=node if r is row else numbers[r.node]) for r in old.rows]
    count = len(old.definitions)
    return dataclasses.replace(
        old, nodes=tuple(pool.nodes), definitions=tuple(rows[:count]), results=tuple(rows[count:])
    )


def at(pool: Pool, root: int, path: Path) -> int:
    """Return the part of an expression at a path."""
    for k in path:
        root = pool.operands(root)[k]
    return root


def summands(nodes: Sequence[Node], root: int) -> list[tuple[int, Path]]:
    """Return the terms of all sums in an expression, with their paths."""
    places = []
    stack: list[tuple[int, Path]] = [(root, ())]
    while stack and len(places) < 1000:
        node, path = stack.pop()
        for k, operand in enumerate(nodes[node][1:]):
            if isinstance(operand, int):
                stack.append((operand, (*path, k)))
                if nodes[node][0] == "add":
                    places.append((operand, (*path, k)))
    return places


def flipped(old: Document, row: Row, path: Path) -> Document:
    """Return a document with the sign of one term flipped."""

    def edit(pool: Pool, root: int) -> Change:
        term = at(pool, root, path)
        minus = pool.many("mul", [term, pool.number(-1)])
        return Change(Kind.SIGN, path, term, minus, minus, "", 0.0)

    return edited(old, row, edit)


def _symbol(name: str) -> dict[str, object]:
    return {
        "name": name,
        "role": "parameter" if name in PARAMETERS else "state",
        "unit": "rad" if name in ANGLES else "1",
        "sign": "positive" if name in POSITIVE else "real",
        "latex": name,
        "description": f"the {name}",
        **(_member(name) if name[:-1] in FAMILIES else {}),
    }


def _member(name: str) -> dict[str, object]:
    index = re.search(r"\d$", name)
    return {"family": name[:-1], "index": int(index[0])} if index else {}


def version(text: str, **declared: dict[str, str]) -> Version:
    """Return a document that is written at first use."""
    return functools.partial(document, text, **declared)
