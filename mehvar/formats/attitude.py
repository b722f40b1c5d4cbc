# SPDX-License-Identifier: Apache-2.0
"""Attitude of a run as an Attitude Ephemeris Message (KVN of CCSDS 504.0-B-2) or a SPICE C-kernel."""

from __future__ import annotations

import itertools
import re
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.spatial.transform import Rotation

from mehvar.base.errors import InputError, bad_value

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

_COMMON = {
    "quaternion": "four variables: vector part, then scalar part, of the turn that takes frame A into frame B",
    "frame_a": "the frame that the attitude is in",
    **TIME,
}
NAMES: Mapping[str, Mapping[str, str]] = {
    "aem": _COMMON | {"frame_b": "the frame of the body", **OBJECT},
    "ck": _COMMON | {
        "instrument": "number of the frame of the body",
        "clock": "number of the spacecraft clock",
        "kernels": "kernels of leap seconds and of the clock",
    },
}  # fmt: skip
"""Names that each format needs; the optional `rates` are three components in frame B."""
_HUB_RATES = "wx,wy,wz"
"""Rates of the hub of a craft from parts, against which an attitude without rates is checked."""
_DIGITS = 1e-6
"""Tolerance of a quaternion's norm, far above a run's error of 1e-12."""


@dataclass(frozen=True)
class Attitude:
    """Attitude along a run.

    Attributes
    ----------
    t : array
        Times since the epoch, s.
    quaternion : array
        Rotation from frame A to frame B, vector part first, one row per time.
    rates : array or None
        Rate of B relative to A, in B, rad/s.
    about : mapping of str to str
        Names that the user gave.
    """

    t: FloatArray
    quaternion: FloatArray
    rates: FloatArray | None
    about: Mapping[str, str]


def attitude(run: xarray.Dataset, to: str, about: Mapping[str, str]) -> Attitude:
    """Return the attitude in a run.

    Parameters
    ----------
    run : xarray.Dataset
        A result.
    to : str
        "aem" or "ck".
    about : mapping of str to str
        Values of the names of `NAMES`.

    Raises
    ------
    InputError
        If a name is unknown or missing, a unit is wrong, or the numbers are no attitude.
    """
    check_named(to, about, NAMES[to], ("rates",))
    quaternion = columns(run, "quaternion", about["quaternion"], 4, {"1": 1.0})
    in_run = all(name in run and run[name].attrs.get("units") == "rad/s" for name in _HUB_RATES.split(","))
    names = about.get("rates", _HUB_RATES if in_run else "")
    rates = columns(run, "rates", names, 3, {"rad/s": 1.0, "deg/s": np.pi / 180}) if names else None
    t = times(run)
    norms = np.linalg.norm(quaternion, axis=1)
    worst = int(np.abs(norms - 1).argmax())
    if not np.abs(norms - 1).max() < _DIGITS:
        raise bad_value(
            "quaternion", about["quaternion"], f"of norm one; it is {norms[worst]:.9g} at {t[worst]:g} s", ORIGIN
        )
    if about.get("frame_b") == about["frame_a"]:
        raise bad_value("frame_b", about["frame_a"], "another frame than frame_a", ORIGIN)
    if rates is not None:
        _check_reading(t, quaternion, rates, about["quaternion"], names)
    return Attitude(t, quaternion, rates if "rates" in about else None, about)


def _check_reading(t: FloatArray, quaternion: FloatArray, rates: FloatArray, named: str, rate_names: str) -> None:
    """Refuse an order or direction of components that contradicts the rates, if another one agrees with them.

    Rates that agree with none, such as those of a vibration between samples, are accepted.
    """
    given = _mismatch(t, quaternion, rates)
    if given < DOUBTFUL:
        return
    for order, components in itertools.product(_READINGS, itertools.permutations(range(3))):
        if _mismatch(t, _READINGS[order](quaternion), rates[:, components]) < BETTER * given:
            names = ",".join(np.array(rate_names.split(","))[list(components)])
            other = [*([order] if order else []), *([f"rates={names}"] if components != (0, 1, 2) else [])]
            raise bad_value(
                "quaternion", named,
                f"consistent with rates={rate_names}: its rotations between samples agree with {', '.join(other)}",
                ORIGIN,
            )  # fmt: skip


_READINGS: Mapping[str, Callable[[FloatArray], FloatArray]] = {
    "": lambda q: q,
    "the first variable as scalar part": lambda q: np.roll(q, -1, axis=1),
    "the inverse turn": lambda q: q * [-1, -1, -1, 1],
    "the first variable as scalar part of the inverse turn": lambda q: np.roll(q, -1, axis=1) * [-1, -1, -1, 1],
}
_LARGEST_TURN = 0.3
"""Largest turn between two samples, rad, from which rates are judged."""


def _mismatch(t: FloatArray, quaternion: FloatArray, rates: FloatArray) -> float:
    """Return the relative difference between rotations from sample to sample and the integral of the rates."""
    turns = Rotation.from_quat(quaternion)
    return mismatch(t, (turns[:-1].inv() * turns[1:]).as_rotvec(), rates, _LARGEST_TURN)


def message(attitude: Attitude) -> bytes:
    """Return an Attitude Ephemeris Message: KVN of CCSDS 504.0-B-2, rates in degrees."""
    about, rates = attitude.about, attitude.rates
    frames = {"REF_FRAME_A": about["frame_a"], "REF_FRAME_B": about["frame_b"]}
    kind = {"ATTITUDE_TYPE": "QUATERNION"}
    numbers = attitude.quaternion
    if rates is not None:
        kind = {"ATTITUDE_TYPE": "QUATERNION/ANGVEL", "ANGVEL_FRAME": "REF_FRAME_B"}
        numbers = np.hstack([numbers, np.degrees(rates)])
    rows = data(about["epoch"], attitude.t, numbers)
    return message_text("CCSDS_AEM_VERS = 2.0", about, frames, attitude.t, ["DATA_START", *rows, "DATA_STOP"], kind)


def kernel(attitude: Attitude) -> bytes:
    """Return a C-kernel with a segment of type 3, written by spiceypy; the rates are in frame A.

    Raises
    ------
    InputError
        If spiceypy is missing, or SPICE refuses a name.
    """
    try:
        import spiceypy
    except ImportError as error:
        raise InputError('a C-kernel needs spiceypy: pip install "mehvar[spice]"') from error
    about, kernels = attitude.about, attitude.about["kernels"].split(",")
    instrument, clock = (_whole(name, about[name]) for name in ("instrument", "clock"))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "attitude.bc"
        try:
            for name in kernels:
                spiceypy.furnsh(name)
            zero = spiceypy.str2et(f"{about['epoch'].replace('T', ' ')} {about['time_system']}")
            ticks = [spiceypy.sce2c(clock, zero + t) for t in attitude.t.tolist()]
            handle = spiceypy.ckopn(str(path), "mehvar", 0)
            spiceypy.ckw03(handle, ticks[0], ticks[-1], instrument, about["frame_a"], attitude.rates is not None,
                           "mehvar", len(ticks), ticks, *_spice(attitude), 1, [ticks[0]])  # fmt: skip
            spiceypy.ckcls(handle)
        except spiceypy.utils.exceptions.SpiceyError as error:
            raise InputError(
                f"SPICE refuses this attitude: {' '.join(str(error.short).split())}: {error.long}"
            ) from error
        finally:
            for name in kernels:
                spiceypy.unload(name)
        return path.read_bytes()


def _whole(name: str, text: str) -> int:
    if not re.fullmatch(r"-?\d+", text, re.ASCII):
        raise bad_value(name, text, "a whole number", ORIGIN)
    return int(text)


def _spice(attitude: Attitude) -> tuple[Sequence[Any], Sequence[Any]]:
    """Return SPICE's quaternions, scalar first, from A to B, and the rates in A."""
    vector, scalar = attitude.quaternion[:, :3], attitude.quaternion[:, 3:]
    rates = np.zeros_like(vector) if attitude.rates is None else attitude.rates
    across = 2 * np.cross(vector, rates)
    return np.hstack([scalar, -vector]).tolist(), (rates + scalar * across + np.cross(vector, across)).tolist()
