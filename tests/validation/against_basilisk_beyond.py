# SPDX-License-Identifier: Apache-2.0
"""The satellite beyond its paper against Basilisk: a tensor and a pyramid of wheels on an ellipse; wheels off balance.

Basilisk's fully coupled wheel has its centre of mass at d = U_s/m along w2 and the product J13 = U_d between its axis
and w3, about that centre; the hub is what is left of mass, first moment and inertia. Its wheels are symmetric about
their centres of mass: the equation of their spin leaves out Jt - Jg. Those here are symmetric about the centre on their
axis. The two differ by m d^2 of inertia, and the bound has what such a difference makes in Basilisk.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field
from importlib.metadata import version

import numpy as np
import pytest
from Basilisk.architecture import messaging
from Basilisk.simulation import (
    GravityGradientEffector,
    reactionWheelStateEffector,
    spacecraft,
    sphericalHarmonicsGravityModel,
)
from Basilisk.utilities import RigidBodyKinematics, SimulationBaseClass, macros, simIncludeGravBody, simIncludeRW
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from tests.models.satellite.beyond import body_axes, column, craft, names, place, state
from tests.validation.table import record

TENSOR = np.array([[2.13, 0.05, -0.08], [0.05, 3.04, 0.06], [-0.08, 0.06, 3.09]])
AXES = np.array([[1.0, -1, -1, 1], [1, 1, -1, -1], [1, 1, 1, 1]]) / np.sqrt(3)
PLACES = np.array([[0.1, -0.1, -0.1, 0.1], [0.1, 0.1, -0.1, -0.1], [0.0, 0.05, 0.0, -0.05]])
Q, W, H = ("q0", "q1", "q2", "q3"), ("wx", "wy", "wz"), ("h1", "h2", "h3", "h4")
MASS, ROTOR = 50.0, 1.5
"""Mass of the craft, and of a wheel, kg."""


@dataclass(frozen=True)
class Motion:
    """Initial state of a craft, and its loads.

    Attributes
    ----------
    turn : array, shape (3, 3)
        From body to inertial axes.
    rate, speeds, motors : array
        Inertial rate, rad/s; speeds of the wheels relative to the body, rad/s; torques of their motors on it, N m.
    spin : float
        Spin inertia of a wheel about its axis, kg m^2.
    static, dynamic : float
        Imbalances of each wheel, kg m and kg m^2.
    model : int
        Basilisk's model of the wheels.
    lean : float
        By how many m d^2 Basilisk's Jg is less than its Jt.
    orbit : dict
        Parameters of an ellipse, place and velocity; none in empty space.
    """

    turn: np.ndarray
    rate: np.ndarray
    speeds: np.ndarray
    motors: np.ndarray
    spin: float
    static: float = 0.0
    dynamic: float = 0.0
    model: int = messaging.BalancedWheels
    lean: float = 0.0
    orbit: dict[str, float] = field(default_factory=dict)


def basilisk(motion: Motion, span: float, h: float) -> np.ndarray:
    """Return attitude, rates and speeds of the wheels after `span` seconds in steps of h; on an orbit the place too."""
    simulation = SimulationBaseClass.SimBaseClass()
    simulation.CreateNewProcess("p").addTask(simulation.CreateNewTask("t", macros.sec2nano(h)))
    hub = spacecraft.Spacecraft()
    parts = [hub]
    if motion.orbit:
        parts.append(_gravity(hub, motion.orbit))
    else:
        hub.hub.r_CN_NInit = hub.hub.v_CN_NInit = [[0], [0], [0]]
    _masses(hub.hub, motion)
    hub.hub.sigma_BNInit = [[s] for s in RigidBodyKinematics.C2MRP(motion.turn.T)]
    hub.hub.omega_BN_BInit = [[w] for w in motion.rate]
    wheels = _wheels(hub, motion)
    message = messaging.ArrayMotorTorqueMsg().write(
        messaging.ArrayMotorTorqueMsgPayload(motorTorque=(-motion.motors).tolist())
    )
    wheels.rwMotorCmdInMsg.subscribeTo(message)
    for part in (*parts, wheels):
        simulation.AddModelToTask("t", part)
    simulation.InitializeSimulation()
    simulation.ConfigureStopTime(macros.sec2nano(span))
    simulation.ExecuteSimulation()
    end = hub.scStateOutMsg.read()
    turn = RigidBodyKinematics.MRP2C(np.array(end.sigma_BN)).T
    where = np.array(end.r_CN_N) if motion.orbit else np.empty(0)
    return np.concatenate([turn.ravel(), end.omega_BN_B, wheels.rwSpeedOutMsg.read().wheelSpeeds[:4], where])


def _masses(hub: spacecraft.HubEffector, motion: Motion) -> None:
    """Give the hub what balanced wheels are part of, or what is left when they are bodies."""
    whole = TENSOR + motion.spin * AXES @ AXES.T
    hub.mHub, hub.IHubPntBc_B = MASS, whole.tolist()
    if motion.model == messaging.BalancedWheels:
        return
    for axis, r in zip(AXES.T, PLACES.T, strict=True):
        whole = whole - ROTOR * (r @ r * np.eye(3) - np.outer(r, r)) - motion.spin * np.outer(axis, axis)
        whole -= motion.spin / 2 * (np.eye(3) - np.outer(axis, axis))
    hub.mHub = MASS - 4 * ROTOR
    center = -ROTOR * PLACES.sum(axis=1) / hub.mHub
    hub.r_BcB_B = center.reshape(3, 1).tolist()
    hub.IHubPntBc_B = (whole - hub.mHub * (center @ center * np.eye(3) - np.outer(center, center))).tolist()


def _wheels(hub: spacecraft.Spacecraft, motion: Motion) -> reactionWheelStateEffector.ReactionWheelStateEffector:
    wheels, factory = reactionWheelStateEffector.ReactionWheelStateEffector(), simIncludeRW.rwFactory()
    off = motion.static**2 / ROTOR
    for axis, r, speed in zip(AXES.T, PLACES.T, motion.speeds, strict=True):
        wheel = factory.create(
            "custom", axis, Js=motion.spin - off, Omega=float(speed / macros.RPM), useMaxTorque=False,
            rWB_B=r.tolist(), RWModel=motion.model,
        )  # fmt: skip
        wheel.mass, wheel.U_s, wheel.U_d = ROTOR, motion.static, motion.dynamic
        wheel.Jt, wheel.Jg = motion.spin / 2, motion.spin / 2 - motion.lean * off
        first = across(axis)
        wheel.w2Hat0_B, wheel.w3Hat0_B = first.reshape(3, 1).tolist(), np.cross(axis, first).reshape(3, 1).tolist()
    factory.addToSpacecraft("wheels", wheels, hub)
    return wheels


def across(axis: np.ndarray) -> np.ndarray:
    """Return x, turned the short way from z to an axis on its side: where the satellite's wheel angles are zero."""
    turn = np.cross([0, 0, 1], axis)
    x = np.array([1.0, 0, 0])
    return x + np.cross(turn, x) + np.cross(turn, np.cross(turn, x)) / (1 + axis[2])


def _gravity(hub: spacecraft.Spacecraft, orbit: dict[str, float]) -> GravityGradientEffector.GravityGradientEffector:
    factory = simIncludeGravBody.gravBodyFactory()
    earth = factory.createEarth()
    earth.isCentralBody, earth.mu = True, orbit["mu"]
    if orbit["J2"]:
        model = sphericalHarmonicsGravityModel.SphericalHarmonicsGravityModel()
        model.radEquator, model.muBody, model.maxDeg = orbit["earth_radius"], orbit["mu"], 2
        model.cBar = [[1.0], [0.0, 0.0], [-orbit["J2"] / np.sqrt(5), 0.0, 0.0]]
        model.sBar = [[0.0], [0.0, 0.0], [0.0, 0.0, 0.0]]
        earth.gravityModel = model
    where, velocity = place(state(**ELEMENTS), orbit)
    hub.hub.r_CN_NInit, hub.hub.v_CN_NInit = where.reshape(3, 1).tolist(), velocity.reshape(3, 1).tolist()
    factory.addBodiesTo(hub)
    gradient = GravityGradientEffector.GravityGradientEffector()
    gradient.addPlanetName(earth.planetName)
    hub.addDynamicEffector(gradient)
    return gradient


ELEMENTS = {"anomaly": 0.3, "perigee": 0.7, "node": -1.1}
ORBIT = {
    "mu": 3.986004418e14, "semi_major_axis": 1e7, "eccentricity": 0.3, "inclination": 1.1, "J2": 0.0,
    "earth_radius": 6378137.0,
}  # fmt: skip


def ours(motion: Motion, span: float) -> np.ndarray:
    """Return the same of the satellite: its compiled right-hand side, SciPy's dop853 at its tightest."""
    kind = "unbalanced" if motion.model != messaging.BalancedWheels else "any"
    model, inertias = craft(kind), {f"wheel_inertia_{k}": motion.spin for k in range(1, 5)}
    orbit = motion.orbit or {"mu": 1e-30, "inclination": 1.1}
    values = {**inertias, **orbit}
    if kind == "unbalanced":
        values |= {f"wheel_places_{i + 1}_{k + 1}": PLACES[i, k] for i in range(3) for k in range(4)}
        values |= {f"static_imbalance_{k}": motion.static for k in range(1, 5)}
        values |= {f"dynamic_imbalance_{k}": motion.dynamic for k in range(1, 5)}
        # J13 = +U_d stands in the inertia itself, and so for masses on the other side of w3
        values |= {f"imbalance_phase_{k}": -np.pi / 2 for k in range(1, 5)}
        values |= {"mass": MASS}
    p, known = model.parameters(**values), {"semi_major_axis": 6978137.0, "eccentricity": 0.0, **orbit}
    x = state(kind, **ELEMENTS)
    upright = body_axes(x, known, kind)
    held = motion.spin * (motion.speeds + AXES.T @ motion.rate)
    turn = Rotation.from_matrix(upright.T @ motion.turn).as_quat(scalar_first=True)
    start = {
        **dict(zip(Q, turn, strict=True)),
        **dict(zip(W, motion.rate, strict=True)),
        **dict(zip(H, held, strict=True)),
    }
    x = state(kind, **ELEMENTS, **start)
    u = np.concatenate([motion.motors, np.zeros(len(names("inputs", kind)) - 4)])
    run = solve_ivp(lambda _t, y: model.rhs(y, u, p), (0, span), x, "DOP853", rtol=1e-13, atol=1e-15, max_step=1.0)
    end = run.y[:, -1]
    w = column(end, *W, wheels=kind)
    speeds = column(end, *H, wheels=kind) / motion.spin - AXES.T @ w
    where = place(end, known, kind)[0] if motion.orbit else np.empty(0)
    return np.concatenate([body_axes(end, known, kind).ravel(), w, speeds, where])


def start(speed: float, spin: float, torque: float, **more: object) -> list[Motion]:
    """Return motions from random attitudes and rates, with wheels near a speed and motors near a torque."""
    random = np.random.default_rng(3)
    return [
        Motion(
            turn, random.normal(0, 0.02, 3), speed * random.uniform(0.5, 1, 4) * random.choice([-1, 1], 4),
            torque * random.normal(0, 1, 4), spin, **more,
        )
        for turn in Rotation.random(3, rng=random).as_matrix()
    ]  # fmt: skip


SIZES = np.concatenate([np.ones(9), np.full(3, 0.02)])


@pytest.mark.parametrize("torque", [0.0, 1e-3], ids=["free", "driven"])
def test_a_tensor_and_a_pyramid_of_wheels_on_an_ellipse(torque: float) -> None:
    span, errors, moves = 600.0, [], []
    sizes = np.concatenate([SIZES, np.full(4, 100.0), np.full(3, 1e7)])
    for motion in start(100.0, 8e-4, torque, orbit=ORBIT):
        coarse, fine = (basilisk(motion, span, h) for h in (0.1, 0.05))
        errors.append((ours(motion, span) - fine) / sizes)
        moves.append((coarse - fine) / sizes)
    record(
        f"satellite beyond: tensor and pyramid on an ellipse, {'torques' if torque else 'no torque'}, {span:.0f} s",
        "Basilisk", version("bsk"), errors, np.abs(moves).max(), "of 1, 0.02 rad/s, 100 rad/s, 1e7 m",
        "change of Basilisk's rk4 when its step of 0.1 s is halved",
    )  # fmt: skip


def test_the_same_about_an_oblate_earth() -> None:
    """Mean rates of node, perigee and anomaly against the bulge itself, which moves the place to and fro besides."""
    span, errors, oblate = 600.0, [], {**ORBIT, "J2": 1.08262668e-3}
    sizes = np.concatenate([SIZES, np.full(4, 100.0), np.full(3, 1e7)])
    latus = oblate["semi_major_axis"] * (1 - oblate["eccentricity"] ** 2)
    for motion in start(100.0, 8e-4, 1e-3, orbit=oblate):
        errors.append((ours(motion, span) - basilisk(motion, span, 0.1)) / sizes)
    record(
        f"satellite beyond: tensor and pyramid on an ellipse about an oblate Earth, torques, {span:.0f} s",
        "Basilisk", version("bsk"), errors, oblate["J2"] * (oblate["earth_radius"] / latus) ** 2,
        "of 1, 0.02 rad/s, 100 rad/s, 1e7 m", "J2 (R/p)^2, the size of the short periods that mean rates leave out",
    )  # fmt: skip


WHEELS = {
    "of data sheets": (5e-6, 1e-6, 300.0),
    "large": (2e-3, 2e-4, 60.0),
}
"""Static and dynamic imbalance, kg m and kg m^2, and about how fast wheels turn, rad/s."""


@pytest.mark.parametrize("kind", WHEELS)
@pytest.mark.parametrize("torque", [0.0, 1e-2], ids=["free", "driven"])
def test_wheels_off_balance_in_empty_space(kind: str, torque: float) -> None:
    static, dynamic, speed = WHEELS[kind]
    span, errors, moves, leans = 5.0, [], [], []
    sizes = np.concatenate([SIZES, np.full(4, speed)])
    for motion in start(speed, 1e-3, torque, static=static, dynamic=dynamic, model=messaging.JitterFullyCoupled):
        coarse, fine = (basilisk(motion, span, h) for h in (0.002, 0.001))
        errors.append((ours(motion, span) - fine) / sizes)
        moves.append((coarse - fine) / sizes)
        leans.append((basilisk(dataclasses.replace(motion, lean=1.0), span, 0.001) - fine) / sizes)
    record(
        f"satellite beyond: wheels off balance, {kind}, {'torques' if torque else 'no torque'}, {span:.0f} s",
        "Basilisk", version("bsk"), errors, np.abs(moves).max() + np.abs(leans).max(),
        f"of 1, 0.02 rad/s, {speed:.0f} rad/s",
        "change of Basilisk's rk4 when its step of 2 ms is halved, and of its motion when U_s^2/m goes from Jg",
    )  # fmt: skip
