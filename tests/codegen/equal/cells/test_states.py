# SPDX-License-Identifier: Apache-2.0
"""Joint states of branches: those that are excluded, and the budget of those that are compared."""

import pytest
import sympy as sp

from mehvar.codegen.equal.cells import states
from mehvar.codegen.equal.cells.cells import Cells
from mehvar.codegen.equal.equality import EqualityTest
from mehvar.codegen.equal.meaning import Meaning
from mehvar.codegen.equal.pool import Pool
from mehvar.codegen.equal.sampler import PointSampler
from mehvar.codegen.equations.document import reached
from mehvar.codegen.ledger.sides import Sides

NAMES = sp.symbols("x y z", real=True)
x, y, z = NAMES
WHOLE = (None, None, None)


def cells_of(monkeypatch, old, new):
    """Return the cells that a test of equality makes."""
    made = []
    walk = Cells.walk
    monkeypatch.setattr(Cells, "walk", lambda self: (made.append(self), walk(self))[1])
    pool = Pool()
    free = Meaning(pool, lambda _: None)
    left, right = ((free, node) for node in Sides(pool).entries(sp.Matrix([old, new])))
    sampler = PointSampler({name.name: WHOLE for name in NAMES}, frozenset())
    verdict = EqualityTest(pool, lambda _: False, sampler).decide(left, right)
    return made[0], verdict


def test_a_limit_that_both_sides_exceed_is_excluded(monkeypatch):
    cells, verdict = cells_of(monkeypatch, sp.Max(-1, sp.Min(x, 1)) * y, sp.Min(1, sp.Max(x, -1)) * y)
    assert verdict.equal
    assert cells.are_proved()
    assert "is equal in the field or excluded" in cells.settle().how


def test_the_budget_of_joint_states_is_used_to_its_end(monkeypatch):
    """Each joint state costs the nodes of both sides; the last one may take what is left."""
    old = sp.Piecewise((x, x > 1), (y, x > 0), (y * z, True)) * sp.Piecewise((x, y > 1), (z, True))
    new = sp.Piecewise((x, x >= 1), (y, x >= 0), (y * z, True)) * sp.Piecewise((x, y >= 1), (z, True))
    cells, _ = cells_of(monkeypatch, old, new)

    def decided(budget):
        monkeypatch.setattr(states, "_MOST_COMPARED", budget)
        return None not in cells.states.open(lambda old, new: old == new)

    each = len(reached(cells.pool.nodes, cells.conditions.roots))
    count = next(count for count in range(40) if decided(count * each))
    assert count > 1
    assert not decided(count * each - 1)


@pytest.mark.parametrize(("old", "new"), [(sp.Abs(x), sp.Max(x, -x)), (sp.sign(x) * x, sp.Abs(x))])
def test_joint_states_of_two_sides_are_those_of_one_condition(monkeypatch, old, new):
    cells, _ = cells_of(monkeypatch, old * z, new * z)
    assert cells.are_proved()


def test_two_sides_without_branches_that_only_points_decide_have_one_open_state(monkeypatch):
    cells, verdict = cells_of(monkeypatch, sp.asin(sp.sin(x) / 2) * y, (sp.pi / 2 - sp.acos(sp.sin(x) / 2)) * y)
    assert list(cells.states.open(lambda old, new: old == new)) == [()]
    assert not cells.are_proved()
    assert verdict.equal
    assert verdict.points >= 64


def test_a_branch_that_another_excludes_is_not_open():
    pool = Pool()
    roots = Sides(pool).entries(sp.Matrix([sp.Max(x, 1) + sp.Max(-x, 1), sp.Abs(x)]))
    known = EqualityTest(pool, lambda _: False, PointSampler({}, frozenset())).known
    joint = states.JointStates(pool, tuple(roots), known, ())
    open_states = list(joint.open(lambda old, new: old == new))
    assert None not in open_states
    chosen = [{pool.nodes[node][0]: way for node, way in state} for state in open_states]
    assert {state["abs"] for state in chosen} == {0, 1}
    assert 2 < len(open_states) < 8
    assert not any(map(joint.are_excluded, open_states))
    assert all(map(joint.possible, open_states))
