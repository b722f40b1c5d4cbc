# SPDX-License-Identifier: Apache-2.0
"""Bounds of fields whose numbers are shared or expressions, and rotors that are bodies."""

import functools
import re

import pytest
import sympy as sp

from mehvar.models.check import check
from mehvar.models.parts import (
    Chain,
    ControlMomentGyro,
    Drag,
    Engine,
    Gyro,
    Hinge,
    Hub,
    Link,
    Mode,
    Modes,
    Orbit,
    Pendulum,
    PointMass,
    Rod,
    Slider,
    SprungMass,
    Tether,
    Thruster,
    UnbalancedWheel,
    Value,
    Wheel,
)
from mehvar.models.quantities import ModelError

from . import table

X = (1, 0, 0)
BALL = (0.1, 0.1, 0.1)
ROTOR = {"axis": X, "mass": 1.0, "static": 1e-3}
GIMBAL = {"gimbal": X, "spin": (0, 1, 0)}


craft_of = functools.partial(table.craft_of, Hub("hub", mass=4.0, inertia=BALL))


FIELDS = [
    (-0.01, "kg m^2", lambda s: Wheel("a", axis=X, inertia=s), r"k = -0.01: must be in \(0, inf\), kg m\^2, .* a_Js"),
    (-1.0, "kg", lambda s: PointMass("a", mass=s), r"k = -1.0: must be in \(0, inf\), kg, for its use as a_m \(mass\)"),
    (-4.0, "N/m", lambda s: SprungMass("a", mass=1.0, axis=X, stiffness=s), r"k = -4.0: must be in [\[(]0, inf\), N/m"),
    (-4.0, "N s/m", lambda s: SprungMass("a", mass=1.0, axis=X, stiffness=1.0, damping=s), r"must be in \[0, inf\)"),
    (-0.05, "N m", lambda s: Wheel("a", axis=X, inertia=0.1, torque_limit=s), r"must be in \(0, inf\), N m"),
    (1.5, "1", lambda s: Gyro("a", dropout=s), r"k = 1.5: must be in \[0, 1\), 1, for its use as a_dropout"),
    (-1.0, "N m/rad", lambda s: Chain("a", [Link(1.0, BALL, axis=X, stiffness=s)]), r"\[0, inf\), N m/rad, .* a_1_k"),
    (-1.0, "rad/s", lambda s: Modes("a", [Mode(s, 0.0, X, X)]), r"must be in \(0, inf\), rad/s, for its use as a_1_f"),
    (-1.0, "kg m^2", lambda s: Hub("a", mass=1.0, inertia=(s, 1.0, 1.0)), r"must be in \(0, inf\), kg m\^2, .* a_Jxx"),
]  # fmt: skip


@pytest.mark.parametrize(("value", "unit", "part", "words"), FIELDS)
def test_a_shared_number_has_the_bounds_of_its_fields(value, unit, part, words):
    craft = craft_of()
    k = craft.parameter("k", value, unit)
    with pytest.raises(ModelError, match=words):
        craft.add(part(k))
    with pytest.raises(ModelError, match="must be a number in"):
        craft_of().add(part(sp.Float(value)))
    with pytest.raises(ModelError, match=r"with .*k = .*(: must be in|of no body)"):
        craft.add(part(2 * k))


def test_a_shared_number_has_the_bounds_of_all_fields_in_the_model():
    craft = craft_of()
    k = craft.parameter("k", 0.05, "kg m^2", bounds="[-1, 5]")
    craft.add(Wheel("a", axis=(0, 1, 0), inertia=k))
    craft.add(Wheel("b", axis=X, inertia=k))
    system = craft.system()
    check(system)
    shared = next(q for q in system.parameters if q.name == "k")
    assert (str(shared.bounds), shared.symbol) == ("(0, 5]", k)
    assert craft.system().parameters == system.parameters


def test_bounds_without_a_common_value_are_refused():
    craft = craft_of()
    k = craft.parameter("k", -2.0, "kg m^2", bounds="[-3, -1]")
    with pytest.raises(ModelError, match=r"k: its bounds \[-3, -1\] allow no value in \(0, inf\), as b_Js .* needs"):
        craft.add(Wheel("b", axis=X, inertia=k))


def test_narrower_bounds_of_a_shared_number_stay():
    craft = craft_of()
    craft.add(Wheel("b", axis=X, inertia=craft.parameter("k", 0.2, "kg m^2", bounds="[0.1, 0.3]")))
    assert str(next(q for q in craft.system().parameters if q.name == "k").bounds) == "[0.1, 0.3]"


FLAT = (1.0, 1.0, 5.0)
LINE = {"start": X, "length": 1.0, "stiffness": 1.0}


@pytest.mark.parametrize(
    "part",
    [
        Hub("a", 1.0, FLAT),
        Hinge("a", 1.0, FLAT, axis=X),
        Slider("a", 1.0, FLAT, axis=X),
        Hinge("a", 1.0, FLAT, axis=X, motion="locked"),
        Hinge("a", 1.0, FLAT, axis=X, motion="prescribed"),
        Chain("a", [Link(1.0, BALL, axis=X), Link(1.0, FLAT, axis=X)]),
        Chain("a", [Link(1.0, FLAT, joint="ball")]),
        Rod("a", mass=1.0, inertia=FLAT, **LINE),
        Tether("a", mass=1.0, inertia=((1.0, 0, 0), (0, 1.0, 3.0), (0, 3.0, 1.0)), **LINE),
    ],
    ids=lambda part: type(part).__name__,
)
def test_a_part_that_is_no_body_is_refused_when_it_is_mounted(part):
    craft = craft_of()
    with pytest.raises(ModelError, match=r"craft: a(_\d)?\.inertia, with a(_\d)?_Jxx = 1, .* is the inertia of no"):
        craft.add(part)
    assert len(craft.parts) == 1


@pytest.mark.parametrize(
    ("rotor", "words"),
    [
        (UnbalancedWheel("u", inertia=0.1, across=0.1, dynamic=0.5, **ROTOR),
         r"u.inertia = 0.1, u.across = 0.1, u.dynamic = 0.5 kg m\^2 is the inertia of no body"),
        (UnbalancedWheel("u", inertia=0.3, across=0.1, **ROTOR), "u.inertia = 0.3, u.across = 0.1 .* of no body"),
        (ControlMomentGyro("u", inertia=0.1, gimbal_inertia=0.01, **GIMBAL), "u.gimbal_inertia = 0.01 .* of no body"),
        (ControlMomentGyro("u", inertia=0.1, gimbal_inertia=0.1, across=0.01, **GIMBAL), "u.across = 0.01 .* no body"),
        (ControlMomentGyro("u", inertia=0.1, gimbal_inertia=0.1, across=0.1, frame=0.2, **GIMBAL), "u.frame = 0.2"),
    ],
)  # fmt: skip
def test_the_inertia_of_a_rotor_is_that_of_a_body(rotor, words):
    with pytest.raises(ModelError, match=words):
        craft_of(rotor)


def test_a_rotor_is_a_body_at_later_values_too():
    system = craft_of(UnbalancedWheel("u", inertia=0.2, across=0.1, dynamic=0.0, **ROTOR)).system()
    check(system)
    values = {q.symbol: q.default for q in system.parameters}

    def least(**changes):
        given = values | {s: changes[s.name] for s in values if s.name in changes}
        return min(float(c.margin.subs(given)) for c in system.constraints)

    assert least() > 0  # a flat disc
    assert least(u_Js=0.19, u_Ud=0.02) > 0
    assert least(u_Js=0.21) < 0
    assert least(u_Js=0.19, u_Ud=0.05) < 0


@pytest.mark.parametrize(
    ("part", "changes", "words"),
    [
        *(
            (part, changes, rf"a(_1)?\.{field}, with .*: must have a length from 1e-150 to 1e\+150")
            for part, field, one, two in (
                (Wheel("a", axis=(1, 1, 0), inertia=0.1), "axis", "a_ax", "a_ay"),
                (Thruster("a", direction=(0, 1, 2)), "direction", "a_ay", "a_az"),
                (Chain("a", [Link(1.0, BALL, axis=(1, 0, 1))]), "axis", "a_1_ax", "a_1_az"),
                (Drag("a", area=1.0, normal=(1, 1, 0)), "normal", "a_nx", "a_ny"),
            )
            for changes in ({one: 1e200}, {one: -1e200}, {one: 1e-200, two: 1e-200}, {one: 0.0, two: 0.0})
        ),
        *(
            (part, changes, rf"a\.{field}, with .*: must not be along {axis}")
            for part, field, axis, changes in (
                (ControlMomentGyro("a", (1, 1, 0), (1, 1, 2), 0.1, 0.1), "spin", "gimbal", {"a_sz": 0.0}),
                (Engine("a", (1, 2, 0), (0, 1, 0), lag=0.1), "direction", "axis", {"a_tx": 1e-12}),
                (Pendulum("a", 1.0, 1.0, axis=(1, 0, 1), rest=(0, 0, 1)), "rest", "axis", {"a_ax": 1e-12}),
            )
        ),
    ],
)
def test_a_direction_is_one_at_later_values_too(part, changes, words):
    """With a component of 1e200 an axis had the length zero, and nothing turned."""
    system = craft_of(part, orbit=Orbit() if isinstance(part, Drag) else None).system()
    check(system)
    values = {q.symbol: q.default for q in system.parameters}
    assert all(float(c.margin.subs(values)) > 0 for c in system.constraints)
    values |= {s: changes[s.name] for s in values if s.name in changes}
    broken = [c.message for c in system.constraints if not float(c.margin.subs(values)) > 0]
    assert len(broken) >= 1
    assert all(re.match(words, message) for message in broken)


@pytest.mark.parametrize("bounds", ["(-1, 1)", "[0, 1]", "(0, inf]", "(-inf, inf)"])
def test_bounds_of_a_value_are_within_those_of_its_field(bounds):
    words = (
        rf"a_Js: bounds {re.escape(bounds)}: must lie within \(0, inf\), kg m\^2 \(moment of inertia about the axis\)"
    )
    with pytest.raises(ModelError, match=words):
        craft_of(Wheel("a", axis=X, inertia=Value(0.1, bounds=bounds)))
    craft = craft_of(Wheel("a", axis=X, inertia=Value(0.1, bounds="(0, 1]")))
    assert str(next(q for q in craft.system().parameters if q.name == "a_Js").bounds) == "(0, 1]"
