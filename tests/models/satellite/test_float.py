# SPDX-License-Identifier: Apache-2.0
"""The laws in C: the same numbers as in Python, and a million samples in single precision."""

import ctypes
import functools
import math
from pathlib import Path

import numpy as np
import pytest

from mehvar.runtime.compiling.library import load_library, native_headers
from tests.models.satellite.loop import run, satellite

G = satellite()
AXES = ("roll", "pitch", "yaw")
DRIVER = Path(__file__).parent / "driver.c"
STILL = {"roll_step_deg": 0, "pitch_step_deg": 0, "roll_0_deg": 0, "pitch_0_deg": 0, "yaw_0_deg": 0}


@functools.cache
def laws(real):
    """Compile the model in one precision."""
    texts = native_headers() | {path.name: path.read_text() for path in G.folder.glob("satellite.[ch]")}
    flags = ("-O2", "-DMEHVAR_FLOAT") if real is np.float32 else ("-O2",)
    return load_library("satellite", texts, ["satellite.c"], flags)


@functools.cache
def driver(real):
    """Compile the loop for laws of one precision."""
    name = "float" if real is np.float32 else "double"
    return load_library("satellite_driver", {DRIVER.name: DRIVER.read_text()}, [DRIVER.name], ("-O2", f"-DREAL={name}"))


def function(real, name):
    return ctypes.cast(getattr(laws(real), f"satellite_{name}"), ctypes.c_void_p)


def pointer(array):
    return array.ctypes.data_as(ctypes.c_void_p)


def drive(real, law, scenario, samples, every=1, **settings):
    """Return memory as found, state and command, one row for each `every` samples, of a run in C."""
    p, c, s = G.parameters(settings, law, scenario)
    x, tag, nz = np.array(G.initial(p, s)), law.replace("-", "_"), len(G.memory(law))
    noise = np.random.default_rng(1).normal(0, settings.get("noise", 0.0), 300007)
    out = np.zeros((-(-samples // every), nz + 13))
    reals = p.astype(real), c.astype(real)
    driver(real).drive(
        *(function(np.float64, name) for name in ("rhs", "reference", "actuate")),
        function(real, tag),
        function(real, f"{tag}_start"),
        *map(pointer, (p, s, *reals, x)),
        ctypes.c_int(nz),
        ctypes.c_long(samples),
        ctypes.c_long(every),
        ctypes.c_int(int(settings.get("delay", 0))),
        ctypes.c_double(0.5),
        pointer(noise),
        ctypes.c_long(noise.size),
        pointer(out),
    )
    return out[:, :nz], out[:, nz : nz + 10], out[:, nz + 10 :]


def column(law, z, *names):
    known = G.memory(law)
    return np.stack([z[:, known.index(name)] for name in names], axis=-1)


def covariance(law, z, axis):
    """Return F = U D U' of one axis."""
    U, D = np.tile(np.eye(5), (len(z), 1, 1)), column(law, z, *(f"D{i}_{axis}" for i in range(1, 6)))
    for j in range(5):
        for i in range(j):
            U[:, i, j] = column(law, z, f"U{i + 1}{j + 1}_{axis}")[:, 0]
    return np.einsum("kij,kj,klj->kil", U, D, U)


@pytest.mark.parametrize("law", ["mrac", "mrac-literal", "pd"])
@pytest.mark.parametrize("delay", [0, 1])
@pytest.mark.share(6)
def test_python_and_c_agree_sample_by_sample(law, delay):
    """Each sample from the same memory, and the same loop over 600 samples where it is not lost before."""
    samples = 60 if (law, delay) == ("mrac-literal", 1) else 600
    cases = run(G, law, [("printed", {"delay": delay})], samples, substeps=1)
    p, c, _ = G.parameters({"delay": delay}, law, "printed")
    size = len(G.memory(law))
    u, z_next = np.zeros(3), np.zeros(size)
    call = getattr(laws(np.float64), "satellite_" + law.replace("-", "_"))
    applied = np.vstack([np.zeros((1, 3)), cases.u[:-1, 0]])
    for k in range(samples):
        arguments = [np.ascontiguousarray(a) for a in (cases.x[k, 0], cases.r[k, 0], applied[k], cases.z[k, 0], p, c)]
        call(*map(pointer, (*arguments, u, z_next)))
        if k + 1 < samples:
            scale = 1 + np.abs(cases.z[k + 1, 0])
            assert (np.abs(z_next - cases.z[k + 1, 0]) <= 1e-12 * scale).all()
        if not delay:
            assert u == pytest.approx(cases.u[k, 0], rel=1e-12, abs=1e-12)


def test_single_precision_tracks_as_well():
    """The row mrac_f32_delay, and the difference from double precision."""
    z, x, u = drive(np.float32, "mrac", "paper", 1600, delay=1)
    _, exact, _ = drive(np.float64, "mrac", "paper", 1600, delay=1)
    late = slice(400, None)
    error = np.degrees(x[:, :3] - column("mrac", z, *(f"ym_{a}" for a in AXES)))[late]
    assert np.sqrt((error**2).mean(axis=0)) == pytest.approx([0.0370, 0.0381, 0.1165], rel=0.02)
    assert np.abs(error).max(axis=0) == pytest.approx([0.287, 0.294, 0.743], rel=0.02)
    assert np.abs(u[late]).max(axis=0) == pytest.approx([0.01768, 0.03029, 0.01823], rel=0.02)
    assert np.degrees(np.abs(x[late, :3] - exact[late, :3]).max()) < 0.01


@pytest.mark.soak
@pytest.mark.parametrize(
    ("still", "noise"),
    [
        (False, 5e-5),
        (True, 0.0),
        pytest.param(False, 0.0, marks=pytest.mark.soak),
        pytest.param(True, 5e-5, marks=pytest.mark.soak),
    ],
)
def test_a_million_samples_in_single_precision(still, noise):
    """Manoeuvring or idle the covariance stays positive, the estimates bounded and the loop as in double precision."""
    settings = {"umax": 0.1, "noise": noise, "F0": 1e4, "delay": 1, **(STILL if still else {})}
    for name in ("dipole_x", "dipole_y", "dipole_z", "air_density", "solar_pressure"):
        settings[name] = 0.0
    settings["hmax"] = 1e6
    results = [drive(real, "mrac", "flight", 1_000_000, 500, **settings) for real in (np.float32, np.float64)]
    for z, x, _ in results:
        assert np.isfinite(z).all()
        assert not column("mrac", z, "sensor_lost").any()
        for axis in AXES:
            F = covariance("mrac", z, axis)
            trace = np.trace(F, axis1=1, axis2=2)
            assert (np.linalg.eigvalsh(F)[:, 0] >= -1e-6 * trace).all()
            assert (trace < 5e4 / 0.998 * 1.001).all()
            # from one sample to the next the double integrator moves as 2 y(k-1) - y(k-2): a1 + a2 = -1
            estimates = column("mrac", z, f"a1_{axis}", f"a2_{axis}")
            assert np.abs(estimates.sum(axis=1) + 1).max() < 1
        error = np.degrees(x[1000:, :3] - column("mrac", z[1000:], *(f"ym_{a}" for a in AXES)))
        assert math.sqrt((error**2).mean()) < 0.1
