# SPDX-License-Identifier: Apache-2.0
"""Shifted coordinates and the first design of the triangle's paper: equations (24)-(39), as printed."""

from __future__ import annotations

from collections.abc import Iterator

import sympy as sp

from mehvar.ledger import Printed, Relation, printed

from .laws import Shifted, Sliding
from .symbols import Kinematics

HALF = sp.Rational(1, 2)


def shift(k: Kinematics, t: Shifted) -> Iterator[Printed]:
    """(24)-(27): the target becomes the origin."""
    yield printed(
        "24",
        "system to be controlled",
        "equation",
        Relation(k.rho_dot, k.w1),
        Relation(k.phi_dot, k.w2),
        Relation(k.theta_dot, k.rho**2 * k.w2, cases=(k.still,)),
        Relation(k.rho**2, HALF, "<", given=True),
    )
    chart = (t.chart,)
    yield printed(
        "25",
        "distance and direction of the target",
        "definition",
        Relation(-t.rho * sp.cos(t.phi + t.phi_f), k.rho * sp.cos(k.phi) - t.a * sp.cos(t.phi_f), cases=chart),
        Relation(-t.rho * sp.sin(t.phi + t.phi_f), k.rho * sp.sin(k.phi) - t.a * sp.sin(t.phi_f), cases=chart),
        note="rho_f is written a here, as the paper does from (26) on.",
    )
    moved = t.rho**2 - 2 * t.a * t.rho * sp.cos(t.phi) + t.a**2
    yield printed(
        "26",
        "equations of motion in the shifted coordinates",
        "equation",
        Relation(t.rho_dot, t.v1, cases=chart),
        Relation(t.phi_dot, t.v2, cases=chart),
        Relation(t.theta_dot, t.rho**2 * t.v2, cases=chart),
        Relation(moved, HALF, "<", given=True),
        Relation(moved, k.rho**2, cases=chart, says="the left side of the inequality is rho^2"),
    )
    rho_0, phi_0, theta_t0, theta_0 = t.start
    error = theta_0 - t.theta_f
    yield printed(
        "27",
        "initial shifted attitude",
        "equation",
        Relation(
            theta_t0,
            error + t.a * rho_0 * sp.sin(phi_0) / 2,
            corrected=error + t.a * rho_0 * sp.sin(phi_0),
            cases=chart,
        ),
        note="The formula holds at every instant.",
    )


def surface(k: Kinematics, t: Shifted, s: Sliding) -> Iterator[Printed]:
    """(28)-(33): the circle rho = R and the sliding surface."""
    yield (
        printed("text before (28)", "radius of the largest circle", "condition")
        .reading(
            "rho = R < sqrt(2)/2",
            Relation(
                s.R,
                sp.sqrt(2) / 2,
                "<",
                says="R of the paper's runs is below sqrt(2)/2",
                cases=({s.R: s.R_run},),
            ),
            why="R is a free choice inside the disc, as the sentence before (47) prints it.",
        )
        .reading(
            "rho = R sqrt(2)/2",
            Relation(k.rho, s.R * sp.sqrt(2) / 2, cases=({k.rho: s.R},)),
            used=False,
            why="As the characters stand, twice in one sentence; it contradicts (28), whose circle is rho = R.",
        )
    )
    root = sp.sqrt(s.R**2 - t.a**2 * sp.sin(t.phi) ** 2)
    along = t.a * sp.cos(t.phi)
    yield printed(
        "28",
        "the circle rho = R seen from the target",
        "equation",
        Relation(t.rho, along + root, cases=(s.on_circle,)),
    )
    yield printed(
        "29",
        "the surface for the smallest and the largest attitude error",
        "definition",
        Relation(s.s, t.rho, cases=({t.theta: sp.S.Zero},)),
        Relation(s.s, t.rho - (along + root), cases=({t.theta: s.theta_star}, {t.theta: -s.theta_star})),
        note="The paper adds = 0 to both: that is the surface.",
    )
    misread = sp.sqrt(s.R**2 + t.a**2 * sp.sin(t.phi) ** 2)
    alone = Relation(s.s, t.rho - (along + misread), corrected=t.rho - (along + root) * s.f)
    minus = Relation(s.s, t.rho - (along + misread) * s.f, corrected=t.rho - (along + root) * s.f)
    yield (
        printed("30", "the sliding variable", "definition")
        .reading(
            "one formula over two lines: s = rho~ - (...) f = 0",
            minus,
            why="The only one with the two ends (29); the line breaks before f. Only the sign under the root "
            "is wrong; (28) and (32) have the minus.",
        )
        .reading(
            "two formulas: s = rho~ - (...), and f = 0",
            alone,
            used=False,
            why="Without f the surface would not depend on the attitude.",
        )
    )
    tau = sp.Abs(t.theta / s.theta_star)
    yield printed("31", "size of the surface's circle", "definition", Relation(s.f, tau ** (1 / s.m)))
    drift = s.g - t.rho**2 / (s.m * t.theta)
    slope = t.a * sp.sin(t.phi) / root
    yield printed(
        "32",
        "rate of the sliding variable",
        "equation",
        Relation(s.s, t.rho - s.f * s.h),
        Relation(s.s_dot, t.rho_dot + s.f * s.h * drift * t.phi_dot),
        Relation(s.h, along + root),
        Relation(s.h, slope, corrected_left=s.g),
    )
    yield printed(
        "33",
        "motion along the surface",
        "equation",
        Relation(t.rho_dot, -s.f * s.h * drift * t.phi_dot, cases=(s.on_surface,)),
    )


def control(t: Shifted, s: Sliding) -> Iterator[Printed]:
    """(34)-(37): the law."""
    driven = (s.driven,)
    reach = -s.eta * sp.sign(s.s)
    drift = s.g - t.rho**2 / (s.m * t.theta)
    yield printed(
        "34",
        "the law by its equivalent rates",
        "definition",
        Relation(t.phi_dot, s.phi_eq, cases=driven),
        Relation(t.rho_dot, s.rho_eq + reach, cases=driven),
        Relation(s.rho_eq, -s.f * s.h * drift * s.phi_eq),
        note="Compared with the law of the model, its smoothed signs made sharp.",
    )
    spiral = s.f * s.h * drift * t.phi_dot
    yield printed(
        "35",
        "the surface is reached in finite time",
        "equation",
        Relation(s.s_dot, spiral, corrected=t.rho_dot + spiral, cases=driven),
        Relation(s.s_dot, reach, cases=driven),
    )
    yield printed(
        "text before (36), rate of the attitude",
        "attitude follows the turn",
        "equation",
        Relation(
            t.phi_dot,
            t.rho**2 * t.theta_dot,
            corrected_left=t.theta_dot,
            corrected=t.rho**2 * t.phi_dot,
        ),
        note="They are exchanged in the sentence before (37) too. For the same reason the condition for convergence "
        "is phi~' sgn(theta~) < 0: the dot is missing.",
    )
    yield printed(
        "text before (36), slope of f",
        "slope of f",
        "equation",
        Relation(s.f_slope, s.f ** (s.m - 1), corrected=s.f ** (1 - s.m) / (s.m * s.theta_star)),
        note="f' grows without bound at zero; that is why phi~' is made proportional to f^(m - 1).",
    )
    side = sp.sign(t.theta)
    turn = Relation(s.phi_eq, -s.sigma * s.f ** (s.m - 1) * side)
    closed = s.sigma * s.h / s.theta_star * (s.g * t.theta - t.rho**2 / s.m)
    tau = sp.Abs(t.theta / s.theta_star)
    equivalent = (
        Relation(s.rho_eq, s.sigma * s.h * tau * side * drift),
        Relation(s.rho_eq, closed),
    )
    yield (
        printed("36", "equivalent rates", "definition", note="The model's law has the last, smooth form.")
        .reading(
            "rho~' = rho~'_eq on the surface s = 0",
            turn,
            Relation(t.rho_dot, s.rho_eq, cases=({**s.driven, t.rho: s.f * s.h},)),
            *equivalent,
            why="There the term with eta_rho of (34) vanishes.",
        )
        .reading(
            "rho~' = rho~'_eq everywhere",
            turn,
            Relation(t.rho_dot, s.rho_eq, corrected=s.rho_eq + reach, cases=driven),
            *equivalent,
            used=False,
            why="This would omit the term with eta_rho of (34).",
        )
    )
    yield printed(
        "text after (36)",
        "what rho~' is made of",
        "statement",
        Relation(
            s.rho_eq,
            s.h * (s.g * side * (s.f**s.m * s.sigma) - s.sigma**2 * t.rho / (s.m * s.theta_star)),
            corrected=s.h * (s.g * side * (s.f**s.m * s.sigma) - s.sigma * t.rho**2 / (s.m * s.theta_star)),
            says="bounded terms f^m sigma and sigma^2 rho~ make rho~' bounded",
        ),
        note="The sentence names rho~' and phi~' the other way round.",
    )
    ratio = t.rho / s.h
    yield printed(
        "text before (37)",
        "f on the surface",
        "equation",
        Relation(s.h, ratio, corrected_left=s.f, cases=({t.rho: s.f * s.h},), says="on s = 0"),
    )
    yield printed(
        "37",
        "speed of the turn",
        "definition",
        Relation(s.sigma, s.k_phi * sp.sqrt(ratio) / (s.f**s.m + ratio**2)),
    )


def bound(k: Kinematics, t: Shifted, s: Sliding) -> Iterator[Printed]:
    """(38), (39): the state stays inside rho = R."""
    inside = (s.theta_star - sp.Abs(t.theta),)
    yield printed(
        "text before (38)",
        "on the circle rho~ = h",
        "equation",
        Relation(s.s, sp.S.Zero, ">", cases=(s.on_circle,), domain=inside),
        Relation(s.sigma, s.k_phi / (1 + s.f**s.m), cases=(s.on_circle,)),
    )
    leaving = t.rho_dot - s.h_dot
    circle = ({**s.driven, t.rho: s.h},)

    def on_circle(right: sp.Expr, corrected: sp.Expr | None = None, op: str = "=") -> Relation:
        return Relation(leaving, right, op, corrected=corrected, cases=circle, domain=inside)  # type: ignore[arg-type]

    last = s.h**3 / (s.theta_star * (1 + s.f**s.m))
    rises = s.m * s.f ** (s.m - 1) * (1 - s.f)
    factor = rises / (1 + s.f**s.m)
    side = sp.sign(t.theta)
    fourth = s.k_phi / s.m * (-factor * s.g * s.h * side - last) - s.eta
    third_right = -s.sigma * s.h / s.m * (rises * s.g * side + s.h**2 / s.theta_star) - s.eta
    third = -s.sigma * s.h / s.m * (rises * s.g * sp.sign(k.theta) + s.h**2 / s.theta_star) - s.eta
    grouped = (
        s.h
        * ((1 - s.f) * s.g + s.f * s.h**2 / (s.m * s.f**s.m * s.theta_star * side))
        * (-s.sigma * s.f ** (s.m - 1) * side)
        - s.eta
    )
    drift = s.g - t.rho**2 / (s.m * t.theta)
    steps = -s.f * s.h * drift * s.phi_eq - s.eta * sp.sign(s.s) + s.g * s.h * t.phi_dot
    yield printed(
        "38",
        "motion across the circle",
        "equation",
        on_circle(steps),
        on_circle(grouped),
        on_circle(third, third_right),
        on_circle(fourth),
        note="For |theta~| < theta*, where f < 1.",
    )
    yield printed(
        "text before (39)",
        "bounds of the factors",
        "equation",
        Relation(factor, HALF, "<=", domain=inside),
        Relation(s.h, sp.S.Zero, ">"),
        Relation(sp.Abs(s.g) * s.h, 2 * s.R, "<", domain=(s.R - t.a,)),
        note="The second bound is printed for |h|; (39) uses |g| h, and both are below 2R. They vary with phi~, "
        "printed theta~.",
    )
    largest = s.k_phi / s.m * (factor * sp.Abs(s.g) * s.h - last) - s.eta
    yield printed(
        "39",
        "the bound of the motion outwards",
        "equation",
        on_circle(largest, op="<="),
        on_circle(s.k_phi / s.m * (HALF * 2 * s.R - 0) - s.eta, op="<"),
        on_circle(s.k_phi * s.R / s.m - s.eta, op="<"),
        note="Hence eta_rho >= k_phi R/m keeps rho~ below h, and rho below R.",
    )
