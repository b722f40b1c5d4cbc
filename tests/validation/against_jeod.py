# SPDX-License-Identifier: Apache-2.0
"""The satellite against the published verification data of NASA's JEOD: rotation under torque and gravity gradient."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from tests.validation import craft
from tests.validation.table import record

DATA = tomllib.loads((Path(__file__).parent / "jeod.toml").read_text(encoding="utf-8"))
MU = DATA["mu"]
PUBLISHED = "published data"
STEP = 1 / 32
"""s, of JEOD's rk4: DYNAMICS in verif/SIM_dyncomp/S_define. The row at t = 0, before any step, agrees to 2e-15 of the
largest acceleration, all later ones of 10A and 10D to 3e-14 to 5e-14. (2 n STEP)^3 / 12, what the last stage of an rk4
lacks of a motion at twice the orbit's rate n, has this size. That the logs hold this stage's accelerations is inferred
from the size alone, not verified in JEOD. The bound is the cube, twelve times as much: an allowance."""
REASON = "16 digits of the log, carried through; cube of JEOD's step of 1/32 s at twice the orbit's rate, an allowance"


def carried(function: Callable[[np.ndarray], np.ndarray], logged: np.ndarray) -> float:
    """Return the effect on a result of half a unit in the sixteenth digit of every logged number, summed."""
    units = np.array([0.5 * 10.0 ** (np.floor(np.log10(abs(v))) - 15) if v else 0.0 for v in logged])
    far = 1e6  # a smaller step would drown in rounding
    here, moves = function(logged), np.diag(units)[units > 0]
    return float(sum(np.abs(function(logged + far * move) - here) / far for move in moves).max())


def down(row: dict) -> tuple[np.ndarray, float]:
    """Return the nadir in body axes and the rate of a circular orbit through the place of a row."""
    place = np.array(row["r"])
    radius = np.linalg.norm(place)
    nadir = np.array(row["T"]) @ (-place / radius)
    return nadir / np.linalg.norm(nadir), np.sqrt(MU / radius**3)


def test_accelerations_in_the_gravity_gradient() -> None:
    data = DATA["gradient"]
    inertia, errors, digits, orders = np.array(data["inertia"]), [], [], []

    def acceleration(logged: np.ndarray) -> np.ndarray:
        nadir, omega0 = down({"r": logged[:3], "T": logged[3:12].reshape(3, 3)})
        return craft.acceleration(craft.facing(nadir), logged[12:], np.zeros(3), craft.parameters(inertia, omega0))

    for row in data["rows"]:
        logged = np.concatenate([row["r"], np.ravel(row["T"]), row["w"]])
        errors.append(acceleration(logged) - row["a"])
        digits.append(carried(acceleration, logged))
        orders.append((2 * down(row)[1] * STEP) ** 3)  # the torque of an angle goes with twice the angle
    largest = max(np.abs(row["a"]).max() for row in data["rows"])
    record(
        "satellite: accelerations of a cylinder in the gravity gradient, runs 10A and 10D",
        "JEOD",
        PUBLISHED,
        np.array(errors) / largest,
        max(digits) / largest + max(orders),
        "of the largest",
        REASON,
    )


def principal() -> tuple[np.ndarray, np.ndarray]:
    """Return the station's principal moments and the matrix from principal to body axes, a rotation."""
    moments, axes = np.linalg.eigh(np.array(DATA["torque"]["inertia"]))
    return moments, axes * np.linalg.det(axes)


def test_accelerations_under_torque() -> None:
    moments, axes = principal()
    rows, p, errors, digits = DATA["torque"]["rows"], craft.parameters(moments, 0.0), [], []
    for row in rows:
        torque = axes.T @ [row["torque"], 0, 0]

        def acceleration(logged: np.ndarray, torque: np.ndarray = torque) -> np.ndarray:
            return axes @ craft.acceleration(np.eye(3), axes.T @ logged, torque, p)

        errors.append(acceleration(np.array(row["w"])) - row["a"])
        digits.append(carried(acceleration, np.array(row["w"])))
    largest = np.abs([row["a"] for row in rows]).max()
    record(
        "satellite: accelerations of the space station under torque and free, run 9B",
        "JEOD",
        PUBLISHED,
        np.array(errors) / largest,
        max(digits) / largest + (max(np.linalg.norm(row["w"]) for row in rows) * STEP) ** 3,
        "of the largest",
        REASON,
    )


def test_free_motion_of_the_space_station() -> None:
    moments, axes = principal()
    rows = [row for row in DATA["torque"]["rows"] if not row["torque"]]
    p, times = craft.parameters(moments, 0.0), np.array([float(row["t"]) for row in rows])
    turns = [left(row["q"]) for row in rows]
    x = craft.state(axes.T @ turns[0], axes.T @ rows[0]["w"])
    run = craft.motion(x, p, times)
    rates = run[:, 4:7] @ axes.T - [row["w"] for row in rows]
    attitude = [
        axes @ Rotation.from_quat(y[:4], scalar_first=True).as_matrix().T - turn
        for y, turn in zip(run, turns, strict=True)
    ]
    size = np.linalg.norm(rows[0]["w"])
    record(
        "satellite: free asymmetric motion of the space station, five minutes of run 9B",
        "JEOD",
        PUBLISHED,
        np.concatenate([np.ravel(rates / size), np.ravel(attitude)]),
        (times[-1] - times[0]) / STEP * 2.0**-53,
        "of the rate, of 1",
        "a rounding of double in each step of JEOD's rk4, which is 1/32 s",
    )


def left(q: list[float]) -> np.ndarray:
    """Return the matrix from inertial to body axes of JEOD's left transformation quaternion, scalar first."""
    return Rotation.from_quat([q[0], *(-np.array(q[1:]))], scalar_first=True).as_matrix().T


def test_gravity_torque_of_points() -> None:
    data = DATA["table"]
    masses, places = np.array(data["masses"]), np.array(data["places"])
    inertia = np.einsum("i,ijk", masses, np.einsum("ij,ij,kl->ikl", places, places, np.eye(3)))
    inertia -= np.einsum("i,ij,ik", masses, places, places)
    moments, axes = np.linalg.eigh(inertia)
    axes = axes * np.linalg.det(axes)
    pitch, yaw, roll = np.radians(data["pitch_yaw_roll_deg"])
    body = Rotation.from_euler("YZX", [pitch, yaw, roll]).as_matrix().T
    p = craft.parameters(moments, np.sqrt(MU / data["radius"] ** 3))
    errors, moved, size = [], [], []
    for row in data["rows"]:
        lat, lon = np.radians([row["lat"], row["lon"]])
        place = np.array([np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), np.sin(lat)])
        nadir = axes.T @ body @ -place
        torque = axes @ (moments * craft.acceleration(craft.facing(nadir), np.zeros(3), np.zeros(3), p))
        errors.append(torque - row["harmonic"])
        size.append(np.abs(row["harmonic"]).max())
        moved.append(np.subtract(row["points"], row["harmonic"]))
    scale = np.array(size)[:, None]
    record(
        "satellite: gravity torque on three masses at ten places of the Earth",
        "JEOD",
        PUBLISHED,
        np.array(errors) / scale,
        np.abs(np.array(moved) / scale).max(),
        "of the torque",
        "how far JEOD's harmonics are from its point masses",
    )
