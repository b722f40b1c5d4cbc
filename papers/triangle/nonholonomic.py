# SPDX-License-Identifier: Apache-2.0
"""Checks of the opening of the paper's section 3: attitude as an area, Brockett's condition, the usual laws."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mehvar.reproduction import Check, Expected, about, below, not_essential

from .chart import law_direction, target_shape
from .surfaces import arc_to, law_xi

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from mehvar.reproduction import Runs

    FloatArray = NDArray[np.float64]
    ComplexArray = NDArray[np.complex128]

_STEP = 0.1
"""s, of the fourth-order steps of a smooth law with rates of 0.5 to 5 1/s: half of it moves an attitude by 3e-5 rad."""
_POINTS = 400
"""Points of a loop; the trapezoidal rule is exact for a circle."""
_COLLINEAR = math.sqrt(0.5)
_REST = 1e-12
"""Bound for zero rates, 1/s, and zero singular values: rounding leaves 1e-16 of rates near 1."""

_GAIN = 0.5
"""1/s: the speed of the path law, so that times can be compared."""
_SMOOTH: Mapping[str, Callable[[ComplexArray, FloatArray], ComplexArray]] = {
    "straight to the target": lambda w, theta: -_GAIN * w,
    "turning by the attitude": lambda w, theta: -_GAIN * w * (1 + 10j * theta),
    "pushed aside by the attitude": lambda w, theta: -_GAIN * w + 0.2j * theta,
}
"""Rates w' by w and theta~, polynomials that vanish at the target. Other factors than 10 and 0.2 leave
another attitude, not none."""


@dataclass(frozen=True)
class _Start:
    """Start of the paper's run relative to its target."""

    w: complex
    theta: float
    target: complex


def _start(runs: Runs) -> _Start:
    run = runs("path", "paper")
    series = run.variables()
    w = series["rho_error"][0] * np.exp(1j * series["phi_error"][0])
    return _Start(complex(w), float(series["theta_shifted"][0]), target_shape(runs.model, run))


def attitude_is_area(runs: Runs, expected: Expected) -> Sequence[Check]:
    """Check the attitude after a circle of shapes, in both directions; an integrable constraint would give zero."""
    radius, centre = 0.3, 0.2 + 0.1j
    area = math.pi * radius**2
    there, back = (_loop(runs, centre, side * radius) for side in (1, -1))
    return (
        about("turn after a loop of shapes", 2 * area, there, "rad", _REST),
        about("the same loop the other way round", -2 * area, back, "rad", _REST),
    )


def _loop(runs: Runs, centre: complex, radius: float) -> float:
    """Return the change of the attitude after a circle, counter-clockwise for a positive radius."""
    turn = np.linspace(0, 2 * np.pi, _POINTS, endpoint=False)
    sense = math.copysign(1.0, radius)
    way = abs(radius) * np.exp(1j * sense * turn)
    zeta, rate = centre + way, 1j * sense * way
    return float(2 * np.pi * np.mean(_attitude_rate(runs, zeta, rate)))


def _attitude_rate(runs: Runs, zeta: ComplexArray, rate: ComplexArray) -> FloatArray:
    """Return theta' of the model for shapes and their rates, rad/s."""
    rho, polar = np.abs(zeta), rate * np.exp(-1j * np.angle(zeta))
    nothing = np.zeros_like(rho)
    x = np.stack([rho, np.angle(zeta), nothing + 0.3, nothing], axis=-1)
    u = np.stack([polar.real, polar.imag / rho, nothing], axis=-1)
    return np.asarray(runs.model.rhs(x, u, runs.model.parameters())[..., 3])


def smooth_laws_fail(runs: Runs, expected: Expected) -> Sequence[Check]:
    """Check Brockett's condition: smooth laws leave an attitude error, the paper's two laws do not."""
    g = np.random.default_rng(1)
    zeta = 0.7 * np.sqrt(g.random(1000)) * np.exp(2j * np.pi * g.random(1000))
    resting = float(np.abs(_attitude_rate(runs, zeta, 0 * zeta)).max())
    checks = [
        Check("largest |θ′| while the shape rests, over 1000 shapes", "0 rad/s", f"{resting:g} rad/s", resting == 0.0),
        Check("states that the linearised model controls", "3 of 4", f"{(rank := _rank(runs))} of 4", rank == 3),
    ]
    start = _start(runs)
    for name, early, late in zip(_SMOOTH, *(_attitudes_left(runs, start, t) for t in (35.0, 350.0)), strict=True):
        stays = late > expected("left") and late > 0.99 * early
        checks.append(
            Check(
                f"smooth, {name}: |θ| at 35 s and at 350 s",
                f"> {expected('left'):g} rad, no smaller",
                f"{early:.3g} and {late:.3g} rad",
                stays,
            )
        )
    for law in ("sliding", "path"):
        left = abs(float(runs(law, "paper").variables()["theta_error"][-1]))
        checks.append(below(f"{law}: |θ| at 35 s", expected(law), left, "rad"))
    return checks


def _rank(runs: Runs) -> int:
    """Return the rank of [B, AB, A^2 B, A^3 B] at the paper's target."""
    target = target_shape(runs.model, runs("path", "paper"))
    x, u = [abs(target), np.angle(target), 0.43, 0.0], [0.0] * 3
    p = runs.model.parameters()
    a, b = np.asarray(runs.model.jac_x(x, u, p)), np.asarray(runs.model.jac_u(x, u, p))
    return int(np.linalg.matrix_rank(np.hstack([np.linalg.matrix_power(a, k) @ b for k in range(4)]), _REST))


def _attitudes_left(runs: Runs, start: _Start, end: float) -> list[float]:
    """Return |theta - theta_f| of the model under each smooth law, by the classical fourth-order method."""
    a, turn = abs(start.target), start.target / abs(start.target)

    def rates(w: ComplexArray, theta: FloatArray) -> tuple[ComplexArray, FloatArray]:
        shifted = theta + a * w.imag
        rate = np.array([law(w[k], shifted[k]) for k, law in enumerate(_SMOOTH.values())])
        return rate, _attitude_rate(runs, (a - w) * turn, -rate * turn)

    w = np.full(len(_SMOOTH), start.w)
    theta = np.full(len(_SMOOTH), start.theta - a * start.w.imag)
    for _ in range(round(end / _STEP)):
        k1 = rates(w, theta)
        k2 = rates(w + _STEP / 2 * k1[0], theta + _STEP / 2 * k1[1])
        k3 = rates(w + _STEP / 2 * k2[0], theta + _STEP / 2 * k2[1])
        k4 = rates(w + _STEP * k3[0], theta + _STEP * k3[1])
        w = w + _STEP / 6 * (k1[0] + 2 * k2[0] + 2 * k3[0] + k4[0])
        theta = theta + _STEP / 6 * (k1[1] + 2 * k2[1] + 2 * k3[1] + k4[1])
    return [abs(float(angle)) for angle in theta]


def usual_laws_leave(runs: Runs, expected: Expected) -> Sequence[Check]:
    """Laws for the unbounded integrator from the paper's start: Bloch and Drakunov's, and the arc without a bound.

    Bloch and Drakunov (reference 6 of the paper): rho~' = -k rho~, phi~' = -b sgn(theta~). On its way in it removes
    b rho~^2/(2k) of the attitude, so it first has to go out to sqrt(2 k |theta~|/b).
    """
    start, run = _start(runs), runs("path", "paper")
    removed = abs(start.w) ** 2 / 2
    needed, farthest = math.sqrt(2 * start.theta), _COLLINEAR + abs(start.target)
    free = (np.pi - float(law_xi(runs, 2 * start.theta / abs(start.w) ** 2))) / 2
    arc = start.target - arc_to(start.w, free, 1.0) * start.target / abs(start.target)
    largest = float(np.abs(arc).max())
    ratio = start.theta / removed
    rate = _rod_rate(runs, start, -_GAIN * start.w * (1 + 1j * ratio))
    touching = abs(float(np.angle(-law_direction(runs.model, run, start.w, start.theta, start.target))))
    return (
        about("Bloch and Drakunov, equal gains: attitude removed on the way in", expected("removed"), removed, "rad"),
        Check(
            "distance from the target at which they would have to begin",
            f"> {farthest:.3f}, the farthest triangle",
            f"{needed:.3f}",
            needed > farthest,
        ),
        Check("arc (40) without a bound: largest ρ", f"> {_COLLINEAR:.4f}", f"{largest:.3f}", largest > _COLLINEAR),
        Check("the bound (47) takes a flatter arc", f"x < {free:.3f}", f"{touching:.3f} rad", touching < free),
        not_essential(
            below(f"Bloch and Drakunov, b = {ratio:.0f} k, no way out: rod rate", expected("rate"), rate, "m/s")
        ),
    )


def _rod_rate(runs: Runs, start: _Start, w_rate: complex) -> float:
    """Return the largest rod rate of the paper's first triangle for a rate of w, m/s."""
    x = runs("path", "paper").x[0].copy()
    rate = -w_rate * start.target / abs(start.target) * np.exp(-1j * x[1])
    return float(np.abs(runs.model.functions["length_rates"](x, [rate.real, rate.imag / x[0], 0.0])).max())
