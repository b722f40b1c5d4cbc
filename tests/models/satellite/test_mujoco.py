# SPDX-License-Identifier: Apache-2.0
"""Rigid body with three reaction wheels against MuJoCo, which knows nothing of momentum exchange but joints."""

import mujoco
import numpy as np
import pytest

from tests.models.satellite.loop import satellite
from tests.reference.reference_satellite import INERTIA, SPIN

TRANSVERSE = 0.7 * SPIN
"""Transverse inertia of each wheel: any value that a body can have."""


def body():
    """Return a free body at rest in empty space with a wheel along each axis."""
    hull = [INERTIA[k] - TRANSVERSE.sum() + TRANSVERSE[k] for k in range(3)]
    wheels = ""
    for k, axis in enumerate(np.eye(3)):
        inertia = np.where(axis > 0, SPIN[k], TRANSVERSE[k])
        wheels += (
            f'<body><joint type="hinge" axis="{_text(axis)}"/>'
            f'<inertial pos="0 0 0" mass="0.001" diaginertia="{_text(inertia)}"/></body>'
        )
    return mujoco.MjModel.from_xml_string(
        f'<mujoco><option gravity="0 0 0"/><worldbody><body><freejoint/>'
        f'<inertial pos="0 0 0" mass="50" diaginertia="{_text(hull)}"/>{wheels}</body></worldbody></mujoco>'
    )


def _text(numbers):
    return " ".join(repr(float(n)) for n in numbers)


@pytest.mark.parametrize("friction", [0.0, 1e-6])
def test_body_and_wheels_accelerate_as_in_mujoco(friction):
    generated, random, model = satellite(), np.random.default_rng(8), body()
    p = generated.parameters({"omega0": 0.0, "wheel_friction": friction})[0]
    data = mujoco.MjData(model)
    for _ in range(50):
        x = np.zeros(10)
        x[:3], x[3:6] = random.uniform(-1.2, 1.2, 3), random.normal(0, 0.1, 3)
        wheel_speed, u = random.normal(0, 500, 3), random.normal(0, 0.1, 3)
        x[6:9] = SPIN * (wheel_speed + x[3:6])
        data.qpos[3:7] = 1, 0, 0, 0
        data.qvel[:] = [0, 0, 0, *x[3:6], *wheel_speed]
        data.qfrc_applied[6:] = -u - friction * wheel_speed
        mujoco.mj_forward(model, data)
        turning = data.qacc[3:6]
        storing = SPIN * (data.qacc[6:] + turning)
        slope = generated.rhs(x, u, p)
        assert slope[3:6] == pytest.approx(turning, abs=1e-9)
        assert slope[6:9] == pytest.approx(storing, abs=1e-9)


def test_a_tumble_is_that_of_mujoco():
    """Ten seconds under steady motor torques: rates and stored momentum, each by its own integrator."""
    generated, model = satellite("quaternion"), body()
    model.opt.timestep, model.opt.integrator = 0.002, mujoco.mjtIntegrator.mjINT_RK4
    p = generated.parameters({"omega0": 0.0})[0]
    u = np.array([0.01, -0.02, 0.015])
    data = mujoco.MjData(model)
    x = np.array([1.0, 0, 0, 0, 0.1, -0.2, 0.15, 0, 0, 0, 0])
    x[7:10] = SPIN * x[4:7]
    data.qvel[3:6] = x[4:7]
    data.qfrc_applied[6:] = -u
    h = 0.01
    for _ in range(1000):
        k1 = generated.rhs(x, u, p)
        k2 = generated.rhs(x + h / 2 * k1, u, p)
        k3 = generated.rhs(x + h / 2 * k2, u, p)
        k4 = generated.rhs(x + h * k3, u, p)
        x = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    mujoco.mj_step(model, data, 5000)
    sign = np.sign(data.qpos[3] * x[0])
    assert x[4:7] == pytest.approx(data.qvel[3:6], abs=1e-9)
    assert x[7:10] == pytest.approx(SPIN * (data.qvel[6:] + data.qvel[3:6]), abs=1e-9)
    assert x[:4] * sign == pytest.approx(data.qpos[3:7], abs=1e-9)
