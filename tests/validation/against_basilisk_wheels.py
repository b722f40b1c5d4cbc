# SPDX-License-Identifier: Apache-2.0
"""Wheels off balance of a craft from parts against Basilisk's fully coupled wheels, in empty space.

Basilisk's wheel has its centre of mass at d = U_s/m along w2 and the product J13 = U_d between its axis and w3, about
that centre, as an `UnbalancedWheel` has.
"""

from __future__ import annotations

import functools
from importlib.metadata import version

import numpy as np
import pytest
from Basilisk.architecture import messaging
from Basilisk.simulation import reactionWheelStateEffector, spacecraft
from Basilisk.utilities import RigidBodyKinematics, SimulationBaseClass, macros, simIncludeRW
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import mehvar
from mehvar.parts import Hub, Spacecraft, UnbalancedWheel
from tests.validation.table import record

INERTIA = np.array([[2.13, 0.05, -0.08], [0.05, 3.04, 0.06], [-0.08, 0.06, 3.09]])
AXES = np.array([[1.0, -1, -1, 1], [1, 1, -1, -1], [1, 1, 1, 1]]).T / np.sqrt(3)
PLACES = np.array([[0.1, -0.1, -0.1, 0.1], [0.1, 0.1, -0.1, -0.1], [0.0, 0.05, 0.0, -0.05]]).T
MASS, ROTOR, SPIN, ACROSS = 44.0, 1.5, 1e-3, 7e-4
"""Masses of hub and wheel, kg, and moments of inertia about and across the wheel's axis, kg m^2. A thin disc, with half
as much across, has no dynamic imbalance."""
SPAN = 5.0
WHEELS = {
    "of data sheets": (5e-6, 1e-6, 300.0),
    "large": (2e-3, 2e-4, 60.0),
}
"""Static and dynamic imbalance, kg m and kg m^2, and about how fast wheels turn, rad/s."""


def basilisk(kind: str, turn: np.ndarray, rate: np.ndarray, speeds: np.ndarray, motors: np.ndarray, h: float):
    """Return attitude, rates and speeds of the wheels after SPAN seconds in steps of h."""
    static, dynamic, _ = WHEELS[kind]
    simulation = SimulationBaseClass.SimBaseClass()
    simulation.CreateNewProcess("p").addTask(simulation.CreateNewTask("t", macros.sec2nano(h)))
    craft = spacecraft.Spacecraft()
    craft.hub.r_CN_NInit = craft.hub.v_CN_NInit = [[0], [0], [0]]
    craft.hub.mHub, craft.hub.IHubPntBc_B = MASS, INERTIA.tolist()
    craft.hub.sigma_BNInit = [[s] for s in RigidBodyKinematics.C2MRP(turn.T)]
    craft.hub.omega_BN_BInit = [[w] for w in rate]
    wheels, factory = reactionWheelStateEffector.ReactionWheelStateEffector(), simIncludeRW.rwFactory()
    for axis, r, speed in zip(AXES, PLACES, speeds, strict=True):
        wheel = factory.create(
            "custom", axis, Js=SPIN, Omega=float(speed / macros.RPM), useMaxTorque=False, rWB_B=r.tolist(),
            RWModel=messaging.JitterFullyCoupled,
        )  # fmt: skip
        wheel.mass, wheel.U_s, wheel.U_d, wheel.Jt, wheel.Jg = ROTOR, static, dynamic, ACROSS, ACROSS
        out = across(axis)
        wheel.w2Hat0_B, wheel.w3Hat0_B = out.reshape(3, 1).tolist(), np.cross(axis, out).reshape(3, 1).tolist()
    factory.addToSpacecraft("wheels", wheels, craft)
    payload = messaging.ArrayMotorTorqueMsgPayload(motorTorque=motors.tolist())
    message = messaging.ArrayMotorTorqueMsg().write(payload)
    wheels.rwMotorCmdInMsg.subscribeTo(message)
    for part in (craft, wheels):
        simulation.AddModelToTask("t", part)
    simulation.InitializeSimulation()
    simulation.ConfigureStopTime(macros.sec2nano(SPAN))
    simulation.ExecuteSimulation()
    end = craft.scStateOutMsg.read()
    turn = RigidBodyKinematics.MRP2C(np.array(end.sigma_BN)).T
    return np.concatenate([turn.ravel(), end.omega_BN_B, wheels.rwSpeedOutMsg.read().wheelSpeeds[:4]])


def across(axis: np.ndarray) -> np.ndarray:
    """Return the direction of a static imbalance at angle zero: across the axis, nearest to x."""
    out = np.eye(3)[0] - axis[0] * axis
    return out / np.linalg.norm(out)


@functools.cache
def craft(kind: str) -> mehvar.Model:
    """Return the craft from parts, compiled."""
    static, dynamic, _ = WHEELS[kind]
    result = Spacecraft("craft", motion="attitude")
    result.add(Hub("hub", mass=MASS, inertia=INERTIA.tolist()))
    for k, (axis, r) in enumerate(zip(AXES, PLACES, strict=True), 1):
        given = {"axis": axis.tolist(), "at": r.tolist(), "inertia": SPIN, "mass": ROTOR, "across": ACROSS}
        result.add(UnbalancedWheel(f"wheel{k}", **given, static=static, dynamic=dynamic, towards="x"))
    return mehvar.build(result)


def ours(kind: str, turn: np.ndarray, rate: np.ndarray, speeds: np.ndarray, motors: np.ndarray) -> np.ndarray:
    """Return the same quantities of a craft from parts, by its compiled right-hand side and SciPy's dop853."""
    model = craft(kind)
    names, p = [q.name for q in model.manifest.states], model.parameters()
    start = dict(zip((f"q{k}" for k in range(4)), Rotation.from_matrix(turn).as_quat(scalar_first=True), strict=True))
    start |= dict(zip(("wx", "wy", "wz"), rate, strict=True))
    start |= {f"wheel{k}_speed": speed for k, speed in enumerate(speeds, 1)}
    x = np.array([start.get(name, 0.0) for name in names])
    run = solve_ivp(lambda _t, y: model.rhs(y, motors, p), (0, SPAN), x, "DOP853", rtol=1e-13, atol=1e-15)
    end = dict(zip(names, run.y[:, -1], strict=True))
    attitude = Rotation.from_quat([end[f"q{k}"] for k in range(4)], scalar_first=True)
    moving = [end[name] for name in ("wx", "wy", "wz", *(f"wheel{k}_speed" for k in range(1, 5)))]
    return np.concatenate([attitude.as_matrix().ravel(), moving])


@pytest.mark.parametrize("kind", WHEELS)
@pytest.mark.parametrize("torque", [0.0, 1e-2], ids=["free", "driven"])
def test_wheels_off_balance_in_empty_space(kind: str, torque: float) -> None:
    speed, random, errors, moves = WHEELS[kind][2], np.random.default_rng(3), [], []
    sizes = np.concatenate([np.ones(9), np.full(3, 0.02), np.full(4, speed)])
    for turn in Rotation.random(3, rng=random).as_matrix():
        speeds = speed * random.uniform(0.5, 1, 4) * random.choice([-1, 1], 4)
        motion = (kind, turn, random.normal(0, 0.02, 3), speeds, torque * random.normal(0, 1, 4))
        coarse, fine = (basilisk(*motion, h) for h in (0.002, 0.001))
        errors.append((ours(*motion) - fine) / sizes)
        moves.append((coarse - fine) / sizes)
    record(
        f"parts: wheels off balance, {kind}, {'torques' if torque else 'no torque'}, {SPAN:.0f} s",
        "Basilisk", version("bsk"), errors, np.abs(moves).max(), f"of 1, 0.02 rad/s, {speed:.0f} rad/s",
        "change of Basilisk's rk4 when its step of 2 ms is halved",
    )  # fmt: skip
