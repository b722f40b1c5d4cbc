# SPDX-License-Identifier: Apache-2.0
"""Bodies connected to the hub by an elastic tether or rod."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated

import sympy as sp

from ...derivation import Expr
from ...events import Event
from ...mechanics import quaternion_product, quaternion_rates, quaternion_rotation
from ...quantities import ModelError, Quantity
from ..frame import quaternion, symbols, triple
from ..motion import Motion
from ..part import Mounted, Part, start
from ..terms import Aggregates, Contribution, Load, State
from ..values import Number, Parameters, Tensor, Vector, listed, place, scalar, tensor


@dataclass(frozen=True)
class _Line:
    """The line between two mounts: direction from the hub's mount, length and its rate."""

    along: sp.Matrix
    length: Expr
    rate: Expr


@dataclass(frozen=True, kw_only=True)
class _Elastic(Part):
    """Interface of a massless elastic line: tension, stored energy and damping power."""

    length: Annotated[Number, scalar("l", "m", "length without load")]
    stiffness: Annotated[Number, scalar("k", "N/m", "stiffness")]
    damping: Annotated[Number | None, scalar("d", "N s/m", "damping", "[0, inf)", absent=0)] = None

    @abstractmethod
    def _line(self, at: Mounted) -> _Line: ...

    def _pull(self, at: Mounted) -> Expr:
        """Return the tension of a line that can also push, N."""
        v, line = at.values, self._line(at)
        pull: Expr = v.stiffness * (line.length - v.length) + v.damping * line.rate
        return pull

    def _tension(self, at: Mounted) -> Expr:
        return at.define("tension", self._pull(at), "tension", "N")

    def _potential(self, at: Mounted) -> Expr:
        potential: Expr = at.values.stiffness * (self._line(at).length - at.values.length) ** 2 / 2
        return potential

    def aggregates(self, at: Mounted) -> Aggregates:
        line, potential = self._line(at), self._potential(at)
        loss = (potential.diff(line.length) - self._tension(at)) * line.rate
        return Aggregates(potential=potential, power=loss)


@dataclass(frozen=True, kw_only=True)
class _Slackening(_Elastic):
    """An elastic line without compression: it pulls when taut."""

    def _tension(self, at: Mounted) -> Expr:
        taut = self._line(at).length > at.values.length
        pull = at.define("pull0", self._pull(at), "tension of a rod", "N")
        return at.define("tension", sp.Piecewise((sp.Max(pull, 0), taut), (0, True)), "tension", "N")

    def _potential(self, at: Mounted) -> Expr:
        taut = self._line(at).length > at.values.length
        return sp.Piecewise((super()._potential(at), taut), (0, True))

    def events(self, at: Mounted) -> tuple[Event, ...]:
        name, line = self.name, self._line(at)
        result = Event(f"{name}_taut", line.length - at.values.length, title=f"{name} becomes taut, or slack")
        if at.values.damping == 0:
            return (result,)
        return (result, Event(f"{name}_pulls", self._pull(at), title=f"the damper of {name} takes up its pull"))


@dataclass(frozen=True, kw_only=True)
class Rod(_Elastic):
    """A rigid body on a massless elastic rod, with ball joints at the hub and at the body.

    Parameters
    ----------
    name : str
        As of a `Part`. The states are the place NAME_x, ... of the centre of mass and its velocity NAME_vx, ...
        relative to the hub, in the axes of the hub; the quaternion NAME_q0, ... from the axes of the body to those of
        the hub; and the absolute rate NAME_wx, ... of the body in its own axes.
    mass, inertia : number; three numbers, or three rows
        Of the body, about its centre of mass in its own axes; kg, kg m^2.
    at : three numbers
        Mount on the hub, m.
    mount : three numbers
        Mount on the body, from its centre of mass in its own axes, m.
    length : number
        Of the line without load, m.
    stiffness : number
        N/m.
    damping : number, optional
        N s/m.
    start : three numbers
        Place of the body at the start, m.
    """

    mass: Annotated[Number, scalar("m", "kg", "mass")]
    inertia: Annotated[Tensor, tensor("J", "moment of inertia about its centre of mass")]
    at: Annotated[Vector, place("r", "mount")] = (0, 0, 0)
    mount: Annotated[Vector, place("b", "mount on the body, in its axes")] = (0, 0, 0)
    start: Sequence[float]

    def _quantities(self) -> tuple[tuple[Quantity, ...], ...]:
        name = self.name
        return (
            triple(f"{name}_", "m", f"place of {name}"),
            quaternion(f"{name}_q", f"quaternion of {name}"),
            triple(f"{name}_v", "m/s", f"relative velocity of {name}"),
            triple(f"{name}_w", "rad/s", f"rate of {name}"),
        )

    def vectors(self) -> list[sp.Matrix]:
        """Return symbols of position, attitude, relative velocity and rate of the body."""
        return list(map(symbols, self._quantities()))

    def states(self, scenario: Parameters) -> tuple[State, ...]:
        places, turn, velocity, rate = self._quantities()
        first = [
            start(q, scenario, default)
            for q, default in zip(places, listed(self.start, f"{self.name}.start", 3), strict=True)
        ]
        upright = [State(q, sp.Integer(int(k == 0))) for k, q in enumerate(turn)]
        return (*first, *upright, *(start(q, scenario) for q in (*velocity, *rate)))

    def projection(self) -> Mapping[sp.Symbol, Expr]:
        q = self.vectors()[1]
        return {entry: entry / sp.sqrt(q.dot(q)) for entry in q}

    def _rotation(self, at: Mounted) -> sp.Matrix:
        """Return the matrix from body axes to hub axes."""
        return at.matrix("R", quaternion_rotation(list(self.vectors()[1])).T, "rotation", "1")

    def _turning(self, at: Mounted) -> tuple[sp.Matrix, sp.Matrix]:
        """Return the rate relative to the hub, and the mount from the body's centre of mass, in hub axes."""
        rotation, (*_, rate) = self._rotation(at), self.vectors()
        turning = at.vector("turn", rotation * rate - at.frame.rate, "rate relative to the hub", "rad/s")
        return turning, at.vector("arm", rotation * at.values.mount, "mount from the centre of mass", "m")

    def _line(self, at: Mounted) -> _Line:
        (centre, _, velocity, _), (turning, arm) = self.vectors(), self._turning(at)
        reach = at.vector("reach", centre + arm - at.values.at, "from mount to mount", "m")
        moving = at.vector("moving", velocity + turning.cross(arm), "its rate in the axes of the hub", "m/s")
        return _line(at, reach, moving)

    def aggregates(self, at: Mounted) -> Aggregates:
        v, (centre, _, velocity, _), rotation = at.values, self.vectors(), self._rotation(at)
        inertia = rotation * v.inertia * rotation.T
        return super().aggregates(at) + Aggregates.body(v.mass, centre, inertia, velocity, self._turning(at)[0])

    def contribution(self, at: Mounted) -> Contribution:
        return Contribution(loads=(Load(self._tension(at) * self._line(at).along, at.values.at),))

    def rates(self, at: Mounted, motion: Motion) -> tuple[Expr, ...]:
        v, w, (centre, turn, velocity, rate) = at.values, at.frame.rate, self.vectors()
        rotation, (_, arm) = self._rotation(at), self._turning(at)
        pull = at.vector("pull", -self._tension(at) * self._line(at).along, "force on the body", "N")
        cables = (cable.force_on(self, mounted) for cable, mounted in at.craft.parts if isinstance(cable, Cable))
        carried = motion.at(centre, f"{self.name}_a", f"the hub at the place of {self.name}")
        linear = sum(cables, pull) / v.mass - carried - 2 * w.cross(velocity)
        moment = rotation.T * arm.cross(pull) - rate.cross(v.inertia * rate)
        angular = at.vector("dw", _solved(v.inertia, moment), "angular acceleration", "rad/s^2")
        turned = quaternion_rates(list(turn), list(rate)) - quaternion_product((sp.S.Zero, *w), list(turn)) / 2
        return (*velocity, *turned, *linear, *angular)


@dataclass(frozen=True, kw_only=True)
class Tether(_Slackening, Rod):
    """A rigid body on an elastic tether that pulls when taut and never pushes; events switch between taut and slack.

    Parameters
    ----------
    name, mass, inertia, at, mount, length, stiffness, damping, start
        As of a `Rod`.
    """


@dataclass(frozen=True, kw_only=True)
class Cable(_Slackening):
    """A massless elastic tether between the centres of mass of two bodies on a `Rod` or `Tether`.

    Parameters
    ----------
    name, length, stiffness, damping
        As of a `Rod`.
    between : two of Rod or Tether
        The bodies at its ends.
    """

    between: tuple[Rod, Rod]

    def __post_init__(self) -> None:
        names = [end.name for end in self.between]
        if len(set(names)) != 2:
            raise ModelError(f"{self.name}.between = {', '.join(names)}: must be two different bodies")

    def _line(self, at: Mounted) -> _Line:
        for end in self.between:
            if not any(part is end for part, _ in at.craft.parts):
                raise ModelError(f"{self.name}.between: {end.name} is not mounted on the craft")
        (near, _, slow, _), (far, _, fast, _) = (body.vectors() for body in self.between)
        return _line(at, far - near, fast - slow)

    def force_on(self, body: Rod, at: Mounted) -> sp.Matrix:
        """Return the force on a body in hub axes, N."""
        sign = sum(side for end, side in zip(self.between, (1, -1), strict=True) if end.name == body.name)
        return sign * self._tension(at) * self._line(at).along


def _line(at: Mounted, reach: sp.Matrix, moving: sp.Matrix) -> _Line:
    """Define a line between points at the distance vector `reach`, whose rate is `moving`."""
    length = at.define("length", sp.sqrt(reach.dot(reach)), "distance of the ends", "m")
    along = at.vector("along", reach / length, "direction from end to end", "1")
    return _Line(along, length, at.define("pace", along.dot(moving), "rate of the distance", "m/s"))


def _solved(inertia: sp.Matrix, moment: sp.Matrix) -> sp.Matrix:
    """Return the angular acceleration of a body."""
    if inertia.is_diagonal():
        return sp.Matrix([moment[k] / inertia[k, k] for k in range(3)])
    return inertia.adjugate() * moment / inertia.det(method="berkowitz")
