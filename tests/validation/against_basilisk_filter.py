# SPDX-License-Identifier: Apache-2.0
"""The attitude filter of a craft beside Basilisk's unscented filter, with the same measurements of a slew.

Basilisk's inertialUKF estimates attitude and rate from star trackers, gyros, inertia and wheel speeds, and no bias: the
gyro has none here. Its noise of the rate is the best of 3e-6, 1e-5, 3e-5 and 1e-4 rad/s.
"""

from __future__ import annotations

from importlib.metadata import version

import numpy as np
import xarray as xr
from Basilisk.architecture import messaging
from Basilisk.fswAlgorithms import inertialUKF
from Basilisk.utilities import RigidBodyKinematics, SimulationBaseClass, macros

import mehvar
from mehvar.parts import AttitudeFilter, Gyro, Hub, Spacecraft, StarTracker, Wheel
from tests.validation.against_basilisk_mission import INERTIA, MASS, PERIOD, PYRAMID, SPIN
from tests.validation.table import record

SIGMA, RATE_NOISE = (2e-5, 2e-5, 1e-4), 3e-5
QUATERNION = [f"q{k}" for k in range(4)]


def slew() -> xr.Dataset:
    """Return a slew of 120 s under the estimates, with the measurements in the law's memory."""
    craft = Spacecraft("filtered", motion="attitude", period=PERIOD)
    craft.add(Hub("hub", mass=MASS, inertia=INERTIA))
    wheels = [craft.add(Wheel(f"wheel{k}", axis=tuple(axis), inertia=SPIN)) for k, axis in enumerate(PYRAMID, 1)]
    gyro = craft.add(Gyro("gyro", noise=1e-5, walk=1e-9, integrating=True))
    tracker = craft.add(StarTracker("tracker", sigma=SIGMA, every=10))
    craft.add(AttitudeFilter("filter", gyro=gyro, tracker=tracker, bias=1e-6))

    def steer(law):
        for q in (*gyro.shown(), *tracker.shown()):
            law.update(law.keep(f"kept_{q.name}", q.unit), q.symbol)
        (_, *q), w = law.attitude, law.rates
        kp, kd = law.parameter("kp", 0.8, "N m"), law.parameter("kd", 1.2, "N m s")
        return law.torque([-kp * a - kd * b for a, b in zip(q, w, strict=True)], wheels)

    craft.law("steer", steer)
    return mehvar.simulate(mehvar.build(craft), "steer", t_end=120.0, roll_0=0.8, yaw_0=-0.5, wz_0=0.1)


def columns(run: xr.Dataset, names: list[str]) -> np.ndarray:
    """Return series side by side."""
    return np.stack([run[name].values for name in names], axis=1)


def prepared(first: np.ndarray) -> inertialUKF.inertialUKF:
    """Return Basilisk's filter at a first quaternion, with the numbers of the craft."""
    result = inertialUKF.inertialUKF()
    result.alpha, result.beta, result.kappa, result.switchMag = 0.02, 2.0, 0.0, 1.2
    result.stateInit = [float(s) for s in (*RigidBodyKinematics.EP2MRP(first), 0.0, 0.0, 0.1)]
    result.covarInit = np.diag([2e-5**2] * 3 + [1e-4] * 3).ravel().tolist()
    result.qNoise = np.diag([1e-7**2] * 3 + [RATE_NOISE**2] * 3).ravel().tolist()
    low_pass = inertialUKF.LowPassFilterData()
    low_pass.hStep, low_pass.omegCutoff = PERIOD, 15 / (2 * np.pi)
    result.gyroFilt = [low_pass] * 3
    return result


def theirs(gyro: np.ndarray, tracker: np.ndarray, new: np.ndarray, speeds: np.ndarray) -> np.ndarray:
    """Return the quaternions of Basilisk's filter after each sample."""
    simulation = SimulationBaseClass.SimBaseClass()
    simulation.CreateNewProcess("p").addTask(simulation.CreateNewTask("t", macros.sec2nano(PERIOD)))
    module, camera, stars = prepared(tracker[0]), inertialUKF.STMessage(), messaging.STAttMsg()
    camera.noise = np.diag(np.square(SIGMA) / 16).ravel().tolist()  # of a quarter of the angles
    camera.stInMsg.subscribeTo(stars)
    module.STDatasStruct.STMessages, module.STDatasStruct.numST = [camera], 1
    mass, wheels = messaging.VehicleConfigMsgPayload(), messaging.RWArrayConfigMsgPayload()
    mass.ISCPntB_B = (np.diag(INERTIA) + SPIN * PYRAMID.T @ PYRAMID).ravel().tolist()
    wheels.GsMatrix_B, wheels.JsList, wheels.numRW = PYRAMID.ravel().tolist(), [SPIN] * 4, 4
    kept = messaging.VehicleConfigMsg().write(mass), messaging.RWArrayConfigMsg().write(wheels)
    module.massPropsInMsg.subscribeTo(kept[0])
    module.rwParamsInMsg.subscribeTo(kept[1])
    turning, felt = messaging.RWSpeedMsg(), messaging.AccDataMsg()
    module.rwSpeedsInMsg.subscribeTo(turning)
    module.gyrBuffInMsg.subscribeTo(felt)
    simulation.AddModelToTask("t", module)
    result = []
    for k, (rate, q, speed) in enumerate(zip(gyro, tracker, speeds, strict=True)):
        now, packet = macros.sec2nano(PERIOD * k), messaging.AccDataMsgPayload()
        if new[k]:
            seen = messaging.STAttMsgPayload(timeTag=now, MRP_BdyInrtl=RigidBodyKinematics.EP2MRP(q).tolist())
            stars.write(seen, now)
        turning.write(messaging.RWSpeedMsgPayload(wheelSpeeds=speed.tolist()), now)
        packets = packet.accPkts
        packets[k % len(packets)].gyro_B, packets[k % len(packets)].measTime = rate.tolist(), now
        packet.accPkts = packets
        felt.write(packet, now)
        if k == 0:
            simulation.InitializeSimulation()
        simulation.ConfigureStopTime(now)
        simulation.ExecuteSimulation()
        result.append(RigidBodyKinematics.MRP2EP(np.array(module.navStateOutMsg.read().sigma_BN)))
    return np.array(result)


def test_filters_of_a_slew() -> None:
    run = slew()
    shown = run.isel(t=slice(1, None))  # the memory shows a measurement one sample later
    gyro, tracker = (columns(shown, [f"kept_{name}" for name in names]) for names in (
        [f"gyro_{axis}" for axis in "xyz"], [f"tracker_q{k}" for k in range(4)]
    ))  # fmt: skip
    new, true = shown["kept_tracker_new"].values > 0.5, columns(run, QUATERNION)[:-1]
    seen = theirs(gyro, tracker, new, columns(run, [f"wheel{k}_speed" for k in range(1, 5)])[:-1])
    settled = slice(300, None)
    product = np.abs((seen * true).sum(axis=1))
    other = np.sqrt(np.mean((2 * np.arccos(np.minimum(product[settled], 1))) ** 2))
    own = np.sqrt(np.mean(shown["filter_error"].values[settled] ** 2))
    record(
        "parts: attitude filter in a slew, 30 to 120 s", "Basilisk", version("bsk"), own, other,
        "rad, root mean square", "error of Basilisk's inertialUKF with the same measurements",
    )  # fmt: skip
