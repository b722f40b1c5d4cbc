# SPDX-License-Identifier: Apache-2.0
"""Small documents written down as text, for comparisons with known answers.

A line `name = expression` is a definition, `name: expression` a result, `0: expression` an equation that is shown.
"""

from __future__ import annotations

import json
import re

import sympy as sp

from codegen.diff import Document
from codegen.equations import SCHEMA, Graph

PARAMETERS = {"m", "l", "k", "J", "r", "m1", "m2", "m3", "l1", "l2", "l3"}
STATES = {"x", "y", "z", "v", "w", "a", "b", "c", "phi", "theta", "q1", "q2", "q3", "w1", "w2", "w3"}
POSITIVE = PARAMETERS
ANGLES = {"a", "b", "phi", "theta", "q1", "q2", "q3"}
FAMILIES = {"m": "m", "l": "l", "q": "q", "w": "w"}


def document(text: str, **declared: dict[str, str]) -> Document:
    """Write a document; keyword arguments declare further symbols, or change those that there are."""
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
        row = {"name": name, "node": graph.add(sp.sympify(right, locals=local)), "latex": name, "unit": "", "title": ""}
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
                "definitions": definitions, "results": results, "rates": {}, "nodes": graph.nodes,
            }
        )
    )  # fmt: skip


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
