# SPDX-License-Identifier: Apache-2.0
"""The paper's shape and attitude of the dynamic triangle, from rod lengths and the direction of rod 3."""

from __future__ import annotations

import sympy as sp

from ...system import Derivation, Expr, Group
from ..dynamics import (
    LENGTHS,
    MU,
    RATES,
    THETA,
    ZETA1,
    ZETA2,
    BaseTriangle,
    complement_squared,
    regular_shape,
    rod_rates,
    stretch,
    zeta,
)
from .states import COSTS, DRIFT, HEADING, lengths


def shape_and_attitude(base: BaseTriangle, d: Derivation) -> sp.Matrix:
    """Define the paper's states zeta, mu and theta from the rods; return S."""
    z1, z2, _, margin = regular_shape(lengths, base, d, "")
    n = sp.sqrt(complement_squared(margin))
    for quantity, z in ((ZETA1, z1), (ZETA2, z2)):
        d.define(quantity.name, z / n, "(19)", quantity.description, latex=quantity.latex)
    stretched = stretch(d)
    theta = HEADING.symbol - _tilt(stretched)
    d.define(THETA.name, theta, title=THETA.description, unit="rad", latex=THETA.latex)
    return stretched


def _tilt(stretched: sp.Matrix) -> Expr:
    """Return the direction of rod 3 from the attitude, S d_3: edge 3 of the base triangle lies along x."""
    return sp.atan2(stretched[1, 0], stretched[0, 0])


def rates_of_shape(from_shape: tuple[Expr, ...], d: Derivation) -> tuple[Expr, ...]:
    """Return the rates of the rods (22) from the rates of zeta and mu."""
    aside = Derivation(d.steps)
    here = dict(zip(from_shape, lengths, strict=True))
    return tuple(aside.definitions[rate].xreplace(here) for rate in rod_rates(from_shape, aside))


def polar() -> tuple[Expr, Expr]:
    """Return rho and phi."""
    return sp.sqrt(zeta.dot(zeta)), sp.atan2(zeta[1], zeta[0])


def first_state(s: Group, start: tuple[Expr, ...]) -> tuple[Expr, ...]:
    """Return the initial state: the scenario's rods and attitude, and zero work of the thrust."""
    rho, phi, size, _ = start
    aside = Derivation()
    stretched = stretch(aside)
    shape = {zeta[0]: rho * sp.cos(phi), zeta[1]: rho * sp.sin(phi), MU.symbol: size}
    tilt = _tilt(stretched).subs(aside.definitions).subs(shape, simultaneous=True)
    lengths_0, rates_0 = ((getattr(s, f"{q.name}_0") for q in group) for group in (LENGTHS, RATES))
    return (*lengths_0, s.theta_0 + tilt, *rates_0, s.H_0, s.nu_0, *(sp.S.Zero for _ in (*DRIFT, *COSTS)))
