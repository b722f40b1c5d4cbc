# SPDX-License-Identifier: Apache-2.0
"""The satellite against Basilisk: a hub with balanced wheels on a circular orbit in the gravity gradient.

Basilisk's hub has the inertia with locked wheels, I + Iw, and its wheels the momentum Js (Omega + w), as the
satellite's h. Its bound is its own: how far its rk4 moves when the step is halved.
"""

from __future__ import annotations

from importlib.metadata import version

import numpy as np
import pytest
from Basilisk.architecture import messaging
from Basilisk.simulation import GravityGradientEffector, reactionWheelStateEffector, spacecraft
from Basilisk.utilities import RigidBodyKinematics, SimulationBaseClass, macros, simIncludeGravBody, simIncludeRW
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import mehvar
from tests.models.satellite.loop import satellite
from tests.validation.table import record

RADIUS, SPAN = 6978137.0, 600.0
WHEELS = {"small wheels": (1.47e-5, 1.26e-5, 1.26e-5), "wheels of half the hub": (1.1, 1.5, 1.4)}
INERTIA = np.array([2.13, 3.04, 3.09])


def basilisk(turn: np.ndarray, rate: np.ndarray, spin: np.ndarray, momentum: np.ndarray, torque: np.ndarray, h: float):
    """Return body rates, wheel momenta and nadir in body axes after SPAN seconds in steps of h."""
    simulation = SimulationBaseClass.SimBaseClass()
    simulation.CreateNewProcess("p").addTask(simulation.CreateNewTask("t", macros.sec2nano(h)))
    craft = spacecraft.Spacecraft()
    craft.hub.mHub = 50.0
    craft.hub.IHubPntBc_B = np.diag(INERTIA + spin).tolist()
    gravity = simIncludeGravBody.gravBodyFactory()
    earth = gravity.createEarth()
    earth.isCentralBody = True
    speed = np.sqrt(earth.mu / RADIUS)
    craft.hub.r_CN_NInit, craft.hub.v_CN_NInit = [[0], [0], [-RADIUS]], [[speed], [0], [0]]
    craft.hub.sigma_BNInit = [[s] for s in RigidBodyKinematics.C2MRP(turn)]
    craft.hub.omega_BN_BInit = [[w] for w in rate]
    gravity.addBodiesTo(craft)
    gradient = GravityGradientEffector.GravityGradientEffector()
    gradient.addPlanetName(earth.planetName)
    craft.addDynamicEffector(gradient)
    wheels, factory = reactionWheelStateEffector.ReactionWheelStateEffector(), simIncludeRW.rwFactory()
    for k, axis in enumerate(np.eye(3)):
        relative = momentum[k] / spin[k] - rate[k]
        factory.create("custom", axis, Js=spin[k], Omega=relative / macros.RPM, useMaxTorque=False)
    factory.addToSpacecraft("wheels", wheels, craft)
    message = messaging.ArrayMotorTorqueMsg().write(
        messaging.ArrayMotorTorqueMsgPayload(motorTorque=(-torque).tolist())
    )
    wheels.rwMotorCmdInMsg.subscribeTo(message)
    for part in (craft, gradient, wheels):
        simulation.AddModelToTask("t", part)
    simulation.InitializeSimulation()
    simulation.ConfigureStopTime(macros.sec2nano(SPAN))
    simulation.ExecuteSimulation()
    state, relative = craft.scStateOutMsg.read(), wheels.rwSpeedOutMsg.read().wheelSpeeds[:3]
    end = np.array(state.omega_BN_B)
    place = np.array(state.r_CN_N)
    nadir = RigidBodyKinematics.MRP2C(np.array(state.sigma_BN)) @ (-place / np.linalg.norm(place))
    return np.concatenate([end, spin * (np.array(relative) + end), nadir]), np.sqrt(earth.mu / RADIUS**3)


def ours(turn: np.ndarray, rate: np.ndarray, spin: np.ndarray, momentum: np.ndarray, torque: np.ndarray, w0: float):
    """Return the same quantities of the satellite, by its compiled right-hand side and SciPy's dop853."""
    model = mehvar.load(satellite("quaternion").folder)
    values = {f"Iw_{axis}": value for axis, value in zip("xyz", spin, strict=True)}
    p = model.parameters(omega0=w0, **values)
    x = np.concatenate([as_quaternion(turn), rate, momentum, [0.0]])
    run = solve_ivp(lambda _t, y: model.rhs(y, torque, p), (0, SPAN), x, "DOP853", rtol=1e-13, atol=1e-15, max_step=1.0)
    end = run.y[:, -1]
    q, v = end[0], end[1:4]
    down = np.array([0.0, 0.0, 1.0])
    nadir = (q * q - v @ v) * down + 2 * v * v[2] - 2 * q * np.cross(v, down)
    return np.concatenate([end[4:10], nadir / (q * q + v @ v)])


def as_quaternion(turn: np.ndarray) -> np.ndarray:
    """Return the quaternion, scalar first, of a matrix that takes components from orbit to body axes."""
    return Rotation.from_matrix(turn.T).as_quat(scalar_first=True)


@pytest.mark.parametrize("kind", WHEELS)
@pytest.mark.parametrize("torque", [(0.0, 0.0, 0.0), (1e-3, -2e-3, 1.5e-3)], ids=["free", "driven"])
def test_hub_with_wheels_in_the_gravity_gradient(kind: str, torque: tuple[float, float, float]) -> None:
    random, errors, moves = np.random.default_rng(3), [], []
    spin, u = np.array(WHEELS[kind]), np.array(torque)
    sizes = np.repeat([0.02, 0.02, 1.0], 3)
    for turn in Rotation.random(4, rng=random).as_matrix():
        rate, momentum = random.normal(0, 0.02, 3), random.normal(0, 0.02, 3)
        (coarse, w0), (fine, _) = (basilisk(turn, rate, spin, momentum, u, h) for h in (0.1, 0.05))
        errors.append((ours(turn, rate, spin, momentum, u, w0) - fine) / sizes)
        moves.append((coarse - fine) / sizes)
    record(
        f"satellite: hub with {kind} in orbit, {'torques' if any(torque) else 'no torque'}, {SPAN:.0f} s",
        "Basilisk",
        version("bsk"),
        errors,
        np.abs(moves).max(),
        "of 0.02 rad/s, 0.02 N m s, 1",
        "change of Basilisk's rk4 when its step of 0.1 s is halved",
    )
