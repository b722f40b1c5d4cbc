# SPDX-License-Identifier: Apache-2.0
"""Hinged panels, a sprung mass and a spherical pendulum of a craft from parts against Basilisk's, in empty space.

A constant force and torque in axes of the hub push the craft, and its velocity is compared too. Basilisk's panels turn
about the second of their axes, with the centre of mass behind the hinge on the first.
"""

from __future__ import annotations

import functools
from importlib.metadata import version
from typing import Any

import numpy as np
import pytest
from Basilisk.simulation import (
    dualHingedRigidBodyStateEffector,
    extForceTorque,
    hingedRigidBodyStateEffector,
    linearSpringMassDamper,
    spacecraft,
    sphericalPendulum,
)
from Basilisk.utilities import RigidBodyKinematics, SimulationBaseClass, macros
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import mehvar
from mehvar.parts import Bob, Chain, ExternalForce, Hinge, Hub, Link, Part, Spacecraft, SprungMass, Torquer
from tests.validation.table import record

MASS, CENTRE = 60.0, np.array([0.03, -0.02, 0.05])
INERTIA = np.array([[9.0, 0.3, -0.2], [0.3, 8.0, 0.4], [-0.2, 0.4, 6.0]])
AT = np.array([0.5, -0.2, 0.3])
"""The joint, m."""
AXES = Rotation.from_rotvec([0.4, -0.7, 0.9]).as_matrix().T
"""Rows: axes of the panel at angle zero, of the pendulum, and in the first row of the spring, in those of the hub."""
BODY, PANEL = 5.0, np.array([0.4, 0.6, 0.9])
"""Mass, kg, and moments of inertia of a panel in its axes, kg m^2; the panel beyond it has half of both."""
ARM, LENGTH = 0.4, 0.9
"""Centre of mass from the hinge, and second hinge from the first, m; the arm is also the rod of the pendulum."""
STIFFNESS, DAMPING = 12.0, 0.5
PLACES, SPEEDS = (0.3, -0.2), (0.1, 0.15)
"""The joints at the start: rad and rad/s, or a third of them in m and m/s; the pendulum begins on its first axis."""
PUSH, TURN = np.array([0.5, -0.3, 0.4]), np.array([0.2, 0.3, -0.1])
SPAN, STEP = 10.0, 0.004


def column(vector: Any) -> list[list[float]]:
    return np.reshape(vector, (3, 1)).tolist()


def part(kind: str) -> Part:
    """Return the part from mehvar.parts."""
    body: dict[str, Any] = {"stiffness": STIFFNESS, "damping": DAMPING, "axis": AXES[1].tolist()}
    inertia = AXES.T @ np.diag(PANEL) @ AXES
    first, second = (
        body | {"mass": share * BODY, "inertia": (share * (inertia + inertia.T) / 2).tolist(),
                "centre": (-ARM * AXES[0]).tolist(), "at": at.tolist()}
        for share, at in ((1, AT), (0.5, -LENGTH * AXES[0]))
    )  # fmt: skip
    if kind == "hinged panel":
        return Hinge("part", **first)
    if kind == "panel of two bodies":
        return Chain("part", [Link(**first), Link(**second)])
    if kind == "sprung mass":
        spring = {"stiffness": STIFFNESS, "damping": DAMPING, "axis": AXES[0].tolist()}
        return SprungMass("part", mass=BODY, at=AT.tolist(), **spring)
    return Bob("part", mass=BODY, length=ARM, at=AT.tolist(), damping=DAMPING)


def effector(kind: str) -> tuple[Any, list[str]]:
    """Return Basilisk's part and the names of its states."""
    if kind == "hinged panel":
        result = hingedRigidBodyStateEffector.HingedRigidBodyStateEffector()
        result.mass, result.d, result.k, result.c = BODY, ARM, STIFFNESS, DAMPING
        result.IPntS_S, result.dcm_HB, result.r_HB_B = np.diag(PANEL).tolist(), AXES.tolist(), column(AT)
        result.thetaInit, result.thetaDotInit = PLACES[0], SPEEDS[0]
        return result, [result.nameOfThetaState, result.nameOfThetaDotState]
    if kind == "panel of two bodies":
        result = dualHingedRigidBodyStateEffector.DualHingedRigidBodyStateEffector()
        result.mass1, result.d1, result.k1, result.c1, result.l1 = BODY, ARM, STIFFNESS, DAMPING, LENGTH
        result.mass2, result.d2, result.k2, result.c2 = BODY / 2, ARM, STIFFNESS, DAMPING
        result.IPntS1_S1, result.IPntS2_S2 = np.diag(PANEL).tolist(), np.diag(PANEL / 2).tolist()
        result.dcm_H1B, result.r_H1B_B = AXES.tolist(), column(AT)
        (result.theta1Init, result.theta2Init), (result.theta1DotInit, result.theta2DotInit) = PLACES, SPEEDS
        names = [result.nameOfTheta1State, result.nameOfTheta1DotState]
        return result, [*names, result.nameOfTheta2State, result.nameOfTheta2DotState]
    if kind == "sprung mass":
        result = linearSpringMassDamper.LinearSpringMassDamper()
        result.massInit, result.k, result.c = BODY, STIFFNESS, DAMPING
        result.r_PB_B, result.pHat_B = column(AT), column(AXES[0])
        result.rhoInit, result.rhoDotInit = PLACES[0] / 3, SPEEDS[0] / 3
        return result, [result.nameOfRhoState, result.nameOfRhoDotState]
    result = sphericalPendulum.SphericalPendulum()
    result.massInit, result.pendulumRadius, result.d = BODY, ARM, column(AT)
    result.D = (DAMPING / ARM**2 * np.eye(3)).tolist()
    result.pHat_01, result.pHat_02, result.pHat_03 = map(column, AXES)
    result.phiDotInit, result.thetaDotInit = SPEEDS
    names = [result.nameOfPhiState, result.nameOfThetaState]
    return result, [*names, result.nameOfPhiDotState, result.nameOfThetaDotState]


def direction(own: Any, angles: list[float], rate: np.ndarray) -> list[float]:
    """Return direction and absolute rate of a pendulum from its angles and their rates."""
    axes = np.column_stack([np.ravel(axis) for axis in (own.pHat_01, own.pHat_02, own.pHat_03)])
    (a, b), (da, db) = np.reshape(angles, (2, 2))
    arm = axes @ [np.cos(a) * np.cos(b), np.sin(a) * np.cos(b), -np.sin(b)]
    along, down = [-np.sin(a), np.cos(a), 0], [np.cos(a) * np.sin(b), np.sin(a) * np.sin(b), np.cos(b)]
    return [*arm, *(axes @ (da * np.cos(b) * np.array(along) - db * np.array(down)) + np.cross(rate, arm))]


def basilisk(kind: str, turn: np.ndarray, rate: np.ndarray, h: float) -> tuple[np.ndarray, np.ndarray]:
    """Return attitude, rate, velocity in axes of the hub and the part's states at the start and after SPAN."""
    simulation = SimulationBaseClass.SimBaseClass()
    simulation.CreateNewProcess("p").addTask(simulation.CreateNewTask("t", macros.sec2nano(h)))
    craft, push, (own, names) = spacecraft.Spacecraft(), extForceTorque.ExtForceTorque(), effector(kind)
    craft.hub.mHub, craft.hub.r_BcB_B, craft.hub.IHubPntBc_B = MASS, column(CENTRE), INERTIA.tolist()
    craft.hub.sigma_BNInit, craft.hub.omega_BN_BInit = column(RigidBodyKinematics.C2MRP(turn.T)), column(rate)
    push.extForce_B, push.extTorquePntB_B = column(PUSH), column(TURN)
    craft.addStateEffector(own)
    craft.addDynamicEffector(push)
    for model in (craft, push):
        simulation.AddModelToTask("t", model)

    def states() -> np.ndarray:
        sigma, omega, v = (
            np.ravel(craft.dynManager.getStateObject(name).getState())
            for name in (craft.hub.nameOfHubSigma, craft.hub.nameOfHubOmega, craft.hub.nameOfHubVelocity)
        )
        turn = RigidBodyKinematics.MRP2C(sigma)
        values = [craft.dynManager.getStateObject(name).getState()[0][0] for name in names]
        return np.concatenate([turn.T.ravel(), omega, turn @ v,
                               direction(own, values, omega) if kind == "spherical pendulum" else values])  # fmt: skip

    simulation.InitializeSimulation()
    start = states()
    simulation.ConfigureStopTime(macros.sec2nano(SPAN))
    simulation.ExecuteSimulation()
    return start, states()


@functools.cache
def craft(kind: str) -> mehvar.Model:
    """Return the craft from parts, compiled."""
    result = Spacecraft("craft")
    result.add(Hub("hub", mass=MASS, inertia=INERTIA.tolist(), centre=CENTRE.tolist()))
    for each in (ExternalForce("push"), Torquer("turn"), part(kind)):
        result.add(each)
    return mehvar.build(result)


def ours(kind: str, start: np.ndarray) -> np.ndarray:
    """Return the same quantities at the end of a craft from parts, by its right-hand side and SciPy's dop853."""
    model = craft(kind)
    names, p = [q.name for q in model.manifest.states], model.parameters()
    own = [name for name in names if name.startswith("part_")]
    moving = ["wx", "wy", "wz", "vx", "vy", "vz", *own]
    if kind == "panel of two bodies":
        assert own == ["part_1_angle", "part_1_rate", "part_2_angle", "part_2_rate"], own
    attitude = [f"q{k}" for k in range(4)]
    given = dict(zip(attitude, Rotation.from_matrix(start[:9].reshape(3, 3)).as_quat(scalar_first=True), strict=True))
    given |= dict(zip(moving, start[9:], strict=True))
    x = np.array([given.get(name, 0.0) for name in names])
    u = np.concatenate([PUSH, TURN])
    run = solve_ivp(lambda _t, y: model.rhs(y, u, p), (0, SPAN), x, "DOP853", rtol=1e-13, atol=1e-15)
    end = dict(zip(names, run.y[:, -1], strict=True))
    turn = Rotation.from_quat([end[name] for name in attitude], scalar_first=True).as_matrix()
    return np.concatenate([turn.ravel(), [end[name] for name in moving]])


@pytest.mark.parametrize("kind", ["hinged panel", "panel of two bodies", "sprung mass", "spherical pendulum"])
def test_a_part_on_a_joint_in_empty_space(kind: str) -> None:
    random, errors, moves = np.random.default_rng(3), [], []
    for turn in Rotation.random(3, rng=random).as_matrix():
        rate = random.normal(0, 0.2, 3)
        (start, coarse), (_, fine) = (basilisk(kind, turn, rate, h) for h in (STEP, STEP / 2))
        errors.append(ours(kind, start) - fine)
        moves.append(coarse - fine)
    record(
        f"parts: {kind} on a hub, force and torque, {SPAN:.0f} s",
        "Basilisk", version("bsk"), errors, np.abs(moves).max(), "of 1, 1 rad/s, 1 m/s, 1 rad, 1 m",
        f"change of Basilisk's rk4 when its step of {1000 * STEP:.0f} ms is halved",
    )  # fmt: skip
