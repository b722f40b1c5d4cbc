# SPDX-License-Identifier: Apache-2.0
"""One reason gives one entry: a longer family, the same edit in every axis."""

import dataclasses
import random

import pytest

from mehvar.codegen.diff import compare
from mehvar.codegen.diff.report import EXTENDED, MEMBER, EquationVerdict
from mehvar.comparison.equations import Equations
from mehvar.comparison.text import lines
from mehvar.terminal import plain_text
from tests.codegen.diff.documents import document


def sums(count, seed):
    """Write sums over members at two depths, with numbers drawn with a seed."""
    draw = random.Random(seed)
    numbers = [draw.randint(2, 9) for _ in range(6)]
    members = range(1, count + 1)
    inner = " + ".join(f"{numbers[0]}*m{i}*l{i}**2" for i in members)
    outer = " + ".join(f"{numbers[1]}*m{i}*x" for i in members)
    return f"total = sin(a)*({inner} + k)\nw: {numbers[2]}*total*y + cos(b)*({outer} + J)"


def family(document, count):
    """Declare the members of the families m and l as far as `count`."""
    kept = [s for s in document.symbols if not (s.family in ("m", "l") and s.index > count)]
    return dataclasses.replace(document, symbols=tuple(kept))


@pytest.mark.parametrize("seed", range(5))
def test_a_longer_family_is_one_entry(seed):
    old, new = family(document(sums(2, seed)), 2), family(document(sums(3, seed)), 3)
    for comparison, word in ((compare(old, new), "extended, 2 -> 3"), (compare(new, old), "shortened, 3 -> 2")):
        changed = comparison.of(EquationVerdict.CHANGED)
        assert changed
        assert all(equation.how == EXTENDED for equation in changed)
        (story,) = comparison.groups
        assert story.kind == "extended"
        assert word in story.says
        assert story.names == ("l3", "m3")
        text = plain_text(lines(Equations(comparison).blocks(), 0))
        assert story.says in text
        assert "m3" not in text.replace(story.says, "")


def test_a_family_that_only_its_declaration_makes_longer_is_no_entry():
    """As of wheels of which one no longer shares its inertia: no equation has a term more."""
    text = document(sums(3, 0))
    assert compare(family(text, 2), text).groups == ()


@pytest.mark.parametrize("seed", range(5))
def test_another_edit_beside_a_longer_family_is_explained(seed):
    """One number of the longer text is another: that equation is no mere extension."""
    text = sums(3, seed)
    edited = text.replace("*total*y", "*2*total*y")
    comparison = compare(family(document(sums(2, seed)), 2), family(document(edited), 3))
    by_name = {equation.name: equation for equation in comparison}
    assert by_name["total"].how == EXTENDED
    assert by_name["w"].verdict is EquationVerdict.CHANGED
    assert not by_name["w"].extended


def test_a_mean_over_more_members_is_no_mere_extension():
    comparison = compare(family(document("w: (m1 + m2)*x/2"), 2), family(document("w: (m1 + m2 + m3)*x/3"), 3))
    assert not comparison["w"].extended


def test_a_definition_of_a_new_member_is_its_own():
    old, new = family(document("q1 = m1*x\nv: q1"), 1), family(document("q1 = m1*x\nq2 = m2*x\nv: q1 + q2"), 2)
    comparison = compare(old, new)
    assert comparison["q2"].how == MEMBER
    assert comparison["v"].how == EXTENDED


def test_the_same_edit_in_every_axis_is_one_entry():
    old = "T_x = 3*k*(J - m)*a\nT_y = 3*k*(m - r)*b\nT_z = -3*k*(r - J)*c\nv: T_x + T_y + T_z"
    comparison = compare(document(old), document(old.replace("3*k", "2*k")))
    (story,) = comparison.groups
    assert (story.kind, story.names) == ("symmetric", ("T_x", "T_y", "T_z"))
    assert "3 became 2" in story.says
    text = plain_text(lines(Equations(comparison).blocks(), 0))
    assert text.count("changed T_x, T_y, T_z") == 1
    assert "changed T_y" not in text


def test_different_edits_in_two_axes_are_two_entries():
    old = "T_x = 3*k*(J - m)*a\nT_y = 3*k*(m - r)*b\nv: T_x + T_y"
    new = old.replace("3*k*(J", "2*k*(J").replace("3*k*(m", "4*k*(m")
    assert not compare(document(old), document(new)).groups
