# SPDX-License-Identifier: Apache-2.0
"""Terms of a part: what determines its motion, and what it adds to the equations of the hub.

The kinetic energy of a part that is mounted on a hub is quadratic in the velocity V of the hub's origin O, in the rate
W of its axes, and in the part's own speeds:

    T = m V.V/2 + V.(W x s + p) + W.J W/2 + W.h + T_own.

Mass m, first moment s, inertia J, relative momentum p, relative angular momentum h (all about O, in hub axes) and
T_own are the `Aggregates` of the part. They determine the part's `Contribution` to the hub's equations and the part's
own equations, with row i

    G_i . (a, W') + sum_j D_ij q_j'' = Q_i - k_i,    G_i = (dp/dq_i', dh/dq_i'),

with the acceleration a = V' + W x V of O. A point mass m at the place r(q) gives the same terms in a shorter form: its
force on the hub is -m (a + W' x r + W x (W x r + 2 r') + r'' at constant speeds), its rows are G_i = m dr/dq_i at r.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, fields, is_dataclass
from types import SimpleNamespace
from typing import Self

import sympy as sp

from ..derivation import Expr
from ..quantities import Quantity
from .frame import ZERO, point_inertia

_NONE = sp.zeros(3, 3)


@dataclass(frozen=True)
class Coordinate:
    """A degree of freedom of a part.

    Attributes
    ----------
    speed : Quantity
        Its rate, a state.
    place : Quantity, optional
        The coordinate, a state; None if nothing depends on it, as for a wheel.
    """

    speed: Quantity
    place: Quantity | None = None


@dataclass(frozen=True)
class Moments:
    """Mass of a body and its moments about O.

    Attributes
    ----------
    mass : Expr
        kg.
    first : sympy.Matrix
        First moment s about O, kg m, a function of the coordinates.
    inertia : sympy.Matrix
        J about O, kg m^2.
    momentum, angular : sympy.Matrix
        Relative momentum p = s', kg m/s, and relative angular momentum h about O, kg m^2/s; linear in the speeds.
    """

    mass: Expr = sp.S.Zero
    first: sp.Matrix = field(default_factory=lambda: ZERO)
    inertia: sp.Matrix = field(default_factory=lambda: sp.zeros(3, 3))
    momentum: sp.Matrix = field(default_factory=lambda: ZERO)
    angular: sp.Matrix = field(default_factory=lambda: ZERO)

    def __post_init__(self) -> None:
        _as_expressions(self, "mass")

    def __add__(self, other: Moments) -> Self:
        return type(self)(*(getattr(self, f.name) + getattr(other, f.name) for f in fields(self)))

    @staticmethod
    def whole(each: Iterable[Moments]) -> Moments:
        """Return the moments of several bodies as one."""
        return sum(each, Moments())


@dataclass(frozen=True)
class Aggregates(Moments):
    """Masses, momenta and energies that determine the motion of a part and its effect on the hub.

    Attributes
    ----------
    energy : Expr
        Kinetic energy relative to the hub, J; quadratic in the speeds.
    potential : Expr
        Potential energy of springs, J.
    forces : tuple of Expr
        Generalised force of dampers and motors on each coordinate.
    prescribed : tuple of (Expr or None)
        Prescribed acceleration of each coordinate, or None for a free one; empty if all are free.
    power : Expr
        Power of dampers and motors that are not in `forces`, W.
    """

    energy: Expr = sp.S.Zero
    potential: Expr = sp.S.Zero
    forces: tuple[Expr, ...] = ()
    prescribed: tuple[Expr | None, ...] = ()
    power: Expr = sp.S.Zero

    def __post_init__(self) -> None:
        super().__post_init__()
        _as_expressions(self, "energy", "potential", "power")

    @classmethod
    def body(
        cls, mass: Expr, place: sp.Matrix, inertia: sp.Matrix = _NONE,
        velocity: sp.Matrix = ZERO, rate: sp.Matrix = ZERO,
    ) -> Aggregates:  # fmt: skip
        """Return the terms of a body from its centre of mass, and from inertia, velocity and rate relative to the hub.

        Parameters
        ----------
        mass : Expr
            kg.
        place, velocity : sympy.Matrix
            Of its centre of mass from O, m, m/s.
        inertia : sympy.Matrix
            About its centre of mass, in hub axes, kg m^2; without one it is a point mass.
        rate : sympy.Matrix
            rad/s.
        """
        spin = inertia * rate
        return cls(
            mass, mass * place, inertia + point_inertia(mass, place), mass * velocity,
            mass * place.cross(velocity) + spin, (mass * velocity.dot(velocity) + rate.dot(spin)) / 2,
        )  # fmt: skip


@dataclass(frozen=True)
class Particle:
    """A point mass that moves with the coordinates of a part.

    Attributes
    ----------
    mass : Expr
        kg.
    place : sympy.Matrix
        From O, m, a function of the coordinates.
    squared : Expr, optional
        Square of its speed relative to the hub, m^2/s^2, where a shorter form is known than that of the derivatives of
        `place`.
    """

    mass: Expr
    place: sp.Matrix
    squared: Expr | None = None

    def __post_init__(self) -> None:
        _as_expressions(self, "mass", "squared")


@dataclass(frozen=True)
class Point:
    """A point of a part, to which the mass and the terms of its rows move.

    Attributes
    ----------
    at : sympy.Matrix
        From O, m.
    mass : Expr
        kg.
    force : sympy.Matrix
        On the hub, N, without terms of accelerations.
    """

    at: sp.Matrix
    mass: Expr
    force: sp.Matrix


@dataclass(frozen=True)
class Row:
    """Equation of a coordinate: G . (a, W') + D q'' = right.

    Attributes
    ----------
    linear, angular : sympy.Matrix
        The two parts of G: for a part with a `Point`, a force there and a couple; else a force at O and a moment.
    coupling : tuple of Expr
        Row of D.
    right : Expr
        Q - k.
    """

    linear: sp.Matrix
    angular: sp.Matrix
    coupling: tuple[Expr, ...]
    right: Expr


@dataclass(frozen=True)
class Load:
    """A force at a point of the hub, N, and a couple, N m."""

    force: sp.Matrix = field(default_factory=lambda: ZERO)
    at: sp.Matrix = field(default_factory=lambda: ZERO)
    couple: sp.Matrix = field(default_factory=lambda: ZERO)


@dataclass(frozen=True)
class Follower:
    """A mass that follows a point P of the hub along e. Its force on the hub at P is (pull - mass e . a_P) e.

    Attributes
    ----------
    mass : Expr
        kg.
    along, at : sympy.Matrix
        e, of length one, and P from O, m.
    pull : Expr
        N.
    """

    mass: Expr
    along: sp.Matrix
    at: sp.Matrix
    pull: Expr = sp.S.Zero


@dataclass(frozen=True)
class Contribution(Moments):
    """Terms that a part adds to the equations of the hub; the assembly forms those of a rigid body from its moments.

    Attributes
    ----------
    loads : tuple of Load
        Forces between part and hub, and the terms of p', h' and J' W without accelerations.
    rows : tuple of Row
        Equations of the part's coordinates, which the assembly eliminates.
    held : tuple of Row
        Equations of prescribed coordinates, which determine the motor's force.
    followers : tuple of Follower
        Masses that follow the hub along one direction each.
    matrix : sympy.Matrix
        Symmetric (6, 6): additional resistance to a and W', beyond that of a rigid body.
    point : Point, optional
        Where a mass and the rows act.
    """

    loads: tuple[Load, ...] = ()
    rows: tuple[Row, ...] = ()
    held: tuple[Row, ...] = ()
    followers: tuple[Follower, ...] = ()
    matrix: sp.Matrix = field(default_factory=lambda: sp.zeros(6, 6))
    point: Point | None = None


@dataclass(frozen=True)
class State:
    """A state of a part, and its initial value as a function of plant and scenario parameters."""

    quantity: Quantity
    start: Expr = sp.S.Zero


@dataclass(frozen=True)
class Jump:
    """A state's value after a sample: `after`, and a normal number of standard deviation `size`."""

    state: Quantity
    after: Expr = sp.S.Zero
    size: Expr = sp.S.Zero


def _as_expressions(terms: object, *names: str) -> None:
    """Replace numbers of Python, such as a mass of 2.0, by those of SymPy; None stays."""
    for name in names:
        if getattr(terms, name) is not None:
            object.__setattr__(terms, name, sp.sympify(getattr(terms, name)))


def expressions(value: object) -> Iterator[Expr]:
    """Yield all expressions in terms of a part, or in a part of a system."""
    if isinstance(value, sp.Expr):
        yield value
    elif is_dataclass(value) and not isinstance(value, type):
        for entry in fields(value):
            yield from expressions(getattr(value, entry.name))
    elif isinstance(value, tuple | list | set | sp.MatrixBase):
        for entry in value:
            yield from expressions(entry)
    elif isinstance(value, Mapping | SimpleNamespace):
        yield from expressions(tuple((value if isinstance(value, Mapping) else vars(value)).values()))
