# SPDX-License-Identifier: Apache-2.0
"""The craft of every tool: a hub, four skew wheels, two panels of two hinged bodies each, a spherical pendulum.

A constant force along x keeps the pendulum, whose joint is 0.2 m behind O, within reach of two angles; the torques
of the wheels are constant.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]
Fly = Callable[[Array], Array]
"""From starts (runs, 16) to final states (runs, 30): rotation matrix from body to inertial axes, rate, velocity of O in
body axes, angles and then rates of each panel, direction of the pendulum, speeds of the wheels over SPEED."""

SPAN = 100.0
MASS, INERTIA = 100.0, np.diag([20.0, 25.0, 22.0])
"""Of the hub without wheels; its centre of mass is O."""
AXES = np.array([[1, 1, 1], [-1, 1, 1], [-1, -1, 1], [1, -1, 1]]) / np.sqrt(3)
WHEEL, SPIN, ACROSS, REACH = 2.0, 0.02, 0.012, 0.3
"""Mass of a wheel, moments of inertia about and across its axis, and its distance from O along its axis."""
BODY, LONG, WIDE, STIFFNESS, DAMPING, EDGE = 4.0, 0.8, 1.0, 20.0, 0.05, 0.6
"""Mass, length and width of a body of a panel, spring and damper of its hinge, distance of the first hinges from O."""
PLATE = BODY / 12 * np.array([LONG**2, WIDE**2, LONG**2 + WIDE**2])
"""About the hinge's axis, x; about the length, y; about z."""
BOB, ROD, PIVOT = 10.0, 0.3, np.array([-0.2, 0.0, 0.0])
FORCE, TORQUES = 20.0, np.array([0.01, -0.02, 0.015, 0.005])
SIDES = (1.0, -1.0)
SPEED = 100.0

STARTS = {
    **dict.fromkeys(("roll", "pitch", "yaw"), (-0.3, 0.3)),
    **dict.fromkeys(("wx", "wy", "wz"), (-0.02, 0.02)),
    **dict.fromkeys((f"wheel{k}_speed" for k in range(1, 5)), (50.0, 150.0)),
    **dict.fromkeys((f"panel{k}_{link}_angle" for k in (1, 2) for link in (1, 2)), (-0.1, 0.1)),
    "bob_phi": (0.0, 0.3),
    "bob_theta": (-3.0, 3.0),
}
"""Uniform dispersions of the start, by mehvar's names."""


def starts(n: int) -> Array:
    """Return the starts of n runs, a column for each entry of STARTS."""
    low, high = np.array(list(STARTS.values())).T
    return np.random.default_rng(1).uniform(low, high, (n, len(STARTS)))


def attitude(values: Mapping[str, float]) -> Array:
    """Return the matrix from body to inertial axes at a start."""
    return Rotation.from_euler("ZYX", [values[name] for name in ("yaw", "pitch", "roll")]).as_matrix()


def arm(values: Mapping[str, float]) -> Array:
    """Return the direction of the pendulum at a start; it does not turn in inertial axes."""
    phi, theta = values["bob_phi"], values["bob_theta"]
    return np.array([-np.cos(phi), np.sin(phi) * np.sin(theta), np.sin(phi) * np.cos(theta)])


def composite(locked: bool) -> tuple[float, Array, Array]:
    """Return mass, centre of mass from O and inertia about it of hub and wheels.

    Locked wheels also resist turning about their axes.
    """
    across = sum(ACROSS * (np.eye(3) - np.outer(a, a)) + WHEEL * REACH**2 * (np.eye(3) - np.outer(a, a)) for a in AXES)
    centre = WHEEL * REACH * AXES.sum(axis=0)
    mass = MASS + 4 * WHEEL
    inertia = INERTIA + across + locked * SPIN * sum(np.outer(a, a) for a in AXES)
    return mass, centre / mass, inertia - (centre @ centre * np.eye(3) - np.outer(centre, centre)) / mass
