# SPDX-License-Identifier: Apache-2.0
"""Orbit of a run as an Orbit Ephemeris Message (KVN of CCSDS 502.0-B-3)."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from mehvar.base.errors import bad_value

from .messages import (
    BETTER,
    DOUBTFUL,
    OBJECT,
    ORIGIN,
    TIME,
    FloatArray,
    check_named,
    columns,
    data,
    message_text,
    mismatch,
    times,
)

if TYPE_CHECKING:
    import xarray

NAMES: Mapping[str, str] = {
    "position": "three variables: position in the frame",
    "velocity": "three variables: velocity in the frame",
    "frame": "the frame of position and velocity",
    "center": "the body at its origin",
    **TIME,
    **OBJECT,
}
"""Names that an orbit message needs."""


def orbit_message(run: xarray.Dataset, about: Mapping[str, str]) -> bytes:
    """Return an Orbit Ephemeris Message, in km and km/s.

    Parameters
    ----------
    run : xarray.Dataset
        A result.
    about : mapping of str to str
        Values of `NAMES`.

    Raises
    ------
    InputError
        If a name is unknown or missing, a unit is wrong, or velocities contradict the positions.
    """
    check_named("oem", about, NAMES)
    t = times(run)
    position = columns(run, "position", about["position"], 3, {"m": 1e-3, "km": 1.0})
    velocity = columns(run, "velocity", about["velocity"], 3, {"m/s": 1e-3, "km/s": 1.0})
    _check_velocity(t, position, velocity, about)
    frame = {"CENTER_NAME": about["center"], "REF_FRAME": about["frame"]}
    return message_text(
        "CCSDS_OEM_VERS = 2.0", about, frame, t, data(about["epoch"], t, np.hstack([position, velocity]))
    )


def _check_velocity(t: FloatArray, position: FloatArray, velocity: FloatArray, about: Mapping[str, str]) -> None:
    """Refuse an order of velocity components that contradicts the positions, if another order agrees with them."""
    change = np.diff(position, axis=0)
    given = mismatch(t, change, velocity)
    if given < DOUBTFUL:
        return
    names = np.array(about["velocity"].split(","))
    for order in map(list, itertools.permutations(range(3))):
        if mismatch(t, change, velocity[:, order]) < BETTER * given:
            allowed = f"{','.join(names[order])}, with which the positions {about['position']} agree"
            raise bad_value("velocity", about["velocity"], allowed, ORIGIN)
