# SPDX-License-Identifier: Apache-2.0
"""Bob on a ball joint, described by the arm's direction s: an extension of the paper without singularity.

The bob does not spin about its arm, so its rotational energy is I/2 |sigma|^2 with the inertial rate sigma = s' +
Omega x s. T depends only on s and sigma and needs no chart. The dissipation R = eps/2 |s'|^2 = eps/2 (phi'^2 + sin^2
phi theta'^2) depends on motion relative to the hull. Unlike eps/2 (phi'^2 + theta'^2) of (8), it ignores rotation of
the arm about itself. With I = 0 and eps = 0 all three conventions agree.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence

import sympy as sp

from ...mechanics import kirchhoff, lagrange
from ...system import Expr
from ..states import Pendulum, arm_rate_quantities, direction_quantities, rate, rod, velocity
from .pendulum import GENERIC, Contribution, frame_rates, galilean

direction = sp.Matrix(sp.symbols("s_{ix} s_{iy} s_{iz}", real=True))
"""Unit vector s from pivot to bob, in body axes."""
arm_rate = sp.Matrix(sp.symbols(r"\sigma_{ix} \sigma_{iy} \sigma_{iz}", real=True))
"""Inertial rate sigma = s' + Omega x s, with sigma.s = 0."""
arm_acceleration = sp.Matrix(sp.symbols(r"\dot{\sigma}_{ix} \dot{\sigma}_{iy} \dot{\sigma}_{iz}", real=True))
"""Components of sigma'."""
_slip = sp.Matrix(sp.symbols(r"\dot{s}_{ix} \dot{s}_{iy} \dot{s}_{iz}", real=True))
_slip_rate = sp.Matrix(sp.symbols(r"\ddot{s}_{ix} \ddot{s}_{iy} \ddot{s}_{iz}", real=True))


@functools.cache
def contribution() -> Contribution:
    """Derive a pendulum's contribution by (1)-(3) with Cartesian s, without the multiplier of |s| = 1.

    Returns
    -------
    Contribution
        `rows` are the left sides of the three equations row = lambda s.
    """
    m, length = GENERIC.mass, GENERIC.length
    pivot = sp.Matrix([GENERIC.pivot, 0, 0])
    position = pivot + length * direction
    turning = _slip + rate.cross(direction)
    bob = velocity + rate.cross(pivot) + length * turning
    energy = m * bob.dot(bob) / 2 + GENERIC.inertia * turning.dot(turning) / 2
    dissipation = GENERIC.damping * _slip.dot(_slip) / 2
    rates = dict(zip((*direction, *_slip), (*_slip, *_slip_rate), strict=True)) | frame_rates()
    force, moment = kirchhoff(energy, velocity, rate, rates)
    rows = lagrange(energy, dissipation, tuple(direction), tuple(_slip), rates)
    linear = sp.Matrix([energy.diff(v) for v in velocity])
    angular = sp.Matrix([energy.diff(w) for w in rate])
    absolute = (e.applyfunc(_absolute) for e in (linear, angular))
    left = (galilean(e.applyfunc(_absolute)) for e in (force, moment, rows))
    return Contribution(_absolute(energy), _absolute(dissipation), position, *absolute, *left)


def _absolute(expr: Expr) -> Expr:
    """Express s' and s'' by sigma and sigma'."""
    turns = frame_rates()
    slip = arm_rate - rate.cross(direction)
    angular = sp.Matrix([turns[w] for w in rate])
    slip_rate = arm_acceleration - angular.cross(direction) - rate.cross(slip)
    return expr.xreplace(dict(zip((*_slip, *_slip_rate), (*slip, *slip_rate), strict=True)))


def tangential_rows() -> sp.Matrix:
    """Return the equations of s without multiplier: s x row = 0 across s, D (sigma.s)' = 0 along it, N m."""
    row = contribution().rows
    inertia = row[0].diff(arm_acceleration[0])
    slip = arm_rate - rate.cross(direction)
    constraint = arm_acceleration.dot(direction) + arm_rate.dot(slip)
    return direction.cross(row) + direction * (inertia * constraint)


@functools.cache
def arm_equation() -> sp.Matrix:
    """Return sigma' for given a and Omega', as (25), (26) do for angles.

    row = D sigma' + rest = lambda s, and (sigma.s)' = 0 gives lambda.
    """
    row = contribution().rows
    inertia = row[0].diff(arm_acceleration[0])
    rest = row.xreplace(dict.fromkeys(arm_acceleration, sp.S.Zero)) / inertia
    slip = arm_rate - rate.cross(direction)
    return -rest + direction * (direction.dot(rest) - arm_rate.dot(slip))


def instance(pendulum: Pendulum, k: int) -> dict[sp.Symbol, Expr]:
    """Return the values of the generic symbols for pendulum k."""
    generic = (GENERIC.mass, GENERIC.length, GENERIC.pivot, GENERIC.inertia, GENERIC.damping)
    values = (pendulum.mass, pendulum.length, pendulum.pivot, pendulum.inertia, pendulum.damping)
    states = (*direction_quantities(k), *arm_rate_quantities(k))
    named = dict(zip((*direction, *arm_rate), (q.symbol for q in states), strict=True))
    return dict(zip(generic, values, strict=True)) | named


def at_angles(phi: Expr, theta: Expr, rates: Sequence[Expr], turning: Sequence[Expr]) -> tuple[Expr, ...]:
    """Return s and sigma of a bob from its angles (7), angle rates and body rates."""
    angles = sp.symbols("phi theta", real=True)
    s = rod(*angles)
    slip = s.diff(angles[0]) * rates[0] + s.diff(angles[1]) * rates[1]
    sigma = slip + sp.Matrix(turning).cross(s)
    here = dict(zip(angles, (phi, theta), strict=True))
    return (*s.xreplace(here), *sigma.xreplace(here))
