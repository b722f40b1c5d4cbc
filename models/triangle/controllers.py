# SPDX-License-Identifier: Apache-2.0
"""Control laws of the triangle: sliding mode, equations (29)-(39), and online path, equations (40)-(51).

Both use coordinates with the target at the origin, (25)-(27): w = rho~ exp(i phi~) points from the current shape to
the target. A law determines rho~' and phi~'; mu follows (52) independently.
"""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from ..mechanics import rotate
from ..system import Derivation, Expr, Group
from .dynamics import THETA, mu, shifted_attitude, shifted_position, zeta

_ORIGIN = sp.Rational(1, 10**9)
"""Distance from the target below which its direction phi~ is set to zero. Above it, rounding of w (1e-16) leaves phi~
seven digits. The effects of phi~ are proportional to the distance, so half or twice the bound hardly changes the state.
"""
_LARGEST_K = sp.Integer(10) ** 12
"""Ratio (42) above which the arc is a full circle: x is then within sqrt(pi/K) = 2e-6 rad of pi."""

_BARRIER = sp.Integer(100)
"""Largest rate of rho towards R, divided by k_phi (R - rho). On arcs it acts only if R - rho < pi R/100^2 = 2e-4. It
changes settling times of the path law by a relative 8e-7: four times as much at half the value, a quarter as much at
twice. Runs of the sliding law stay 0.1 away from R and are bit-identical. Sample periods above 2/(100 k_phi), 40 ms
with the path law and 7 ms with the sliding law, overshoot R.
"""

_TURN_SPEED = sp.Symbol("turn_speed", positive=True)


@dataclass(frozen=True)
class ShiftedState:
    """State in the chart whose origin is the target.

    Attributes
    ----------
    a : Expr
        Distance rho_f of the target from the base shape.
    rho, cosine, sine : Expr
        rho~ and the direction phi~.
    exact_theta, theta : Expr
        theta~ as derived in (27), and with the law's factor of its last term.
    target_phi : Expr
        phi_f.
    """

    a: Expr
    rho: Expr
    cosine: Expr
    sine: Expr
    exact_theta: Expr
    theta: Expr
    target_phi: Expr


def shifted_state(reference: Group, area_factor: Expr, d: Derivation) -> ShiftedState:
    """Define the shifted coordinates (25)-(27) of the state."""
    a, target_phi = reference.rho_ref, reference.phi_ref
    w1, w2 = shifted_position(a, target_phi)
    w1 = d.define(
        "w_along",
        w1,
        "(25)",
        "component of w along the target's direction",
        latex=r"\tilde\rho\cos\tilde\varphi",
    )
    w2 = d.define("w_across", w2, "(25)", "component of w across it", latex=r"\tilde\rho\sin\tilde\varphi")
    rho = d.define("rho_t", sp.sqrt(w1**2 + w2**2), "(25)", "distance to the target", latex=r"\tilde\rho")
    away = rho > _ORIGIN
    cosine = d.define(
        "cos_t",
        sp.Piecewise((w1 / rho, away), (1, True)),
        "(25)",
        "direction of the target",
        latex=r"\cos\tilde\varphi",
    )
    sine = d.define(
        "sin_t",
        sp.Piecewise((w2 / rho, away), (0, True)),
        "(25)",
        "direction of the target",
        latex=r"\sin\tilde\varphi",
    )
    error = THETA.symbol - reference.theta_ref
    exact = d.define(
        "theta_exact",
        shifted_attitude(error, a, (w1, w2), sp.S.One),
        "(27)",
        "shifted attitude",
        "rad",
        r"\tilde\theta",
    )
    theta = d.define(
        "theta_t",
        shifted_attitude(error, a, (w1, w2), area_factor),
        "(27)",
        "shifted attitude the law sees",
        "rad",
        r"\tilde\theta_c",
    )
    return ShiftedState(a, rho, cosine, sine, exact, theta, target_phi)


def sliding(shifted: ShiftedState, law: Group, d: Derivation) -> tuple[Expr, Expr]:
    """Define the sliding-mode law (29)-(38) with smooth sign functions.

    Returns
    -------
    tuple of Expr
        zeta1', zeta2'.
    """
    radius, slope = _circle(shifted, law.R, d)
    closeness = d.define(
        "tau", sp.Abs(shifted.theta) / law.theta_star, "(31)", "|shifted attitude| over theta*", latex=r"\tau"
    )
    f = d.define("f", closeness ** (1 / law.m), "(31)", "size of the surface's circle", latex="f")
    s = d.define("s", shifted.rho - f * radius, "(30)", "sliding variable", latex="s")
    ratio = shifted.rho / radius
    speed = law.k_phi * sp.sqrt(ratio) / (closeness + ratio**2)
    sigma = d.define(
        "sigma",
        sp.Piecewise((speed, shifted.rho > 0), (0, True)),
        "(37)",
        "speed of the turn",
        "1/s",
        r"\sigma",
    )
    side = _saturate(shifted.theta / law.theta_min)
    phi_rate = d.define(
        "phi_t_rate",
        -sigma * f ** (law.m - 1) * side,
        "(36)",
        "turn of the direction",
        "rad/s",
        r"\tilde\varphi'",
    )
    along_surface = _equivalent_rate(sigma, radius, slope, shifted, law)
    rho_rate = d.define(
        "rho_t_rate",
        along_surface - law.eta_rho * _saturate(s / law.s_min),
        "(34)",
        "approach to the target",
        "1/s",
        r"\tilde\rho'",
    )
    rate = _shape_rate(rho_rate, shifted.rho * phi_rate, shifted)
    return _inside(rate, law, "rho_t_rate_excess", d)


def _circle(shifted: ShiftedState, radius: Expr, d: Derivation) -> tuple[Expr, Expr]:
    """Solve rho = R for rho~ (28) and differentiate it: h and g = -h'/h of (32)."""
    root, rho, angle = sp.symbols("root rho angle", real=True)
    rho_squared = rho**2 - 2 * shifted.a * rho * sp.cos(angle) + shifted.a**2
    linear, constant = sp.Poly(rho_squared - radius**2, rho).all_coeffs()[1:]
    discriminant = sp.expand((linear**2 / 4 - constant).subs(sp.cos(angle) ** 2, 1 - sp.sin(angle) ** 2))
    h = -linear / 2 + root
    root_rate = sp.diff(discriminant, angle) / (2 * root)
    g = sp.factor(-(sp.diff(-linear / 2, angle) + root_rate) / h)
    here = {sp.sin(angle): shifted.sine, sp.cos(angle): shifted.cosine}
    chord = d.define(
        "chord",
        sp.sqrt(discriminant.subs(here)),
        "(28)",
        "half chord of the circle rho = R",
        latex=r"\sqrt{R^2-a^2\sin^2\tilde\varphi}",
    )
    h = d.define(
        "h",
        h.subs(here).subs(root, chord),
        "(28)",
        "distance from the target to the circle rho = R",
        latex="h",
    )
    return h, d.define("g", g.subs(here).subs(root, chord), "(32)", "relative slope -h'/h of the circle", latex="g")


def _equivalent_rate(sigma: Expr, radius: Expr, slope: Expr, shifted: ShiftedState, law: Group) -> Expr:
    """Solve s' = 0 for rho~' (33) with phi~' = -sigma f^(m-1) sgn(theta~): the smooth closed form of (36).

    The derivation sets theta~ = side * size with side = +-1; the sign cancels.
    """
    size, side, h, g, rho, angle_rate = sp.symbols("size side h g rho angle_rate", positive=True)
    f = (size / law.theta_star) ** (1 / law.m)
    size_rate = side * rho**2 * angle_rate
    surface_rate = sp.diff(f, size) * size_rate * h - f * h * g * angle_rate
    turn = -_TURN_SPEED * (size / law.theta_star) ** ((law.m - 1) / law.m) * side
    rate = sp.simplify(sp.powsimp(sp.expand(surface_rate.subs(angle_rate, turn))))
    signed = sp.expand(rate.subs(size, side * sp.Symbol("signed"))).subs(side**2, 1)
    actual = {h: radius, g: slope, rho: shifted.rho, _TURN_SPEED: sigma, sp.Symbol("signed"): shifted.theta}
    return sp.factor(signed).subs(actual, simultaneous=True)


def path(shifted: ShiftedState, law: Group, d: Derivation) -> tuple[Expr, Expr]:
    """Define the online-path law (40)-(51): follow the arc to the target that encloses the attitude error.

    Returns
    -------
    tuple of Expr
        zeta1', zeta2'.
    """
    alpha = d.define("alpha", sp.sign(shifted.theta), "(40)", "side of the arc", latex=r"\alpha")
    # at the target K is 0/0; distances below 1e-12 are raised to 1e-12, which keeps K large for errors above 1e-12 rad
    distance_squared = sp.Max(shifted.rho**2, sp.Rational(1, 10**24))
    ratio = sp.Min(2 * sp.Abs(shifted.theta) / distance_squared, _LARGEST_K)
    ratio = d.define("K", ratio, "(42)", "attitude error over the square of the distance", latex="K")
    free = chord_angle(ratio, d)
    x = d.define(
        "x",
        sp.Min(free, _tangent_angle(shifted, law.R, alpha, d)),
        "(47)",
        "angle between chord and arc, kept inside rho = R",
        "rad",
        "x",
    )
    # An arc of area |theta~| needs a distance of about its root: near the target rounding must not kick the state out.
    # Circles that touch rho = R are at least R - a large, and the law must be slow on a small one.
    escape = d.define(
        "escape",
        sp.Min(law.rho_escape, sp.sqrt(sp.Abs(shifted.theta)), law.R - shifted.a),
        title="distance below which the law leaves the target faster than in proportion to rho~",
        latex=r"\tilde\rho_e",
    )
    speed = d.define(
        "speed",
        law.k_phi * sp.Max(shifted.rho, -escape * sp.cos(x)),
        "(45)",
        "speed along the arc, also where the target is left",
        "1/s",
        r"|\tilde w'|",
    )
    rho_rate = d.define("rho_p_rate", -speed * sp.cos(x), "(46)", "approach to the target", "1/s", r"\tilde\rho'")
    turn = d.define(
        "turn_rate",
        -alpha * speed * sp.sin(x),
        "(46)",
        "rho~ phi~': motion across the direction of the target",
        "1/s",
        r"\tilde\rho\tilde\varphi'",
    )
    return _inside(_shape_rate(rho_rate, turn, shifted), law, "rho_rate_excess", d)


def _inside(rate: tuple[Expr, Expr], law: Group, name: str, d: Derivation) -> tuple[Expr, Expr]:
    """Limit rho' to a multiple of R - rho, so that rho stays below R."""
    distance = sp.sqrt(zeta.dot(zeta))
    bound = _BARRIER * law.k_phi * (law.R - distance)
    outward = zeta.dot(sp.Matrix(rate)) / sp.Max(distance, _ORIGIN)
    excess = d.define(
        name,
        sp.Max(0, outward - bound) / sp.Max(distance, _ORIGIN),
        title="rho' above it, over rho",
        unit="1/s",
        latex=r"(\rho'-\rho'_{max})/\rho",
    )
    return rate[0] - excess * zeta[0], rate[1] - excess * zeta[1]


def arc_area(x: Expr) -> Expr:
    """Return K of (42) for an arc with angle x = (pi - xi)/2 to its chord.

    Integrates rho~^2 along the circle rho~ = A cos(phi~ - phi*) of (40) from the current point to the target.
    """
    angle, diameter = sp.symbols("angle A", positive=True)
    start = x - sp.pi / 2
    swept = sp.integrate((diameter * sp.cos(angle)) ** 2, angle)
    area = swept.subs(angle, start) - swept.subs(angle, -sp.pi / 2)
    distance = diameter * sp.sin(x)
    return sp.simplify(2 * area / distance**2)


def chord_angle(ratio: Expr, d: Derivation) -> Expr:
    """Solve (42), K = (x - sin x cos x)/sin^2 x, for x in [0, pi) with a fixed number of operations.

    A rational start (relative error below 7 %) is followed by three Halley steps; for K < 0.03 the inverted power
    series is used. The relative error stays below 1e-11 for K up to 1e12.

    Two steps leave an error of 5e-10, three steps 1e-13. At K = 0.03 truncation of the series equals cancellation in
    the steps, 6e-14 each; at half this K the steps leave 4e-13, at twice the series 2e-11. The coefficients of the
    start are a fit that tends to pi for large K.
    """
    root = d.define("sqrt_K", sp.sqrt(ratio), title="root of K", latex=r"\sqrt K")
    numerator = sp.pi * root**2 * (root + sp.Float("1.661023"))
    denominator = ((root + sp.Float("2.225213")) * root + sp.Float("0.566927")) * root + sp.Float("3.478838")
    x = d.define("x_start", numerator / denominator, "(42)", "fitted first guess of x", "rad", "x_0")
    for step in (1, 2, 3):
        x = d.define(f"x_step{step}", _halley(x, ratio, d, step), "(42)", f"Halley step {step}", "rad", f"x_{step}")
    return sp.Piecewise((_small_chord_angle(ratio), ratio < sp.Rational(3, 100)), (x, True))


def _halley(x: Expr, ratio: Expr, d: Derivation, step: int) -> Expr:
    """Return a Halley step for F(x) = sin^2(x) (K(x) - K), with derivatives by SymPy."""
    unknown = sp.Symbol("x")
    sine = d.define(f"sin_x{step}", sp.sin(x), title="sine of the iterate", latex=rf"\sin x_{step - 1}")
    cosine = d.define(f"cos_x{step}", sp.cos(x), title="cosine of the iterate", latex=rf"\cos x_{step - 1}")
    residual = unknown - sp.sin(unknown) * sp.cos(unknown) - ratio * sp.sin(unknown) ** 2
    here = {sp.sin(unknown): sine, sp.cos(unknown): cosine, unknown: x}
    value, slope, bend = (sp.diff(residual, unknown, order).subs(here) for order in (0, 1, 2))
    return x - 2 * value * slope / (2 * slope**2 - value * bend)


def _small_chord_angle(ratio: Expr) -> Expr:
    """Return the inverse of the power series K(x) = 2x/3 + ..., up to K^7."""
    x, k = sp.symbols("x k")
    series = sp.series(arc_area(x), x, 0, 9).removeO()
    coefficients = sp.symbols("c1 c3 c5 c7")
    guess = sum((c * k ** (2 * i + 1) for i, c in enumerate(coefficients)), sp.S.Zero)
    composed = sp.expand(series.subs(x, guess) - k)
    values: dict[sp.Symbol, Expr] = {}
    for i, coefficient in enumerate(coefficients):
        values[coefficient] = sp.solve(composed.coeff(k, 2 * i + 1).subs(values), coefficient)[0]
    square = ratio**2
    return ratio * sp.horner(sum((values[c] * k**i for i, c in enumerate(coefficients)), sp.S.Zero), k).subs(k, square)


def _tangent_angle(shifted: ShiftedState, radius: Expr, alpha: Expr, d: Derivation) -> Expr:
    """Return x of the arc that touches the circle rho = R from inside, which is the limit of (47).

    The arc's circle has diameter A = (R^2 - a^2)/(R - a cos phi*) when it touches, and passes through the current point
    when rho~ = A cos(phi~ - phi*). With delta = phi* - phi~ that is P cos delta + Q sin delta = rho~ R.
    """
    a = shifted.a
    p = d.define(
        "P",
        radius**2 - a**2 + a * shifted.rho * shifted.cosine,
        "(47)",
        "tangency: coefficient of cos delta",
        latex="P",
    )
    q = d.define("Q", -a * shifted.rho * shifted.sine, "(47)", "tangency: coefficient of sin delta", latex="Q")
    cosine = sp.Min(1, shifted.rho * radius / sp.sqrt(p**2 + q**2))
    limit = sp.pi / 2 - alpha * sp.atan2(q, p) + sp.acos(cosine)
    return d.define("x_tangent", limit, "(47)", "angle of the arc that touches rho = R", "rad", "x_t")


def size_rate(reference: Group, law: Group) -> Expr:
    """Return mu' = w_3 of law (52), a first-order law with a rate limit."""
    rate = law.mu_gain * (reference.mu_ref - mu)
    return sp.Max(-law.mu_rate_max, sp.Min(law.mu_rate_max, rate))


def _saturate(x: Expr) -> Expr:
    return sp.Max(-1, sp.Min(1, x))


def _shape_rate(radial: Expr, transverse: Expr, shifted: ShiftedState) -> tuple[Expr, Expr]:
    """Convert rho~' and rho~ phi~' to zeta' = -w' exp(i phi_f), the derivative of (25)."""
    w_rate = rotate((radial, transverse), shifted.cosine, shifted.sine)
    along, across = rotate(w_rate, sp.cos(shifted.target_phi), sp.sin(shifted.target_phi))
    return -along, -across
