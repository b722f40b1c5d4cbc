# SPDX-License-Identifier: Apache-2.0
"""Reader of CCSDS messages in KVN: orbits (OEM, 502.0-B) and attitudes (AEM, 504.0-B)."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mehvar.base.errors import InputError, bad_value, either

if TYPE_CHECKING:
    import xarray

FloatArray = NDArray[np.float64]
MESSAGES = (".oem", ".aem")
"""Endings of the files that `read_message` reads."""
_VERSION = {".oem": "CCSDS_OEM_VERS", ".aem": "CCSDS_AEM_VERS"}
_NEEDED = {
    ".oem": ("OBJECT_NAME", "CENTER_NAME", "REF_FRAME", "TIME_SYSTEM"),
    ".aem": ("OBJECT_NAME", "REF_FRAME_A", "REF_FRAME_B", "TIME_SYSTEM", "ATTITUDE_TYPE"),
}
_QUATERNION, _WITH_RATES = "QUATERNION", "QUATERNION/ANGVEL"
_NORM = 1e-3
"""Tolerance of a quaternion's norm; messages have at least three digits."""
_EPOCH = re.compile(r"(?P<day>\d{4}-\d\d-\d\d|\d{4}-\d{3})T(?P<time>\d\d:\d\d:\d\d)(?:\.(?P<part>\d+))?Z?", re.ASCII)
_PAIR = re.compile(r"([A-Z0-9_]+)\s*=\s*(.*)", re.ASCII)


@dataclass(frozen=True)
class _Segment:
    """Metadata and rows of a message's segment, with their line numbers."""

    about: Mapping[str, str]
    rows: Sequence[tuple[int, list[str]]]


def read_message(path: Path) -> xarray.Dataset:
    """Read an Orbit or Attitude Ephemeris Message with one segment.

    Parameters
    ----------
    path : Path
        A file whose name ends in `.oem` or `.aem`.

    Returns
    -------
    xarray.Dataset
        Over `t` in s since the first line: `x`, `y`, `z`, m, and `vx`, `vy`, `vz`, m/s, of an orbit; `q0` to `q3`,
        scalar first, and where the message has them `wx`, `wy`, `wz`, rad/s, of an attitude. The attributes have the
        epoch of the first line, frames and time system. Accelerations and covariances are not read.

    Raises
    ------
    InputError
        If the file is not such a message; the error names the line.
    """
    kind = path.suffix.lower()
    try:
        lines = path.read_text(encoding="ascii").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"cannot read {path}: {getattr(error, 'strerror', None) or error}") from error
    segment = _segment(path, kind, lines)
    if missing := [name for name in _NEEDED[kind] if name not in segment.about]:
        raise InputError(f"{path} lacks {missing[0]} between META_START and META_STOP")
    columns = _orbit(path, segment) if kind == ".oem" else _attitude(path, segment)
    return _dataset(path, segment, columns)


def _segment(path: Path, kind: str, lines: Sequence[str]) -> _Segment:
    """Return the only segment of a message."""
    about: dict[str, str] = {}
    rows: list[tuple[int, list[str]]] = []
    place, version = "head", ""
    for number, raw in enumerate(lines, 1):
        line = raw.strip()
        if not line or line.startswith("COMMENT"):
            continue
        if line == "META_START" and about:
            raise InputError(
                f"{path}, line {number}: a second segment begins; a file must have only one: split the file"
            )
        if line in ("META_START", "META_STOP", "COVARIANCE_START", "COVARIANCE_STOP", "DATA_START", "DATA_STOP"):
            place = {"META_START": "meta", "COVARIANCE_START": "skipped", "DATA_STOP": "end"}.get(line, "data")
        elif place in ("head", "meta"):
            pair = _PAIR.fullmatch(line)
            if not pair:
                raise InputError(f"{path}, line {number}: {line!r} must be KEYWORD = VALUE")
            if place == "meta" and pair[1] in about:
                raise InputError(f"{path}, line {number}: {pair[1]} is given twice")
            version = pair[2] if pair[1] == _VERSION[kind] else version
            about |= {pair[1]: pair[2]} if place == "meta" else {}
        elif place == "data":
            rows.append((number, line.split()))
    if not version:
        raise InputError(f"{path} is not a CCSDS message: it lacks {_VERSION[kind]}")
    if len(rows) < 2:
        raise InputError(f"{path} has {len(rows)} lines of data; must have at least two")
    return _Segment(about, rows)


def _numbers(path: Path, segment: _Segment, counts: Sequence[int]) -> FloatArray:
    """Return the numbers of the rows; the length of each row must be one of `counts`."""
    width = len(segment.rows[0][1]) - 1
    table = np.empty((len(segment.rows), width))
    for row, (number, words) in enumerate(segment.rows):
        if len(words) - 1 != width or width not in counts:
            allowed = either(list(map(str, counts))) if width not in counts else f"{width} as in the first line"
            raise InputError(f"{path}, line {number}: {len(words) - 1} numbers after the epoch; must be {allowed}")
        try:
            table[row] = [float(word) for word in words[1:]]
        except ValueError as error:
            raise InputError(f"{path}, line {number}: {error}") from error
        if not np.isfinite(table[row]).all():
            raise InputError(f"{path}, line {number}: must have finite numbers")
    return table


def _orbit(path: Path, segment: _Segment) -> dict[str, tuple[FloatArray, str]]:
    """Return position and velocity in SI units, without accelerations."""
    table = _numbers(path, segment, (6, 9)) * 1e3
    names = (("x", "m"), ("y", "m"), ("z", "m"), ("vx", "m/s"), ("vy", "m/s"), ("vz", "m/s"))
    return {name: (table[:, k], unit) for k, (name, unit) in enumerate(names)}


def _attitude(path: Path, segment: _Segment) -> dict[str, tuple[FloatArray, str]]:
    """Return the quaternion from frame A to frame B, and rates in B."""
    about, kind = segment.about, segment.about["ATTITUDE_TYPE"]
    if kind not in (_QUATERNION, _WITH_RATES):
        raise bad_value("ATTITUDE_TYPE", kind, f"{_QUATERNION} or {_WITH_RATES}", str(path))
    usual = {"ATTITUDE_DIR": ("A2B",), "ANGVEL_FRAME": ("REF_FRAME_B", about["REF_FRAME_B"])}
    for name, allowed in usual.items():
        if (value := about.get(name, allowed[0])) not in allowed:
            raise bad_value(name, value, allowed[0], str(path))
    table = _numbers(path, segment, (4,) if kind == _QUATERNION else (7,))
    first = about.get("QUATERNION_TYPE", "LAST") == "FIRST"  # of version 1; later the scalar is last
    order = ("q0", "q1", "q2", "q3") if first else ("q1", "q2", "q3", "q0")
    columns = {name: (table[:, k], "1") for k, name in enumerate(order)}
    columns = {name: columns[name] for name in sorted(columns)}
    norms = np.linalg.norm(table[:, :4], axis=1)
    worst = int(np.argmax(np.abs(norms - 1)))
    if abs(norms[worst] - 1) > _NORM:
        raise InputError(
            f"{path}, line {segment.rows[worst][0]}: a quaternion of norm {norms[worst]:.6g}; must have norm one"
        )
    rates = {f"w{axis}": (np.radians(table[:, 4 + k]), "rad/s") for k, axis in enumerate("xyz") if kind == _WITH_RATES}
    return columns | rates


def _dataset(path: Path, segment: _Segment, columns: Mapping[str, tuple[FloatArray, str]]) -> xarray.Dataset:
    """Return a segment over seconds since its first epoch; refuse epochs that do not increase."""
    import xarray as xr

    instants = [_instant(path, number, words[0]) for number, words in segment.rows]
    (day, part), *_ = instants
    t = np.array([(d - day).total_seconds() + (p - part) * 1e-9 for d, p in instants])
    if not (np.diff(t) > 0).all():
        number = segment.rows[int(np.argmax(np.diff(t) <= 0)) + 1][0]
        raise InputError(f"{path}, line {number}: epochs must increase")
    about = {"epoch": segment.rows[0][1][0], **{name.lower(): value for name, value in segment.about.items()}}
    series = {name: ("t", values, {"units": unit}) for name, (values, unit) in columns.items()}
    return xr.Dataset(series, {"t": ("t", t, {"units": "s"})}, about)


def _instant(path: Path, number: int, text: str) -> tuple[datetime, int]:
    """Return seconds and nanoseconds of an epoch; days have 86 400 s."""
    match = _EPOCH.fullmatch(text)
    try:
        if match is None:
            raise ValueError("no epoch")
        written = "%Y-%m-%d" if match["day"].count("-") == 2 else "%Y-%j"
        day = datetime.strptime(f"{match['day']} {match['time']}", f"{written} %H:%M:%S")
        if day.year != int(match["day"][:4]):
            raise ValueError("strptime takes day 366 of any year")
    except ValueError as error:
        raise InputError(
            f"{path}, line {number}: {text!r} must be a time such as 2026-03-21T12:00:00 or 2026-080T12:00:00"
        ) from error
    return day, int((match["part"] or "0").ljust(9, "0")[:9])
