# SPDX-License-Identifier: Apache-2.0
"""The evaluated right-hand side against the derived equations and against hand-written Newton-Euler dynamics."""

import numpy as np
import pytest

from mehvar.codegen.code.tape import tape
from mehvar.models.slosh.plant import ball, pendulum
from mehvar.models.slosh.states import velocity
from tests.models.slosh.variants import CONVENTIONS, implicit, rate_positions, slosh
from tests.reference import reference_slosh as reference


@pytest.mark.parametrize("inertia", CONVENTIONS)
@pytest.mark.parametrize("pendulums", ["1", "2", "6"])
@pytest.mark.soak
def test_evaluation_form_solves_the_derived_equations(inertia, pendulums):
    model, equations = slosh(pendulums, inertia), implicit(pendulums, inertia)
    rng = np.random.default_rng(1)
    at = rate_positions(model)
    for _ in range(10):
        x, u, p = model.sample(rng)
        matrix, rest = (np.array(e) for e in equations(x, u, p))
        expected = np.linalg.solve(matrix, -rest[:, 0])
        result = model.functions["rhs"](x, u, p)[at]
        assert np.max(np.abs(result - expected)) <= 1e-12 * max(1, np.max(np.abs(expected)))


@pytest.mark.parametrize("inertia", CONVENTIONS)
@pytest.mark.parametrize("pendulums", ["1", "2", "6"])
@pytest.mark.share(8)
def test_evaluation_form_agrees_with_newton_and_euler(inertia, pendulums):
    model = slosh(pendulums, inertia)
    rng = np.random.default_rng(2)
    for _ in range(10):
        x, u, p = model.sample(rng)
        a, alpha, own = reference.accelerations(reference.spacecraft(p), inertia, model.motion(x), u)
        expected = np.concatenate([a, alpha, own.ravel()])
        result = model.accelerations(x, u, p)
        assert np.max(np.abs(result - expected)) <= 1e-11 * max(1, np.max(np.abs(expected)))


@pytest.mark.parametrize("inertia", ["paper", "hinge"])
def test_velocity_drops_out_of_the_derived_equations(inertia):
    part = pendulum.contribution(inertia)
    for expr in (*part.force, *part.moment, *part.rows):
        assert not expr.free_symbols.intersection(velocity)
    assert part.energy.free_symbols.intersection(velocity)


def test_mass_matrices_of_the_angle_conventions_are_symmetric():
    rng = np.random.default_rng(3)
    for inertia in ("paper", "hinge"):
        x, u, p = slosh("2", inertia).sample(rng)
        matrix = np.array(implicit("2", inertia)(x, u, p)[0])
        np.testing.assert_allclose(matrix, matrix.T, atol=1e-13)


@pytest.mark.soak
def test_conventions_agree_for_point_bobs_without_damping():
    rng = np.random.default_rng(4)
    paper, hinge, joint = (slosh("2", inertia) for inertia in CONVENTIONS)
    for _ in range(10):
        x, u, p = paper.sample(rng)
        for name in ("I1", "I2", "eps1", "eps2"):
            p[paper.position(name)] = 0.0
        expected = paper.accelerations(x, u, p)
        np.testing.assert_allclose(hinge.accelerations(x, u, p), expected, rtol=1e-10, atol=1e-10)
        craft, motion = reference.spacecraft(p), paper.motion(x)
        y = np.zeros(len(joint.system.states))
        y[:9] = x[:9]
        for k, bob in enumerate(craft.pendulums):
            s, slip = reference.bob_motion(bob, motion.q[k], motion.qd[k])
            y[9 + 6 * k : 15 + 6 * k] = np.concatenate([s, slip + np.cross(x[3:6], s)])
        result = joint.accelerations(y, u, p)
        np.testing.assert_allclose(result[:6], expected[:6], rtol=1e-10, atol=1e-10)
        for k, bob in enumerate(craft.pendulums):
            acceleration = arm_acceleration(bob, motion, k, expected[6 + 2 * k : 8 + 2 * k], expected[3:6])
            np.testing.assert_allclose(result[6 + 3 * k : 9 + 3 * k], acceleration, rtol=1e-10, atol=1e-10)


def arm_acceleration(bob, motion, k, angles, alpha):
    """sigma' by components, from the accelerations of the angles."""
    hinge, tilt, r = reference.arm(bob, motion.q[k])
    phid, thetad = motion.qd[k]
    spin = thetad * hinge + phid * tilt
    change = angles[1] * hinge + angles[0] * tilt + np.cross(thetad * hinge, phid * tilt)
    slip = np.cross(spin, r) / bob.length
    slip_rate = (np.cross(change, r) + np.cross(spin, np.cross(spin, r))) / bob.length
    return slip_rate + np.cross(alpha, r / bob.length) + np.cross(motion.W, slip)


def test_ball_joint_keeps_its_constraints():
    model = slosh("2", "ball")
    rng = np.random.default_rng(5)
    x, u, p = model.sample(rng)
    dx = model.functions["rhs"](x, u, p)
    for k in (1, 2):
        at = model.index(f"s{k}x")
        s, sigma = x[at : at + 3], x[at + 3 : at + 6]
        s_rate, sigma_rate = dx[at : at + 3], dx[at + 3 : at + 6]
        assert s @ s_rate == pytest.approx(0, abs=1e-13)
        assert s_rate @ sigma + s @ sigma_rate == pytest.approx(0, abs=1e-12)


def test_projection_puts_directions_and_quaternion_back():
    model = slosh("2", "ball", "quaternion")
    x, _, _ = model.sample(np.random.default_rng(6))
    off = x + 1e-3 * np.random.default_rng(7).standard_normal(len(x))
    back = model.functions["project"](off)
    assert np.linalg.norm(back[6:10]) == pytest.approx(1, abs=1e-15)
    for k in (1, 2):
        at = model.index(f"s{k}x")
        s, sigma = back[at : at + 3], back[at + 3 : at + 6]
        assert np.linalg.norm(s) == pytest.approx(1, abs=1e-15)
        assert s @ sigma == pytest.approx(0, abs=1e-15)
    np.testing.assert_array_equal(back[:6], off[:6])


def test_ball_joint_equation_holds_a_multiplier_along_the_arm_only():
    row = ball.contribution().rows
    across = ball.direction.cross(row)
    assert ball.direction.dot(across).expand() == 0


def test_operation_counts_stay_within_their_budget():
    rhs = {n: slosh(n).functions.graph("rhs") for n in ("1", "2", "6")}
    assert rhs["2"].n_instructions() <= 800  # 1.12 times the operations of a form by hand that parts replaced
    assert rhs["6"].n_instructions() - rhs["2"].n_instructions() <= 4 * 285
    assert varying_operations(slosh("2", "ball", "quaternion")) <= 300
    assert varying_operations(slosh("6", "ball")) - varying_operations(slosh("2", "ball")) <= 4 * 180


def varying_operations(model):
    """Count the operations that depend on the state: the rest needs doing once a parameter set or once a sample."""
    instructions = tape(model.functions.graph("rhs")).instructions
    varies, count = [], 0
    for i in instructions:
        moved = i.args[0] == 0 if i.op == "input" else any(varies[a] for a in i.operands)
        varies.append(moved)
        count += moved and i.op not in ("input", "const", "neg", "truth", "num")
    return count
