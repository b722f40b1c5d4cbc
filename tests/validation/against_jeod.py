# SPDX-License-Identifier: Apache-2.0
"""The satellite against the published verification data of NASA's JEOD: rotation under torque and gravity gradient."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from tests.validation import craft
from tests.validation.table import record

DATA = tomllib.loads((Path(__file__).parent / "jeod.toml").read_text(encoding="utf-8"))
MU = DATA["mu"]
PUBLISHED = "published data"


def down(row: dict) -> tuple[np.ndarray, float]:
    """Return the nadir in body axes and the rate of a circular orbit through the place of a row."""
    place = np.array(row["r"])
    radius = np.linalg.norm(place)
    nadir = np.array(row["T"]) @ (-place / radius)
    return nadir / np.linalg.norm(nadir), np.sqrt(MU / radius**3)


def test_accelerations_in_the_gravity_gradient() -> None:
    data = DATA["gradient"]
    inertia, errors = np.array(data["inertia"]), []
    for row in data["rows"]:
        nadir, omega0 = down(row)
        p = craft.parameters(inertia, omega0)
        errors.append(craft.acceleration(craft.facing(nadir), np.array(row["w"]), np.zeros(3), p) - row["a"])
    largest = max(np.abs(row["a"]).max() for row in data["rows"])
    record(
        "satellite: accelerations of a cylinder in the gravity gradient, runs 10A and 10D",
        "JEOD",
        PUBLISHED,
        np.array(errors) / largest,
        1e-12,
        "of the largest",
        "log of 16 digits; squares of r and T lose three, T is orthonormal to 1e-13",
    )


def principal() -> tuple[np.ndarray, np.ndarray]:
    """Return the station's principal moments and the matrix from principal to body axes, a rotation."""
    moments, axes = np.linalg.eigh(np.array(DATA["torque"]["inertia"]))
    return moments, axes * np.linalg.det(axes)


def test_accelerations_under_torque() -> None:
    moments, axes = principal()
    p, errors = craft.parameters(moments, 0.0), []
    for row in DATA["torque"]["rows"]:
        torque = axes.T @ [row["torque"], 0, 0]
        result = craft.acceleration(np.eye(3), axes.T @ row["w"], torque, p)
        errors.append(axes @ result - row["a"])
    record(
        "satellite: accelerations of the space station under torque and free, run 9B",
        "JEOD",
        PUBLISHED,
        np.array(errors) / np.abs([row["a"] for row in DATA["torque"]["rows"]]).max(),
        1e-13,
        "of the largest",
        "log of 16 digits; inverse of an inertia with condition 1.9, differences of products that lose two",
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
        1e-12,
        "of the rate, of 1",
        "rounding of an rk4 that is exact to rounding, 1e4 steps",
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
