# SPDX-License-Identifier: Apache-2.0
"""Names and epochs of runs for flight dynamics, and CCSDS messages in KVN.

A result has its own names, frames and time origin. The user gives the names, frames and epoch of the message.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime, timedelta
from decimal import Decimal
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mehvar.base.errors import InputError, bad_value, unknown_name
from mehvar.base.versions import installed

if TYPE_CHECKING:
    import xarray

FloatArray = NDArray[np.float64]
ORIGIN = "--about"
TIME = {"epoch": "time zero of the run, as 2026-03-21T12:00:00", "time_system": "time system of the epoch"}
OBJECT = {
    "object": "name of the object",
    "id": "its international designator",
    "originator": "originator of the message",
}
_EPOCH = re.compile(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d(\.\d{1,9})?", re.ASCII)
DOUBTFUL, BETTER = 0.03, 0.1
"""Mean relative difference between changes and integrated rates above which other readings are tested, and the share
of it below which such a reading is accepted. The trapezoidal rule errs less for up to 0.3 rad per sample.
"""


def check_named(to: str, about: Mapping[str, str], needed: Mapping[str, str], optional: Sequence[str] = ()) -> None:
    """Refuse unknown and missing names and invalid epochs."""
    for name in about:
        if name not in (*needed, *optional):
            raise unknown_name(f"name of {to}", name, [*needed, *optional], ORIGIN)
    for name, text in about.items():
        if not text.isprintable():
            raise bad_value(name, text, "a text in one line", ORIGIN)
    if missing := [f"{name} ({text})" for name, text in needed.items() if not about.get(name)]:
        raise InputError(f"{to} needs {'; '.join(missing)}: give {ORIGIN} NAME=VALUE")
    if not _EPOCH.fullmatch(about["epoch"]):
        raise bad_value(
            "epoch", about["epoch"], "a time such as 2026-03-21T12:00:00, with at most nine decimals", ORIGIN
        )


def times(run: xarray.Dataset) -> FloatArray:
    """Return the times of a run, s; at least two, which must increase."""
    t = run["t"].values
    if len(t) < 2 or not (np.diff(t) > 0).all():
        raise InputError("a message needs at least two samples at increasing times")
    return np.asarray(t, np.float64)


def columns(run: xarray.Dataset, name: str, text: str, size: int, units: Mapping[str, float]) -> FloatArray:
    """Return the variables that a text names as columns in SI units."""
    names = text.split(",")
    if len(names) != size:
        raise bad_value(name, text, f"{size} variables, separated by commas", ORIGIN)
    series = [str(n) for n, array in run.data_vars.items() if array.dims == ("t",)]
    factors = []
    for variable in names:
        if variable not in series:
            raise unknown_name("variable", variable, series, f"{ORIGIN} {name}")
        unit = run[variable].attrs.get("units", "1")
        if unit not in units:
            raise bad_value(name, variable, f"in {' or '.join(units)}; it is in {unit}", ORIGIN)
        factors.append(units[unit])
    return np.asarray(np.column_stack([run[variable].values for variable in names]) * factors)


def mismatch(t: FloatArray, change: FloatArray, rates: FloatArray, largest: float = np.inf) -> float:
    """Return the mean relative difference between changes from sample to sample and the integral of rates.

    Parameters
    ----------
    t : array, shape (n,)
        Times, s.
    change : array, shape (n - 1, 3)
        Changes of a vector, or rotation vectors.
    rates : array, shape (n, 3)
        Its rates, or angular velocities.
    largest : float
        Larger changes are ignored.
    """
    expected = (rates[:-1] + rates[1:]) / 2 * np.diff(t)[:, None]
    size = np.maximum(np.linalg.norm(change, axis=1), np.linalg.norm(expected, axis=1))
    small = size < largest
    total = float(size[small].sum())
    return float(np.linalg.norm(change - expected, axis=1)[small].sum()) / total if total else 0.0


def instant(epoch: str, t: float) -> str:
    """Return the time t after an epoch, rounded to nanoseconds; days have 86 400 s."""
    whole, _, fraction = epoch.partition(".")
    nanoseconds = int(fraction.ljust(9, "0") or 0) + round(Decimal(t) * 10**9)
    try:
        seconds = datetime.fromisoformat(whole) + timedelta(seconds=nanoseconds // 10**9)
    except (ValueError, OverflowError) as error:
        raise bad_value("epoch", epoch, f"a date ({error})", ORIGIN) from error
    return f"{seconds:%Y-%m-%dT%H:%M:%S}.{nanoseconds % 10**9:09d}"


def data(epoch: str, t: FloatArray, numbers: FloatArray) -> list[str]:
    """Return a line of data for each time."""
    return [" ".join([instant(epoch, when), *map(repr, row)]) for when, row in zip(t, numbers.tolist(), strict=True)]


def message_text(
    version: str,
    about: Mapping[str, str],
    frames: Mapping[str, str],
    t: FloatArray,
    rows: Sequence[str],
    kind: Mapping[str, str] = MappingProxyType({}),
) -> bytes:
    """Return a message with one segment; the standards fix the order of keywords.

    Parameters
    ----------
    version : str
        First line.
    about : mapping of str to str
        Names that the user gave.
    frames, kind : mapping of str to str
        Metadata before and after those of time.
    t : array, shape (n,)
        Times since the epoch, s.
    rows : sequence of str
        Lines of data.
    """
    metadata = {
        "OBJECT_NAME": about["object"],
        "OBJECT_ID": about["id"],
        **frames,
        "TIME_SYSTEM": about["time_system"],
        "START_TIME": instant(about["epoch"], t[0]),
        "STOP_TIME": instant(about["epoch"], t[-1]),
        **kind,
    }
    lines = [
        version,
        f"COMMENT written by mehvar {installed('mehvar').get('mehvar', '')}".rstrip(),
        f"CREATION_DATE = {datetime.now(UTC):%Y-%m-%dT%H:%M:%S}",
        f"ORIGINATOR = {about['originator']}",
        "META_START",
        *(f"{name} = {value}" for name, value in metadata.items()),
        "META_STOP",
        *rows,
    ]
    return ("\n".join(lines) + "\n").encode()
