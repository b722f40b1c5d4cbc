# SPDX-License-Identifier: Apache-2.0
"""Monitors of the assumptions in the proofs of the Lyapunov laws, evaluated along a run.

The proofs differentiate V along the reduced model: accelerations equal their demands, a_x is F over the mass, and the
attitude angles have the body rates as their rates. Then V' is the one that (30) promises. Here V is differentiated
along the full craft.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import sympy as sp

from ...mechanics import angle_rates, frame_turn
from ...system import Derivation, Expr, Group, Output, Quantity
from ..laws.controllers import Law
from ..states import rate, velocity
from .dynamics import Craft, slip_of
from .tanks import Fuel

V_DOT = Quantity("V_dot", "1/s", "rate of the Lyapunov function along the craft")
PROMISE = Quantity("V_promise", "1/s", "rate of the Lyapunov function that the proof promises, (30)")
REST = Quantity("V_rest", "1/s", "A of (29): the part of that rate that no input makes negative")
UNMET = Quantity("unmet", "m/s^2", "demanded lateral acceleration that does not come about")
UNTURNED = Quantity("unturned", "rad/s^2", "demanded angular acceleration that does not come about")
SKEW = Quantity("att_skew", "rad/s", "rates of the attitude angles less the body rates")


def monitors(
    law: Law,
    c: Group,
    command: Sequence[Expr],
    tag: str,
    craft: Craft,
    fuel: Fuel,
    angles: Sequence[sp.Symbol],
    flow: Expr,
    d: Derivation,
) -> tuple[Output, ...]:
    """Return what a law reports of its proof.

    Parameters
    ----------
    law : Law
        V, its derivative (29), and the demand.
    c : Group
        Parameters of the law.
    command : sequence of Expr
        Its inputs.
    tag : str
        Appended to the names of definitions.
    craft : Craft
        Equations of motion.
    fuel : Fuel
        What the tanks hold.
    angles : sequence of Symbol
        Attitude angles.
    flow : Expr
        Rate of the burnt fuel.
    d : Derivation
        Receives the steps.
    """
    d.section(f"Assumptions of the proof of {tag.upper()}")
    real = craft.accelerations(command[:3], f"Y_{tag}", d)
    linear = sp.Matrix(real[:3]) - rate.cross(velocity)
    turned = frame_turn(0, angles[0]) * frame_turn(1, angles[1]) * frame_turn(2, angles[2])
    swept = tuple(angle_rates(turned, tuple(angles), rate))
    rates: dict[sp.Symbol, Expr] = dict(zip((*velocity, *rate, *angles), (*linear, *real[3:], *swept), strict=True))
    arms = craft.arm_rates(real)
    for k in range(1, len(fuel.tanks) + 1):
        turning, slip = sp.Matrix(arms[3 * k - 3 : 3 * k]), slip_of(k)
        s = [sp.Symbol(f"s{k}{axis}", real=True) for axis in "xyz"]
        sigma = [sp.Symbol(f"sigma{k}{axis}", real=True) for axis in "xyz"]
        rates |= dict(zip((*s, *sigma), (*slip, *turning), strict=True))
    rates[sp.Symbol("burnt", real=True)] = flow
    form, u = law.form, law.demand
    squares = c.w1 * form.B**2 + c.w2 * form.C**2 + c.w3 * rate[0] ** 2 + c.w4 * rate[1] ** 2 + c.w5 * rate[2] ** 2
    unmet = [real[k] - u[k - 1] for k in (1, 2)]
    unturned = [real[k + 3] - u[k + 2] for k in range(3)]
    skew = [a - w for a, w in zip(swept, rate, strict=True)]
    return (
        Output(V_DOT, along(law.value, rates, d.definitions), at_most=0.0),
        Output(PROMISE, form.A - squares),
        Output(REST, form.A, at_most=0.0),
        *(Output(q, _norm(entries)) for q, entries in ((UNMET, unmet), (UNTURNED, unturned), (SKEW, skew))),
    )


def along(value: Expr, rates: Mapping[sp.Symbol, Expr], definitions: Mapping[sp.Symbol, Expr]) -> Expr:
    """Return the rate of an expression, through the definitions in it."""
    known = dict(rates)

    def of(expr: Expr) -> Expr:
        total: Expr = sp.S.Zero
        for symbol in sorted(expr.free_symbols, key=str):
            if symbol not in known:
                known[symbol] = of(definitions[symbol]) if symbol in definitions else sp.S.Zero
            if known[symbol] is not sp.S.Zero:
                total += expr.diff(symbol) * known[symbol]
        return total

    return of(value)


def _norm(entries: Sequence[Expr]) -> Expr:
    return sp.sqrt(sp.Add(*(entry**2 for entry in entries)))
