# SPDX-License-Identifier: Apache-2.0
"""Derived equations: kinematics, the linear model (8)-(11), the sampled model (43)-(45) polynomial equations."""

import numpy as np
import pytest
import sympy as sp

from mehvar.models.mechanics import (
    angle_rates,
    angular_velocity,
    quaternion_of_turns,
    quaternion_rates,
    quaternion_rotation,
)
from mehvar.models.satellite.dynamics import angles, euler_rotation
from mehvar.models.satellite.linear import linear_torques, pulse_transfer
from mehvar.models.satellite.polynomials import (
    RIGHT,
    a1,
    a2,
    b0,
    b1,
    cancelling,
    numerators,
    q,
    resultant,
    retaining,
    s1,
)
from mehvar.models.satellite.wheels import along_axes
from mehvar.models.system import Equation
from tests import derived
from tests.reference.reference_satellite import INERTIA, PRINTED_B, desired, diophantine, rotation

HERE = dict(zip(angles, (0.3, -0.5, 1.1), strict=True))
OMEGA = sp.symbols("p q r", real=True)


def numeric(matrix):
    return np.array(matrix.evalf(subs=HERE).tolist(), dtype=float)


def test_the_rotation_is_that_of_the_3_2_1_angles():
    assert numeric(euler_rotation()) == pytest.approx(rotation(np.array(list(HERE.values()))), abs=1e-15)


def test_the_kinematics_are_those_of_the_paper():
    roll, pitch, _ = angles
    p, q_, r = OMEGA
    turn = q_ * sp.sin(roll) + r * sp.cos(roll)
    printed = [p + turn * sp.tan(pitch), q_ * sp.cos(roll) - r * sp.sin(roll), turn / sp.cos(pitch)]
    result = angle_rates(euler_rotation(), angles, OMEGA)
    assert [sp.simplify(a - b) for a, b in zip(result, printed, strict=True)] == [0, 0, 0]


def test_both_charts_turn_alike():
    parts = quaternion_of_turns([(2, angles[2]), (1, angles[1]), (0, angles[0])])
    assert numeric(quaternion_rotation(list(parts))) == pytest.approx(numeric(euler_rotation()), abs=1e-15)
    rates = dict(zip(angles, angle_rates(euler_rotation(), angles, (0.1, -0.2, 0.3)), strict=True))
    moving = sp.Matrix([sum(sp.diff(part, a) * rate for a, rate in rates.items()) for part in parts])
    assert numeric(moving) == pytest.approx(numeric(quaternion_rates(list(parts), (0.1, -0.2, 0.3))), abs=1e-15)


def test_the_rate_of_a_frame_is_found_from_its_matrix():
    speeds = dict(zip(angles, (0.1, -0.2, 0.3), strict=True))
    back = angle_rates(euler_rotation(), angles, angular_velocity(euler_rotation(), speeds))
    assert numeric(back)[:, 0] == pytest.approx([0.1, -0.2, 0.3], abs=1e-15)


def test_the_linear_model_keeps_and_drops_what_the_paper_does(system):
    plant = system.parameters
    x, y, z, w0 = plant.I_x, plant.I_y, plant.I_z, plant.omega0
    roll, pitch, yaw = angles
    phi, _, psi = sp.symbols(r"\dot\varphi \dot\theta \dot\psi", real=True)
    up = sp.symbols(r"\ddot\varphi \ddot\theta \ddot\psi", real=True)
    of_wheels = 3 * w0**2 * sp.Matrix([plant.Iw_y - plant.Iw_z, plant.Iw_x - plant.Iw_z])
    kept = [
        x * up[0] + (4 * w0**2 * (y - z) + of_wheels[0]) * roll,
        y * up[1] + (3 * w0**2 * (x - z) + of_wheels[1]) * pitch,
        z * up[2] + w0**2 * (y - x) * yaw,
    ]
    dropped = {0: -w0 * (x - y + z) * psi, 2: w0 * (x - y + z) * phi}
    shown = {step.left: step.expr for step in system.steps if isinstance(step, Equation)}
    for k, axis in enumerate("xyz"):
        assert sp.expand(shown[f"T_{axis}"] - kept[k]) == 0
    for k, coupling in dropped.items():
        assert sp.expand(shown[rf"T_{{{'xyz'[k]},\mathrm{{dropped}}}}"] - coupling) == 0
    assert r"T_{y,\mathrm{dropped}}" not in shown


def test_stored_momentum_enters_the_linear_model(system):
    plant, s = system.parameters, system.scenario_parameters
    hx, hy, hz = (system.states.symbols[k] for k in (6, 7, 8))
    w0 = plant.omega0
    roll, _, yaw = angles
    phi, theta, psi = sp.symbols(r"\dot\varphi \dot\theta \dot\psi", real=True)
    added = [
        hz * theta - hy * (psi + w0 * roll) - w0 * hz,
        -hz * phi + hx * psi + w0 * (hx * roll + hz * yaw),
        hy * phi - hx * theta - w0 * hy * yaw + w0 * hx,
    ]
    for torque, expected in zip(linear_torques(plant, along_axes(plant, s)), added, strict=True):
        assert sp.expand(torque - torque.subs({hx: 0, hy: 0, hz: 0}) - expected) == 0


def test_the_sampled_plant_has_its_zero_at_minus_one():
    inertia, period, frequency = sp.symbols("I T w", positive=True)
    A, B = pulse_transfer(inertia, period)
    assert list(A) == [1, -2, 1]
    assert [sp.simplify(b - period**2 / (2 * inertia)) for b in B] == [0, 0]
    _, stiff = pulse_transfer(inertia, period, frequency)
    assert sp.simplify(stiff[0] - stiff[1]) == 0
    assert sp.limit(stiff[0], frequency, 0) == period**2 / (2 * inertia)


def test_only_b1_of_the_printed_polynomials_is_right():
    for inertia, (first, second) in zip(INERTIA, PRINTED_B, strict=True):
        true = 0.5**2 / (2 * inertia)
        assert second == pytest.approx(true, rel=2e-3)
        assert 5 < first / true < 8


def polynomial(coefficients):
    return sum(c * q**k for k, c in enumerate(coefficients))


@pytest.mark.parametrize("d", [1, 2])
def test_the_cancelling_equation_is_solved(d):
    pole = sp.Symbol("c")
    result = cancelling((pole, pole), d)
    A = 1 + a1 * q + a2 * q**2
    residual = sp.expand(A * polynomial(result.S) + q**d * polynomial(result.T) - (1 - pole * q) ** 2)
    assert residual == 0


def test_the_printed_polynomials_of_the_law():
    nominal = {a1: -2, a2: 1}
    one, two = (cancelling((sp.Rational(1, 1000),) * 2, d) for d in (1, 2))
    assert list(one.S) == [1]
    assert [float(t.subs(nominal)) for t in one.T] == pytest.approx([1.998, -(1 - 1e-6)], abs=1e-12)
    assert float(two.S[1].subs(nominal)) == pytest.approx(1.998)
    assert [float(t.subs(nominal)) for t in two.T] == pytest.approx([2.996001, -1.998], abs=1e-12)


@pytest.mark.parametrize("d", [1, 2])
def test_the_retaining_equation_is_solved(d):
    pole = sp.Rational(1, 2)
    result = retaining(pole, d)
    assert result.matrix == retaining(pole, 1).matrix
    values = {a1: sp.Rational(-19, 10), a2: sp.Rational(11, 12), b0: sp.Rational(1, 17), b1: sp.Rational(1, 19)}
    if d == 2:
        values[s1] = result.first[0].subs(values)
    right = dict(zip(RIGHT, (e.subs(values) for e in result.right), strict=True))
    size = resultant(result.matrix).subs(values)
    last, *T = (n.subs(values | right) / size for n in numerators(result.matrix))
    S = [1, values[s1], last] if d == 2 else [1, last]
    A = 1 + values[a1] * q + values[a2] * q**2
    B = values[b0] + values[b1] * q
    assert sp.expand(A * polynomial(S) + q**d * B * polynomial(T) - (1 - pole * q) ** (d + 2)) == 0


@pytest.mark.parametrize(
    ("d", "S", "T"), [(1, [1, 0.15625], [5.8575, -4.7925]), (2, [1, 0, 0.265625], [3.99375, -3.46125])]
)
def test_the_nominal_roll_design(d, S, T):
    b = 0.5**2 / (2 * INERTIA[0])
    result = diophantine(np.array([1.0, -2, 1]), np.array([b, b]), desired(0.5, d), d)
    assert result[0] == pytest.approx(S, abs=1e-12)
    assert result[1] == pytest.approx(T, abs=1e-9)


def test_names_that_are_fixed(system):
    names = [quantity.name for quantity in system.states]
    assert names[:9] == ["roll", "pitch", "yaw", "wx", "wy", "wz", "hx", "hy", "hz"]
    quaternion = [quantity.name for quantity in derived.system("satellite", chart="quaternion").states]
    assert quaternion[:10] == ["q0", "q1", "q2", "q3", "wx", "wy", "wz", "hx", "hy", "hz"]
    assert [law.name for law in system.controllers] == ["mrac", "mrac-literal", "pd"]
    assert {"I_x", "I_y", "I_z", "Iw_x", "Iw_y", "Iw_z", "omega0", "noise"} <= {
        quantity.name for quantity in system.parameters
    }
    for law in system.controllers:
        assert {"ym_roll", "ym_pitch", "ym_yaw", "sensor_lost"} <= {quantity.name for quantity in law.memory}
