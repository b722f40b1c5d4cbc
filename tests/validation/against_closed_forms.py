# SPDX-License-Identifier: Apache-2.0
"""The models against motions that are known in closed form; Jacobi's functions are mpmath's, with thirty digits.

The formulas are exact, so the bounds are those of the numbers that they are compared in: a rounding of double a step.
"""

from __future__ import annotations

from typing import Any

import mpmath
import numpy as np
import pytest
from mpmath import mpf
from scipy.integrate import solve_ivp

import mehvar
from mehvar.runtime import simulate
from tests.models.slosh.variants import slosh
from tests.validation import craft
from tests.validation.table import record

pytestmark = pytest.mark.filterwarnings("ignore:Kp_. = 0 N m/rad")
mpmath.mp.dps = 30
VERSION = mpmath.__version__
ROUNDING = 2.0**-53
ALLOWANCE = 12 * ROUNDING
"""A step's share of the bound. Chosen, not derived: a rounding for each of the twelve stages of dop853, of the size of
the state. An analysis would weigh each by its coefficient and by what a right-hand side rounds, and differ from problem
to problem. The errors against Jacobi's functions are less than a hundredth of the bound; half of it would hold too."""
REASON = "exact to 30 digits; allowed: a rounding of double for each of the twelve stages of a step"
FREE = {f"{gain}_{axis}": 0.0 for gain in ("Kp", "Kd") for axis in "xyz"} | {f"Iw_{a}": craft.NO_WHEEL for a in "xyz"}


def free(values: dict[str, float], initial: dict[str, float], t_end: float, chart: str = "quaternion") -> Any:
    """Return a run of the satellite, compiled, with a law whose gains are zero and no wheels."""
    model = craft.model() if chart == "quaternion" else mehvar.load("satellite")
    given = {"wheels": 0.0, "Ts": t_end, "half_period": 2 * t_end} | FREE | values
    return simulate(model, "pd", parameters=given, initial=initial, t_end=t_end, dt_out=t_end / 400)


@pytest.mark.parametrize("rate", [(0.02, 0.03), (0.03, 0.004)], ids=["about the largest", "about the least"])
def test_asymmetric_top(rate: tuple[float, float]) -> None:
    """Landau and Lifshitz, Mechanics, section 37; w2 is zero at first."""
    one, two, three = mpf("2.13"), mpf("2.6"), mpf("3.09")
    w1, w3 = map(mpf, rate)
    moments = {"I_x": float(one), "I_y": float(two), "I_z": float(three), "omega0": 0.0}
    run = free(moments, {"wx": rate[0], "wy": 0.0, "wz": rate[1]}, 600.0)
    first, third = (one, three) if one * (one - two) * w1**2 + three * (three - two) * w3**2 > 0 else (three, one)
    swapped = first is three
    a1, a3 = (w3, w1) if swapped else (w1, w3)
    a2 = a1 * mpmath.sqrt(first * (third - first) / (two * (third - two)))
    speed = a3 * mpmath.sqrt((third - two) * (third - first) / (first * two))
    m = (two - first) * first * a1**2 / ((third - two) * third * a3**2)
    expected = []
    for t in run.t:
        sn, cn, dn = (mpmath.ellipfun(f, speed * mpf(t), m=m) for f in ("sn", "cn", "dn"))
        values = [a1 * cn, a2 * sn, a3 * dn]
        expected.append([float(v) for v in (values[::-1] if swapped else values)])
    record(
        f"satellite: free asymmetric top, {'least' if swapped else 'largest'} axis, 600 s",
        "Jacobi's functions",
        f"mpmath {VERSION}",
        run.x[:, 4:7] - expected,
        ALLOWANCE * run.statistics["steps"] * np.linalg.norm(rate),
        "rad/s",
        REASON,
    )


@pytest.mark.parametrize("degrees", [0.01, 80.0])
def test_libration(degrees: float) -> None:
    """Planar pitch: sin(pitch) = k sn(n t + K), n^2 = 3 omega0^2 (I_x - I_z)/I_y."""
    omega0 = 1.083077791e-3
    moments = {"I_x": 3.04, "I_y": 3.09, "I_z": 2.13, "omega0": omega0}
    start = {"roll_0_deg": 0.0, "pitch_0_deg": degrees, "yaw_0_deg": 0.0}
    run = free(moments | start, {}, 5801.2, "euler")
    k = mpmath.sin(mpmath.radians(mpf(degrees)))
    n = mpf(omega0) * mpmath.sqrt(3 * (mpf("3.04") - mpf("2.13")) / mpf("3.09"))
    quarter = mpmath.ellipk(k**2)
    expected = [float(mpmath.asin(k * mpmath.ellipfun("sn", n * mpf(t) + quarter, m=k**2))) for t in run.t]
    assert np.ptp(expected) > np.radians(degrees) * 1.9
    record(
        f"satellite: libration of {degrees:g} degrees in the gravity gradient, one orbit",
        "Jacobi's functions",
        f"mpmath {VERSION}",
        run.x[:, 1] - expected,
        ALLOWANCE * run.statistics["steps"],
        "rad",
        REASON,
    )


def test_spherical_pendulum() -> None:
    """A bob under a craft of 1e9 kg that is pushed at g: u = s_x follows u1 + (u2 - u1) sn^2(w t)."""
    model, g, length, mass = slosh("1", "ball"), 1.7, 0.8, 1e9
    values = {"m": mass, "F": g * mass, "m0": 1e-6, "I0": 1e-6, "m1": 1.0, "l1": length, "I1": 1e-12, "eps1": 0.0}
    p = model.parameters(**values, J_x=mass, J_y=mass, J_z=mass)
    x = np.zeros(len(model.system.states))
    at = model.index("s1x")
    tilt, swing = 0.7, 0.9
    x[at : at + 6] = -np.cos(tilt), 0, np.sin(tilt), 0, swing, 0
    times = np.linspace(0, 20, 201)
    run = solve_ivp(
        lambda _t, y: model.functions["rhs"](y, np.zeros(5), p), (0, 20), x, "DOP853", times, rtol=1e-12, atol=1e-14
    )
    level, turn = mpf(g) / length, mpf(swing) * mpmath.sin(mpf(tilt))
    total = mpf(swing) ** 2 / 2 - level * mpmath.cos(mpf(tilt))
    roots = mpmath.polyroots([2 * level, -2 * total, -2 * level, 2 * total - turn**2], maxsteps=200, extraprec=100)
    low, high, far = sorted(mpmath.re(r) for r in roots)
    m, speed = (high - low) / (far - low), mpmath.sqrt(level * (far - low) / 2)
    phase = 0 if abs(low + mpmath.cos(mpf(tilt))) < mpf("1e-20") else mpmath.ellipk(m)
    expected = [float(low + (high - low) * mpmath.ellipfun("sn", speed * mpf(t) + phase, m=m) ** 2) for t in times]
    record(
        "slosh: spherical pendulum under a heavy pushed craft, 20 s",
        "Jacobi's functions",
        f"mpmath {VERSION}",
        run.y[at] - expected,
        1e-9 * 20 * np.sqrt(g / length),
        "1",
        "the closed form holds the craft fixed: mass of the bob over that of the craft, times the swings",
    )


@pytest.mark.parametrize(("centre", "radius"), [(0.0, 0.5), (0.3, 0.2), (0.1, 0.35)])
def test_holonomy_of_the_triangle(centre: float, radius: float) -> None:
    """A closed circle in the disc of shapes turns the triangle by twice its area, half the area on the sphere."""
    model = mehvar.load("triangle")
    p, mu = model.parameters(), 0.17

    def slope(t: float, x: np.ndarray) -> np.ndarray:
        zeta, rate = centre + radius * np.exp(1j * t), 1j * radius * np.exp(1j * t)
        radial = (np.conj(zeta) * rate).real / abs(zeta)
        return np.asarray(model.rhs(x, [radial, (np.conj(zeta) * rate).imag / abs(zeta) ** 2, 0.0], p))

    start = model.state(rho=centre + radius, mu=mu)
    rough, run = (
        solve_ivp(slope, (0, 2 * np.pi), start, "DOP853", rtol=tolerance, atol=tolerance / 100)
        for tolerance in (1e-11, 1e-12)
    )
    record(
        f"triangle: holonomy of a circle of radius {radius} about {centre}",
        "area of the circle",
        "exact",
        run.y[3, -1] - 2 * np.pi * radius**2,
        abs(run.y[3, -1] - rough.y[3, -1]) + ALLOWANCE * len(run.t),
        "rad",
        "change of SciPy's result between tolerances 1e-11 and 1e-12; allowed: a rounding for each stage of a step",
    )
