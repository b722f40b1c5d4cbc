# SPDX-License-Identifier: Apache-2.0
"""craft = beyond: neutral numbers give the paper's craft; Cartesian masses with multipliers; balances of momentum."""

from __future__ import annotations

import functools

import casadi as ca
import numpy as np
import pytest

from mehvar.models.quantities import ModelError
from mehvar.models.slosh import system
from mehvar.runtime.board.run import BoardRequest, run_on_board
from mehvar.runtime.model.model import load
from mehvar.runtime.run.problem import Status
from mehvar.runtime.run.simulate import simulate
from papers.slosh.regulator import matrices, settings
from tests import derived
from tests.models.slosh.variants import Functions, Slosh, slosh
from tests.reference import reference_draining as reference

BURN = {"flow": 0.8166666666666667, "y1": 0.2, "z1": -0.1, "y2": -0.3, "z2": 0.15, "orbit_rate": 0.3, "zenith_0": 0.4}
"""Off the axis by more than the scenario has, and in an orbit that turns far too fast: so that every term is large."""


@functools.cache
def craft() -> Slosh:
    return Slosh(derived.system("slosh", inertia="ball", attitude="quaternion", craft="beyond"))


def sample(model: Slosh, rng: np.random.Generator, burnt: float) -> tuple[np.ndarray, np.ndarray]:
    """Return a state on its manifold with so much fuel burnt, and moments."""
    x, u, _ = model.sample(rng)
    x[model.index("burnt")] = burnt
    x[model.index("gimbal1")], x[model.index("gimbal2")] = rng.uniform(-0.6, 0.6, 2)
    x[model.index("clock")] = rng.uniform(0, 3)
    return x, u


def named(model: Slosh, x: np.ndarray) -> dict[str, float]:
    return {q.name: value for q, value in zip(model.system.states, x, strict=True)}


def test_neutral_numbers_give_the_papers_craft_on_ball_joints():
    model, paper = craft(), slosh("2", "ball", "quaternion")
    rng = np.random.default_rng(1)
    shared = [model.index(q.name) for q in paper.system.states]
    p = [model.position(q.name) for q in paper.system.parameters]
    for _ in range(10):
        x, u = sample(model, rng, 0.0)
        values = model.p
        at_gimbals = np.array([*u[:3], x[model.index("gimbal1")], x[model.index("gimbal2")]])
        expected = paper.functions["rhs"](x[shared], at_gimbals, values[p])
        result = model.functions["rhs"](x, u, values)
        assert np.max(np.abs(result[shared] - expected)) <= 1e-11 * max(1, np.max(np.abs(expected)))


@pytest.mark.parametrize("burnt", [0.0, 50.0, 200.0, 470.0])
def test_agrees_with_cartesian_masses_and_multipliers(burnt):
    model, rng = craft(), np.random.default_rng(2)
    p = model.parameters(**BURN)
    v = {q.name: value for q, value in zip(model.system.parameters, p, strict=True)}
    for _ in range(5):
        x, u = sample(model, rng, burnt)
        state = named(model, x)
        expected = reference.rates(v, 2, state, u, state["clock"])
        result = named(model, model.functions["rhs"](x, u, p))
        worst = max(abs(result[name] - value) for name, value in expected.items())
        assert worst <= 1e-10 * max(1, *map(abs, expected.values()))


@pytest.mark.parametrize("name", ["flow", "y1", "z2", "orbit_rate", "eps1", "I1"])
def test_every_addition_moves_the_craft(name):
    model, rng = craft(), np.random.default_rng(3)
    x, u = sample(model, rng, 200.0)
    p = model.parameters(**BURN)
    other = model.parameters(**{**BURN, name: 0.5})
    rhs = model.functions["rhs"]
    assert np.max(np.abs(rhs(x, u, p)[:6] - rhs(x, u, other)[:6])) > 1e-6


def test_rocket_equation():
    """Straight ahead, without fuel that sloshes far: dv = c ln(m_0/m), for the thrust flow c."""
    model = craft()
    p = model.parameters(flow=0.8)
    x = np.zeros(len(model.system.states))
    for name in ("q0",):
        x[model.index(name)] = 1.0
    for k in (1, 2):
        x[model.index(f"s{k}x")] = -1.0
    rhs = model.functions["rhs"]
    values = {q.name: v for q, v in zip(model.system.parameters, p, strict=True)}
    whole = values["m"] + values["m0"] + values["m1"] + values["m2"]
    steps, end = 400, 400.0
    h = end / steps
    u = np.zeros(5)
    for _ in range(steps):  # Runge-Kutta's classical steps
        k1 = rhs(x, u, p)
        k2 = rhs(x + h / 2 * k1, u, p)
        k3 = rhs(x + h / 2 * k2, u, p)
        k4 = rhs(x + h * k3, u, p)
        x = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    ideal = values["F"] / 0.8 * np.log(whole / (whole - 0.8 * end))
    # O is not the centre of mass, which moves in the hull as the tanks drain: by less than a metre in 400 s
    momentum = model.functions["momentum"](x, p)
    through = momentum[0] / (whole - 0.8 * end)
    assert x[model.index("burnt")] == pytest.approx(0.8 * end, rel=1e-12)
    assert x[0] == pytest.approx(ideal, rel=2e-5)
    assert through == pytest.approx(ideal, rel=2e-5)


def test_momentum_leaves_through_the_gimbal_only():
    """P and H of what is inside, in fixed axes, change by thrust, moments, gravity and what passes the gimbal."""
    model, rng = craft(), np.random.default_rng(4)
    p = model.parameters(**{**BURN, "orbit_rate": 0.0})
    v = {q.name: value for q, value in zip(model.system.parameters, p, strict=True)}
    gradient = momentum_rate(model)
    gimbal = np.array([-(v["b"] + v["d"]), 0.0, 0.0])
    for burnt in (10.0, 300.0):
        x, u = sample(model, rng, burnt)
        P, H = np.split(model.functions["momentum"](x, p), 2)
        P_rate, H_rate = np.split(np.array(gradient(x, u, p)).ravel(), 2)
        V, W = x[:3], x[3:6]
        d1, d2 = x[model.index("gimbal1")], x[model.index("gimbal2")]
        thrust = v["F"] * np.array([np.cos(d1) * np.cos(d2), np.sin(d2), -np.sin(d1) * np.cos(d2)])
        leaving = thrust - v["flow"] * (V + np.cross(W, gimbal))
        np.testing.assert_allclose(P_rate + np.cross(W, P), leaving, atol=1e-9)
        expected = u[:3] + np.cross(gimbal, leaving)
        np.testing.assert_allclose(H_rate + np.cross(W, H) + np.cross(V, P), expected, atol=1e-7)


def momentum_rate(model: Slosh) -> ca.Function:
    """Return (x, u, p) -> the rate of the components of P and H, by CasADi's derivative of the two functions."""
    graphs: Functions = model.functions
    momentum, rhs = graphs.graph("momentum"), graphs.graph("rhs")
    x, u, p = (
        ca.SX.sym(name, len(g))
        for name, g in zip("xup", (model.system.states, model.system.inputs, model.system.parameters), strict=True)
    )
    value = momentum(x, p)
    return ca.Function("rate", [x, u, p], [ca.jtimes(value, x, rhs(x, u, p))])


def test_gimbals_follow_with_their_lag_and_within_their_limits():
    model = craft()
    p = model.parameters(lag=0.1, gimbal_rate=0.2, delta1_max=0.3, delta2_max=0.4)
    x, _ = sample(model, np.random.default_rng(5), 0.0)
    at = [model.index("gimbal1"), model.index("gimbal2")]
    x[at] = [0.29, 0.1]
    rates = model.functions["rhs"](x, np.array([0, 0, 0, 1.0, 0.11]), p)[at]
    np.testing.assert_allclose(rates, [0.1, 0.1], rtol=1e-12)  # (0.3 - 0.29)/0.1 and (0.11 - 0.1)/0.1
    rates = model.functions["rhs"](x, np.array([0, 0, 0, -1.0, 1.0]), p)[at]
    np.testing.assert_allclose(rates, [-0.2, 0.2], rtol=1e-12)


def test_structures_that_cannot_be_beyond_are_refused():
    with pytest.raises(ModelError, match=r"craft = 'beyond' with inertia = 'paper'"):
        system(craft="beyond")


@pytest.mark.parametrize("law", ["lyapunov-v1", "lyapunov-v2"])
def test_reported_rate_is_that_of_the_function_along_the_loop(law):
    """V_dot against CasADi's derivative of V along the closed loop; the promise is that rate where the proof holds."""
    model = craft()
    functions, name = model.functions, law.replace("-", "_")
    x, _ = sample(model, np.random.default_rng(6), 100.0)
    p, c, r = model.parameters(**BURN), model.law(law), np.zeros(0)
    graph = functions.graph(f"{name}_value")
    at, controls = ca.SX.sym("x", len(x)), functions[name](x, r, p, c)
    slope = ca.Function("slope", [at], [ca.jtimes(graph(at, p, c), at, ca.DM(functions["rhs"](x, controls, p)))])
    outputs = next(q for q in model.system.controllers if q.name == law).outputs
    reported = functions[f"{name}_outputs"](x, r, p, c)
    values = {output.quantity.name: value for output, value in zip(outputs, reported, strict=True)}
    assert values["V_dot"] == pytest.approx(float(slope(x)), rel=1e-9)
    assert abs(values["V_promise"] - values["V_dot"]) > 1e-6  # where nothing that the proof assumes holds


def test_a_sampling_period_that_the_gains_are_not_made_for_is_warned_of():
    model = craft()
    (law,) = (law for law in model.system.controllers if law.name == "regulator")
    (warning,) = law.warnings
    period, made = model.system.parameters.sample, law.parameters.sample_of_gains
    for value, fits in ((0.1, True), (0.1 + 1e-12, True), (0.2, False), (0.05, False)):
        assert bool(warning.margin.subs({period: value, made: 0.1}) > 0) is fits


@pytest.mark.soak
def test_regulator_on_the_emulated_board_and_its_gains(tmp_path):
    """The same bits as on the host; and the gains that stand in the table are those of the generated Jacobian."""
    for name, text in derived.variant("slosh", inertia="ball", attitude="quaternion", craft="beyond").items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    model = load(tmp_path)
    empty = simulate(model, "regulator", m0=5.0, m1=50.0, flow=0.06, t_end=520.0)
    assert (empty.status, empty.t_stop) == (Status.LIMIT, pytest.approx(84.1585, abs=1e-4))
    assert "the fuel that does not slosh is used up" in empty.reason
    with pytest.warns(UserWarning, match=r"sample = 0.2 s: the regulator's gains are made for sample_of_gains = 0.1 s"):
        assert simulate(model, "regulator", sample=0.2, t_end=1.0).advice
    request = BoardRequest("regulator", "unicorn", "mps2-m7", samples=100, selftest=4, profiled=False)
    assert run_on_board(model, request).max_ulp == 0
    kept = {q.name: q.default for q in model.manifest.controllers["regulator"].parameters}
    for name, value in settings(matrices(model)).items():
        assert kept[name] == pytest.approx(value, rel=1e-6, abs=1e-9)
