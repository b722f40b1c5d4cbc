# SPDX-License-Identifier: Apache-2.0
"""Laws of a craft in symbols: they run as the same law in Python does, within limits, and on what sensors show."""

import functools

import casadi as ca
import numpy as np
import pytest
import sympy as sp
from scipy.linalg import solve_continuous_are

import mehvar
from mehvar.base.errors import MehvarError
from mehvar.codegen.functions.graphs import generate_functions
from mehvar.models.check import check
from mehvar.models.parts import Bob, Gyro, Hub, StarTracker, Thruster, Torquer, Wheel
from tests.models.parts import table

HUB = Hub("hub", mass=40.0, inertia=(2.0, 3.0, 2.5), centre=(0.02, 0.0, -0.01))
AXES = [(1, 0, 1), (0, 1, 1), (-1, 0, 1), (0, -1, 1)]


def wheels(limit=0.05):
    return [Wheel(f"wheel{k}", axis=axis, inertia=0.01, torque_limit=limit) for k, axis in enumerate(AXES, 1)]


def jets():
    """Return twelve thrusters in couples about each axis."""
    result = []
    for k in range(3):
        for sign in (1, -1):
            for side in (1, -1):
                at, along = np.zeros(3), np.zeros(3)
                at[(k + 1) % 3], along[(k + 2) % 3] = side * 0.5, side * sign
                name = f"jet{'xyz'[k]}{'p' if sign > 0 else 'm'}{'a' if side > 0 else 'b'}"
                result.append(Thruster(name, direction=along.tolist(), at=at.tolist(), limit=1.0))
    return result


craft_of = functools.partial(table.craft_of, HUB)


def steering(by):
    def write(law):
        kp, kd = law.parameter("kp", 0.4, "N m"), law.parameter("kd", 1.2, "N m s")
        (_, *q), w = law.attitude, law.rates
        return law.torque([-kp * a - kd * b for a, b in zip(q, w, strict=True)], by)

    return write


@pytest.mark.parametrize("kind", ["wheels", "jets"])
@pytest.mark.share(2)
def test_the_actuators_give_the_torque(kind):
    """On the hub at rest, found from what happens to its momentum, and scaled down as a whole beyond a limit."""
    by = wheels() if kind == "wheels" else jets()
    craft = craft_of(*by)
    craft.law("steer", steering(by))
    system = craft.system()
    check(system)
    law = next(
        g.graph for g in generate_functions(system) if g.name.endswith("steer") and g.graph.size1_out(0) == len(by)
    )
    arms, along = [], []
    for part in by:
        direction = np.array(part.axis if kind == "wheels" else part.direction, float)
        direction /= np.linalg.norm(direction)
        along.append(direction if kind == "jets" else 0 * direction)
        arms.append(-direction if kind == "wheels" else np.cross(np.array(part.at) - HUB.centre, direction))
    effect = np.array(arms).T
    names, p = [q.name for q in system.states], [float(q.default) for q in system.parameters]
    rng = np.random.default_rng(1)
    for size in (0.01, 10.0):
        for _ in range(3):
            x = dict.fromkeys(names, 0.0)
            q, w = size * rng.normal(size=(2, 3))
            x |= {f"q{k}": v for k, v in enumerate(q, 1)} | {f"w{a}": v for a, v in zip("xyz", w, strict=True)}
            values = {"x": [x[n] for n in names], "p": p, "c": [0.4, 1.2]}
            given = {f"arg_{n}": ca.DM(v) for n, v in values.items()}
            u = np.array(
                law.call({n: given.get(n, ca.DM.zeros(law.sparsity_in(n))) for n in law.name_in()})[law.name_out(0)]
            )
            wanted, got, limit = -0.4 * q - 1.2 * w, effect @ u.ravel(), 0.05 if kind == "wheels" else 1.0
            assert abs(u).max() <= limit * (1 + 1e-12)
            if kind == "jets":
                assert u.min() >= -1e-14
            share = got @ wanted / (wanted @ wanted)
            np.testing.assert_allclose(got, share * wanted, atol=1e-12 * abs(wanted).max())
            assert share == pytest.approx(1.0) if size < 1 else 0 < share < 1


def test_a_law_runs_in_c_as_in_python():
    by = wheels()
    craft = craft_of(*by)
    craft.law("steer", steering(by), "quaternion feedback")
    model = mehvar.build(craft)
    effect = -np.array(AXES, float).T / np.sqrt(2)

    def law(t, x):
        wanted = [-0.4 * q - 1.2 * w for q, w in ((x.q1, x.wx), (x.q2, x.wy), (x.q3, x.wz))]
        u = np.linalg.pinv(effect) @ wanted
        return u / max(1.0, abs(u).max() / 0.05)

    start = {"roll_0": 1.0, "yaw_0": -0.5, "wy_0": 0.05}
    options = {"t_end": 20.0, "parameters": start, "rtol": 1e-10, "atol": 1e-10}
    ours, theirs = mehvar.simulate(model, "steer", **options), mehvar.simulate(model, law, period=0.1, **options)
    for name in ("q1", "q2", "q3", "wheel1_speed"):
        np.testing.assert_allclose(ours[name], theirs[name], atol=1e-9)
    assert max(float(abs(ours[f"u_wheel{k}_torque"]).max()) for k in range(1, 5)) == pytest.approx(0.05)


def test_laws_see_sensors_and_keep_numbers():
    by = wheels()
    craft = craft_of(*by, Gyro("gyro"), StarTracker("tracker"))

    def integral(law):
        (_, *q), w = law.attitude, law.rates
        torque = []
        for k, axis in enumerate("xyz"):
            total = law.keep(f"total_{axis}", "s", f"integral of the error about {axis}")
            law.update(total, total + law.period * q[k])
            torque.append(-0.4 * q[k] - 1.2 * w[k] - 0.02 * total)
        return law.torque(torque, by)

    craft.law("integral", integral)
    system = craft.system()
    law = next(law for law in system.controllers if law.name == "integral")
    assert {s.name for s in law.update[0].free_symbols} == {"total_x", "Ts", "tracker_q1"}
    assert [law.name for law in system.controllers] == ["integral", "watch"]


def test_a_law_names_intermediate_results():
    craft = craft_of(Torquer("turn"))

    def damping(law):
        gain = law.define("gain", law.parameter("k", 2.0, "N m s") ** 2 / law.parameter("k0", 4.0, "N m s"), "N m s")
        return {"turn": tuple(law.define("torque", -gain * sp.Matrix(law.rates), "N m"))}

    craft.law("damp", damping)
    system = craft.system()
    (law,) = system.controllers
    assert [u.name for u in law.command] == [f"damp_torque_{k}_1" for k in (1, 2, 3)]
    steps = {step.symbol.name: step.expr for step in system.steps if hasattr(step, "symbol")}
    assert str(steps["damp_torque_1_1"]) == "-damp_gain*wx"
    assert str(steps["damp_gain"]) == "k**2/k0"


def test_lqr_on_the_linearised_craft():
    """The plant linearised at rest is a double integrator of each axis, which a Riccati equation stabilises."""
    craft = craft_of(Torquer("turn"), motion="attitude")
    model = mehvar.build(craft)
    x = np.array([0.0, 0, 0, 1, 0, 0, 0])
    A, B, *_ = model.linearize(x, np.zeros(3), model.parameters())
    keep = [0, 1, 2, 4, 5, 6]
    A, B = A[np.ix_(keep, keep)], B[keep]
    np.testing.assert_allclose(A[3:, :3], np.eye(3) / 2, atol=1e-15)
    np.testing.assert_allclose(B[:3], np.diag(1 / np.array([2.0, 3.0, 2.5])), atol=1e-12)
    gain = B.T @ solve_continuous_are(A, B, np.eye(6), np.eye(3))
    assert np.linalg.eigvals(A - B @ gain).real.max() < 0


PLUS = [jet for jet in jets() if jet.name[4] == "p"]


def two(law):
    return law.torque([0.1, 0, 0], wheels()[:2])


@pytest.mark.parametrize(
    ("parts", "write", "words"),
    [
        (
            wheels(),
            two,
            "law l: wheel1, wheel2 produce torques about only 2 of 3 axes: add actuators, or tilt these",
        ),
        (wheels(), lambda law: {"wheel9": 1}, r"law l commands 'wheel9' \(did you mean 'wheel"),
        (wheels(), lambda law: {"wheel1": (1, 2)}, "law l: wheel1 has 1 inputs, but gets 2 commands"),
        (wheels(), lambda law: law.torque([1, 2], wheels()), "law l: torque has 2 components; must have 3"),
        (wheels(), lambda law: law.torque([1, 2, 3], jets()), "law l: jetxpa is not an actuator of the craft"),
        (PLUS, lambda law: law.torque([1, 2, 3], PLUS), "can only push to one side; add thrusters"),
        (
            [Gyro("gyro")],
            lambda law: {"x": law.attitude[0]},
            "law l: no sensor measures the attitude: add a StarTracker",
        ),
        (
            [Gyro("a"), Gyro("b"), StarTracker("s")],
            lambda law: {"x": law.rates[0]},
            r"law l: several sensors measure the rates \(a, b\): use law.measured of one",
        ),
        ([Bob("tank", mass=1.0, length=1.0)], lambda law: law.torque([1, 2, 3], [HUB]), "hub is not an actuator"),
        (wheels(), lambda law: law.update(law.period, 1), "law l: Ts is not in the memory; declare it by keep"),
    ],
)
def test_wrong_laws_are_refused(parts, write, words):
    craft = craft_of(*parts)
    craft.law("l", write)
    with pytest.raises(MehvarError, match=words):
        craft.system()


def test_a_branch_in_a_law_names_the_function_to_write():
    craft = craft_of(Torquer("torque"))
    craft.law("limited", lambda law: {"torque": (min(law.parameter("k", 0.4, "N m"), 1), 0, 0)})
    with pytest.raises(MehvarError, match=r"test_law.py:\d+: a Python branch asks .* k > 1; use .* sympy.Min"):
        craft.system()
