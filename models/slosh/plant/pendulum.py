# SPDX-License-Identifier: Apache-2.0
"""One spherical pendulum in angles, (5)-(8), and its terms in (9)-(16), in generic symbols.

The bob hangs at phi from -x with azimuth theta, from z towards y. Its inertia term is a modelling choice: `paper`
uses the rates (phi', 0, theta') relative to the body, as of two rotors geared to the angles; `hinge` uses the angular
velocity of the arm.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass

import sympy as sp

from ...mechanics import expanded, gradient, kirchhoff, lagrange, matrix_rate
from ...system import Expr, ModelError
from ..states import Pendulum, angle_quantities, angle_rate_quantities, rate, rod, velocity

_NAMES = ("m_i", "l_i", "h_i", "I_i", r"\varepsilon_{i}")
GENERIC = Pendulum("i", *(sp.Symbol(name, real=True) for name in _NAMES))
"""A pendulum with symbolic parameters."""
phi, theta = sp.symbols(r"\varphi_{i} \theta_{i}", real=True)
phi_rate, theta_rate = sp.symbols(r"\dot{\varphi}_{i} \dot{\theta}_{i}", real=True)
acceleration = sp.Matrix(sp.symbols("a_x a_y a_z", real=True))
"""Acceleration of O in body axes, a = V' + Omega x V (17)."""
angular_acceleration = sp.Matrix(sp.symbols("alpha_x alpha_y alpha_z", real=True))
angle_acceleration = sp.symbols(r"\ddot{\varphi}_{i} \ddot{\theta}_{i}", real=True)


@dataclass(frozen=True)
class Contribution:
    """Contribution of one pendulum to energy, momentum and the equations of motion, in generic symbols.

    Attributes
    ----------
    energy, dissipation : Expr
        Its term of (5), J, and of (8), W.
    position : sympy.Matrix
        Of the bob (7), m.
    linear, angular : sympy.Matrix
        dT/dV, kg m/s, and dT/dOmega about O, kg m^2/s.
    force, moment : sympy.Matrix
        Its terms of (9)-(11), N, and (12)-(14), N m.
    rows : sympy.Matrix
        Left sides of (15) and (16), N m.
    """

    energy: Expr
    dissipation: Expr
    position: sp.Matrix
    linear: sp.Matrix
    angular: sp.Matrix
    force: sp.Matrix
    moment: sp.Matrix
    rows: sp.Matrix


@functools.cache
def contribution(inertia: str) -> Contribution:
    """Derive one pendulum's contribution by (1)-(3) from its energy.

    Parameters
    ----------
    inertia : {"paper", "hinge"}
        Convention of its inertia term.

    Raises
    ------
    ModelError
        If V remains in the equations; with a = V' + Omega x V (17) it must cancel.
    """
    m, length, pivot = GENERIC.mass, GENERIC.length, GENERIC.pivot
    turning = {phi: phi_rate, theta: theta_rate}
    position = sp.Matrix([pivot, 0, 0]) + length * rod(phi, theta)
    bob = velocity + rate.cross(position) + matrix_rate(position, turning)
    spin = rate + _own_rate(inertia)
    energy = m * bob.dot(bob) / 2 + GENERIC.inertia * spin.dot(spin) / 2
    dissipation = GENERIC.damping * (phi_rate**2 + theta_rate**2) / 2
    rates = turning | dict(zip((phi_rate, theta_rate), angle_acceleration, strict=True)) | frame_rates()
    force, moment = kirchhoff(energy, velocity, rate, rates)
    rows = lagrange(energy, dissipation, (phi, theta), (phi_rate, theta_rate), rates)
    linear, angular = (sp.Matrix(gradient(energy, group)) for group in (velocity, rate))
    return Contribution(
        energy, dissipation, position, linear, angular, galilean(force), galilean(moment), galilean(rows)
    )


def _own_rate(inertia: str) -> sp.Matrix:
    """Return omega_i of (5): the paper's, or that of an arm on hinges about -x and the rotated y axis."""
    if inertia == "paper":
        return sp.Matrix([phi_rate, 0, theta_rate])
    return phi_rate * sp.Matrix([0, sp.cos(theta), -sp.sin(theta)]) - theta_rate * sp.Matrix([1, 0, 0])


def frame_rates() -> dict[sp.Symbol, Expr]:
    """Return V' and Omega' from the accelerations of O (17) and of the axes."""
    linear = acceleration - rate.cross(velocity)
    return dict(zip((*velocity, *rate), (*linear, *angular_acceleration), strict=True))


def galilean(left: sp.Matrix) -> sp.Matrix:
    """Expand the left sides of the equations of motion, and check that they do not contain the velocity of O."""
    terms = left.applyfunc(expanded)
    if terms.free_symbols.intersection(velocity):
        raise ModelError("the equations of motion contain the velocity of O, so they are not Galilean")
    return terms


def instance(pendulum: Pendulum, k: int) -> dict[sp.Symbol, Expr]:
    """Return the values of the generic symbols for pendulum k."""
    values = (pendulum.mass, pendulum.length, pendulum.pivot, pendulum.inertia, pendulum.damping)
    generic = (GENERIC.mass, GENERIC.length, GENERIC.pivot, GENERIC.inertia, GENERIC.damping)
    states = (*angle_quantities(k), *angle_rate_quantities(k))
    named = dict(zip((phi, theta, phi_rate, theta_rate), (q.symbol for q in states), strict=True))
    return dict(zip(generic, values, strict=True)) | named
