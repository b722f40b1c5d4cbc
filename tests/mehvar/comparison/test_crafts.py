# SPDX-License-Identifier: Apache-2.0
"""Two spacecraft that Python code has made: what changed is said part by part, then equation by equation."""

import pytest

import mehvar
from mehvar.base.errors import MehvarError
from mehvar.parts import Hinge, Hub, PointMass, Spacecraft, Torquer, Wheel


def craft_of(axis=(0, 1, 0), *more, mass=100.0):
    craft = Spacecraft("survey", motion="attitude")
    parts = (Hub("hub", mass=mass, inertia=(10.0, 12.0, 15.0)), Wheel("wheel1", axis=(1, 0, 0), inertia=0.1),
             Wheel("wheel2", axis=axis, inertia=0.1), *more)  # fmt: skip
    for part in parts:
        craft.add(part)
    return craft


def test_the_part_is_named():
    found = mehvar.diff(craft_of(), craft_of((0, 0, 1)))
    assert found.differs
    assert found.notes == ("wheel2: axis (0, 1, 0) -> (0, 0, 1)",)
    assert "wheel2: axis (0, 1, 0) -> (0, 0, 1)" in str(found)
    assert repr(found) == str(found)


def test_the_same_craft_is_the_same():
    found = mehvar.diff(craft_of(), craft_of())
    assert not found.differs
    assert not found.notes


def test_eigenvalues_are_those_at_a_possible_state():
    """At zero the craft has no attitude; its panel swings at sqrt(k/I (1 + I/J)) about the hub."""

    def with_panel(stiffness):
        panel = Hinge("panel", mass=1e-6, inertia=(1.0, 1.0, 1.0), axis=(0, 1, 0), stiffness=stiffness)
        return craft_of((0, 1, 0), panel)

    found = str(mehvar.diff(with_panel(1.0), with_panel(4.0)))
    assert "eigenvalues at q0 = 1, the rest 0" in found
    hub = 12.0 - 0.1  # the wheel along the axis is free
    slow = (1 + 1 / hub) ** 0.5
    assert f"± {slow:.4g}i -> ± {2 * slow:.4g}i" in found


def test_parts_that_come_and_go():
    older, newer = craft_of(), craft_of((0, 1, 0), Torquer("turn"))
    assert older.changes(newer) == ("turn: added, a Torquer",)
    assert newer.changes(older) == ("turn: removed",)
    assert craft_of((0, 1, 0), PointMass("turn", mass=1.0)).changes(newer) == ("turn: a PointMass -> a Torquer",)
    assert Spacecraft("a").changes(Spacecraft("b", attitude="mrp")) == ("attitude: quaternion -> mrp",)


def test_wrong_arguments_are_refused():
    with pytest.raises(MehvarError, match="leave new and structures out"):
        mehvar.diff(craft_of(), craft_of(), "work~1")
    with pytest.raises(MehvarError, match=r"model = .*must be a text"):
        mehvar.diff(craft_of(), "HEAD")
    with pytest.raises(MehvarError, match="must be a System, a Spacecraft, or a function"):
        mehvar.diff(1, 2)
