# SPDX-License-Identifier: Apache-2.0
"""Attitude files of a run for flight dynamics: CCSDS Attitude Ephemeris Message and SPICE C-kernel.

A result has quaternions and rates under names of its own, in frames of its own, from a time zero of its own. Whoever
converts it names what they are elsewhere.
"""

from __future__ import annotations

import itertools
import re
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from decimal import Decimal
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from mehvar.base.errors import InputError, bad_value, unknown_name
from mehvar.base.versions import installed

if TYPE_CHECKING:
    import xarray

ORIGIN = "--attitude"
_COMMON = {
    "quaternion": "four variables: vector part, then scalar part, of the turn that takes frame A into frame B",
    "frame_a": "the frame that the attitude is in",
    "epoch": "time zero of the run, as 2026-03-21T12:00:00",
    "time_system": "time system of the epoch",
}
NAMES: Mapping[str, Mapping[str, str]] = {
    "aem": _COMMON | {
        "frame_b": "the frame of the body",
        "object": "name of the object",
        "id": "its international designator",
        "originator": "whoever the message is from",
    },
    "ck": _COMMON | {
        "instrument": "number of the frame of the body",
        "clock": "number of the spacecraft clock",
        "kernels": "kernels of leap seconds and of the clock",
    },
}  # fmt: skip
"""Arguments of each format by name; the optional `rates` are three components in frame B."""
_DIGITS = 1e-6
"""Tolerance of a quaternion's norm: far above a run's error of 1e-12, far below the norm of anything else."""
_EPOCH = re.compile(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d(\.\d{1,9})?", re.ASCII)


@dataclass(frozen=True)
class Attitude:
    """Attitude along a run.

    Attributes
    ----------
    t : array
        Times since the epoch, s.
    quaternion : array
        Vector part and scalar part of the turn that takes frame A into frame B, a row each time.
    rates : array or None
        Rate of B relative to A, in B, rad/s.
    about : mapping of str to str
        What was named.
    """

    t: NDArray[np.float64]
    quaternion: NDArray[np.float64]
    rates: NDArray[np.float64] | None
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
        For a name that is unknown or missing, variables of other units, or numbers that are no attitude.
    """
    needed = NAMES[to]
    for name in about:
        if name not in (*needed, "rates"):
            raise unknown_name("name of an attitude", name, [*needed, "rates"], ORIGIN)
    if missing := [f"{name} ({text})" for name, text in needed.items() if not about.get(name)]:
        raise InputError(f"{to} needs {'; '.join(missing)}: give {ORIGIN} NAME=VALUE")
    if not _EPOCH.fullmatch(about["epoch"]):
        raise bad_value("epoch", about["epoch"], "as 2026-03-21T12:00:00, with nine decimals at most", ORIGIN)
    quaternion = _columns(run, "quaternion", about["quaternion"], 4, {"1": 1.0})
    rates = None
    if "rates" in about:
        rates = _columns(run, "rates", about["rates"], 3, {"rad/s": 1.0, "deg/s": np.pi / 180})
    t = run["t"].values
    if len(t) < 2 or not (np.diff(t) > 0).all():
        raise InputError("an attitude needs at least two samples at increasing times")
    norms = np.linalg.norm(quaternion, axis=1)
    worst = int(np.abs(norms - 1).argmax())
    if not np.abs(norms - 1).max() < _DIGITS:
        raise bad_value(
            "quaternion", about["quaternion"], f"of norm one; it is {norms[worst]:.9g} at {t[worst]:g} s", ORIGIN
        )
    if about.get("frame_b") == about["frame_a"]:
        raise bad_value("frame_b", about["frame_a"], "another frame than frame_a", ORIGIN)
    if rates is not None:
        _check_reading(t, quaternion, rates, about)
    return Attitude(t, quaternion, rates, about)


def _check_reading(
    t: NDArray[np.float64], quaternion: NDArray[np.float64], rates: NDArray[np.float64], about: Mapping[str, str]
) -> None:
    """Refuse an order or a direction that the rates contradict while they agree with another one.

    Rates that agree with none, as those of a vibration between the samples, are accepted.
    """
    if _mismatch(t, quaternion, rates) < _UNLIKE:
        return
    for order, components in itertools.product(_READINGS, itertools.permutations(range(3))):
        if _mismatch(t, _READINGS[order](quaternion), rates[:, components]) < _ALIKE:
            names = ",".join(np.array(about["rates"].split(","))[list(components)])
            other = [*([order] if order else []), *([f"rates={names}"] if components != (0, 1, 2) else [])]
            raise bad_value(
                "quaternion", about["quaternion"],
                f"in agreement with rates={about['rates']}: its turns between samples agree with {', '.join(other)}",
                ORIGIN,
            )  # fmt: skip


_READINGS: Mapping[str, Callable[[NDArray[np.float64]], NDArray[np.float64]]] = {
    "": lambda q: q,
    "the first variable as scalar part": lambda q: np.roll(q, -1, axis=1),
    "the inverse turn": lambda q: q * [-1, -1, -1, 1],
    "the first variable as scalar part of the inverse turn": lambda q: np.roll(q, -1, axis=1) * [-1, -1, -1, 1],
}
_UNLIKE, _ALIKE = 0.3, 0.03
"""Mean difference between turn and rates, relative, of a wrong reading and of the right one. A wrong order of axes
changes a vector by about its length; the trapezoidal rule errs by the square of a turn between samples."""
_LARGEST_TURN = 0.3
"""Largest turn between two samples, rad, from which rates are judged."""


def _mismatch(t: NDArray[np.float64], quaternion: NDArray[np.float64], rates: NDArray[np.float64]) -> float:
    """Return the difference between the turns from sample to sample and the integral of the rates, relative."""
    turns = Rotation.from_quat(quaternion)
    turn = (turns[:-1].inv() * turns[1:]).as_rotvec()
    expected = (rates[:-1] + rates[1:]) / 2 * np.diff(t)[:, None]
    size = np.maximum(np.linalg.norm(turn, axis=1), np.linalg.norm(expected, axis=1))
    small = size < _LARGEST_TURN
    total = float(size[small].sum())
    return float(np.linalg.norm(turn - expected, axis=1)[small].sum()) / total if total else 0.0


def _columns(run: xarray.Dataset, name: str, text: str, size: int, units: Mapping[str, float]) -> NDArray[np.float64]:
    names = text.split(",")
    if len(names) != size:
        raise bad_value(name, text, f"{size} variables with commas between them", ORIGIN)
    series = [str(n) for n, array in run.data_vars.items() if array.dims == ("t",)]
    factors = []
    for variable in names:
        if variable not in series:
            raise unknown_name("variable", variable, series, f"{ORIGIN} {name}")
        unit = run[variable].attrs.get("units", "1")
        if unit not in units:
            raise bad_value(name, variable, f"in {' or '.join(units)}; it is in {unit}", ORIGIN)
        factors.append(units[unit])
    return np.column_stack([run[variable].values for variable in names]) * factors


def message(attitude: Attitude) -> bytes:
    """Return an Attitude Ephemeris Message: KVN of CCSDS 504.0-B-2, rates in degrees."""
    about, rates = attitude.about, attitude.rates
    instants = [_instant(about["epoch"], t) for t in attitude.t]
    metadata = {
        "OBJECT_NAME": about["object"],
        "OBJECT_ID": about["id"],
        "REF_FRAME_A": about["frame_a"],
        "REF_FRAME_B": about["frame_b"],
        "TIME_SYSTEM": about["time_system"],
        "START_TIME": instants[0],
        "STOP_TIME": instants[-1],
        "ATTITUDE_TYPE": "QUATERNION" if rates is None else "QUATERNION/ANGVEL",
        **({} if rates is None else {"ANGVEL_FRAME": "REF_FRAME_B"}),
    }
    numbers = attitude.quaternion if rates is None else np.hstack([attitude.quaternion, np.degrees(rates)])
    rows = (" ".join([instant, *map(repr, row)]) for instant, row in zip(instants, numbers.tolist(), strict=True))
    lines = [
        "CCSDS_AEM_VERS = 2.0",
        f"COMMENT written by mehvar {installed('mehvar').get('mehvar', '')}".rstrip(),
        f"CREATION_DATE = {datetime.now(UTC):%Y-%m-%dT%H:%M:%S}",
        f"ORIGINATOR = {about['originator']}",
        "META_START",
        *(f"{name} = {value}" for name, value in metadata.items()),
        "META_STOP",
        "DATA_START",
        *rows,
        "DATA_STOP",
    ]
    return ("\n".join(lines) + "\n").encode()


def _instant(epoch: str, t: float) -> str:
    """Return the time t after an epoch, rounded to nanoseconds; days have 86 400 s."""
    whole, _, fraction = epoch.partition(".")
    nanoseconds = int(fraction.ljust(9, "0") or 0) + round(Decimal(t) * 10**9)
    try:
        seconds = datetime.fromisoformat(whole) + timedelta(seconds=nanoseconds // 10**9)
    except (ValueError, OverflowError) as error:
        raise bad_value("epoch", epoch, f"a date ({error})", ORIGIN) from error
    return f"{seconds:%Y-%m-%dT%H:%M:%S}.{nanoseconds % 10**9:09d}"


def kernel(attitude: Attitude) -> bytes:
    """Return a C-kernel with a segment of type 3, written by spiceypy; the rates are in frame A.

    Raises
    ------
    InputError
        If spiceypy is missing, or SPICE refuses what was named.
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
