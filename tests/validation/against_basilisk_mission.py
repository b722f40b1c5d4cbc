# SPDX-License-Identifier: Apache-2.0
"""A mission from parts against Basilisk: a J2 orbit, a pyramid of wheels, a slew law each 0.1 s.

Both fly the same law, which measures the state; Basilisk's is a Python module of its own, as its users write them.
Seconds and lines of both are printed.
"""

from __future__ import annotations

import inspect
import time
from importlib.metadata import version

import numpy as np
from Basilisk.architecture import messaging, sysModel
from Basilisk.simulation import (
    GravityGradientEffector,
    reactionWheelStateEffector,
    spacecraft,
    sphericalHarmonicsGravityModel,
)
from Basilisk.utilities import RigidBodyKinematics, SimulationBaseClass, macros, simIncludeGravBody, simIncludeRW

import mehvar
from mehvar.parts import GravityGradient, Hub, Orbit, Spacecraft, Wheel
from tests.validation.table import record

MU, J2, RADIUS, SIZE, INCLINATION = 3.986004418e14, 1.08262668e-3, 6378137.0, 6.9e6, 1.7
MASS, INERTIA, SPIN, PERIOD, SPAN = 40.0, (2.0, 3.0, 2.5), 0.01, 0.1, 600.0
PYRAMID = np.array([(1, 0, 1), (0, 1, 1), (-1, 0, 1), (0, -1, 1)]) / np.sqrt(2)
LEAD, KD, FASTEST = 0.3, 0.3, 0.05
START = (0.8, -0.5)
"""Roll and yaw at the start, rad."""


def wanted(q, rates):
    """Return the torque of the law about the axes of the hub, of a quaternion without its scalar."""
    return [KD * (np.clip(-2 * LEAD * a, -FASTEST, FASTEST) - w) for a, w in zip(q, rates, strict=True)]


def ours() -> mehvar.Model:
    """Return the craft from parts."""
    craft = Spacecraft("mission", orbit=Orbit("J2", size=SIZE, inclination=INCLINATION), period=PERIOD)
    craft.add(Hub("hub", mass=MASS, inertia=INERTIA))
    for k, axis in enumerate(PYRAMID, 1):
        craft.add(Wheel(f"wheel{k}", axis=tuple(axis), inertia=SPIN))
    craft.add(GravityGradient())
    return mehvar.build(craft)


def flown(model: mehvar.Model) -> np.ndarray:
    """Return final position, attitude, rates and wheel speeds."""
    share = np.linalg.pinv(PYRAMID.T)

    def law(t, x):
        return -share @ wanted((x.q1, x.q2, x.q3), (x.wx, x.wy, x.wz))

    options = {"period": PERIOD, "t_end": SPAN, "dt_out": SPAN, "rtol": 1e-12, "atol": 1e-12}
    run = mehvar.simulate(model, law, roll_0=START[0], yaw_0=START[1], **options)
    names = [*(f"orbit_{a}" for a in "xyz"), "q0", "q1", "q2", "q3", "wx", "wy", "wz"]
    return np.array([float(run[name][-1]) for name in (*names, *(f"wheel{k}_speed" for k in range(1, 5)))])


class Law(sysModel.SysModel):
    """The slew law as a module of Basilisk."""

    def __init__(self, craft: spacecraft.Spacecraft) -> None:
        super().__init__()
        self.state = messaging.SCStatesMsgReader()
        self.state.subscribeTo(craft.scStateOutMsg)
        self.torque = messaging.ArrayMotorTorqueMsg()
        self.share = np.linalg.pinv(PYRAMID.T)

    def UpdateState(self, now: int) -> None:  # noqa: N802 - Basilisk calls it so
        state = self.state()
        q = RigidBodyKinematics.MRP2EP(np.array(state.sigma_BN))
        motors = -self.share @ wanted(q[1:] * np.sign(q[0]), state.omega_BN_B)
        self.torque.write(messaging.ArrayMotorTorqueMsgPayload(motorTorque=motors.tolist()), now)


def theirs(start: np.ndarray, place: np.ndarray, velocity: np.ndarray, h: float) -> np.ndarray:
    """Return the same quantities of Basilisk, in steps of h, from quaternion, position and velocity."""
    simulation = SimulationBaseClass.SimBaseClass()
    process = simulation.CreateNewProcess("p")
    process.addTask(simulation.CreateNewTask("motion", macros.sec2nano(h)), 2)
    process.addTask(simulation.CreateNewTask("law", macros.sec2nano(PERIOD)), 1)
    craft, gravity = spacecraft.Spacecraft(), simIncludeGravBody.gravBodyFactory()
    earth = gravity.createEarth()
    earth.isCentralBody, earth.mu = True, MU
    model = sphericalHarmonicsGravityModel.SphericalHarmonicsGravityModel()
    model.radEquator, model.muBody, model.maxDeg = RADIUS, MU, 2
    model.cBar, model.sBar = [[1.0], [0.0, 0.0], [-J2 / np.sqrt(5), 0.0, 0.0]], [[0.0], [0.0, 0.0], [0.0, 0.0, 0.0]]
    earth.gravityModel = model
    gravity.addBodiesTo(craft)
    craft.hub.mHub, craft.hub.IHubPntBc_B = MASS, (np.diag(INERTIA) + SPIN * PYRAMID.T @ PYRAMID).tolist()
    craft.hub.r_CN_NInit, craft.hub.v_CN_NInit = place.reshape(3, 1).tolist(), velocity.reshape(3, 1).tolist()
    craft.hub.sigma_BNInit = [[s] for s in RigidBodyKinematics.EP2MRP(start)]
    gradient = GravityGradientEffector.GravityGradientEffector()
    gradient.addPlanetName(earth.planetName)
    craft.addDynamicEffector(gradient)
    wheels, factory = reactionWheelStateEffector.ReactionWheelStateEffector(), simIncludeRW.rwFactory()
    for axis in PYRAMID:
        factory.create("custom", axis, Js=SPIN, Omega=0.0, useMaxTorque=False)
    factory.addToSpacecraft("wheels", wheels, craft)
    law = Law(craft)
    wheels.rwMotorCmdInMsg.subscribeTo(law.torque)
    for part in (craft, gradient, wheels):
        simulation.AddModelToTask("motion", part)
    simulation.AddModelToTask("law", law)
    simulation.InitializeSimulation()
    simulation.ConfigureStopTime(macros.sec2nano(SPAN))
    simulation.ExecuteSimulation()
    end = craft.scStateOutMsg.read()
    q = RigidBodyKinematics.MRP2EP(np.array(end.sigma_BN))
    return np.concatenate([end.r_CN_N, q * np.sign(q[0]), end.omega_BN_B, wheels.rwSpeedOutMsg.read().wheelSpeeds[:4]])


def test_a_slew_on_an_oblate_orbit() -> None:
    model = ours()
    first = mehvar.simulate(model, None, inputs={}, t_end=PERIOD, roll_0=START[0], yaw_0=START[1])
    start, place, velocity = (
        np.array([float(first[name][0]) for name in names])
        for names in (["q0", "q1", "q2", "q3"], [f"orbit_{a}" for a in "xyz"], [f"orbit_v{a}" for a in "xyz"])
    )
    begun = time.perf_counter()
    here = flown(model)
    mine = time.perf_counter() - begun
    coarse, fine = theirs(start, place, velocity, PERIOD), theirs(start, place, velocity, PERIOD / 2)
    took = time.perf_counter() - begun - mine
    sizes = np.concatenate([np.full(3, SIZE), np.ones(4), np.full(3, FASTEST), np.full(4, 10.0)])
    here[3:7] *= np.sign(here[3])
    print(f"{mine:.2f} s, Basilisk {took / 3:.2f} s; {lines(ours, flown)} lines, Basilisk {lines(Law, theirs)}")
    record(
        f"parts: slew by a pyramid of wheels on a J2 orbit, {SPAN:.0f} s", "Basilisk", version("bsk"),
        (here - (2 * fine - coarse)) / sizes, np.abs((coarse - fine) / sizes).max(),
        "of 6.9e6 m, 1, 0.05 rad/s, 10 rad/s",
        "change when Basilisk's step of 0.1 s is halved; its error is linear in the step and extrapolated",
    )  # fmt: skip


def lines(*things: object) -> int:
    """Return the lines of functions and classes, without empty ones and docstrings of one line."""
    texts = (inspect.getsource(thing).splitlines() for thing in things)
    return sum(bool(line.strip()) and '"""' not in line for text in texts for line in text)
