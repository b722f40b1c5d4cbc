# SPDX-License-Identifier: Apache-2.0
"""Accelerations and a trajectory of the slosh model against MuJoCo, which shares nothing with it."""

import mujoco
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tests.models.slosh.variants import slosh
from tests.reference import reference_slosh as reference

K = 0.51
"""Inertia of a disc across its axis over that about it: more than half, as rigid bodies have it."""
TINY = 1e-11
FREE = slice(0, 6)


def numbers(*values: float) -> str:
    return " ".join(repr(float(v)) for v in values)


def world(craft: reference.Spacecraft, pendulums: str, hull: np.ndarray, timestep: float = 1e-3) -> mujoco.MjModel:
    """Build a free hull with its frame at O, the fixed fuel welded to it, and pendulums."""
    return mujoco.MjModel.from_xml_string(f"""
    <mujoco>
      <compiler angle="radian" balanceinertia="false"/>
      <option gravity="0 0 0" integrator="RK4" timestep="{timestep}"/>
      <worldbody><body name="hull"><freejoint/>
        <inertial pos="{numbers(-craft.b, 0, 0)}" mass="{numbers(craft.m)}" diaginertia="{numbers(*hull)}"/>
        <body pos="{numbers(-craft.h0, 0, 0)}">
          <inertial pos="0 0 0" mass="{numbers(craft.m0)}" diaginertia="{numbers(*(craft.I0,) * 3)}"/>
        </body>
        {pendulums}
      </body></worldbody>
    </mujoco>""")


def hinged(bob: reference.Pendulum, inertia: float, damping: float) -> str:
    return f"""<body pos="{numbers(bob.h, 0, 0)}">
      <joint type="hinge" axis="-1 0 0" damping="{numbers(damping)}"/>
      <joint type="hinge" axis="0 1 0" damping="{numbers(damping)}"/>
      <inertial pos="{numbers(-bob.length, 0, 0)}" mass="{numbers(bob.m)}" diaginertia="{numbers(*(inertia,) * 3)}"/>
    </body>"""


def jointed(bob: reference.Pendulum) -> str:
    return f"""<body pos="{numbers(bob.h, 0, 0)}"><joint type="ball"/>
      <inertial pos="{numbers(-bob.length, 0, 0)}" mass="{numbers(bob.m)}"
        diaginertia="{numbers(*(bob.inertia,) * 3)}"/></body>"""


def disc(axis: str, inertia: tuple[float, float, float]) -> str:
    return f"""<body><joint type="hinge" axis="{axis}"/>
      <inertial pos="0 0 0" mass="{TINY}" diaginertia="{numbers(*inertia)}"/></body>"""


def applied(craft: reference.Spacecraft, u: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """Return the generalised force of a free joint: force in world axes, moment in body axes."""
    thrust, moment = reference.loads(craft, u)
    return np.concatenate([turn @ thrust, moment])


def interleaved(motion: reference.Motion, values: np.ndarray) -> np.ndarray:
    """Order phi, theta of each pendulum as its hinges are: theta first."""
    return np.ravel(values[:, ::-1])


def plain_sample(inertia: str, seed: int):
    model = slosh("2", inertia)
    x, u, p = model.sample(np.random.default_rng(seed))
    return model, x, u, p, reference.spacecraft(p)


@pytest.mark.parametrize("seed", range(5))
def test_hinge_convention(seed):
    model, x, u, p, craft = plain_sample("hinge", seed)
    motion = model.motion(x)
    built = world(craft, "".join(hinged(bob, bob.inertia, bob.eps) for bob in craft.pendulums), craft.J)
    data = mujoco.MjData(built)
    data.qpos[7:] = interleaved(motion, motion.q)
    data.qvel[:] = np.concatenate([motion.V, motion.W, interleaved(motion, motion.qd)])
    data.qfrc_applied[FREE] = applied(craft, u, np.eye(3))
    mujoco.mj_forward(built, data)
    angles = data.qacc[6:].reshape(-1, 2)[:, ::-1]
    expected = np.concatenate([data.qacc[FREE], angles.ravel()])
    result = model.accelerations(x, u, p)
    assert np.max(np.abs(result - expected)) <= 1e-9 * max(1, np.max(np.abs(expected)))


@pytest.mark.parametrize("seed", range(5))
def test_paper_convention_with_geared_discs(seed):
    """Two discs a pendulum, geared to phi about x and to theta about z, carry the paper's inertia terms."""
    model, x, u, p, craft = plain_sample("paper", seed)
    motion = model.motion(x)
    total = sum(bob.inertia for bob in craft.pendulums)
    text = "".join(
        hinged(bob, TINY, 0.0)
        + disc("1 0 0", (bob.inertia, K * bob.inertia, K * bob.inertia))
        + disc("0 0 1", (K * bob.inertia, K * bob.inertia, bob.inertia))
        for bob in craft.pendulums
    )
    built = world(craft, text, craft.J + total * np.array([-K, 1 - 2 * K, -K]))
    data = mujoco.MjData(built)
    gears = np.zeros((built.nv, 10))
    gears[FREE, FREE] = np.eye(6)
    for k in range(2):
        row, column = 6 + 4 * k, 6 + 2 * k
        gears[row, column + 1] = gears[row + 1, column] = 1
        gears[row + 2, column] = gears[row + 3, column + 1] = 1
        data.qpos[7 + 4 * k : 9 + 4 * k] = motion.q[k][::-1]
    data.qvel[:] = gears @ np.concatenate([motion.V, motion.W, motion.qd.ravel()])
    mujoco.mj_forward(built, data)
    full = np.zeros((built.nv, built.nv))
    mujoco.mj_fullM(built, data, full)
    push = np.zeros(10)
    push[FREE] = applied(craft, u, np.eye(3))
    push[6:] = -np.ravel([bob.eps * rates for bob, rates in zip(craft.pendulums, motion.qd, strict=True)])
    expected = np.linalg.solve(gears.T @ full @ gears, push - gears.T @ data.qfrc_bias)
    result = model.accelerations(x, u, p)
    assert np.max(np.abs(result - expected)) <= 1e-9 * max(1, np.max(np.abs(expected)))


def facing(s: np.ndarray) -> np.ndarray:
    """Return the quaternion, scalar first, of a turn that takes -x to s."""
    axis, cosine = np.cross([-1, 0, 0], s), -s[0]
    q = np.array([1 + cosine, *axis])
    return q / np.linalg.norm(q)


def on_balls(model, x, u, p):
    """Return the world, its data, and accelerations on ball joints, bobs without spin along their arms."""
    craft, motion = reference.spacecraft(p), model.motion(x)
    built = world(craft, "".join(jointed(bob) for bob in craft.pendulums), craft.J)
    data = mujoco.MjData(built)
    data.qvel[FREE] = np.concatenate([motion.V, motion.W])
    data.qfrc_applied[FREE] = applied(craft, u, np.eye(3))
    turns = []
    for k, bob in enumerate(craft.pendulums):
        s, sigma = motion.q[k], motion.qd[k]
        data.qpos[7 + 4 * k : 11 + 4 * k] = facing(s)
        matrix = np.zeros(9)
        mujoco.mju_quat2Mat(matrix, facing(s))
        turns.append(matrix.reshape(3, 3))
        data.qvel[6 + 3 * k : 9 + 3 * k] = turns[k].T @ (np.cross(s, sigma) - motion.W)
        damping = -bob.eps * np.cross(s, sigma - np.cross(motion.W, s))
        data.qfrc_applied[6 + 3 * k : 9 + 3 * k] = turns[k].T @ damping
    mujoco.mj_forward(built, data)
    arms = []
    for k in range(model.count):
        own, spin = data.qacc[6 + 3 * k : 9 + 3 * k], data.qvel[6 + 3 * k : 9 + 3 * k]
        carried = turns[k].T @ motion.W
        turning = turns[k] @ (own - np.cross(spin, carried)) + data.qacc[3:6]
        arms.append(reference.arm_rate_change(motion.W, motion.q[k], motion.qd[k], turning))
    return built, data, np.concatenate([data.qacc[FREE], *arms])


@pytest.mark.parametrize("seed", range(5))
def test_ball_joint_without_spin(seed):
    model, x, u, p, _ = plain_sample("ball", seed)
    *_, expected = on_balls(model, x, u, p)
    result = model.accelerations(x, u, p)
    assert np.max(np.abs(result - expected)) <= 1e-9 * max(1, np.max(np.abs(expected)))


def test_forced_damped_trajectory_on_hinges():
    model, x, _, p, craft = plain_sample("hinge", 40)
    x[:3] = [1.0, -0.5, 0.3]
    x[3:6] *= 0.2
    x[9:] *= 0.6
    u = np.array([20.0, -35.0, 25.0, 0.05, -0.08])
    motion = model.motion(x)
    built = world(craft, "".join(hinged(bob, bob.inertia, bob.eps) for bob in craft.pendulums), craft.J)
    data = mujoco.MjData(built)
    data.qpos[7:] = interleaved(motion, motion.q)
    data.qvel[:] = np.concatenate([motion.V, motion.W, interleaved(motion, motion.qd)])
    turn = np.zeros(9)

    def push(_model: object, d: mujoco.MjData) -> None:
        mujoco.mju_quat2Mat(turn, d.qpos[3:7])
        d.qfrc_applied[FREE] = applied(craft, u, turn.reshape(3, 3))

    mujoco.set_mjcb_control(push)
    try:
        for _ in range(5000):
            mujoco.mj_step(built, data)
    finally:
        mujoco.set_mjcb_control(None)
    run = solve_ivp(lambda _t, y: model.functions["rhs"](y, u, p), (0, 5), x, method="DOP853", rtol=1e-11, atol=1e-12)
    end = model.motion(run.y[:, -1])
    mujoco.mju_quat2Mat(turn, data.qpos[3:7])
    velocity = turn.reshape(3, 3).T @ data.qvel[:3]
    np.testing.assert_allclose(end.V, velocity, atol=1e-8)
    np.testing.assert_allclose(end.W, data.qvel[3:6], atol=1e-8)
    np.testing.assert_allclose(interleaved(end, end.q), data.qpos[7:], atol=1e-8)
    np.testing.assert_allclose(interleaved(end, end.qd), data.qvel[6:], atol=1e-8)
