# SPDX-License-Identifier: Apache-2.0
"""Recursive least squares of one axis, equations (34)-(42), used for each axis of each adaptive law.

The covariance is stored as F = U D U' with unit upper triangular U and diagonal D. Bierman's algorithm updates it, so
that F stays positive even in single precision. Further extensions are a cap on its trace, a dead zone, and a lower
bound of the gain in the laws.
"""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from ..system import Derivation, Expr, Group, Quantity
from .dynamics import AXES, angles, inertia_matrix
from .linear import nominal_gain

HALF = sp.Rational(1, 2)
"""Threshold between off (0) and on (1) of parameters that act as switches."""
WARM = 2
"""Samples after a start or a gap until all regressors are valid."""

_THETA = (
    ("a1", "1", "a_1"),
    ("a2", "1", "a_2"),
    ("b0", "rad/N/m", "b_0"),
    ("b1", "rad/N/m", "b_1"),
    ("d", "rad", "d_o"),
)
_ABOVE = tuple((i, j) for j in range(5) for i in range(j))
"""Rows and columns of U above its diagonal."""

SAMPLES = Quantity("samples", "1", "samples since the start or the last gap, up to two")
SENSOR_LOST = Quantity("sensor_lost", "1", "1 while a measurement is not finite: memory kept, torque zero")


def memory(axis: str) -> tuple[Quantity, ...]:
    """Return the memory of an axis's estimator: estimates, factors of F, past angles and torques."""
    estimates = (
        Quantity(f"{name}_{axis}", unit, f"estimate of {name}, {axis}", rf"\hat {latex}")
        for name, unit, latex in _THETA
    )
    diagonal = (
        Quantity(f"D{i + 1}_{axis}", "1", f"F = U D U', entry {i + 1} of D, {axis}", f"D_{i + 1}") for i in range(5)
    )
    upper = (
        Quantity(
            f"U{i + 1}{j + 1}_{axis}", "1", f"F = U D U', entry {i + 1}, {j + 1} of U, {axis}", f"U_{{{i + 1}{j + 1}}}"
        )
        for i, j in _ABOVE
    )
    past = (
        Quantity(f"y1_{axis}", "rad", f"{axis} one sample ago", "y(k-1)"),
        Quantity(f"y2_{axis}", "rad", f"{axis} two samples ago", "y(k-2)"),
        Quantity(f"v1_{axis}", "N m", f"torque applied one sample before the last, {axis}", "v(k-1)"),
        Quantity(f"u1_{axis}", "N m", f"torque commanded one sample ago, {axis}", "u(k-1)"),
        Quantity(f"u2_{axis}", "N m", f"torque commanded two samples ago, {axis}", "u(k-2)"),
    )
    return (*estimates, *diagonal, *upper, *past)


def symbols(axis: str) -> dict[str, sp.Symbol]:
    """Return the symbols of an axis's memory, by names without the axis."""
    return {q.name.removesuffix(f"_{axis}"): q.symbol for q in memory(axis)}


@dataclass(frozen=True)
class Estimate:
    """Estimates of an axis at this sample.

    Attributes
    ----------
    y, y1 : Expr
        The angle now and one sample ago.
    torque : Expr
        v(k), torque over the last sample.
    theta : tuple of Expr
        a1, a2, b0, b1, d for the laws.
    trace : Expr
        Trace of F.
    update : dict of str to Expr
        Next memory by name, without commanded torques, which the law adds.
    """

    y: Expr
    y1: Expr
    torque: Expr
    theta: tuple[Expr, ...]
    trace: Expr
    update: dict[str, Expr]


def estimate(axis: int, applied: Expr, law: Group, plant: Group, d: Derivation) -> Estimate:
    """Define one step of the estimator.

    Parameters
    ----------
    axis : int
        0, 1, 2 for roll, pitch, yaw.
    applied : Expr
        Torque that acted since the last sample.
    law, plant : Group
        Parameters.
    d : Derivation
        Receives the steps.
    """
    name, y = AXES[axis], angles[axis]
    z = symbols(name)
    d.section(f"Estimator, {name}")
    # after a gap the angle of one sample ago is not known
    y1 = sp.Piecewise((y, SAMPLES.symbol < HALF), (z["y1"], True))
    y1 = d.define(f"y1_used_{name}", y1, "", "angle one sample ago", "rad", "y(k-1)")
    assumed = sp.Piecewise((z["u2"], law.design_delay > HALF), (z["u1"], True))
    torque = sp.Piecewise((applied, law.applied_regressor > HALF), (assumed, True))
    torque = d.define(f"v_{name}", torque, "(36)", "torque over the last sample", "N m", "v")
    phi = (-y1, -z["y2"], torque, z["v1"], sp.S.One)
    theta = tuple(z[n] for n, _, _ in _THETA)
    predicted = sp.Add(*(p * t for p, t in zip(phi, theta, strict=True)))
    predicted = d.define(f"y_hat_{name}", predicted, "(34)", f"prediction of {name}", "rad", r"\hat y")
    error = d.define(f"eps_{name}", y - predicted, "(39)", "prediction error", "rad", r"\epsilon")
    factors, gain = _bierman(name, phi, z, law, d)
    learns = _learns(name, error, law, plant, d)
    covariance, trace = _capped(name, factors, z, learns, law, d)
    following = tuple(
        d.define(
            f"{n}_now_{name}",
            sp.Piecewise((t + g * error, learns), (t, True)),
            "(42)",
            f"estimate of {n} after this sample",
            unit,
            latex,
        )
        for (n, unit, latex), t, g in zip(_THETA, theta, gain, strict=True)
    )
    update = dict(zip((n for n, _, _ in _THETA), following, strict=True)) | covariance
    update |= {"y1": y, "y2": y1, "v1": torque, "u2": z["u1"]}
    share = law.compensate_d * following[-1]
    offset = d.define(f"d_used_{name}", share, "", "offset that the laws take out", "rad", "d_o")
    return Estimate(y, y1, torque, (*following[:-1], offset), trace, update)


def _bierman(
    name: str, phi: tuple[Expr, ...], z: dict[str, sp.Symbol], law: Group, d: Derivation
) -> tuple[dict[str, Expr], tuple[Expr, ...]]:
    """Define the gain (40) and the updated factors of F (41), one regressor at a time.

    Notes
    -----
    With f = U' Phi and v = D f the denominator of (40) is lambda + sum f_j v_j. Its partial sums alpha_j give D_j and
    column j of U; the gain is F Phi over the last of them.
    """
    alpha: Expr = law.forgetting
    factors: dict[str, Expr] = {}
    product: list[Expr] = []
    for j in range(5):
        n = j + 1
        turned = phi[j] + sp.Add(*(z[f"U{i + 1}{n}"] * phi[i] for i in range(j)))
        turned = d.define(f"f{n}_{name}", turned, "(40)", f"entry {n} of U' Phi", latex=f"f_{n}")
        weighted = d.define(f"Df{n}_{name}", z[f"D{n}"] * turned, "(40)", f"entry {n} of D U' Phi", latex=f"v_{n}")
        title = "lambda + Phi' F Phi" if j > 3 else f"lambda and the first {n} terms of Phi' F Phi"
        total = d.define(f"alpha{n}_{name}", alpha + turned * weighted, "(40)", title, latex=rf"\alpha_{n}")
        smaller = z[f"D{n}"] * alpha / (total * law.forgetting)
        factors[f"D{n}"] = d.define(f"D{n}_free_{name}", smaller, "(41)", f"entry {n} of D", latex=f"D_{n}'")
        for i in range(j):
            entry = z[f"U{i + 1}{n}"]
            title = f"entry {i + 1}, {n} of U"
            moved = entry - product[i] * turned / alpha
            factors[f"U{i + 1}{n}"] = d.define(
                f"U{i + 1}{n}_free_{name}", moved, "(41)", title, latex=f"U_{{{i + 1}{n}}}'"
            )
            product[i] = d.define(
                f"b{i + 1}_{n}_{name}",
                product[i] + entry * weighted,
                "(40)",
                f"entry {i + 1} of F Phi, {n} terms",
                latex=f"b_{{{i + 1},{n}}}",
            )
        product.append(weighted)
        alpha = total
    gain = tuple(
        d.define(f"G{i + 1}_{name}", b / alpha, "(40)", f"gain {i + 1}", latex=f"G_{i + 1}")
        for i, b in enumerate(product)
    )
    return factors, gain


def _learns(name: str, error: Expr, law: Group, plant: Group, d: Derivation) -> sp.Rel:
    """Return the condition for adaptation: switched on, valid regressors, error outside the dead zone."""
    width = sp.Max(law.dead_zone, law.dead_zone_sigma * plant.noise)
    when = sp.And(law.adapt > HALF, SAMPLES.symbol > WARM - HALF, sp.Abs(error) > width)
    flag = d.define(f"learns_{name}", sp.Piecewise((1, when), (0, True)), "", "1 when the estimates move")
    return flag > HALF


def _capped(
    name: str, factors: dict[str, Expr], z: dict[str, sp.Symbol], learns: sp.Rel, law: Group, d: Derivation
) -> tuple[dict[str, Expr], Expr]:
    """Return factors and trace of F with a cap: a step that would exceed it uses no forgetting."""
    squares = (sp.S.One if i is j else factors[f"U{i + 1}{j + 1}"] ** 2 for j in range(5) for i in range(j + 1))
    weights = (factors[f"D{j + 1}"] for j in range(5) for _ in range(j + 1))
    trace = sp.Add(*(s * w for s, w in zip(squares, weights, strict=True)))
    trace = d.define(f"trace_{name}", trace, "(41)", "trace of F", latex=r"\mathrm{tr} F")
    factor = sp.Piecewise((law.forgetting, trace > law.trace_max), (1, True))
    factor = d.define(f"cap_{name}", factor, "", "lambda when the trace is above its cap", latex="c_F")
    scaled = {n: factor * value if n.startswith("D") else value for n, value in factors.items()}
    return {n: sp.Piecewise((value, learns), (z[n], True)) for n, value in scaled.items()}, trace


def start(axis: int, law: Group, plant: Group) -> dict[str, Expr]:
    """Return the initial memory: first guess, F = F0 I, at rest at the measured angle.

    If the offset is not estimated, its variance is zero: the last entry of D is zero, row and column of F stay zero,
    and the offset stays at its first guess, zero. The operations per sample do not change.
    """
    name, y = AXES[axis], angles[axis]
    nominal = law.guess * nominal_gain(inertia_matrix(plant)[axis, axis], plant.Ts)

    def first(which: str) -> Expr:
        guess = getattr(law, f"{which}_{name}_0")
        return sp.Piecewise((guess, guess > 0), (nominal, True))

    values: dict[str, Expr] = {f"D{i + 1}": law.F0 for i in range(4)}
    values["D5"] = sp.Piecewise((law.F0, law.estimate_d > HALF), (0, True))
    values |= {f"U{i + 1}{j + 1}": sp.S.Zero for i, j in _ABOVE}
    values |= {"a1": sp.Integer(-2), "a2": sp.S.One, "b0": first("b0"), "b1": first("b1"), "d": sp.S.Zero}
    values |= {"y1": y, "y2": y, "v1": sp.S.Zero, "u1": sp.S.Zero, "u2": sp.S.Zero}
    return values


def smallest_gain(axis: int, law: Group, plant: Group) -> Expr:
    """Return b_min, the lower bound of the gain in a law."""
    return sp.Max(law.b_min, law.b_min_ratio * nominal_gain(inertia_matrix(plant)[axis, axis], plant.Ts))
