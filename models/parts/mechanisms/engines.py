# SPDX-License-Identifier: Apache-2.0
"""Engines on gimbals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import sympy as sp

from ...derivation import Expr
from ...geometry import Shape
from ...quantities import Quantity
from ..hub import jet
from ..motion import Motion
from ..part import Mounted, Part, clipped, start
from ..terms import Load, State
from ..values import Number, Parameters, Vector, direction, place, scalar


@dataclass(frozen=True)
class Engine(Part):
    """A massless engine on two gimbals, which follow their commands with a lag.

    The first gimbal turns the force about the axis, the second towards the axis. A law commands the force. To consume
    fuel, add a `Tank` without `thrust`.

    Parameters
    ----------
    name : str
        As of a `Part`. Its states are NAME_angle1 and NAME_angle2; its inputs NAME_force, N, and the commanded angles
        NAME_target1 and NAME_target2.
    direction : three numbers
        Direction of the force at angles zero; its component normal to the axis is used, scaled to length one.
    axis : three numbers
        Of the first gimbal; any length.
    lag : number
        Time constant of the gimbals, s.
    at : three numbers
        Where the force acts, m.
    limit, angle_limit, rate_limit : number, optional
        Largest force, N, gimbal angle and rate of it.
    """

    direction: Annotated[Vector, direction("t", "direction of the force", across="axis")]
    axis: Annotated[Vector, direction("a", "axis of the first gimbal")]
    lag: Annotated[Number, scalar("lag", "s", "time constant of the gimbals")]
    at: Annotated[Vector, place("r", "place")] = (0, 0, 0)
    limit: Annotated[Number | None, scalar("Fmax", "N", "largest force", absent=sp.oo)] = None
    angle_limit: Annotated[Number | None, scalar("amax", "rad", "largest gimbal angle", absent=sp.oo)] = None
    rate_limit: Annotated[Number | None, scalar("wmax", "rad/s", "largest rate of a gimbal", absent=sp.oo)] = None

    def inputs(self) -> tuple[Quantity, ...]:
        force = Quantity(f"{self.name}_force", "N", f"force of {self.name}")
        return (
            force,
            *(Quantity(f"{self.name}_target{k}", "rad", f"commanded angle {k} of {self.name}") for k in (1, 2)),
        )

    def _angles(self) -> tuple[Quantity, ...]:
        return tuple(Quantity(f"{self.name}_angle{k}", "rad", f"gimbal angle {k} of {self.name}") for k in (1, 2))

    def states(self, scenario: Parameters) -> tuple[State, ...]:
        return tuple(start(q, scenario) for q in self._angles())

    def _along(self, at: Mounted) -> sp.Matrix:
        """Return the direction of the force."""
        v, (first, second) = at.values, (at.frame.circle(q.symbol) for q in self._angles())
        front, side = at.across(v.axis, v.direction, "direction of the force")
        turned = first[0] * front + first[1] * side
        return second[0] * turned + second[1] * v.axis

    def loads(self, at: Mounted) -> tuple[Load, ...]:
        return (Load(self.inputs()[0].symbol * self._along(at), at.values.at),)

    def shapes(self, at: Mounted) -> tuple[Shape, ...]:
        return jet(at, self._along(at), self.inputs()[0].symbol)

    def rates(self, at: Mounted, motion: Motion) -> tuple[Expr, ...]:
        targets, angles = self.inputs()[1:], self._angles()
        errors = ((t.symbol - a.symbol) / at.values.lag for t, a in zip(targets, angles, strict=True))
        return tuple(clipped(error, at.values.rate_limit) for error in errors)

    def applied(self, at: Mounted, commanded: Sequence[sp.Symbol]) -> tuple[Expr, ...]:
        force, *targets = commanded
        within = (clipped(target, at.values.angle_limit) for target in targets)
        return (sp.Min(sp.Max(force, 0), at.values.limit), *within)
