# SPDX-License-Identifier: Apache-2.0
"""Conditions on a mode, which takes the numbers that it starts at and is reset to: there `<` and `<=` differ."""

import dataclasses

import pytest

from mehvar.codegen.diff import compare
from mehvar.codegen.diff.report import EquationVerdict
from mehvar.codegen.equations.document import LEAVES
from tests.codegen.diff.documents import document

KINDS = {"start": ("initial", "z(0)"), "one": ("reset", "plus: z+"), "two": ("reset", "minus: z+")}


def modal(torque: str, rate: str = "0", one: str = "1"):
    """A mode z that starts at 0 and is reset to 1 and 2, and a rate that depends on it."""
    made = document(f"z': {rate}\nstart: 0\none: {one}\ntwo: 2\n{torque}")
    kinds = [KINDS.get(row.name, (row.kind, row.name)) for row in made.results]
    rows = [
        dataclasses.replace(row, kind=kind, name=name) for row, (kind, name) in zip(made.results, kinds, strict=True)
    ]
    return dataclasses.replace(made, results=tuple(rows))


def started(made, state: str, number: int):
    """Give a state a start."""
    row = next(row for row in made.results if row.name == "z(0)")
    number = len(made.nodes), ("num", str(number))
    rows = (*made.results, dataclasses.replace(row, name=f"{state}(0)", node=number[0]))
    return dataclasses.replace(made, results=rows, nodes=(*made.nodes, number[1]))


def toggled(torque: str):
    """A mode z that starts at 0 and is reset to 1 - z."""
    made = modal(torque)
    rows = [row for row in made.results if row.name != "minus: z+"]
    toggle = next(row for row in document("f: 1 - z").results)
    nodes = (*made.nodes, *(moved(node, len(made.nodes)) for node in document("f: 1 - z").nodes))
    reset = [
        dataclasses.replace(row, node=toggle.node + len(made.nodes)) if row.name == "plus: z+" else row for row in rows
    ]
    return dataclasses.replace(made, results=tuple(reset), nodes=nodes)


def moved(node, by: int):
    """Return a node whose operands stand later in the graph."""
    return node if node[0] in LEAVES else (node[0], *(operand + by for operand in node[1:]))


def piecewise(*branches: str) -> str:
    return f"v': Piecewise({', '.join(f'({branch})' for branch in branches)}, (0, True))/J"


@pytest.mark.parametrize(
    ("old", "new", "at"),
    [
        (piecewise("k, z > 0"), piecewise("k, z >= 0"), 0),
        (piecewise("-k, z > 1", "k, z > 0"), piecewise("-k, z >= 1", "k, z > 0"), 1),
        (piecewise("k, z < 2"), piecewise("k, z <= 2"), 2),
        (f"c0 = z - 2\n{piecewise('k, c0 < 0')}", f"c0 = z - 2\n{piecewise('k, c0 <= 0')}", 2),
        (piecewise("k, z*m > m"), piecewise("k, z*m >= m"), 1),
        (piecewise("k, z*m > 2*m"), piecewise("k, m*(z - 2) >= 0"), 2),
        (piecewise("k, z*x > x"), piecewise("k, z*x >= x"), 1),
        ("v': k*sign(z*m - m)", "v': k*Piecewise((1, z*m >= m), (-1, True))", 1),
    ],
)
def test_a_condition_at_a_number_of_the_mode_is_a_change(old, new, at):
    change = compare(modal(old), modal(new))["v'"]
    assert change.verdict is EquationVerdict.CHANGED
    assert f"they differ at z = {at}, which a reset sets" in change.how


def test_at_joint_numbers_of_two_modes_there_is_a_change():
    old, new = (modal(f"x': 0\n{piecewise('k, z*m > x*m')}".replace(">", sign)) for sign in (">", ">="))
    assert compare(old, new)["v'"].verdict is EquationVerdict.REARRANGED  # nothing sets x
    old, new = (started(side, "x", 2) for side in (old, new))
    assert "they differ at x = 2 and z = 2, which a reset sets" in compare(old, new)["v'"].how


@pytest.mark.parametrize(
    ("old", "new", "at"),
    [
        ("k, m > 2", "k, m >= 2", "m = 2, a possible value"),
        ("k, 3*m < 2*k", "k, 3*m <= 2*k", "k = "),
        ("k, z > m", "k, z >= m", "m = 1, a possible value"),
        ("floor(m), m < k", "ceiling(m) - 1, m < k", "m = 1, a possible value"),
    ],
)
def test_a_parameter_that_may_be_on_a_threshold_leaves_it_undecided(old, new, at):
    change = compare(modal(piecewise(old)), modal(piecewise(new)))["v'"]
    assert change.verdict is EquationVerdict.UNDECIDED
    assert f"they differ at {at}" in change.how


@pytest.mark.parametrize("role", ["memory pd", "reference", "input", "commanded", "time"])
@pytest.mark.parametrize(
    ("old", "new", "at"),
    [("x > 0", "x >= 0", "x = 0"), ("x < 5", "x <= 5", "x = 5"), ("floor(x/5) < 1", "ceiling(x/5) <= 1", "x = ")],
)
def test_a_held_name_that_may_be_on_a_threshold_leaves_it_undecided(role, old, new, at):
    """A counter, a flag, a reference or an input keeps its number for a sample or more."""
    sides = (document(f"f: Piecewise((k, {side}), (0, True))", x={"role": role}) for side in (old, new))
    change = compare(*sides)["f"]
    assert change.verdict is EquationVerdict.UNDECIDED
    assert f"they differ at {at}" in change.how


@pytest.mark.parametrize("role", ["memory pd", "state"])
def test_another_way_to_write_a_condition_is_the_same(role):
    sides = ("Piecewise((k, x > 0), (0, True))", "Piecewise((0, x <= 0), (k, True))")
    assert not compare(*(document(f"f: {side}", x={"role": role}) for side in sides)).differs


def test_a_threshold_that_a_parameter_cannot_have_is_the_same():
    """The parameter m is positive."""
    assert not compare(modal(piecewise("k, m > 0")), modal(piecewise("k, m >= 0"))).differs


def test_at_a_number_that_a_reset_may_give_is_undecided():
    """The reset 1 - z toggles between 0 and 1; no other reset is a number."""
    old, new = (toggled(piecewise(f"k, z {sign} 1")) for sign in (">", ">="))
    change = compare(old, new)["v'"]
    assert change.verdict is EquationVerdict.UNDECIDED
    assert "they differ at z = 1, which a reset may set" in change.how
    assert not compare(old, toggled(piecewise("k, 2*z > 2"))).differs


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (piecewise("k, z > 0"), piecewise("k, z > Rational(1, 2)")),
        (piecewise("k, z > 1"), piecewise("k, z >= 2")),
        (piecewise("k, z > 0"), piecewise("k, 0 < 2*z")),
        (piecewise("k, z > 3"), piecewise("k, z >= 3")),
    ],
)
def test_what_no_number_of_the_mode_tells_apart_keeps_its_verdict(old, new):
    before, after = (compare(modal(side), modal(new))["v'"].verdict for side in (old, new))
    assert after is EquationVerdict.SAME
    plain = compare(modal(old, "x"), modal(new, "x"))["v'"].verdict
    assert before is plain


def test_of_a_state_that_moves_a_point_where_it_does_not_start_is_ignored():
    old, new = (modal(piecewise(f"k, z {sign} 3"), "x") for sign in (">", ">="))
    assert not compare(old, new).differs


def test_where_a_state_starts_it_may_rest():
    """As a wheel without friction at rest does."""
    old, new = (modal(piecewise(f"k, z {sign} 0"), "x") for sign in (">", ">="))
    change = compare(old, new)["v'"]
    assert change.verdict is EquationVerdict.UNDECIDED
    assert "they differ at z = 0, its value at the start, where it may stay" in change.how


@pytest.mark.parametrize(
    ("old", "new", "x"),
    [
        ("(z**2 - x**2)/(z - x)", "z + x", 0),
        ("Abs(z)/z", "sign(z)", 0),
        ("2*atan2(z, x + sqrt(x**2 + z**2))", "atan2(z, x)", -1),
    ],
)
def test_where_a_run_starts_both_sides_have_one_value(old, new, x):
    """They are equal everywhere else, so that no random point tells."""
    sides = [started(modal(f"v': {side}", "x"), "x", x) for side in (old, new)]
    change = compare(*sides)["v'"]
    assert change.verdict is EquationVerdict.UNDECIDED
    assert "z = 0" in change.how
    assert "where a run starts" in change.how


def test_a_product_of_two_signs_counts_both_in_a_proof():
    """sign(v) becomes -1 in a case: -1*-1*acos was taken for -acos, and a narrow window for impossible."""
    value = "sign(v)*acos(cos(b))"
    window = f"(sign({value} - (-3467/2500)) + 1)*(sign(-1386799999/1000000000 - ({value})) + 1)/4"
    change = compare(document(f"f: x + v*{window}"), document("f: x"))["f"]
    assert change.verdict in (EquationVerdict.CHANGED, EquationVerdict.UNDECIDED)


@pytest.mark.parametrize("rate", ["0", "w"], ids=["mode", "state"])
def test_a_state_that_a_reset_sets_to_a_parameter_is_compared_there(rate):
    """After the event it may rest on the threshold, whatever the parameter is."""
    first, second = (modal(piecewise(f"m, z {sign} J"), rate, one="J") for sign in (">", ">="))
    row = next(row for row in compare(first, second).equations if row.name == "v'")
    assert row.verdict is EquationVerdict.UNDECIDED
    assert "after the resets of plus" in row.how or "J = 2" in row.how
