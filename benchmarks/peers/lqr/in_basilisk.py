# SPDX-License-Identifier: Apache-2.0
"""Basilisk: a hub, its own spherical pendulums, an external force, the law as a Python module; rkf78."""

from __future__ import annotations

import numpy as np
import task
from Basilisk.architecture import messaging, sysModel
from Basilisk.simulation import extForceTorque, spacecraft, sphericalPendulum, svIntegrators
from Basilisk.utilities import RigidBodyKinematics, SimulationBaseClass, macros


class Law(sysModel.SysModel):
    """Command force and moment from the hub's states at every sample."""

    def __init__(self, craft):
        super().__init__()
        self.craft = messaging.SCStatesMsgReader()
        self.craft.subscribeTo(craft.scStateOutMsg)
        self.force, self.torque = messaging.CmdForceBodyMsg(), messaging.CmdTorqueBodyMsg()

    def UpdateState(self, now):  # noqa: N802 - Basilisk calls it so
        x = np.zeros(22)
        x[:10] = hub(self.craft())
        force, moment = task.wrench(task.law(x))
        self.force.write(messaging.CmdForceBodyMsgPayload(forceRequestBody=force), now)
        self.torque.write(messaging.CmdTorqueBodyMsgPayload(torqueRequestBody=moment), now)


def hub(state):
    """Return V, Omega and q of a spacecraft's message."""
    turn = RigidBodyKinematics.MRP2C(state.sigma_BN)
    return np.concatenate([turn @ state.v_BN_N, state.omega_BN_B, RigidBodyKinematics.MRP2EP(state.sigma_BN)])


def one(x, tolerance):
    """Simulate one initial state of the task and return the final state."""
    simulation = SimulationBaseClass.SimBaseClass()
    simulation.CreateNewProcess("p").addTask(simulation.CreateNewTask("t", macros.sec2nano(task.PERIOD)))
    craft = spacecraft.Spacecraft()
    mass, centre, inertia = task.hull()
    craft.hub.mHub, craft.hub.r_BcB_B, craft.hub.IHubPntBc_B = mass, centre.reshape(3, 1), inertia
    craft.hub.sigma_BNInit = RigidBodyKinematics.EP2MRP(x[6:10]).reshape(3, 1)
    craft.hub.v_CN_NInit = (task.matrix(x[6:10]) @ x[:3]).reshape(3, 1)
    integrator = svIntegrators.svIntegratorRKF78(craft)
    integrator.setRelativeTolerance(tolerance)
    integrator.setAbsoluteTolerance(tolerance)
    craft.setIntegrator(integrator)
    pendulums = []
    for (m, length, pivot, eps), (arm, _) in zip(task.BOBS, x[10:].reshape(2, 2, 3), strict=True):
        bob = sphericalPendulum.SphericalPendulum()
        bob.pendulumRadius, bob.massInit, bob.d = length, m, [[pivot], [0], [0]]
        bob.D = (eps / length**2 * np.eye(3)).tolist()
        side = np.cross(arm, [0, 0, 1]) / np.hypot(arm[0], arm[1])
        # its first angles are private and zero: the arm starts along the first axis
        bob.pHat_01, bob.pHat_02, bob.pHat_03 = (a.reshape(3, 1) for a in (arm, side, np.cross(arm, side)))
        craft.addStateEffector(bob)
        pendulums.append(bob)
    law, push = Law(craft), extForceTorque.ExtForceTorque()
    push.cmdForceBodyInMsg.subscribeTo(law.force)
    push.cmdTorqueInMsg.subscribeTo(law.torque)
    craft.addDynamicEffector(push)
    for priority, part in enumerate((craft, law, push)):
        simulation.AddModelToTask("t", part, 10 - priority)
    simulation.InitializeSimulation()
    simulation.ConfigureStopTime(macros.sec2nano(task.SAMPLES * task.PERIOD))
    simulation.ExecuteSimulation()
    end = hub(craft.scStateOutMsg.read())
    return np.concatenate([end, *(bob_state(craft, bob, k, end[3:6]) for k, bob in enumerate(pendulums, 1))])


def bob_state(craft, bob, k, omega):
    """Return s and sigma of a bob."""
    names = (bob.nameOfPhiState, bob.nameOfThetaState, bob.nameOfPhiDotState, bob.nameOfThetaDotState)
    phi, theta, a, b = (craft.dynManager.getStateObject(name).getState()[0][0] for name in names)
    turn = np.column_stack([bob.pHat_01, bob.pHat_02, bob.pHat_03]).reshape(3, 3)
    cp, sp, ct, st = np.cos(phi), np.sin(phi), np.cos(theta), np.sin(theta)
    arm = turn @ [cp * ct, sp * ct, -st]
    slip = turn @ [-a * sp * ct - b * cp * st, a * cp * ct - b * sp * st, -b * ct]
    return np.concatenate([arm, slip + np.cross(omega, arm)])


def make(tolerance):
    return lambda starts: np.array([one(x, tolerance) for x in task.initial(starts)])


if __name__ == "__main__":
    task.measure(make, 20)
