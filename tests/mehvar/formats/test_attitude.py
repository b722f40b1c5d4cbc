# SPDX-License-Identifier: Apache-2.0
"""Attitudes of a run as a message of CCSDS, read by the standard's grammar, and as a C-kernel, read by SPICE."""

from __future__ import annotations

from datetime import datetime

import numpy as np
import pytest
import xarray
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import mehvar
from mehvar.base.errors import InputError
from mehvar.formats.attitude import Attitude, _spice, attitude
from mehvar.formats.conversion import convert
from tests.mehvar.cli.test_app import refused, run

COMMON = {"quaternion": "q1,q2,q3,q0", "frame_a": "J2000", "epoch": "2026-03-21T12:00:00.5"}
MESSAGE = COMMON | {
    "time_system": "TAI",
    "frame_b": "SC_BODY_1",
    "object": "DEMO",
    "id": "2026-001A",
    "originator": "ME",
}
CLOCK = """\
KPL/SCLK
\\begindata
SCLK_KERNEL_ID = ( @2026-01-01 )
SCLK_DATA_TYPE_99 = ( 1 )
SCLK01_TIME_SYSTEM_99 = ( 1 )
SCLK01_N_FIELDS_99 = ( 2 )
SCLK01_MODULI_99 = ( 4294967296 65536 )
SCLK01_OFFSETS_99 = ( 0 0 )
SCLK01_OUTPUT_DELIM_99 = ( 1 )
SCLK_PARTITION_START_99 = ( 0.0 )
SCLK_PARTITION_END_99 = ( 2.81474976710655E+14 )
SCLK01_COEFFICIENTS_99 = ( 0.0 0.0 1.0 )
\\begintext
"""
"""A clock of 65536 ticks a second since J2000."""
LEAPS = """\
KPL/LSK
\\begindata
DELTET/DELTA_T_A = 32.184
DELTET/K = 1.657D-3
DELTET/EB = 1.671D-2
DELTET/M = ( 6.239996D0 1.99096871D-7 )
DELTET/DELTA_AT = ( 10, @1972-JAN-1 37, @2017-JAN-1 )
\\begintext
"""


@pytest.fixture
def turning(tmp_path):
    """Return the file of a body that turns about an axis of its own."""
    t, axis = np.arange(0.0, 20.0, 0.5), np.array([2.0, 3.0, 6.0]) / 7
    angle = 0.05 * t
    columns = dict(zip(("q1", "q2", "q3"), np.outer(axis, np.sin(angle / 2)), strict=True))
    columns["q0"] = np.cos(angle / 2)
    columns |= {f"w{name}": np.full_like(t, 0.05 * part) for name, part in zip("xyz", axis, strict=True)}
    units = {"q": "1", "w": "rad/s"}
    values = {name: ("t", value, {"units": units[name[0]]}) for name, value in columns.items()}
    dataset = xarray.Dataset(values, {"t": ("t", t, {"units": "s"})}, {"model_hash": "0", "model": "turning"})
    mehvar.save(dataset, tmp_path / "run.nc")
    return tmp_path / "run.nc", dataset


def parsed(text):
    """Return header, metadata and rows of a message with one segment."""
    head, _, rest = text.partition("META_START\n")
    about, _, rest = rest.partition("META_STOP\nDATA_START\n")
    rows, _, end = rest.partition("DATA_STOP\n")
    assert end == ""
    pairs = [
        dict(line.split(" = ", 1) for line in part.splitlines() if not line.startswith("COMMENT"))
        for part in (head, about)
    ]
    return *pairs, [line.split(" ") for line in rows.splitlines()]


def test_a_message_has_the_quaternions_and_rates_of_the_run(turning):
    source, dataset = turning
    out = source.with_suffix(".aem")
    options = [word for pair in (MESSAGE | {"rates": "wx,wy,wz"}).items() for word in ("--about", "=".join(pair))]
    run("convert", str(source), "--out", str(out), *options)
    head, about, rows = parsed(out.read_text())
    assert head["CCSDS_AEM_VERS"] == "2.0"
    assert about["ATTITUDE_TYPE"] == "QUATERNION/ANGVEL"
    assert (about["REF_FRAME_A"], about["REF_FRAME_B"], about["TIME_SYSTEM"]) == ("J2000", "SC_BODY_1", "TAI")
    assert about["START_TIME"] == rows[0][0] == "2026-03-21T12:00:00.500000000"
    numbers = np.array([row[1:] for row in rows], dtype=float)
    names = ("q1", "q2", "q3", "q0")
    np.testing.assert_array_equal(numbers[:, :4], np.column_stack([dataset[name] for name in names]))
    np.testing.assert_allclose(numbers[:, 4:], np.degrees([[dataset[f"w{n}"].values[0] for n in "xyz"]] * len(rows)))
    times = [datetime.fromisoformat(row[0][:-3]) for row in rows]
    assert [(t - times[0]).total_seconds() for t in times] == dataset["t"].values.tolist()


@pytest.mark.parametrize(
    ("change", "allowed"),
    [
        ({"epoch": "noon"}, "epoch = 'noon'.*must be a time such as 2026-03-21T12:00:00"),
        ({"epoch": "2026-02-30T00:00:00"}, "a date"),
        ({"quaternion": "q1,q2,q3"}, "4 variables"),
        ({"quaternion": "q1,q2,q3,wx"}, "must be in 1; it is in rad/s"),
        ({"quaternion": "q1,q2,q3,q3"}, "of norm one; it is 0"),
        ({"quaternion": "q1,q2,q3,q4"}, "unknown variable 'q4'"),
        ({"frame_b": ""}, r"needs frame_b \(the frame of the body\)"),
        ({"object": "DEMO\nMETA_STOP"}, "object = .*must be a text in one line"),
        ({"frame": "J2000"}, "unknown name 'frame' of aem"),
    ],
)
def test_nothing_is_guessed(turning, change, allowed):
    source, _ = turning
    with pytest.raises(InputError, match=allowed):
        convert(source, "aem", source.with_suffix(".aem"), MESSAGE | change)


def test_other_formats_have_no_frames(turning):
    source, _ = turning
    out = str(source.with_suffix(".csv"))
    assert "one of aem, oem, ck with --about" in refused("convert", str(source), "--out", out, "--about", "epoch=1")


@pytest.fixture
def tumbling():
    """Return a run of a body without torque whose rates change their direction."""
    t = np.arange(0.0, 20.0, 0.1)
    inertia = np.array([1.0, 2.0, 3.0])

    def slopes(_, x):
        (q1, q2, q3, q0), w = x[:4], x[4:]
        turn = [q0 * w[0] + q2 * w[2] - q3 * w[1], q0 * w[1] + q3 * w[0] - q1 * w[2], q0 * w[2] + q1 * w[1] - q2 * w[0]]
        return [*np.array(turn) / 2, -np.dot(x[:3], w) / 2, *np.cross(inertia * w, w) / inertia]

    x = solve_ivp(slopes, (0, 20), [0, 0, 0, 1, 0.3, 0.5, -0.2], t_eval=t, rtol=1e-10, atol=1e-12).y
    names = {"q1": "1", "q2": "1", "q3": "1", "q0": "1", "wx": "rad/s", "wy": "rad/s", "wz": "rad/s"}
    values = {name: ("t", row, {"units": unit}) for (name, unit), row in zip(names.items(), x, strict=True)}
    return xarray.Dataset(values, {"t": ("t", t, {"units": "s"})})


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({}, ""),
        ({"quaternion": "q0,q1,q2,q3"}, "rotations between samples agree with the first variable as scalar part"),
        ({"rates": "wz,wy,wx"}, "agree with rates=wx,wy,wz"),
        ({"quaternion": "q0,q1,q2,q3", "rates": "wy,wx,wz"}, "as scalar part, rates=wx,wy,wz"),
        ({"frame_b": "J2000"}, "frame_b = 'J2000' .*: must be another frame than frame_a"),
    ],
    ids=str,
)
def test_rates_that_contradict_the_quaternion_are_refused(tumbling, given, message):
    """The error names the reading that the turns between samples agree with."""
    about = MESSAGE | {"rates": "wx,wy,wz"} | given
    if not message:
        assert attitude(tumbling, "aem", about).rates is not None
        return
    with pytest.raises(InputError, match=message):
        attitude(tumbling, "aem", about)


def test_a_wrong_order_is_told_without_rates_too(tumbling):
    """The hub's rates are in the run, and in no message."""
    with pytest.raises(InputError, match=r"consistent with rates=wx,wy,wz: .* first variable as scalar part"):
        attitude(tumbling, "aem", MESSAGE | {"quaternion": "q0,q1,q2,q3"})
    assert attitude(tumbling, "aem", MESSAGE).rates is None


def test_the_inverse_turn_is_told(tumbling):
    """The conjugate takes frame B into frame A."""
    for name in ("q1", "q2", "q3"):
        tumbling[name] = -tumbling[name].assign_attrs(tumbling[name].attrs)
        tumbling[name].attrs["units"] = "1"
    with pytest.raises(InputError, match="agree with the inverse turn"):
        attitude(tumbling, "aem", MESSAGE | {"rates": "wx,wy,wz"})


def test_rates_of_a_vibration_are_accepted(tumbling):
    """Between the samples the rates turn to and fro, which no order of names explains."""
    for name in ("wx", "wy", "wz"):
        tumbling[name].values[:] = 40 * np.cos(np.pi * np.arange(tumbling.t.size))
    assert attitude(tumbling, "aem", MESSAGE | {"rates": "wx,wy,wz"}).rates is not None


@pytest.mark.peers
def test_spice_reads_the_same_attitude(turning):
    spice = pytest.importorskip("spiceypy", reason="make peers installs it")
    source, dataset = turning
    clock, leaps = source.with_name("clock.tsc"), source.with_name("leaps.tls")
    clock.write_text(CLOCK)
    leaps.write_text(LEAPS)
    about = COMMON | {"time_system": "TDB", "instrument": "-99000", "clock": "-99", "kernels": f"{leaps},{clock}"}
    out = source.with_suffix(".bc")
    convert(source, "ck", out, about | {"rates": "wx,wy,wz"})
    with pytest.raises(InputError, match="SPICE refuses"):
        convert(source, "ck", out, about | {"kernels": "nothing.tsc"})
    spice.furnsh([str(leaps), str(clock), str(out)])
    zero = spice.str2et("2026-03-21 12:00:00.5 TDB")
    turns = Rotation.from_quat(np.column_stack([dataset[name] for name in ("q1", "q2", "q3", "q0")]))
    rates = turns.apply(np.column_stack([dataset[f"w{n}"] for n in "xyz"]))
    for k, t in enumerate(dataset["t"].values):
        matrix, rate, *_ = spice.ckgpav(-99000, spice.sce2c(-99, zero + t), 0, "J2000")
        np.testing.assert_allclose(matrix, turns[k].as_matrix().T, atol=1e-14)
        np.testing.assert_allclose(rate, rates[k], atol=1e-14)
    spice.kclear()


def test_a_kernel_has_the_matrix_from_a_to_b_and_the_rate_in_a():
    """By SPICE's own definition the quaternion (c, s n) stands for the matrix of that turn, from A to B."""
    turns = Rotation.random(20, random_state=3)
    rates = np.random.default_rng(3).normal(size=(20, 3))
    spice, moved = _spice(Attitude(np.arange(20.0), turns.as_quat(), rates, {}))
    scalar, *vector = np.transpose(spice)
    matrices = Rotation.from_quat(np.transpose([*vector, scalar])).as_matrix()
    np.testing.assert_allclose(matrices, turns.inv().as_matrix(), atol=1e-14)
    np.testing.assert_allclose(moved, turns.apply(rates), atol=1e-14)
