# SPDX-License-Identifier: Apache-2.0
"""Invariants of a model's physics: wherever its limits hold, positive states are positive, and so are masses."""

import numpy as np
import sympy as sp

from tests import derived

POINTS = 4000


def whole(expression, definitions):
    """Return an expression without definitions."""
    while used := expression.free_symbols & definitions.keys():
        expression = expression.xreplace({symbol: definitions[symbol] for symbol in used})
    return expression


def violations(system, positive, drawn):
    """Return which of the expressions are not positive at a point where all limits hold, and at how many they do."""
    margins = [whole(sp.sympify(limit.margin), system.definitions) for limit in system.limits]
    wanted = {name: whole(expression, system.definitions) for name, expression in positive.items()}
    symbols = sorted(set().union(*(e.free_symbols for e in (*margins, *wanted.values()))), key=str)
    values = {symbol: drawn(symbol.name) for symbol in symbols}
    evaluate = sp.lambdify(symbols, [*margins, *wanted.values()], "numpy", cse=True)
    rows = [np.broadcast_to(row, POINTS) for row in evaluate(*values.values())]
    holds = np.all(np.array(rows[: len(margins)]) > 0, axis=0)
    bad = [name for name, row in zip(wanted, rows[len(margins) :], strict=True) if not np.all(row[holds] > 0)]
    return bad, int(holds.sum())


def test_states_that_are_declared_positive_are_so_within_the_limits():
    system, rng = derived.system("triangle", model="dynamic"), np.random.default_rng(1)
    positive = {q.name: q.symbol for q in system.states if q.positive}
    bad, held = violations(system, positive, lambda _: rng.uniform(-1, 1, POINTS))
    assert (bad, len(positive)) == ([], 3)
    assert held > 20
