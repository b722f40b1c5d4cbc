# SPDX-License-Identifier: Apache-2.0
"""One cause is told first, with what follows from it in a line; what does not follow keeps its own words."""

import random
import re

import pytest

from mehvar.codegen.diff import Document, compare
from mehvar.codegen.diff.report import EquationVerdict, Kind
from mehvar.codegen.generate import installed_tree
from mehvar.comparison.document import Card
from mehvar.comparison.equations import Equations
from mehvar.comparison.text import lines
from mehvar.terminal import plain_text
from tests.codegen.diff.documents import document

CART = """
T = m*(v**2 + 2*l*cos(a)*v*w + l**2*w**2)/2 + k*v**2/2
V = m*r*l*cos(a)
M11 = k + m
M12 = m*l*cos(a)
M22 = m*l**2
n = -m*l*sin(a)*w**2
f = m*r*l*sin(a)
quotient = M11*M22 - M12**2
v: (-M22*n - M12*f)/quotient
w: (M12*n + M11*f)/quotient
energy: T + V
"""
"""A cart of mass k with a pendulum: energies, mass matrix, velocity terms and forces, solved."""
PARAMETERS = {"T": "mlk", "V": "mr", "M11": "mk", "M22": "m"}


def scaled(text, name, factor):
    return re.sub(rf"\b{name}\b", f"({factor}*{name})", text)


def causes(comparison):
    """Return the names of the equations with cards of their own that are not folded."""
    return [block.equation.name for block in Equations(comparison).blocks() if isinstance(block, Card)]


@pytest.mark.parametrize("name", ["m", "k", "r"])
@pytest.mark.parametrize("factor", ["2", "2/3", "-1", "5/7"])
def test_the_changed_energy_is_told_and_the_rest_follows(name, factor):
    """A coefficient of an energy, as its derivation carries it into mass matrix, velocity terms and forces."""
    old, new = document(CART), document(scaled(CART, name, factor))
    comparison = compare(old, new)
    first = next(row for row in ("T", "V") if name in PARAMETERS[row])
    changed = [equation.name for equation in comparison.sources]
    assert causes(comparison) == [first]
    (story,) = (group for group in comparison.groups if group.kind == "follows")
    assert list(story.names) == changed
    assert {equation.cause for equation in comparison.sources} == {"", first}
    text = plain_text(lines(Equations(comparison).blocks(), 0))
    explanation = rf"in place of (\w): {len(changed) - 1} equation"  # of the factors of one term, one stands for all
    assert re.search(explanation, text)[1] in ("mlr" if first == "V" else name)
    assert f": {', '.join(changed[1:])}" in text
    assert text.index(f"changed {first}") < text.index("and what follows from it")


@pytest.mark.parametrize("seed", range(12))
def test_an_edit_beside_the_cause_is_not_hidden(seed):
    """A sign, a lost factor or a number more, in one of the lines that a coefficient of T changes."""
    draw = random.Random(seed)
    rows = scaled(CART, "m", f"{draw.randint(2, 9)}/{draw.choice((1, 11))}").strip().splitlines()
    place = draw.choice([k for k, row in enumerate(rows) if row.split()[0] in ("M11", "M12", "M22", "n", "f")])
    name, right = rows[place].split(" = ")
    rows[place] = f"{name} = " + draw.choice((f"-({right})", f"l*({right})", f"3*({right})", f"{right} + r"))
    comparison = compare(document(CART), document("\n".join(rows)))
    assert causes(comparison)[0] == "T"
    assert name in causes(comparison)
    assert not comparison[name].cause
    assert comparison[name].edits


def test_a_quantity_in_an_angle_explains_nothing():
    """The field has angles of its own: sin(k x) is not followed through a multiple of k."""
    old, new = "T = k*v**2/2\nf = k*sin(k*x)", "T = k*v**2\nf = 2*k*sin(k*x)"
    comparison = compare(document(old), document(new))
    assert causes(comparison) == ["T", "f"]


def test_members_of_a_family_are_one_quantity():
    old = "T = m1*v**2/2 + m2*w**2/2\nM = m1*x\nn = m1*a + m2*b"
    comparison = compare(document(old), document(scaled(scaled(old, "m1", 2), "m2", 2)))
    (story,) = (group for group in comparison.groups if group.kind == "follows")
    assert (story.says, story.names) == ("2 m_i in place of m_i", ("T", "M", "n"))


def test_a_quantity_of_a_shipped_model_that_counts_twice_is_one_cause():
    """Twice the hull's mass, wherever the equations name it, from its kinetic energy on."""
    model = Document.read(installed_tree().root / "generated" / "slosh")
    comparison = compare(model, multiplied(model, "m"))
    assert causes(comparison) == ["T"]
    assert comparison["T"].number == "(5), (6)"
    (story,) = (group for group in comparison.groups if group.kind == "follows")
    assert len(story.names) == len(set(story.names)) == len(comparison.of(EquationVerdict.CHANGED))
    assert {"(9)", "(10)", "(11)", "vx", "vy", "vz"} < set(story.names)


def multiplied(old, name):
    """Return a document with twice a quantity in its place, in all rows but the trivial ones."""
    import dataclasses

    from mehvar.codegen.equal.branches import replaced_nodes
    from mehvar.codegen.equal.pool import Pool

    pool = Pool()
    numbers = pool.copy(old.nodes)
    symbol = pool.intern("sym", name)
    twice = {symbol: pool.many("mul", [pool.number(2), symbol])}
    rows = [dataclasses.replace(row, node=replaced_nodes(pool, numbers[row.node], twice)) for row in old.rows]
    count = len(old.definitions)
    return dataclasses.replace(
        old, nodes=tuple(pool.nodes), definitions=tuple(rows[:count]), results=tuple(rows[count:])
    )


@pytest.mark.parametrize(
    ("old", "new", "followers"),
    [
        ("s = m*cos(theta)\nf: k - m*w*sin(theta)", "s = m*sin(theta)\nf: k + m*w*cos(theta)", ("f",)),
        ("s = m*sin(theta)\nf: k + m*w*cos(theta)", "s = m*cos(theta)\nf: k - m*w*sin(theta)", ("f",)),
        (
            "E = m*v**2*cos(theta) + k*sin(theta)\nf: -m*v**2*sin(theta) + k*cos(theta)\ng: m*v*cos(theta)",
            "E = m*v**2*sin(theta) + k*sin(theta)\nf: m*v**2*cos(theta) + k*cos(theta)\ng: m*v*sin(theta)",
            ("f", "g"),
        ),
    ],
)
def test_what_is_derived_from_a_cosine_that_became_a_sine_follows_it(old, new, followers):
    comparison = compare(document(old), document(new))
    first, *others = comparison.sources
    assert tuple(equation.name for equation in others) == followers
    assert {equation.cause for equation in others} == {first.name}
    assert not any(equation.edits for equation in others)
    assert first.cause == ""


@pytest.mark.parametrize("old", ["(m*v**2 + k*w**2)/2", "m*v**2/2 + k*w**2/2"])
def test_what_is_derived_from_a_sum_follows_its_multiple(old):
    comparison = compare(
        document(f"E = {old}\nf: m*v*x + k*w*y\ng: k*w*y"),
        document("E = m*v**2 + k*w**2\nf: 2*m*v*x + 2*k*w*y\ng: 3*k*w*y"),
    )
    assert {equation.name: equation.cause for equation in comparison.sources} == {"E": "", "f": "E", "g": ""}
    (story,) = (group for group in comparison.groups if group.kind == "follows")
    assert story.says == "2 E in place of E"


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("s = m*cos(theta)\nf: k - m*w*sin(theta)", "s = m*sin(theta)\nf: k - m*w*cos(theta)"),  # the other way round
        ("s = m*cos(theta)\nf: k - m*w*sin(phi)", "s = m*sin(theta)\nf: k + m*w*cos(phi)"),  # another angle
        ("s = m*cos(theta)\nf: k - m*w*sin(theta)", "s = m*sin(theta)\nf: k + 2*m*w*cos(theta)"),  # and a factor
    ],
)
def test_another_edit_of_a_sine_is_a_cause_of_its_own(old, new):
    assert {equation.cause for equation in compare(document(old), document(new)).sources} == {""}


@pytest.mark.parametrize(
    ("old", "new"), [("sin", "cos"), ("cos", "sin"), ("-sin", "cos"), ("sin", "-cos"), ("cos", "-sin")]
)
def test_a_function_in_place_of_another_is_not_told_as_a_factor(old, new):
    comparison = compare(document(f"f: {old}(theta)*x + w"), document(f"f: {new}(theta)*x + w"))
    (edit,) = comparison["f"].edits
    assert edit.kind is Kind.FUNCTION
    assert "tan" not in edit.says
