# SPDX-License-Identifier: Apache-2.0
"""Orbits and attitudes in messages of CCSDS: what is written is read, and what is no message is refused by line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray

import mehvar
from mehvar.base.errors import InputError
from mehvar.formats.conversion import convert

from .test_attitude import MESSAGE, turning

OEM = """CCSDS_OEM_VERS = 2.0
CREATION_DATE = 2026-03-21T00:00:00
ORIGINATOR = ME
META_START
OBJECT_NAME = DEMO
OBJECT_ID = 2026-001A
CENTER_NAME = EARTH
REF_FRAME = EME2000
TIME_SYSTEM = UTC
START_TIME = 2026-03-21T23:59:59.5
STOP_TIME = 2026-03-22T00:00:09.25
META_STOP
COMMENT place in km, velocity in km/s
2026-03-21T23:59:59.5 6900.0 1.0 -2.5 0.001 7.6 0.0
2026-03-22T00:00:09.25 6899.9 75.1 -2.5 -0.08 7.6 0.0
COVARIANCE_START
EPOCH = 2026-03-22T00:00:09.25
1.0
COVARIANCE_STOP
"""
AEM = """CCSDS_AEM_VERS = 1.0
META_START
OBJECT_NAME = DEMO
REF_FRAME_A = EME2000
REF_FRAME_B = SC_BODY_1
ATTITUDE_DIR = A2B
TIME_SYSTEM = TAI
ATTITUDE_TYPE = QUATERNION
QUATERNION_TYPE = FIRST
META_STOP
DATA_START
2026-080T12:00:00 1.0 0.0 0.0 0.0
2026-080T12:00:01 0.8 0.6 0.0 0.0
DATA_STOP
"""

__all__ = ["turning"]  # a fixture


def message(folder: Path, name: str, text: str) -> xarray.Dataset:
    (folder / name).write_text(text)
    return mehvar.open_result(folder / name)


def test_an_orbit_is_in_metres(tmp_path: Path) -> None:
    orbit = message(tmp_path, "orbit.oem", OEM)
    assert orbit["t"].values.tolist() == [0.0, 9.75]
    assert orbit["x"].values.tolist() == [6.9e6, 6899.9e3]
    assert (orbit["vy"].values[0], orbit["vy"].units, orbit["z"].units) == (7600.0, "m/s", "m")
    assert (orbit.attrs["epoch"], orbit.attrs["ref_frame"]) == ("2026-03-21T23:59:59.5", "EME2000")


def test_a_scalar_may_be_first_in_an_old_attitude(tmp_path: Path) -> None:
    turn = message(tmp_path, "turn.aem", AEM)
    assert turn["q0"].values.tolist() == [1.0, 0.8]
    assert turn["q1"].values.tolist() == [0.0, 0.6]
    assert turn["t"].values.tolist() == [0.0, 1.0]


def test_an_attitude_that_was_written_is_read(turning: tuple[Path, xarray.Dataset]) -> None:
    source, dataset = turning
    out = source.with_suffix(".aem")
    convert(source, "aem", out, MESSAGE | {"rates": "wx,wy,wz"})
    read = mehvar.open_result(out)
    for name in ("t", "q0", "q1", "q2", "q3"):
        np.testing.assert_array_equal(read[name].values, dataset[name].values)
    for name in ("wx", "wy", "wz"):
        np.testing.assert_allclose(read[name].values, dataset[name].values, rtol=1e-15)


@pytest.mark.parametrize(
    ("name", "old", "new", "words"),
    [
        ("a.oem", "CCSDS_OEM_VERS", "CCSDS_OMM_VERS", "is not a CCSDS message: it lacks CCSDS_OEM_VERS"),
        ("a.oem", "REF_FRAME = EME2000\n", "", "lacks REF_FRAME between META_START and META_STOP"),
        ("a.oem", "ORIGINATOR = ME", "ORIGINATOR", "line 3: 'ORIGINATOR' must be KEYWORD = VALUE"),
        ("a.oem", "6900.0 1.0", "6900.0", "line 14: 5 numbers after the epoch; must be 6 or 9"),
        (
            "a.oem",
            "75.1 -2.5 -0.08 7.6 0.0",
            "75.1 -2.5 -0.08 7.6 0.0 0 0 0",
            "line 15: 9 .*; must be 6 as in the first",
        ),
        ("a.oem", "6900.0", "far", "line 14: could not convert string to float: 'far'"),
        ("a.oem", "6900.0", "nan", "line 14: must have finite numbers"),
        ("a.oem", "2026-03-22T00:00:09.25 6", "2026-03-20T00:00:00 6", "line 15: epochs must increase"),
        ("a.oem", "2026-03-21T23:59:59.5 6", "noon 6", "line 14: 'noon' must be a time such as 2026-03-21T12:00:00"),
        (
            "a.oem",
            "2026-03-21T23:59:59.5 6",
            "2026-02-30T00:00:00 6",
            "line 14: '2026-02-30T00:00:00' must be a time such as",
        ),
        (
            "a.oem",
            "2026-03-21T23:59:59.5 6",
            "2025-366T00:00:00 6",
            "line 14: '2025-366T00:00:00' must be a time such as",
        ),
        ("a.oem", "REF_FRAME = EME2000", "REF_FRAME = EME2000\nREF_FRAME = TOD", "line .*: REF_FRAME is given twice"),
        ("a.aem", "0.8 0.6 0.0 0.0", "0.8 0.7 0.0 0.0", "a quaternion of norm 1.06301; must have norm one"),
        ("a.oem", "COVARIANCE_START", "META_START", "line 16: a second segment begins; a file must have only one"),
        ("a.aem", "2026-080T12:00:01 0.8 0.6 0.0 0.0\n", "", "has 1 lines of data; must have at least two"),
        ("a.aem", "QUATERNION\n", "EULER_ANGLE\n", "ATTITUDE_TYPE = 'EULER_ANGLE' .*: must be QUATERNION or"),
        ("a.aem", "A2B", "B2A", "ATTITUDE_DIR = 'B2A' .*: must be A2B"),
    ],
)
def test_what_is_no_message_is_refused_by_line(tmp_path: Path, name: str, old: str, new: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        message(tmp_path, name, {".oem": OEM, ".aem": AEM}[name[-4:]].replace(old, new, 1))


def test_a_missing_file_is_told(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"cannot read .*: No such file"):
        mehvar.open_result(tmp_path / "none.oem")
