# SPDX-License-Identifier: Apache-2.0
"""The triangle beside masses and rods as a part of a craft in a plane."""

from __future__ import annotations

import dataclasses
import itertools
from fractions import Fraction

import pytest
import sympy as sp

from mehvar.codegen.diff.report import ModelStatus
from mehvar.models.triangle import STRUCTURE

from .shipped import triangle
from .shipped.rederived import POINTS, Side, differ, mutant, structured

BOUNDS = {"rho": (Fraction(0), Fraction(7, 10))} | dict.fromkeys(
    ("mu", "mass", "m1", "m2", "m3"), (Fraction(1, 10), Fraction(10))
)
"""Shapes that are not collinear, rho < sqrt(2)/2, and any sizes and masses."""


@pytest.mark.parametrize("structure", [("equal", "light"), ("general", "uniform")], ids="-".join)
def test_the_rates_of_the_triangle_are_those_of_masses_and_rods(structure):
    assert triangle.forms(*structure).differences() == []


@pytest.mark.parametrize("masses", ["equal", pytest.param("general", marks=pytest.mark.soak)])
def test_the_kinematic_triangle_moves_with_its_angular_momentum(masses):
    """Roots of roots have no sign in a finite field: 50 digits instead. The drift is an addition of the paper."""
    shape, momentum = triangle.kinematic(structured("triangle", masses=masses))
    assert differ(shape, triangle.MOMENTUM, momentum, BOUNDS) == [False] * POINTS
    for wrong in (2 * momentum, momentum.subs(sp.Symbol("w2", real=True), -sp.Symbol("w2", real=True))):
        assert any(differ(shape, triangle.MOMENTUM, wrong, BOUNDS))


@pytest.mark.parametrize(("name", "factor"), [("triangle_q1", -1), ("hub_ax", 2), ("total_py", -1)])
def test_a_wrong_term_of_the_part_is_refused(name, factor):
    pair = triangle.forms("equal", "light")
    wrong = Side(mutant(pair.assembled.system, name, factor), pair.assembled.at)
    drift = {n: pair.readings[n] for n in ("vx", "vy")}
    assert dataclasses.replace(pair, assembled=wrong, readings=drift).differences() == ["vx'", "vy'"]


@pytest.mark.soak
def test_diff_calls_heavier_masses_changed():
    pair = triangle.forms("equal", "light")
    heavier = Side(pair.assembled.system, {**pair.assembled.at, "mass": 2 * sp.Symbol("mass", positive=True)})
    assert dataclasses.replace(pair, assembled=heavier).verdict() is ModelStatus.CHANGED


@pytest.mark.soak
@pytest.mark.parametrize("structure", [*itertools.product(STRUCTURE["masses"], STRUCTURE["rods"])], ids="-".join)
def test_diff_calls_every_structure_of_the_triangle_the_same(structure):
    """On triangles: for lengths of none, the shipped drift still has rates."""
    pair = triangle.forms(*structure)
    assert pair.differences() == []
    assert pair.verdict() is ModelStatus.SAME
