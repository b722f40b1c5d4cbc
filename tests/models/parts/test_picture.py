# SPDX-License-Identifier: Apache-2.0
"""Pictures of crafts: where the shapes of parts are."""

import numpy as np
import pytest

import mehvar
from mehvar.parts import (
    Bob,
    Chain,
    ControlMomentGyro,
    Engine,
    Hinge,
    Hub,
    Link,
    PointMass,
    Thruster,
    Torquer,
    Wheel,
)

from .table import craft_of


def places(craft, **values):
    """Return the points of each shape of a craft, at states, inputs and parameters that differ from their defaults."""
    return {shape.name: np.array(shape.points, dtype=float) for shape in craft.shapes(**values)}


PANEL = Hinge("panel", mass=8.0, inertia=(1.0, 0.1, 1.0), axis=(0, 0, 1), at=(0, 0.5, 0), centre=(0, 0.9, 0))


def craft(*parts, motion="free"):
    return craft_of(Hub("hub", mass=12.0, inertia=(2.0, 2.0, 2.0), centre=(0, 0, 0.1)), *parts, motion=motion)


def test_a_hub_is_the_box_of_its_mass_and_moments():
    """A cube of 12 kg whose moments are m a^2/6 = 2 kg m^2 has edges of 1 m."""
    box = places(craft())["hub"]
    assert np.allclose(box, [(0, 0, 0.1), (0.5, 0, 0.1), (0, 0.5, 0.1), (0, 0, 0.6)])


def test_parts_are_where_their_mass_is_and_turn_with_the_hub():
    tank = Bob("tank", mass=2.0, length=0.25, at=(0, 0, -0.3), rest=(0, 0, -1))
    built = craft(tank, PANEL, PointMass("lump", mass=1.0, at=(1, 2, 3)))
    at = places(built, q0=np.sqrt(0.5), q1=0, q2=0, q3=np.sqrt(0.5), panel_angle=np.pi / 2)
    assert np.allclose(at["tank mount"], [(0, 0, -0.3), (0, 0, -0.55)])
    assert np.allclose(at["panel mount"], [(-0.5, 0, 0), (-0.5, -0.9, 0)])  # a quarter by the hub, another by the hinge
    assert np.allclose(at["lump"], [(-2, 1, 3)])


def test_wheels_show_their_axes_and_thrusters_their_jets():
    jet = Thruster("jet", direction=(1, 0, 0), at=(-0.5, 0, 0), limit=4.0)
    at = places(craft(Wheel("wheel", axis=(0, 3, 0), inertia=0.02), jet), jet_force=2.0)
    tail, head = at["wheel"]
    assert np.allclose(tail, 0)
    assert np.allclose(head / np.linalg.norm(head), (0, 1, 0))
    assert np.allclose(at["jet"], [(-0.5, 0, 0), (-0.5 - head[1] / 2, 0, 0)])


def test_torques_are_arrows_and_a_ball_shows_how_fast_a_wheel_turns():
    built = craft(Wheel("wheel", axis=(0, 3, 0), inertia=0.02, torque_limit=0.1, speed_limit=50.0), Torquer("T"))
    at = places(built, wheel_torque=-0.05, wheel_speed=25.0, Tx=0.008, Ty=0.0, Tz=0.006)
    tip = at["wheel"][1]
    assert np.allclose(at["wheel torque"], [tip, 0.75 * tip])
    assert np.allclose(at["wheel speed"], tip / 2)
    tail, head = at["T"]
    assert np.allclose(tail, 0)
    assert np.allclose(head / np.linalg.norm(head), (0.8, 0.0, 0.6))
    assert np.linalg.norm(tip) / 2 < np.linalg.norm(head) < np.linalg.norm(tip)  # about what turns the hub noticeably


def test_thrusters_engines_gyros_and_chains_are_drawn_where_they_are():
    built = craft()
    built.add(Engine("engine", direction=(1, 0, 0), axis=(0, 1, 0), lag=0.1, at=(-0.6, 0, 0)))
    built.add(ControlMomentGyro("gyro", gimbal=(0, 0, 1), spin=(2, 0, 0), inertia=0.1, gimbal_inertia=0.1))
    link = {"mass": 2.0, "inertia": (0.1, 0.1, 0.1), "at": (1, 0, 0), "centre": (0.5, 0, 0)}
    built.add(Chain("arm", [Link(**link, axis=(0, 0, 1)), Link(**link, joint="slider", axis=(1, 0, 0))]))
    turned = {"engine_angle1": np.pi / 2, "gyro_gimbal": np.pi / 2, "arm_1_angle": np.pi / 2, "arm_2_place": 0.2}
    at = places(built, **turned)
    directions = {n: (at[n][1] - at[n][0]) / np.linalg.norm(at[n][1] - at[n][0]) for n in ("engine nozzle", "gyro")}
    assert np.allclose(directions["engine nozzle"], (0, 0, 1))
    assert np.allclose(directions["gyro"], (0, 1, 0))
    assert np.allclose(at["arm joints"], [(1, 0, 0), (1, 1.2, 0), (1, 1.7, 0)])
    assert np.allclose([at["arm_1"][0], at["arm_2"][0]], [(1, 0.5, 0), (1, 1.7, 0)])
    assert np.allclose(at["craft: centre of mass"], np.array([(4, 4.4, 1.2)]) / 16)


def test_a_model_draws_these_shapes():
    built = craft(PANEL)
    turned = {"q0": 0.8, "q3": 0.6, "panel_angle": 0.5, "panel_m": 3.0}
    model = mehvar.build(built, "python")
    p = model.parameters(panel_m=turned.pop("panel_m"))
    drawn = model.functions["geometry"](model.state(**turned), np.zeros(0), np.zeros(0), p)
    shapes = [p for name, at in places(built, **turned, panel_m=3.0).items() if ":" not in name for p in at.ravel()]
    assert np.allclose(drawn, shapes)


@pytest.mark.parametrize("motion", ["attitude", "plane"])
def test_a_part_whose_numbers_the_motion_does_not_need_is_drawn(motion):
    part = Torquer("torque") if motion == "attitude" else Wheel("wheel", axis=(0, 0, 1), inertia=0.02)
    built = craft(part, motion=motion)
    assert "hub" in [shape.name for shape in built.system().geometry]


def test_a_state_without_values_has_the_identity_attitude_and_a_unit_direction():
    made = craft(Bob("tank", mass=2.0, length=0.25, rest=(0, 0, -1)))
    x = mehvar.build(made).state(wx=0.1)
    assert (x.q0, x.q1, x.tank_ez, x.wx) == (1.0, 0.0, -1.0, 0.1)
    assert mehvar.build(made).state(q1=1.0).q0 == 0.0
