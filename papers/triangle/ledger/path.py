# SPDX-License-Identifier: Apache-2.0
"""The second design of the triangle's paper: equations (40)-(51), as printed."""

from __future__ import annotations

from collections.abc import Iterator

import sympy as sp

from mehvar.ledger import Printed, Relation, printed

from .laws import Path, Shifted


def arcs(t: Shifted, p: Path) -> Iterator[Printed]:
    """(40)-(44): the arc to the target."""
    yield printed(
        "40",
        "the arc goes through the current point and the target and removes the attitude error",
        "condition",
        Relation(p.rho, p.A * sp.cos(p.phi - p.phi_star), cases=p.sides),
        Relation(sp.S.Zero, p.A * sp.cos(p.phi_end - p.phi_star), cases=p.sides),
        Relation(
            0 - p.theta,
            sp.Integral((p.A * sp.cos(t.phi - p.phi_star)) ** 2, (t.phi, p.phi, p.phi_end)),
            cases=p.sides,
        ),
        note="These conditions determine A, phi* and phi~_f; rho~ under the integral is the arc's.",
    )
    xi, alpha = p.xi, p.alpha
    turned = tuple({**side, p.phi_star: p.phi - side[alpha] * xi / 2} for side in p.sides)
    opening = 2 * (p.phi_end - p.phi_star)
    bracket = opening + alpha * xi + alpha * sp.sin(xi)
    scale = p.A**2 / 4
    yield (
        printed("text before (41)", "definition of xi and alpha", "definition")
        .reading(
            "alpha = sgn(theta~_1), phi* - phi~_1 = alpha xi/2",
            Relation(p.phi_star - p.phi, alpha * xi / 2, given=True),
            Relation(-p.theta, scale * bracket, cases=p.sides),
            why="The definitions are lost. With these (41) and (43) hold.",
        )
        .reading(
            "alpha = sgn(theta~_1), phi~_1 - phi* = alpha xi/2",
            Relation(-p.theta, scale * bracket, cases=turned),
            used=False,
            why="(41) fails.",
        )
    )
    misread = opening + t.a * xi + t.a * sp.sin(xi)
    ours = p.rho**2 / (2 * (1 + sp.cos(xi)))
    yield printed(
        "41",
        "attitude error that an arc removes",
        "equation",
        Relation(-p.theta, scale * misread, corrected=scale * bracket, cases=p.sides),
        Relation(-p.theta, ours * misread, corrected=ours * bracket, cases=p.sides),
        note="alpha is the sign of theta~_1.",
    )
    yield printed(
        "text after (41)",
        "direction in which the arc arrives",
        "equation",
        Relation(
            p.phi_star - p.phi_end,
            -alpha * sp.pi / 2,
            corrected_left=p.phi_end - p.phi_star,
            cases=p.sides,
        ),
        note="With the order that was read the arc would add to the attitude error.",
    )
    ratio = 2 * sp.Abs(p.theta) / p.rho**2
    yield printed(
        "42",
        "equation for xi",
        "equation",
        Relation((sp.pi - xi - sp.sin(xi)) / (1 + sp.cos(xi)), ratio, cases=p.sides),
        Relation((sp.pi - xi - sp.sin(xi)) / (1 + sp.cos(xi)), p.K, says="K of figure 7, as the model integrates it"),
    )
    yield printed(
        "text after (42)",
        "range of xi",
        "condition",
        Relation(sp.pi, xi, "<=", corrected_left=xi, corrected=sp.pi),
        Relation(xi, -sp.pi, "<", corrected_left=-sp.pi, corrected=xi),
        note="K falls from infinity to 0 where -pi < xi <= pi.",
    )
    yield printed(
        "43",
        "diameter and direction of the arc",
        "equation",
        Relation(p.A, p.rho / sp.cos(xi / 2), cases=p.sides),
        Relation(p.phi_star, p.phi + alpha * xi / 2, cases=p.sides),
    )
    yield (
        printed("44", "motion along the arc", "equation")
        .reading(
            "a chain: v_1 = -A alpha sin(...) v_2 = rho~_1 alpha tan(xi/2)",
            _along(p, t, -p.A * alpha * sp.sin(alpha * (p.phi - p.phi_star)) * t.v2),
            _along(p, t, p.rho * alpha * sp.tan(xi / 2), p.rho * alpha * sp.tan(xi / 2) * t.v2),
            why="The form of (46).",
        )
        .reading(
            "two equations: v_1 = -A alpha sin(...) and v_2 = rho~_1 alpha tan(xi/2)",
            _along(
                p,
                t,
                -p.A * alpha * sp.sin(alpha * (p.phi - p.phi_star)),
                -p.A * alpha * sp.sin(alpha * (p.phi - p.phi_star)) * t.v2,
            ),
            Relation(
                t.v2,
                p.rho * alpha * sp.tan(xi / 2),
                corrected_left=t.v1,
                corrected=p.rho * alpha * sp.tan(xi / 2) * t.v2,
                cases=tuple({**side, t.v1: p.arc_rate} for side in p.sides),
            ),
            used=False,
            why="As spaced in print; both fail.",
        )
    )


def _along(p: Path, t: Shifted, right: sp.Expr, corrected: sp.Expr | None = None) -> Relation:
    """Compare v_1 with the rate of the distance along the arc."""
    cases = tuple({**side, t.v1: p.arc_rate} for side in p.sides)
    return Relation(t.v1, right, corrected=corrected, cases=cases)


def law(t: Shifted, p: Path) -> Iterator[Printed]:
    """(45)-(47): the law and its limit."""
    xi, alpha = p.xi, p.alpha
    turn = -p.k_phi * alpha * sp.cos(xi / 2)
    yield printed("45", "turn", "definition", Relation(t.v2, turn, cases=p.driven))
    yield printed(
        "46",
        "the law",
        "equation",
        Relation(t.phi_dot, t.v2, cases=p.driven),
        Relation(t.v2, turn, cases=p.driven),
        Relation(t.rho_dot, t.v1, cases=p.driven),
        Relation(t.v1, -p.k_phi * p.rho * sp.sin(xi / 2), cases=p.driven),
        note="Compared with the law of the model without its escape from the origin, which the paper does not print.",
    )
    yield printed(
        "text before (47), tangency",
        "the largest arc touches rho = R",
        "statement",
        Relation(
            sp.sqrt(t.a**2 - t.a * p.A * sp.cos(p.phi_star) + p.A**2 / 4) + p.A / 2,
            p.R,
            cases=p.touching,
            domain=p.inside,
            says="largest rho on the circle of the arc that removes theta~_max",
        ),
    )
    measured = sp.Abs(p.theta)
    right = sp.Piecewise((p.theta_max, measured > p.theta_max), (measured, True))
    wrong = sp.Piecewise((p.theta_max, measured < p.theta_max), (measured, True))
    yield printed(
        "text before (47)",
        "when the limit acts",
        "condition",
        Relation(p.theta_a, wrong, corrected=right, cases=p.limited, domain=p.inside),
        note="(47) has the minimum of both.",
    )
    yield printed(
        "47",
        "attitude error that an arc inside rho = R can remove",
        "definition",
        Relation(p.theta_a, sp.Min(measured, p.theta_max), cases=p.limited, domain=p.inside),
        Relation(
            (sp.pi - xi - sp.sin(xi)) / (1 + sp.cos(xi)),
            2 * p.theta_a / p.rho**2,
            cases=p.limited,
            domain=p.inside,
        ),
        note="The paper gives no formula for theta~_max; it is that of the arc which touches rho = R. The model "
        "takes the smaller of the two angles between chord and arc, which is the same.",
    )


def stability(t: Shifted, p: Path) -> Iterator[Printed]:
    """(48)-(51): the attitude error falls, and with it the distance."""
    second = -p.k_phi * t.rho**2 * sp.Abs(t.theta)
    xi, alpha = p.xi, p.alpha
    first = -p.k_phi * t.rho**2 * alpha * t.theta
    cases = p.anywhere
    factor = sp.cos(xi / 2)
    yield printed(
        "48",
        "rate of V = theta~^2/2",
        "equation",
        Relation(p.V_dot, t.theta * t.theta_dot, cases=cases),
        Relation(p.V_dot, t.rho**2 * t.phi_dot * t.theta, cases=cases),
        Relation(p.V_dot, first, corrected=first * factor, cases=cases),
        Relation(p.V_dot, second, corrected=second * factor, cases=cases),
        Relation(p.V_dot, sp.S.Zero, "<=", cases=cases),
    )
    at_origin = tuple({**case, t.theta: p.size, t.rho: sp.S.Zero} for case in cases)
    no_error = tuple({**case, t.theta: sp.S.Zero} for case in cases)
    yield printed(
        "49",
        "where V does not fall",
        "equation",
        Relation(p.V_dot, sp.S.Zero, cases=at_origin, says="at rho~ = 0"),
        Relation(p.V_dot, sp.S.Zero, cases=no_error, says="at theta~ = 0"),
        Relation(p.V_dot, sp.S.Zero, "<", cases=cases, says="elsewhere: rho~ > 0 and theta~ not 0, so |xi| < pi"),
    )
    left = (sp.pi - xi - sp.sin(xi)) / (1 + sp.cos(xi))
    ratio = 2 * sp.Abs(t.theta) / t.rho**2
    some_error = ({t.theta: p.size},)
    yield printed(
        "50",
        "the target is not reached before the attitude",
        "equation",
        Relation(sp.Limit(ratio, t.rho, 0), sp.oo, cases=some_error),
        Relation(sp.Limit(left, xi, -sp.pi, "+"), sp.oo),
        Relation(sp.Derivative(left, xi), sp.S.Zero, "<", says="K falls with xi, so K to infinity is xi to -pi"),
        Relation(t.rho_dot, -p.k_phi * t.rho * sp.sin(xi / 2), cases=cases),
        Relation(-p.k_phi * t.rho * sp.sin(xi / 2), sp.S.Zero, ">", domain=(-xi,), says="for xi below 0"),
        note="The sentence before it prints theta~ where rho~ = 0 is meant. A start at rho~ = 0 is left to the "
        "reader: the state must leave the origin somehow.",
    )
    size_given = tuple({**case, t.theta: p.size} for case in cases)
    yield printed(
        "51",
        "the target is reached with the attitude",
        "equation",
        Relation(sp.Limit(ratio, t.theta, 0), sp.S.Zero),
        Relation(sp.Limit(left, xi, sp.pi, "-"), sp.S.Zero),
        Relation(sp.Limit(sp.sin(xi / 2), xi, sp.pi), sp.S.One),
        Relation(sp.Limit(t.rho_dot, xi, sp.pi, "-"), -p.k_phi * t.rho, cases=size_given),
    )
