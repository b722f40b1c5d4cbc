# SPDX-License-Identifier: Apache-2.0
"""Wheels as parts of an assembly, balanced and unbalanced.

An unbalanced wheel consists of balanced masses, a first moment q normal to its axis a (static imbalance) and products
of inertia a phi' + phi a' (dynamic imbalance), all about its centre. The centre is at r from O, the centre of mass of
the balanced satellite. Both vectors turn with the wheel: with t = a x q their rates are s t and s a x phi. The hub is
the balanced satellite without the wheels' axial inertias.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import sympy as sp

from ...parts import Aggregates, Contribution, Coordinate, Load, Mounted, Part
from ...parts.part import Motion
from ...system import Derivation, Expr, Group, Quantity
from .. import naming


@dataclass(frozen=True)
class Balanced(Part):
    """A balanced wheel whose state is its absolute momentum about its axis.

    The hub includes the wheel's inertia except the axial one.

    Parameters
    ----------
    name : str
        Begins the names of its steps.
    axis : sympy.Matrix
        a, in body axes.
    inertia, momentum : Expr
        I_w about the axis, and h = I_w (s + w . a), with the speed s relative to the body.
    share : Expr
        1 if the wheel exerts the torque, 0 if the torque is external.
    torque : Expr
        Of motor and bearing on the body, N m.
    """

    axis: sp.Matrix
    inertia: Expr
    momentum: Expr
    share: Expr = sp.S.One
    torque: Expr = sp.S.Zero

    def contribution(self, at: Mounted) -> Contribution:
        return Contribution(angular=self.momentum * self.axis, loads=(Load(couple=self.torque * self.axis),))

    def rates(self, at: Mounted, motion: Motion) -> tuple[Expr, ...]:
        return (-self.share * self.torque,)


@dataclass(frozen=True, kw_only=True)
class Unbalanced(Balanced):
    """An unbalanced wheel.

    Parameters
    ----------
    name, axis, inertia, momentum, share, torque
        As of a balanced one.
    angle, speed : Quantity
        Angle of the wheel, a state, and its rate s, a step.
    place : sympy.Matrix
        r, m.
    offset, across : sympy.Matrix
        q and t, kg m.
    skew : sympy.Matrix
        phi, kg m^2.
    """

    angle: Quantity
    speed: Quantity
    place: sp.Matrix
    offset: sp.Matrix
    across: sp.Matrix
    skew: sp.Matrix

    def coordinates(self) -> tuple[Coordinate, ...]:
        return (Coordinate(self.speed, self.angle),)

    def imbalance(self) -> Aggregates:
        """Return the contribution of the imbalance."""
        a, r, q, speed = self.axis, self.place, self.offset, self.speed.symbol
        shifted = 2 * r.dot(q) * sp.eye(3) - q * r.T - r * q.T
        products = a * self.skew.T + self.skew * a.T
        turning = speed * (r.cross(self.across) - self.skew)
        return Aggregates(first=q, inertia=shifted - products, momentum=speed * self.across, angular=turning)

    def aggregates(self, at: Mounted) -> Aggregates:
        off, a, speed = self.imbalance(), self.axis, self.speed.symbol
        vectors = ((self.offset, self.across), (self.across, -self.offset), (self.skew, a.cross(self.skew)))
        for vector, slope in vectors:
            at.frame.slopes |= {entry: (self.angle.symbol, by) for entry, by in zip(vector, slope, strict=True)}
        return replace(
            off, inertia=off.inertia + self.inertia * a * a.T, angular=off.angular + self.inertia * speed * a,
            energy=self.inertia * speed**2 / 2, forces=(-self.torque,),
        )  # fmt: skip

    def contribution(self, at: Mounted) -> Contribution:
        return Part.contribution(self, at)

    def rates(self, at: Mounted, motion: Motion) -> tuple[Expr, ...]:
        return (self.inertia * (motion.own[0] + self.axis.dot(motion.angular)),)


def unbalanced(wheel: Balanced, k: int, plant: Group, angle: Quantity, d: Derivation) -> Unbalanced:
    """Define the directions of the imbalances of wheel k, counted from zero."""
    label = str(k + 1)
    first, second = _across(wheel.axis, label, d)
    turned = angle.symbol + plant.imbalance_phase[k]
    cosine, sine = sp.cos(angle.symbol), sp.sin(angle.symbol)
    q = plant.static_imbalance[k] * (cosine * first + sine * second)
    t = plant.static_imbalance[k] * (cosine * second - sine * first)
    phi = plant.dynamic_imbalance[k] * (sp.cos(turned) * first + sp.sin(turned) * second)
    return Unbalanced(
        wheel.name, wheel.axis, wheel.inertia, wheel.momentum, angle=angle, speed=speed(label),
        place=plant.wheel_places[:, k],
        offset=_vector(f"q{label}", q, f"static imbalance of wheel {label}", "kg m", f"q_{label}", d),
        across=_vector(f"t{label}", t, f"static imbalance of wheel {label}, a quarter turn ahead", "kg m",
                       f"t_{label}", d),
        skew=_vector(f"skew{label}", phi, f"dynamic imbalance of wheel {label}", "kg m^2", rf"\phi_{label}", d),
    )  # fmt: skip


def speed(label: str) -> Quantity:
    """Return the speed of a wheel relative to the body."""
    return Quantity(f"wheel_{label}", "rad/s", f"speed of wheel {label} relative to the body", rf"\Omega_{{w{label}}}")


def _across(axis: sp.Matrix, label: str, d: Derivation) -> tuple[sp.Matrix, sp.Matrix]:
    """Return two normals of an axis that are normal to each other.

    Notes
    -----
    Duff, Burgess, Christensen, Hery, Kensler, Liani, Villemin: Building an orthonormal basis, revisited. Journal of
    Computer Graphics Techniques 6(1), 2017. The formula holds for every axis.
    """
    x, y, z = axis
    side = sp.Piecewise((sp.S.One, z >= 0), (-sp.S.One, True))
    side = d.define(f"side{label}", side, "", f"side of the body's z to which axis {label} points", latex=f"s_{label}")
    share = d.define(f"share{label}", -1 / (side + z), "", f"of axis {label}", latex=f"c_{label}")
    first = sp.Matrix([1 + side * x**2 * share, side * x * y * share, -side * x])
    second = sp.Matrix([x * y * share, side + y**2 * share, -y])
    title = f"across axis {label}"
    return (
        _vector(f"across{label}", first, f"{title}, where its angle is zero", "1", f"b_{label}", d),
        _vector(f"ahead{label}", second, f"{title}, a quarter turn ahead", "1", f"c_{label}", d),
    )


def _vector(name: str, value: sp.Matrix, title: str, unit: str, latex: str, d: Derivation) -> sp.Matrix:
    """Name the components of a vector in body axes."""
    return naming.vector(f"{name}_*", value, f"{title}, along *", unit, f"{latex.replace('_', '_{')},*}}", d)
