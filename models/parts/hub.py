# SPDX-License-Identifier: Apache-2.0
"""Rigid hub of a spacecraft, point masses on it, and forces and torques on it."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import sympy as sp

from ..derivation import Expr
from ..events import Event
from ..geometry import Shape
from ..quantities import ModelError, Quantity
from ..system import Condition
from .frame import AXES, ZERO, symbols, triple
from .motion import Motion
from .part import Mounted, Part, points
from .terms import Aggregates, Jump, Load, State
from .values import Number, Tensor, Vector, direction, parameters_text, place, scalar, tensor

_OFF = sp.Rational(1, 10**6)
"""Error of a clock at the end of a period, far above rounding and far below a sample."""
_AXES_COLORS = ("blue", "vermillion", "green")


@dataclass(frozen=True)
class Hub(Part):
    """A rigid body that carries the parts.

    Parameters
    ----------
    name : str
        As of a `Part`.
    mass : number
        kg.
    inertia : three numbers, or three rows
        About its own centre of mass, in the axes of the hub, kg m^2.
    centre : three numbers
        Its centre of mass, m.
    """

    mass: Annotated[Number, scalar("m", "kg", "mass")]
    inertia: Annotated[Tensor, tensor("J", "moment of inertia")]
    centre: Annotated[Vector, place("c", "centre of mass")] = (0, 0, 0)

    def aggregates(self, at: Mounted) -> Aggregates:
        v = at.values
        return Aggregates.body(v.mass, v.centre, v.inertia)

    def shapes(self, at: Mounted) -> tuple[Shape, ...]:
        """Return the axes and a box of uniform density with the hub's mass and principal moments."""
        v, ways = at.values, sp.eye(3)
        trace, reach = v.inertia.trace(), at.craft.reach
        half = [sp.sqrt(sp.Max(0, 3 * (trace - 2 * v.inertia[k, k]) / (2 * v.mass))) for k in range(3)]
        middles = [v.centre + half[k] * ways[:, k] for k in range(3)]
        arrows = zip(AXES, [v.centre + reach * ways[:, k] for k in range(3)], _AXES_COLORS, strict=True)
        return (
            Shape(self.name, "box", points(v.centre, *middles), "grey"),
            *(Shape(f"{self.name} {axis}", "arrow", points(v.centre, end), color) for axis, end, color in arrows),
        )


@dataclass(frozen=True)
class PointMass(Part):
    """A point mass fixed to the hub.

    Parameters
    ----------
    name : str
        As of a `Part`.
    mass : number
        kg.
    at : three numbers
        Its place, m.
    """

    mass: Annotated[Number, scalar("m", "kg", "mass")]
    at: Annotated[Vector, place("r", "place")] = (0, 0, 0)

    def aggregates(self, at: Mounted) -> Aggregates:
        return Aggregates.body(at.values.mass, at.values.at)


@dataclass(frozen=True)
class ExternalForce(Part):
    """A force on the hub that a law commands, in hub axes.

    Parameters
    ----------
    name : str
        As of a `Part`; its inputs are NAMEx, NAMEy and NAMEz, in N.
    at : three numbers
        Where it acts, m.
    """

    at: Annotated[Vector, place("r", "point of application")] = (0, 0, 0)

    def inputs(self) -> tuple[Quantity, ...]:
        return triple(self.name, "N", f"force {self.name}")

    def loads(self, at: Mounted) -> tuple[Load, ...]:
        return (Load(symbols(self.inputs()), at.values.at),)


@dataclass(frozen=True)
class Pulsed(Part):
    """A part that switches itself off within a sample period; NAME_off is the located event."""

    @property
    @abstractmethod
    def pulses(self) -> bool:
        """False for a part that acts during whole periods."""

    @abstractmethod
    def share(self, at: Mounted) -> Expr:
        """Return the share of a period in which the part acts."""

    @property
    def _clock(self) -> Quantity:
        """The clock falls from 2 by 1 in a period; at the end of the pulse it goes to minus the share, then to -1.

        The part acts where the clock is above 1/2. The clock is never near that, so that rounding cannot switch. At the
        end of a period it is 1 or -1, by which `jumps` recognises commands at other instants.
        """
        return Quantity(f"{self.name}_clock", "1", f"clock of the pulses of {self.name}")

    def on(self, at: Mounted) -> sp.Basic:
        """Return the condition that the part acts."""
        return sp.And(self._clock.symbol > sp.Rational(1, 2), self.share(at) > 0) if self.pulses else sp.true

    def states(self, scenario: object) -> tuple[State, ...]:
        return (State(self._clock, sp.Integer(2)),) if self.pulses else ()

    def rates(self, at: Mounted, motion: Motion) -> tuple[Expr, ...]:
        return (-1 / at.craft.period,) if self.pulses else ()

    def jumps(self, at: Mounted) -> Sequence[Jump]:
        clock = self._clock.symbol
        regular = sp.Abs(sp.Abs(clock) - 1) < _OFF
        return (Jump(self._clock, sp.Piecewise((2, regular), (-2, True))),) if self.pulses else ()

    def limits(self, at: Mounted) -> tuple[Condition, ...]:
        message = f"the pulses of {self.name} need a command once per period: set hold or period to Ts = {{Ts:g}} s"
        return (Condition(self._clock.symbol + sp.Rational(3, 2), message),) if self.pulses else ()

    def events(self, at: Mounted) -> tuple[Event, ...]:
        if not self.pulses:
            return ()
        clock, share = self._clock.symbol, self.share(at)
        title = f"the pulse of {self.name} ends"
        return (Event(f"{self.name}_off", clock - 2 + share, "falling", {clock: -share}, title=title),)


@dataclass(frozen=True)
class Thruster(Pulsed):
    """A thruster: it pushes along its direction and never pulls.

    Parameters
    ----------
    name : str
        As of a `Part`; its input is NAME_force, in N.
    direction : three numbers
        Of the force on the hub, any length.
    at : three numbers
        Where it acts, m.
    limit : number, optional
        Largest force, N.
    least : number, optional
        Smallest impulse of a period, N s: a smaller command opens no valve. At most `limit` times the period; if equal,
        only the largest force acts.
    pulsed : bool
        True for a valve that opens at the begin of each sample period, with the force `limit`, for so long that the
        mean force is the command; it closes at the events NAME_off. False for a constant force.
    """

    direction: Annotated[Vector, direction("a", "direction")]
    at: Annotated[Vector, place("r", "place")] = (0, 0, 0)
    limit: Annotated[Number | None, scalar("Fmax", "N", "largest force", absent=sp.oo)] = None
    least: Annotated[Number | None, scalar("Imin", "N s", "smallest impulse of a period", absent=0)] = None
    pulsed: bool = False

    def __post_init__(self) -> None:
        if self.pulsed and self.limit is None:
            raise ModelError(f"{self.name}.limit is missing: a pulsed thruster needs the force of its open valve")

    @property
    def pulses(self) -> bool:
        return self.pulsed

    def share(self, at: Mounted) -> Expr:
        return self.inputs()[0].symbol / at.values.limit

    def inputs(self) -> tuple[Quantity, ...]:
        return (Quantity(f"{self.name}_force", "N", f"force of {self.name}"),)

    def loads(self, at: Mounted) -> tuple[Load, ...]:
        if not self.pulsed:
            return self.mean_loads(at)
        force = sp.Piecewise((at.values.limit, self.on(at)), (0, True))
        return (Load(at.define("thrust", force, "force of the open valve", "N") * at.values.direction, at.values.at),)

    def mean_loads(self, at: Mounted) -> tuple[Load, ...]:
        return (Load(self.inputs()[0].symbol * at.values.direction, at.values.at),)

    def shapes(self, at: Mounted) -> tuple[Shape, ...]:
        return jet(at, at.values.direction, self.inputs()[0].symbol)

    def applied(self, at: Mounted, commanded: Sequence[sp.Symbol]) -> tuple[Expr, ...]:
        pushed = sp.Min(sp.Max(commanded[0], 0), at.values.limit)
        return (sp.Piecewise((pushed, pushed * at.craft.period >= at.values.least), (0, True)),)

    def constraints(self, at: Mounted) -> tuple[Condition, ...]:
        largest = at.values.limit * at.craft.period
        if at.values.least == 0 or at.values.limit == sp.oo:
            return super().constraints(at)
        numbers = parameters_text(largest.free_symbols | at.values.least.free_symbols)
        text = f"{self.name}.least, with {numbers}: must not exceed limit times Ts, or nothing fires"
        fires = sp.Piecewise((1, largest >= at.values.least), (-1, True))
        return (*super().constraints(at), Condition(fires, text))


def jet(at: Mounted, along: sp.Matrix, force: Expr) -> tuple[Shape, ...]:
    """Return a nozzle, and its jet with a length proportional to the force; without a limit the length is fixed."""
    v, reach = at.values, at.craft.reach
    share = sp.S.One if v.limit == sp.oo else force / v.limit
    ends = [v.at - length * along for length in (reach / 8, share * reach)]
    return (
        Shape(f"{at.name} nozzle", "rod", points(v.at, ends[0]), "grey"),
        Shape(at.name, "arrow", points(v.at, ends[1]), "purple"),
    )


@dataclass(frozen=True)
class Torquer(Part):
    """A torque on the hub that a law commands, in hub axes.

    Parameters
    ----------
    name : str
        As of a `Part`; its inputs are NAMEx, NAMEy and NAMEz, in N m.
    """

    def inputs(self) -> tuple[Quantity, ...]:
        return triple(self.name, "N m", f"torque {self.name}")

    def loads(self, at: Mounted) -> tuple[Load, ...]:
        return (Load(couple=symbols(self.inputs())),)

    def shapes(self, at: Mounted) -> tuple[Shape, ...]:
        """Return the torque, which the picture's scale has at seven tenths of an arrow."""
        torque = symbols(self.inputs())
        arrow = at.craft.reach * torque / sp.sqrt(at.craft.strength**2 + torque.dot(torque))
        return (Shape(self.name, "arrow", points(ZERO, arrow), "purple"),)
