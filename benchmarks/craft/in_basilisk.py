# SPDX-License-Identifier: Apache-2.0
"""Basilisk: balanced wheels, panels of two hinges, its spherical pendulum, an external force."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from Basilisk.architecture import bskLogging, messaging
from Basilisk.simulation import (
    dualHingedRigidBodyStateEffector,
    extForceTorque,
    reactionWheelStateEffector,
    spacecraft,
    sphericalPendulum,
    svIntegrators,
)
from Basilisk.utilities import RigidBodyKinematics, SimulationBaseClass, macros, simIncludeRW

from benchmarks.craft import task
from benchmarks.craft.task import Array, Fly

bskLogging.setDefaultLogLevel(bskLogging.BSK_ERROR)  # trial steps of rkf78 warn of the wheels' acceleration


def column(vector: Any) -> list[list[float]]:
    return np.reshape(vector, (3, 1)).tolist()


def assembled(start: Array, step: float, tolerance: float | None) -> tuple[Any, Any, Callable[[], Array]]:
    """Return the simulation, the craft and a function that reads the task's final state."""
    values = dict(zip(task.STARTS, start, strict=True))
    simulation, craft = SimulationBaseClass.SimBaseClass(), spacecraft.Spacecraft()
    simulation.CreateNewProcess("p").addTask(simulation.CreateNewTask("t", macros.sec2nano(step)))
    mass, centre, inertia = task.composite(locked=True)
    turn, rate = task.attitude(values), np.array([values[name] for name in ("wx", "wy", "wz")])
    craft.hub.mHub, craft.hub.r_BcB_B, craft.hub.IHubPntBc_B = mass, column(centre), inertia.tolist()
    craft.hub.sigma_BNInit, craft.hub.omega_BN_BInit = column(RigidBodyKinematics.C2MRP(turn.T)), column(rate)
    if tolerance is not None:
        integrator = svIntegrators.svIntegratorRKF78(craft)
        integrator.setRelativeTolerance(tolerance)
        integrator.setAbsoluteTolerance(tolerance)
        craft.setIntegrator(integrator)
    wheels, factory = reactionWheelStateEffector.ReactionWheelStateEffector(), simIncludeRW.rwFactory()
    for k, axis in enumerate(task.AXES, 1):
        speed = float(values[f"wheel{k}_speed"] / macros.RPM)
        factory.create("custom", axis, Js=task.SPIN, Omega=speed, useMaxTorque=False)
    factory.addToSpacecraft("wheels", wheels, craft)
    torques = messaging.ArrayMotorTorqueMsg().write(
        messaging.ArrayMotorTorqueMsgPayload(motorTorque=task.TORQUES.tolist())
    )
    wheels.rwMotorCmdInMsg.subscribeTo(torques)
    panels = [panel(side, values, k) for k, side in enumerate(task.SIDES, 1)]
    bob, push = pendulum(values, rate), extForceTorque.ExtForceTorque()
    push.extForce_B = column([task.FORCE, 0, 0])
    for part in (*panels, bob):
        craft.addStateEffector(part)
    craft.addDynamicEffector(push)
    for priority, part in enumerate((craft, push, wheels)):
        simulation.AddModelToTask("t", part, priority)
    simulation.InitializeSimulation()
    rest = craft.dynManager.getStateObject(craft.hub.nameOfHubVelocity)
    rest.setState(np.zeros((3, 1)).tolist())  # Basilisk is given the velocity of the centre of mass

    def state(name: str) -> Array:
        return np.ravel(craft.dynManager.getStateObject(name).getState())

    def final() -> Array:
        hub = craft.hub
        turn = RigidBodyKinematics.MRP2C(state(hub.nameOfHubSigma))
        angles = [state(getattr(own, f"nameOf{name}State"))[0] for own in panels
                  for name in ("Theta1", "Theta2", "Theta1Dot", "Theta2Dot")]  # fmt: skip
        a, b = state(bob.nameOfPhiState)[0], state(bob.nameOfThetaState)[0]
        axes = np.column_stack([np.ravel(axis) for axis in (bob.pHat_01, bob.pHat_02, bob.pHat_03)])
        arm = axes @ [np.cos(a) * np.cos(b), np.sin(a) * np.cos(b), -np.sin(b)]
        return np.concatenate([turn.T.ravel(), state(hub.nameOfHubOmega), turn @ state(hub.nameOfHubVelocity),
                               angles, arm, state(wheels.nameOfReactionWheelOmegasState) / task.SPEED])  # fmt: skip

    simulation.kept = (torques, wheels, factory, panels, bob, push)  # Python would free them
    return simulation, craft, final


def panel(side: float, values: Mapping[str, float], k: int) -> Any:
    """Return a panel; Basilisk's centre of mass is behind the hinge, its axes are -y, x, z on the first side."""
    own = dualHingedRigidBodyStateEffector.DualHingedRigidBodyStateEffector()
    own.mass1 = own.mass2 = task.BODY
    own.d1 = own.d2 = task.LONG / 2
    own.k1 = own.k2 = task.STIFFNESS
    own.c1 = own.c2 = task.DAMPING
    own.l1, own.r_H1B_B = task.LONG, column([0, side * task.EDGE, 0])
    own.IPntS1_S1 = own.IPntS2_S2 = np.diag(task.PLATE[[1, 0, 2]]).tolist()
    own.dcm_H1B = [[0, -side, 0], [1, 0, 0], [0, 0, side]]
    own.theta1Init, own.theta2Init = (float(values[f"panel{k}_{link}_angle"]) for link in (1, 2))
    return own


def pendulum(values: Mapping[str, float], rate: Array) -> Any:
    """Return the pendulum; its first angles are zero, so it starts along the first of its axes."""
    own, arm = sphericalPendulum.SphericalPendulum(), task.arm(values)
    own.massInit, own.pendulumRadius, own.d = task.BOB, task.ROD, column(task.PIVOT)
    own.D = np.zeros((3, 3)).tolist()
    side = np.cross(arm, [0, 0, 1]) / np.hypot(arm[0], arm[1])
    own.pHat_01, own.pHat_02, own.pHat_03 = map(column, (arm, side, np.cross(arm, side)))
    slip = -np.cross(rate, arm)
    own.phiDotInit, own.thetaDotInit = float(slip @ side), float(-slip @ np.cross(arm, side))
    return own


def fly(step: float, tolerance: float | None = None) -> Fly:
    """Return single runs, one after the other: rk4 at a step, or rkf78 within each step at a tolerance."""

    def one(start: Array) -> Array:
        simulation, _, final = assembled(start, step, tolerance)
        simulation.ConfigureStopTime(macros.sec2nano(task.SPAN))
        simulation.ExecuteSimulation()
        return final()

    return lambda starts: np.array([one(start) for start in starts])


def rhs() -> Callable[[], object]:
    """Return one call of the equations of motion from Python."""
    simulation, craft, _ = assembled(task.starts(1)[0], 0.1, None)
    return lambda kept=simulation: craft.equationsOfMotion(0.0, 0.1)


def evaluations(setting: str, _start: Array) -> int:
    """Return how often a run by rk4 evaluates the equations of motion."""
    return round(4 * task.SPAN / float(setting.removesuffix(" s")))
