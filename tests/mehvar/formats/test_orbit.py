# SPDX-License-Identifier: Apache-2.0
"""Orbits of a run as messages of CCSDS: what is written is read again, and velocities fit the positions."""

import numpy as np
import pytest
import xarray

import mehvar
from mehvar.base.errors import InputError
from mehvar.formats.conversion import convert
from tests.mehvar.cli.test_app import run

ABOUT = {
    "position": "x,y,z", "velocity": "vx,vy,vz", "frame": "EME2000", "center": "EARTH", "epoch": "2026-03-21T12:00:00",
    "time_system": "UTC", "object": "DEMO", "id": "2026-001A", "originator": "ME",
}  # fmt: skip


@pytest.fixture
def circle(tmp_path):
    """Return the file of an inclined circular orbit."""
    t, turn, tilt = np.arange(0.0, 600.0, 10.0), 1.1e-3, 0.9
    along = np.array([np.cos(turn * t), np.sin(turn * t) * np.cos(tilt), np.sin(turn * t) * np.sin(tilt)]) * 6.9e6
    speed = (
        np.array([-np.sin(turn * t), np.cos(turn * t) * np.cos(tilt), np.cos(turn * t) * np.sin(tilt)]) * 6.9e6 * turn
    )
    values = {name: ("t", row, {"units": "m"}) for name, row in zip("xyz", along, strict=True)}
    values |= {f"v{name}": ("t", row, {"units": "m/s"}) for name, row in zip("xyz", speed, strict=True)}
    dataset = xarray.Dataset(values, {"t": ("t", t, {"units": "s"})}, {"model_hash": "0", "model": "circle"})
    mehvar.save(dataset, tmp_path / "run.nc")
    return tmp_path / "run.nc", dataset


def test_an_orbit_that_was_written_is_read(circle):
    source, dataset = circle
    out = source.with_suffix(".oem")
    options = [word for pair in ABOUT.items() for word in ("--about", "=".join(pair))]
    assert run("convert", str(source), "--out", str(out), *options).returncode == 0
    orbit = mehvar.open_result(out)
    for name in ("t", *dataset.data_vars):
        np.testing.assert_allclose(orbit[name].values, dataset[name].values, rtol=1e-15)
        assert orbit[name].units == dataset[name].units
    assert (orbit.attrs["center_name"], orbit.attrs["ref_frame"]) == ("EARTH", "EME2000")
    names = [line.split(" = ")[0] for line in out.read_text().splitlines() if " = " in line]
    order = ["OBJECT_NAME", "OBJECT_ID", "CENTER_NAME", "REF_FRAME", "TIME_SYSTEM", "START_TIME", "STOP_TIME"]
    assert names[3:] == order


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"velocity": "vy,vx,vz"}, "velocity = 'vy,vx,vz' .*: must be vx,vy,vz, with which the positions x,y,z agree"),
        ({"position": "x,z,y"}, "must be vx,vz,vy, with which the positions x,z,y agree"),
        ({"velocity": "x,y,z"}, "must be in m/s or km/s; it is in m"),
        ({"center": ""}, "oem needs center"),
        ({"rates": "vx,vy,vz"}, "unknown name 'rates' of oem"),
    ],
    ids=str,
)
def test_what_is_no_orbit_is_refused(circle, change, words):
    source, _ = circle
    with pytest.raises(InputError, match=words):
        convert(source, "oem", source.with_suffix(".oem"), ABOUT | change)
