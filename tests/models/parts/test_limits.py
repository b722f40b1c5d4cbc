# SPDX-License-Identifier: Apache-2.0
"""Limits of actuators: what acts where more is commanded."""

import casadi as ca
import pytest

from mehvar.codegen.functions.graphs import generate_functions
from mehvar.models.check import check
from mehvar.models.parts import Hub, Spacecraft, Thruster, Wheel


@pytest.fixture(scope="module")
def actuate():
    craft = Spacecraft("craft")
    craft.add(Hub("hub", mass=10.0, inertia=(1.0, 2.0, 3.0)))
    craft.add(Wheel("wheel", axis=(0, 0, 1), inertia=0.1, torque_limit=0.5, speed_limit=100.0))
    craft.add(Thruster("jet", direction=(1, 0, 0), at=(0, 1, 0), limit=2.0))
    system = craft.system()
    check(system)
    graph: ca.Function = next(g.graph for g in generate_functions(system) if g.name == "actuate")
    names, p = [q.name for q in system.states], [float(q.default) for q in system.parameters]

    def acting(torque, force, speed=0.0):
        x = [speed if name == "wheel_speed" else 0.0 for name in names]
        return tuple(map(float, graph(x, [torque, force], p).full().ravel()))

    return acting


@pytest.mark.parametrize(
    ("commanded", "speed", "acts"),
    [
        ((0.2, 1.5), 0.0, (0.2, 1.5)),
        ((0.9, 9.0), 0.0, (0.5, 2.0)),
        ((-0.9, -1.0), 0.0, (-0.5, 0.0)),
        ((0.3, 0.0), 101.0, (0.0, 0.0)),
        ((-0.3, 0.0), 101.0, (-0.3, 0.0)),
        ((-0.3, 0.0), -101.0, (0.0, 0.0)),
    ],
)
def test_what_acts_is_within_the_limits(actuate, commanded, speed, acts):
    assert actuate(*commanded, speed=speed) == acts
