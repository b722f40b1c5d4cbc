# SPDX-License-Identifier: Apache-2.0
"""Conversion of demanded accelerations to thrust direction and moments within the gimbal limits.

The thrust F is constant, so a_x follows from F and the lateral force. The force f = q + P a_x is affine in a_x, and
|f| = F is a quadratic equation, whose larger root is used. Moments are computed last from the acting thrust: the
demanded Omega' is met even if the lateral demand is not.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import sympy as sp

from ...derivation import vector
from ...parts.assembly import substitute
from ...system import Actuator, Derivation, Expr, Group, Quantity
from ..dynamics import Dynamics
from ..plant.equations import gimbal_position, thrust
from ..states import GIMBALS, INPUTS, MOMENTS, rate


@dataclass(frozen=True)
class Inputs:
    """Physical inputs that meet a demand as far as possible.

    Attributes
    ----------
    command : tuple of Expr
        Mx, My, Mz, delta1, delta2.
    lateral : Expr
        Demanded force across x, N.
    excess : Expr
        Lateral demand in excess of the thrust, N; zero for a feasible demand.
    """

    command: tuple[Expr, ...]
    lateral: Expr
    excess: Expr


def to_physical(p: Group, plant: Dynamics, demand: Sequence[Expr], tag: str, d: Derivation) -> Inputs:
    """Invert (9)-(16): moments and gimbal angles for given a_y, a_z and Omega'.

    Parameters
    ----------
    p : Group
        Parameters of the plant.
    plant : Dynamics
        Equations of motion at a state.
    demand : sequence of Expr
        a_y, a_z of O, m/s^2, and Omega', rad/s^2.
    tag : str
        Appended to the names of the definitions.
    d : Derivation
        Receives the steps.
    """

    def name(text: str, value: Expr, title: str, unit: str, latex: str) -> sp.Symbol:
        return d.define(f"{text}_{tag}", value, title=title, unit=unit, latex=latex)

    accelerations = _of_the_centre(plant, demand, name)
    demanded = plant.balance.matrix[:, 1:] * sp.Matrix(accelerations) - plant.balance.right
    offsets = [
        name(f"q{k + 1}", demanded[k], f"force along {axis} at a_x = 0", "N", f"q_{axis}")
        for k, axis in enumerate("xyz")
    ]
    axial = _axial(p, plant, offsets, name)
    matrix = plant.balance.matrix
    force = [
        name(f"f{k + 1}", offsets[k] + matrix[k, 0] * axial, f"demanded force along {'xyz'[k]}", "N", f"f_{'xyz'[k]}")
        for k in range(3)
    ]
    delta1, delta2 = _gimbal_angles(force, p, name)
    acting = thrust(p, (delta1, delta2))
    missing = [
        name(f"df{k + 1}", acting[k] - force[k], f"thrust less demand along {'xyz'[k]}", "N", rf"\Delta f_{'xyz'[k]}")
        for k in range(3)
    ]
    change = _moment_change(plant, missing, f"da_{tag}")
    turned = demanded[3:, :] + axial * matrix[3:, 0] + change
    moments = turned - _lever(p, plant).cross(sp.Matrix(acting))
    named = [name(q.name, moment, q.description, q.unit, q.latex) for q, moment in zip(MOMENTS, moments, strict=True)]
    across = name("lateral", sp.sqrt(force[1] ** 2 + force[2] ** 2), "demanded lateral force", "N", r"f_\perp")
    return Inputs((*named, delta1, delta2), across, sp.Max(across - p.F, 0))


_Named = Callable[[str, Expr, str, str, str], sp.Symbol]


def _of_the_centre(plant: Dynamics, demand: Sequence[Expr], name: _Named) -> tuple[Expr, ...]:
    """Return the demanded lateral acceleration of the centre of the hull's equations, and Omega'."""
    (ay, az, *turning), place, (w1, w2, w3) = demand, plant.balance.centre[0], rate
    if place.is_zero:
        return (ay, az, *turning)
    along_y, along_z = ay + place * (turning[2] + w1 * w2), az + place * (w1 * w3 - turning[1])
    return (
        name("a2", along_y, "demanded acceleration of C along y", "m/s^2", "a_{C,y}"),
        name("a3", along_z, "demanded acceleration of C along z", "m/s^2", "a_{C,z}"),
        *turning,
    )


def _lever(p: Group, plant: Dynamics) -> sp.Matrix:
    """Return the gimbal's place from the centre of the hull's equations."""
    return gimbal_position(p) - plant.balance.centre


def _axial(p: Group, plant: Dynamics, offsets: Sequence[Expr], name: _Named) -> Expr:
    """Return the larger root a of |q + P a|^2 = F^2, or the minimiser of |q + P a| if no root is real."""
    column = [plant.balance.matrix[k, 0] for k in range(3)]
    square = name("PP", sp.Add(*(e**2 for e in column)), "P.P", "kg^2", r"P\cdot P")
    mixed = name("Pq", sp.Add(*(e * q for e, q in zip(column, offsets, strict=True))), "P.q", "kg N", r"P\cdot q")
    rest = sp.Add(*(q**2 for q in offsets)) - p.F**2
    root = name(
        "root", sp.sqrt(sp.Max(mixed**2 - square * rest, 0)), "root of the discriminant", "kg N", r"\sqrt\Delta"
    )
    return name("ax", (root - mixed) / square, "acceleration of C along x that |f| = F leaves", "m/s^2", "a_{C,x}")


def _gimbal_angles(force: Sequence[Expr], p: Group, name: _Named) -> tuple[Expr, Expr]:
    """Return the gimbal angles at which the thrust has the direction of a force in hull axes, N."""
    sine2 = name("sin_d2", _unit(force[1] / p.F), "sine of delta2", "1", r"\sin\delta_2")
    cosine2 = name("cos_d2", sp.sqrt(1 - sine2**2), "cosine of delta2", "1", r"\cos\delta_2")
    # the bound keeps 0/0 away where the thrust lies along y; the sine is limited to 1 long before
    sine1 = _unit(-force[2] / (p.F * sp.Max(cosine2, sp.Float("1e-9"))))
    delta1, delta2 = GIMBALS
    return (
        name("delta1", sp.asin(sine1), delta1.description, "rad", delta1.latex),
        name("delta2", sp.asin(sine2), delta2.description, "rad", delta2.latex),
    )


def _unit(value: Expr) -> Expr:
    return sp.Max(-1, sp.Min(1, value))


def _moment_change(plant: Dynamics, missing: Sequence[Expr], name: str) -> sp.Matrix:
    """Return the change of the moments about the centre for a change of the force at constant Omega'."""
    response = substitute(plant.frame, plant.factors, missing, [f"{name}_{axis}" for axis in "xyz"])
    return plant.balance.matrix[3:, :3] * sp.Matrix(response)


COMMANDED = Group(
    "u_cmd",
    tuple(Quantity(f"{q.name}_cmd", q.unit, f"commanded: {q.description}", rf"{q.latex}^{{c}}") for q in INPUTS),
)


def gimbal_limits(p: Group, plant: Dynamics, d: Derivation) -> Actuator:
    """Limit delta2, then delta1 for the remaining z force, and recompute the moments that give Omega'."""
    d.section("Gimbal limits")
    *moments, angle1, angle2 = COMMANDED.symbols
    delta2 = _clip(angle2, p.delta2_max)
    delta2 = d.define("delta2_act", delta2, title="gimbal angle within its limit", unit="rad", latex=r"\delta_2")
    share = _unit(sp.sin(angle1) * sp.cos(angle2) / sp.cos(p.delta2_max))
    inside = sp.Abs(angle2) <= p.delta2_max
    served = sp.Piecewise((angle1, inside), (sp.asin(share), True))
    delta1 = _clip(served, p.delta1_max)
    delta1 = d.define("delta1_act", delta1, title="gimbal angle within its limit", unit="rad", latex=r"\delta_1")
    acting, demand = thrust(p, (delta1, delta2)), thrust(p, (angle1, angle2))
    missing = [a - b for a, b in zip(acting, demand, strict=True)]
    missing = list(vector("df*_act", missing, "thrust less command", "N", r"\Delta f_*", d, labels="123"))
    change = _moment_change(plant, missing, "da_act") - _lever(p, plant).cross(sp.Matrix(missing))
    corrected = (moment + extra for moment, extra in zip(moments, change, strict=True))
    return Actuator(COMMANDED, (*corrected, delta1, delta2))


def _clip(value: Expr, limit: Expr) -> Expr:
    return sp.Max(-limit, sp.Min(limit, value))
