# SPDX-License-Identifier: Apache-2.0
"""Limits of actuators, what acts where more is commanded; limits of the physics, where a run ends."""

import math

import casadi as ca
import numpy as np
import pytest

import mehvar
from mehvar.codegen.functions.graphs import generate_functions
from mehvar.models.check import check
from mehvar.models.parts import Engine, Gyro, Hub, Pendulum, Tank, Thruster, Torquer, Wheel

from .table import FUEL, PARTS, assembled, craft_of

HUB = Hub("hub", mass=10.0, inertia=(1.0, 2.0, 2.5))


@pytest.fixture(scope="module")
def actuate():
    wheel = Wheel("wheel", axis=(0, 0, 1), inertia=0.1, torque_limit=0.5, speed_limit=100.0)
    system = craft_of(HUB, wheel, Thruster("jet", direction=(1, 0, 0), at=(0, 1, 0), limit=2.0, least=0.01)).system()
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
        ((0.2, 0.11), 0.0, (0.2, 0.11)),
        ((0.2, 0.09), 0.0, (0.2, 0.0)),
        ((0.9, 9.0), 0.0, (0.5, 2.0)),
        ((-0.9, -1.0), 0.0, (-0.5, 0.0)),
        ((0.3, 0.0), 101.0, (0.0, 0.0)),
        ((-0.3, 0.0), 101.0, (-0.3, 0.0)),
        ((-0.3, 0.0), -101.0, (0.0, 0.0)),
    ],
)
def test_what_acts_is_within_the_limits(actuate, commanded, speed, acts):
    assert actuate(*commanded, speed=speed) == acts


def test_gimbals_follow_with_their_lag_and_within_their_limits():
    engine = Engine("e", (1, 0, 0), (0, 1, 0), lag=0.1, at=(-1, 0, 0), limit=5.0, angle_limit=0.3, rate_limit=0.2)
    model = mehvar.build(craft_of(HUB, engine))
    run = mehvar.simulate(model, lambda t, x: [9.0, 1.0, -0.015], period=0.1, t_end=4.0, dt_out=0.5)
    assert run["u_e_force"][1] == 5.0
    np.testing.assert_allclose(run["e_angle2"], -0.015 * (1 - np.exp(-10 * run.t)), atol=1e-7)  # never too fast
    assert run["e_angle1"][1] == pytest.approx(0.2 * 0.5, rel=1e-6)
    assert run["e_angle1"][-1] == pytest.approx(0.3, abs=1e-6)


def test_the_force_of_an_engine_turns_with_its_gimbals():
    engine = Engine("e", (1, 0, 0), (0, 1, 0), lag=0.1, at=(-1, 0, 0))
    balances = assembled([HUB, engine, Torquer("turn")])
    x = dict.fromkeys(balances.x_names, 0.0) | {"q0": 1.0, "e_angle1": 0.3, "e_angle2": 0.2}
    rates = balances.rates(x, dict.fromkeys(balances.u_names, 0.0) | {"e_force": 20.0})
    force = 20.0 * np.array([np.cos(0.3) * np.cos(0.2), np.sin(0.2), -np.sin(0.3) * np.cos(0.2)])
    np.testing.assert_allclose([rates[f"v{a}"] for a in "xyz"], force / 10.0, atol=1e-15)
    np.testing.assert_allclose([rates[f"w{a}"] for a in "xyz"], np.cross([-1, 0, 0], force) / [1, 2, 2.5], atol=1e-15)


@pytest.mark.parametrize("name", PARTS)
@pytest.mark.share(8)
def test_a_mass_that_is_a_state_has_a_limit(name):
    system = craft_of(HUB, PARTS[name]).system()
    limited = {symbol for limit in system.limits for symbol in limit.margin.free_symbols}
    assert {q.symbol for q in system.states if q.unit == "kg"} <= limited


@pytest.fixture(scope="module")
def burning():
    fuel = FUEL | {"mass": 5.0}
    return mehvar.build(craft_of(HUB, Tank("tank", **fuel, share=0.6, length=0.3), Tank("spare", **fuel, reserve=1.0)))


def test_a_run_ends_where_the_fuel_is_used_up(burning):
    """At mass/flow, under constant inputs, under a law between its samples, and in a batch."""
    flows = {"tank_flow": 0.3, "spare_flow": 0.0}
    law = {"controller": lambda t, x: [*flows.values()], "period": 0.1}
    for given in ({"controller": None, "inputs": flows}, law):
        run = mehvar.simulate(burning, t_end=60.0, **given)
        assert run.attrs["reason"].startswith("the fuel in tank is used up (at t = 16.6667 s)")
    runs = mehvar.batch(burning, None, inputs=flows, n=4, t_end=20.0, vary={"tank_fuel_0": "uniform(1, 5)"}, seed=3)
    np.testing.assert_allclose(runs["t_stop"], runs["tank_fuel_0"] / 0.3, atol=2e-8)  # ends are located to 1e-8 s
    with pytest.raises(mehvar.MehvarError, match="the fuel in tank is used up"):
        mehvar.simulate(burning, None, inputs=flows, initial={"tank_fuel": -1.0})


@pytest.mark.parametrize("start", [{"q0": 0.5}, {"q0": 2.0, "q1": 1.0}, {"q0": 0.0}, {"tank_bob_ux": 0.5}], ids=str)
def test_a_start_that_is_no_attitude_is_refused(burning, start):
    """As a quaternion off unit length by more than its last of three digits; the error says the nearest start."""
    with pytest.raises(mehvar.InputError, match=r"initial state .* is impossible: (q0|tank_bob_ux) = .* has length 1"):
        mehvar.simulate(burning, lambda t, x: [0.0, 0.0], period=0.1, t_end=1.0, initial=start)


def test_a_batch_counts_starts_that_are_no_attitude(burning):
    """Run 1 starts at a quaternion of length 1.2."""
    runs = mehvar.batch(burning, lambda t, x: [0.0, 0.0], period=0.1, t_end=0.2, points={"q1": [1e-4, 0.7]})
    assert runs["status"].values.tolist() == [0, 5]


def test_a_reserve_ends_the_thrust_and_not_the_run(burning):
    run = mehvar.simulate(burning, lambda t, x: [0.0, 0.3], period=0.1, t_end=20.0)
    assert run.attrs["reason"] == "end time reached"
    assert 1.0 - 0.3 * 0.1 < run["spare_fuel"][-1] <= 1.0


@pytest.mark.parametrize(
    ("attitude", "turn", "why"),
    [("euler", np.pi / 2, "pitch is 90 or -90 degrees"), ("mrp", 2 * np.pi, "a whole turn")],
)
@pytest.mark.share(4)
def test_a_run_ends_where_its_attitude_is_singular(attitude, turn, why):
    model = mehvar.build(craft_of(HUB, attitude=attitude, motion="attitude"))
    run = mehvar.simulate(model, None, inputs={}, wy_0=0.5, t_end=60.0)
    assert why in run.attrs["reason"]
    assert float(run.attrs["reason"].split("t = ")[1].split()[0]) == pytest.approx(turn / 0.5, rel=1e-3)
    runs = mehvar.batch(model, None, inputs={}, n=4, t_end=60.0, vary={"wy_0": "uniform(0.2, 0.5)"})
    np.testing.assert_allclose(runs["t_stop"], turn / runs["wy_0"], rtol=1e-3)


def test_a_craft_without_inputs_has_derivatives_and_a_linear_system():
    """Its law `watch` commands nothing; a Jacobian with respect to inputs has rows and no columns."""
    model = mehvar.build(craft_of(HUB, Gyro("gyro")))
    x, p = model.state(q0=1.0, wx=0.2), model.parameters()
    assert model.jac_u([x, x], [], p).shape == (2, 10, 0)
    loop = model.linearize(x, None, p, controller="watch")
    assert loop.B.shape == (14, 0)
    shown = [loop.states.index(f"gyro_{a}_shown") for a in "xyz"]
    np.testing.assert_array_equal(loop.A[shown][:, [loop.states.index(f"w{a}") for a in "xyz"]], np.eye(3))


def test_limits_act_once_a_period_whatever_the_step_of_the_result() -> None:
    """A wheel under a constant command stops at its limit, also where results are far apart and in a batch."""
    model = mehvar.build(craft_of(HUB, Wheel("wheel", axis=(0, 0, 1), inertia=1e-3, speed_limit=20.0)))
    push = {"wheel_torque": 0.02}
    fine, coarse = (mehvar.simulate(model, None, inputs=push, t_end=5.0, dt_out=dt) for dt in (0.1, 2.5))
    assert float(fine["wheel_speed"][-1]) < 22
    assert float(coarse["wheel_speed"][-1]) == float(fine["wheel_speed"][-1])
    runs = mehvar.batch(
        model, inputs={"wheel_torque": 0.02}, t_end=5.0, dt_out=2.5, n=2, vary={"hub_Jxx": "uniform(1.0, 1.1)"}
    )
    assert float(runs["maximum"].sel(variable="wheel_speed").max()) < 22
    words = "dt_out = 3.14159 .*must be a multiple of a part of the actuators' period of 0.1 s"
    with pytest.raises(mehvar.InputError, match=words):
        mehvar.simulate(model, None, inputs=push, t_end=31.4159, dt_out=3.14159)


def test_a_pendulum_by_two_angles_ends_a_run_at_its_singularity():
    part = Pendulum("p", mass=1.0, length=0.5, axis=(1, 0, 0), rest=(0, 0, 1), angles=2)
    (limit,) = craft_of(HUB, part).system().limits
    angle = part.coordinates()[1].place.symbol
    assert "p_angle2 is 90 or -90 degrees" in limit.message
    assert [float(limit.margin.subs(angle, at)) > 0 for at in (1.5, -1.5, math.pi / 2, -math.pi / 2)] == [
        True, True, False, False,
    ]  # fmt: skip
