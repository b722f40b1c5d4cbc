# SPDX-License-Identifier: Apache-2.0
"""The balances of momentum from which the equations with draining tanks are derived, and energy and momentum.

What is inside is hull, fuel in places, and fuel that flows through lines that hold none: w kg/s over the length Delta
have the momentum w Delta, and about O that of w at the line's middle. Fuel passes the gimbal with the velocity of the
gimbal; what its speed from there on gives is the thrust. So, about O,

    P' + Omega x P         = thrust - flow v_F + gravity,
    H' + Omega x H + V x P = moments + r_F x (thrust - flow v_F) + gravity,

where the masses of P and H change. A bob loses fuel that moves as the bob does, which does not push it: its own
equation is that of constant mass, with the length that changes.
"""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from ...mechanics import matrix_rate
from ...system import Derivation, Expr, Group
from ..plant.equations import gimbal_position
from ..plant.pendulum import acceleration, angular_acceleration, frame_rates
from ..states import RATE, VELOCITY, arm_rate_quantities, direction_quantities, rate, velocity
from .dynamics import control_moments, slip_of
from .gravity import Gradient
from .tanks import Fuel, Tank


@dataclass(frozen=True)
class Sum:
    """Sums over all that is inside.

    Attributes
    ----------
    energy : Expr
        Kinetic energy, without that of the flow in lines, J.
    linear, angular : sympy.Matrix
        P, kg m/s, and H about O, kg m^2/s.
    pull, twist : sympy.Matrix
        Of the gradient of gravity, N, and about O, N m.
    """

    energy: Expr
    linear: sp.Matrix
    angular: sp.Matrix
    pull: sp.Matrix
    twist: sp.Matrix


def sums(p: Group, fuel: Fuel, gravity: Gradient) -> Sum:
    """Add energy, momentum and gravity up, place by place."""
    still = sp.zeros(3, 1)
    gimbal = gimbal_position(p)
    places = [(p.m, sp.Matrix([-p.b, 0, 0]), still), (fuel.fixed.mass, sp.Matrix([-p.h0, 0, 0]), still)]
    flows = [(fuel.fixed.out, places[1][1])]
    for k, tank in enumerate(fuel.tanks, 1):
        s, _ = symbols(k)
        place = tank.pivot + tank.bob.length * s
        places.append((tank.bob.mass, place, tank.length_rate * s + tank.bob.length * slip_of(k)))
        flows.append((tank.fuel.out, place))
    own = sp.diag(*(j + fuel.fixed.inertia for j in (p.J_x, p.J_y, p.J_z)))
    energy, linear, angular = rate.dot(own * rate) / 2, still, own * rate
    pull, twist = still, gravity.turning(own)
    for mass, place, slip in places:
        moving = velocity + rate.cross(place) + slip
        energy += mass * moving.dot(moving) / 2
        linear += mass * moving
        angular += mass * place.cross(moving)
        pull += mass * gravity.of(place)
        twist += mass * place.cross(gravity.of(place))
    for k, tank in enumerate(fuel.tanks, 1):
        s, sigma = symbols(k)
        energy += tank.bob.inertia * sigma.dot(sigma) / 2
        angular += tank.bob.inertia * s.cross(sigma)
        twist += tank.bob.inertia * s.cross(gravity.of(s))
    for out, place in flows:
        linear += out * (gimbal - place)
        angular += out * place.cross(gimbal)
    return Sum(energy, linear, angular, pull, twist)


def residuals(
    p: Group, fuel: Fuel, thrust: sp.Matrix, gravity: Gradient, whole: Sum
) -> tuple[dict[str, sp.Symbol], tuple[Expr, ...]]:
    """Return the derived equations as residuals that the true rates of the states make zero.

    Parameters
    ----------
    p : Group
        Parameters of the plant.
    fuel : Fuel
        What the tanks hold.
    thrust : sympy.Matrix
        N.
    gravity : Gradient
        In body axes.
    whole : Sum
        Of momentum and gravity.
    """
    moving = [q.name for q in (*VELOCITY, *RATE)]
    moving += [q.name for k in range(1, len(fuel.tanks) + 1) for q in arm_rate_quantities(k)]
    own = {name: sp.Symbol(f"{name}_rate", real=True) for name in moving}
    rates = frame_rates() | _fuel_rates(fuel)
    rows: list[Expr] = []
    for k, tank in enumerate(fuel.tanks, 1):
        _, sigma = symbols(k)
        rates |= dict(zip(symbols(k)[0], slip_of(k), strict=True))
        rates |= {entry: own[entry.name] for entry in sigma}
        rows += list(_bob(tank, k, gravity, rates))
    gimbal = gimbal_position(p)
    leaving = thrust - p.flow * (velocity + rate.cross(gimbal))
    force = matrix_rate(whole.linear, rates) + rate.cross(whole.linear) - leaving - whole.pull
    moment = matrix_rate(whole.angular, rates) + rate.cross(whole.angular) + velocity.cross(whole.linear)
    moment -= sp.Matrix(control_moments()) + gimbal.cross(leaving) + whole.twist
    spelled = sp.Matrix([own[q.name] for q in VELOCITY]) + rate.cross(velocity)
    known = dict(zip(acceleration, spelled, strict=True))
    known |= dict(zip(angular_acceleration, (own[q.name] for q in RATE), strict=True))
    return own, tuple(entry.xreplace(known) for entry in (*force, *moment, *rows))


def show(p: Group, fuel: Fuel, thrust: sp.Matrix, whole: Sum, d: Derivation) -> None:
    """Write the balances down."""
    d.section("Balances of momentum with draining tanks")
    for axis, entry in zip("xyz", whole.linear, strict=True):
        d.show(f"P_{axis}", entry, "", f"momentum of all that is inside, body {axis}", "kg m/s")
    for axis, entry in zip("xyz", whole.angular, strict=True):
        d.show(f"H_{axis}", entry, "", f"its angular momentum about O, body {axis}", "kg m^2/s")
    gimbal = gimbal_position(p)
    leaving = thrust - p.flow * (velocity + rate.cross(gimbal))
    for axis, entry in zip("xyz", leaving, strict=True):
        d.show(rf"(\dot P + \Omega\times P)_{axis}", entry, "", f"thrust less what passes the gimbal, body {axis}", "N")


def symbols(k: int) -> tuple[sp.Matrix, sp.Matrix]:
    """Return s and sigma of bob k."""
    s, sigma = (sp.Matrix([q.symbol for q in group(k)]) for group in (direction_quantities, arm_rate_quantities))
    return s, sigma


def _fuel_rates(fuel: Fuel) -> dict[sp.Symbol, Expr]:
    """Return the rates of what the tanks hold."""
    fixed = fuel.fixed
    rates = {fixed.mass: -fixed.out, fixed.out: fixed.out_rate, fixed.inertia: fixed.inertia_rate}
    for tank in fuel.tanks:
        bob, lump = tank.bob, tank.fuel
        rates |= {bob.mass: -lump.out, lump.out: lump.out_rate, bob.inertia: lump.inertia_rate}
        rates |= {bob.length: tank.length_rate, tank.length_rate: tank.length_change}
    return rates


def _bob(tank: Tank, k: int, gravity: Gradient, rates: dict[sp.Symbol, Expr]) -> sp.Matrix:
    """Return the equation of s across s, and (sigma.s)' = 0 along it, N m."""
    s, sigma = symbols(k)
    a = tank.bob
    place = tank.pivot + a.length * s
    slip = tank.length_rate * s + a.length * slip_of(k)
    push = acceleration + angular_acceleration.cross(place) + rate.cross(rate.cross(place)) + 2 * rate.cross(slip)
    push += matrix_rate(slip, rates)
    turning = matrix_rate(sigma, rates) + rate.cross(sigma)
    row = (
        a.mass * a.length * (push - gravity.of(place)) + a.inertia * (turning - gravity.of(s)) + a.damping * slip_of(k)
    )
    along = matrix_rate(sp.Matrix([sigma.dot(s)]), rates)[0]
    return s.cross(row) + s * ((a.mass * a.length**2 + a.inertia) * along)
