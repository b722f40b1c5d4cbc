# SPDX-License-Identifier: Apache-2.0
"""Opening of section 3 of the triangle's paper: known forms of the equations, and Brockett's condition."""

from __future__ import annotations

from collections.abc import Iterator

import sympy as sp

from mehvar.ledger import Names, Printed, Relation, printed
from mehvar.mechanics import time_derivative

from .symbols import ROOT3, Kinematics


class Forms:
    """Coordinates x of the nonholonomic integrator and z of the chained form, with their rates along a motion."""

    def __init__(self, names: Names, k: Kinematics) -> None:
        self.scale = sp.sqrt(3 * ROOT3 / (2 * k.mu))
        p_1, p_2 = (names.meaning(p) for p in k.p[:2])
        x = (self.scale * p_1, self.scale * p_2)
        self.x, self.x_dot = _with_rates(names, k, "x", x)
        self.z, self.z_dot = _with_rates(names, k, "z", (k.phi, k.rho**2, k.theta))
        self.y, self.y_dot = _with_rates(names, k, "y", (x[1], 2 * x[0], k.theta + x[0] * x[1]))


def _with_rates(
    names: Names, k: Kinematics, letter: str, meanings: tuple[sp.Expr, ...]
) -> tuple[tuple[sp.Symbol, ...], tuple[sp.Symbol, ...]]:
    values = tuple(
        names.derived(f"form_{letter}{i}", f"{letter}_{i}", meaning, text=f"{letter}_{i}")
        for i, meaning in enumerate(meanings, 1)
    )
    rates = tuple(
        names.derived(f"form_{letter}{i}_dot", rf"\dot {letter}_{i}", time_derivative(meaning, k.motion))
        for i, meaning in enumerate(meanings, 1)
    )
    return values, rates


def forms(k: Kinematics, f: Forms) -> Iterator[Printed]:
    """Nonholonomic integrator, chained form, Brockett's condition."""
    (x_1, x_2), (x_1_dot, x_2_dot) = f.x, f.x_dot
    still = (k.still,)
    yield printed(
        "section 3, nonholonomic integrator",
        "row 2 of Table 1 is the nonholonomic integrator",
        "statement",
        Relation(x_1, f.scale * k.p[0], says="the change of variables, which the paper does not print"),
        Relation(x_2, f.scale * k.p[1]),
        Relation(k.theta_dot, x_1 * x_2_dot - x_2 * x_1_dot, cases=still),
        Relation(x_1**2 + x_2**2 + x_1 * x_2, ROOT3 / 2 * k.rho**2, says="its bound: an ellipse, by rho^2 < 1/2"),
        note="Known as Heisenberg's system too, as the abstract calls it. The change of size drops out.",
    )
    (z_1, z_2, z_3), (z_1_dot, z_2_dot, z_3_dot) = f.z, f.z_dot
    (y_1, y_2, y_3), (y_1_dot, _, y_3_dot) = f.y, f.y_dot
    yield printed(
        "section 3, chained form",
        "(23) becomes the chained form",
        "statement",
        Relation(z_1, k.phi),
        Relation(z_2, k.rho**2),
        Relation(z_3, k.theta),
        Relation(z_1_dot, k.w2, says="first input of the chain"),
        Relation(z_2_dot, 2 * k.rho * k.w1, says="second input, free to choose where rho > 0"),
        Relation(z_3_dot, z_2 * z_1_dot, cases=still),
        Relation(y_1, x_2),
        Relation(y_2, 2 * x_1),
        Relation(y_3, k.theta + x_1 * x_2, says="from the integrator, regular at rho = 0 too"),
        Relation(y_3_dot, y_2 * y_1_dot, cases=still),
    )
    resting = {k.theta_dot: k.rates[3].subs({k.w1: 0, k.w2: 0})}
    yield printed(
        "section 3, Brockett",
        "no smooth law that does not depend on time makes a target asymptotically stable",
        "statement",
        Relation(
            k.theta_dot,
            sp.S.Zero,
            cases=(resting,),
            says="theta' where rho' = phi' = 0, at any state and size rate",
        ),
        note="Rates (0, 0, 0, e) with e not 0 come from no state and no input, so the image of the right-hand side has "
        "no neighbourhood of 0, which Brockett's theorem asks for.",
    )
