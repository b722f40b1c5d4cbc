# SPDX-License-Identifier: Apache-2.0
"""Flexible appendages described by vibration modes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Annotated

import sympy as sp

from ...derivation import Expr
from ...quantities import Quantity
from ...system import Condition
from ..hub import Hub, PointMass
from ..part import Mounted, Part
from ..terms import Aggregates, Coordinate, Moments
from ..values import Complete, Number, Rows, Vector, scalar, vector


@dataclass(frozen=True)
class Mode(metaclass=Complete):
    """A vibration mode with modal mass one.

    Parameters
    ----------
    frequency : number
        rad/s.
    damping : number
        Ratio to critical damping.
    linear : three numbers
        Participation in a translation of the hub, kg^(1/2).
    angular : three numbers
        Participation in a rotation of the hub about O, kg^(1/2) m.
    """

    frequency: Annotated[Number, scalar("f", "rad/s", "angular frequency")]
    damping: Annotated[Number, scalar("z", "1", "damping ratio", "[0, inf)")]
    linear: Annotated[Vector, vector("d", "kg^(1/2)", "participation in a translation")]
    angular: Annotated[Vector, vector("b", "kg^(1/2) m", "participation in a rotation about O")]


@dataclass(frozen=True)
class Modes(Part):
    """A flexible appendage; the hub includes its mass and inertia at rest.

    Its deformation moves the centre of mass of the craft, which keeps the momentum consistent with the masses.

    Parameters
    ----------
    name : str
        As of a `Part`; the states are NAME_1, ..., kg^(1/2) m, and NAME_1_dot, ...
    modes : sequence of Mode
        Its modes.
    """

    modes: Annotated[Sequence[Mode], Rows(Mode)] = ()

    def constraints(self, at: Mounted) -> tuple[Condition, ...]:
        return (*super().constraints(at), *self._of_the_hub(at))

    def _of_the_hub(self, at: Mounted) -> Iterator[Condition]:
        """Yield the conditions that the hub without all modal masses has a positive mass and inertia."""
        flexible = [(part.name, its.values.modes) for part, its in at.craft.parts if isinstance(part, Modes)]
        if flexible[0][0] != self.name:
            return
        fixed = [(part.aggregates(its), part.name) for part, its in at.craft.parts if isinstance(part, Hub | PointMass)]
        rigid, name = Moments.whole(of for of, _ in fixed), ", ".join(name for _, name in fixed)
        for what in ("linear", "angular") if fixed else ():
            columns = [getattr(mode, what) for _, modes in flexible for mode in modes]
            whole = rigid.mass * sp.eye(3) if what == "linear" else rigid.inertia
            parts = ", ".join(part for part, _ in flexible)
            rest = whole - sum((v * v.T for v in columns), sp.zeros(3))
            message = f"{what} participations of {parts} exceed {name}, which includes the modes"
            for margin in _minors(rest) if rest != whole else ():
                if not margin.is_positive:
                    yield Condition(margin, message)

    def coordinates(self) -> tuple[Coordinate, ...]:
        return tuple(
            Coordinate(
                Quantity(f"{self.name}_{k}_dot", "kg^(1/2) m/s", f"rate of mode {k} of {self.name}"),
                Quantity(f"{self.name}_{k}", "kg^(1/2) m", f"mode {k} of {self.name}"),
            )
            for k in range(1, len(self.modes) + 1)
        )

    def aggregates(self, at: Mounted) -> Aggregates:
        result = Aggregates()
        for mode, coordinate in zip(at.values.modes, self.coordinates(), strict=True):
            assert coordinate.place is not None
            place, speed = coordinate.place.symbol, coordinate.speed.symbol
            result += Aggregates(
                first=mode.linear * place, momentum=mode.linear * speed, angular=mode.angular * speed,
                energy=speed**2 / 2, potential=mode.frequency**2 * place**2 / 2,
                forces=(-2 * mode.damping * mode.frequency * speed,),
            )  # fmt: skip
        return result


def _minors(m: sp.Matrix) -> tuple[Expr, ...]:
    """Return the leading minors of a symmetric (3, 3) matrix as products of its entries, whose sums stay as they are.

    Expanded, the terms of the determinant grow with the cube of the number of modes.
    """
    return m[0, 0], m[0, 0] * m[1, 1] - m[0, 1] ** 2, m[:, 0].dot(m[:, 1].cross(m[:, 2]))
