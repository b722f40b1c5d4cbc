# SPDX-License-Identifier: Apache-2.0
"""Pictures of crafts: where the shapes of parts are."""

import numpy as np
import pytest
import sympy as sp

import mehvar
from mehvar.parts import Bob, Hinge, Hub, PointMass, Spacecraft, Thruster, Torquer, Wheel


def places(craft, **values):
    """Return the points of each shape of a craft, at states and parameters that differ from their defaults."""
    system = craft.system()
    at = {q.symbol: q.default for q in (*system.parameters, *system.scenario_parameters)}
    at |= {q.symbol: 0 for q in system.inputs}
    start = {q.symbol: sp.sympify(v).subs(at) for q, v in zip(system.states, system.initial, strict=True)}
    steps = {step.symbol: step.expr for step in system.steps if hasattr(step, "symbol")}
    own = {q.symbol: values[q.name] for q in (*system.states, *system.inputs) if q.name in values}

    def number(expr):
        while expr.free_symbols & steps.keys():
            expr = expr.subs(steps)
        return float(expr.subs({**at, **start, **own}))

    return {
        shape.name: np.array([[number(sp.sympify(e)) for e in p] for p in shape.points]) for shape in system.geometry
    }


def craft(motion="attitude"):
    built = Spacecraft("craft", motion=motion)
    built.add(Hub("hub", mass=12.0, inertia=(2.0, 2.0, 2.0), centre=(0, 0, 0.1)))
    return built


def test_a_hub_is_the_box_of_its_mass_and_moments():
    """A cube of 12 kg whose moments are m a^2/6 = 2 kg m^2 has edges of 1 m."""
    box = places(craft())["hub"]
    assert np.allclose(box, [(0, 0, 0.1), (0.5, 0, 0.1), (0, 0.5, 0.1), (0, 0, 0.6)])


def test_parts_are_where_their_mass_is_and_turn_with_the_hub():
    built = craft("free")
    built.add(Bob("tank", mass=2.0, length=0.25, at=(0, 0, -0.3), rest=(0, 0, -1)))
    built.add(Hinge("panel", mass=8.0, inertia=(1.0, 0.1, 1.0), axis=(0, 0, 1), at=(0, 0.5, 0), centre=(0, 0.9, 0)))
    built.add(PointMass("lump", mass=1.0, at=(1, 2, 3)))
    at = places(built, q0=np.sqrt(0.5), q1=0, q2=0, q3=np.sqrt(0.5), panel_angle=np.pi / 2)
    assert np.allclose(at["tank mount"], [(0, 0, -0.3), (0, 0, -0.55)])
    assert np.allclose(at["panel mount"], [(-0.5, 0, 0), (-0.5, -0.9, 0)])  # a quarter by the hub, another by the hinge
    assert np.allclose(at["lump"], [(-2, 1, 3)])


def test_wheels_show_their_axes_and_thrusters_their_jets():
    built = craft("free")
    built.add(Wheel("wheel", axis=(0, 3, 0), inertia=0.02))
    built.add(Thruster("jet", direction=(1, 0, 0), at=(-0.5, 0, 0), limit=4.0))
    at = places(built, jet_force=2.0)
    tail, head = at["wheel"]
    assert np.allclose(tail, 0)
    assert np.allclose(head / np.linalg.norm(head), (0, 1, 0))
    assert np.allclose(at["jet"], [(-0.5, 0, 0), (-0.5 - head[1] / 2, 0, 0)])


def test_torques_are_arrows_and_a_ball_shows_how_fast_a_wheel_turns():
    built = craft("free")
    built.add(Wheel("wheel", axis=(0, 3, 0), inertia=0.02, torque_limit=0.1, speed_limit=50.0))
    built.add(Torquer("T"))
    at = places(built, wheel_torque=-0.05, wheel_speed=25.0, Tx=0.008, Ty=0.0, Tz=0.006)
    tip = at["wheel"][1]
    assert np.allclose(at["wheel torque"], [tip, 0.75 * tip])
    assert np.allclose(at["wheel speed"], tip / 2)
    tail, head = at["T"]
    assert np.allclose(tail, 0)
    assert np.allclose(head / np.linalg.norm(head), (0.8, 0.0, 0.6))
    assert np.linalg.norm(tip) / 2 < np.linalg.norm(head) < np.linalg.norm(tip)  # about what turns the hub noticeably


@pytest.mark.parametrize("motion", ["attitude", "plane"])
def test_a_part_whose_numbers_the_motion_does_not_need_is_drawn(motion):
    built = craft(motion)
    built.add(Torquer("torque") if motion == "attitude" else Wheel("wheel", axis=(0, 0, 1), inertia=0.02))
    assert places(built)["hub"].shape == (4, 3)


def test_a_state_without_values_has_the_identity_attitude_and_a_unit_direction():
    made = craft()
    made.add(Bob("tank", mass=2.0, length=0.25, rest=(0, 0, -1)))
    x = mehvar.build(made).state(wx=0.1)
    assert (x.q0, x.q1, x.tank_ez, x.wx) == (1.0, 0.0, -1.0, 0.1)
    assert mehvar.build(made).state(q1=1.0).q0 == 0.0
