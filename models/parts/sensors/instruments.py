# SPDX-License-Identifier: Apache-2.0
"""Star trackers, Sun sensors, magnetometers and tachometers, and what all sensors share.

White noise of a gyro or a magnetometer is a density, as data sheets print it: a sample has it over the root of the
sampling period, so that a mean over a time does not depend on how often one samples. What a camera or a Sun sensor gets
wrong in one picture is a standard deviation, whatever the period. Without noise a sensor shows the truth.

A sensor with a rate of its own, or whose measurements get lost, has one more number to show: NAME_new, 1 where it has
measured. All others are zero where it has not. A sensor with a delay keeps its last measurements in states that move on
at each sample.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Annotated

import sympy as sp

from ...derivation import Expr
from ...forms.samples import whole_number_margin
from ...mechanics import quaternion_product
from ...quantities import TIME, ModelError, Quantity
from ...system import Condition
from ..environment import sky
from ..frame import AXES, quaternion
from ..motion import Motion
from ..part import Mounted, Part
from ..terms import State
from ..values import Number, Parameters, Vector, direction, scalar, vector

HALF = sp.Rational(1, 2)
HALF_TURN = "(0, 3.141592653589794)"
MOST_DELAY = 100
"""Largest delay of a sensor: each sample of delay is a state for each number that the sensor shows."""


@dataclass(frozen=True)
class Instrument(Part):
    """A sensor of the quantities `seen`; `errors` has the standard deviations of their Gaussian errors.

    Parameters
    ----------
    every : number, optional
        Samples from one measurement to the next; default: it measures at each.
    dropout : number, optional
        Share of the measurements that get lost, at random.
    delay : int
        Samples from a measurement to its arrival. The first to arrive is that of the second sample.
    """

    every: Annotated[
        Number | None, scalar("every", "1", "samples from one measurement to the next", "[1, inf)", absent=1)
    ] = field(default=None, kw_only=True)
    dropout: Annotated[Number | None, scalar("dropout", "1", "share of measurements that get lost", "[0, 1)")] = field(
        default=None, kw_only=True
    )
    delay: int = field(default=0, kw_only=True)

    def __post_init__(self) -> None:
        if isinstance(self.delay, bool) or not isinstance(self.delay, int) or not 0 <= self.delay <= MOST_DELAY:
            raise ModelError(f"{self.name}.delay = {self.delay!r}: must be a whole number from 0 to {MOST_DELAY}")

    @property
    def steady(self) -> bool:
        """True if it measures at each sample."""
        return self.every is None and self.dropout is None

    @property
    def continuous(self) -> bool:
        """True if it measures at each instant, for a continuous law too."""
        return self.steady and not self.delay

    @property
    def new(self) -> Quantity:
        """Flag of a new measurement, for a sensor that skips samples."""
        return Quantity(f"{self.name}_new", "1", f"1 where {self.name} has measured, else 0")

    @property
    def lots(self) -> tuple[Quantity, ...]:
        """Standard normal numbers that decide which measurements are lost."""
        count = 0 if self.dropout is None else 2
        return tuple(Quantity(f"{self.name}_lot{k + 1}", "1", f"lot of a dropout of {self.name}") for k in range(count))

    def constraints(self, at: Mounted) -> tuple[Condition, ...]:
        message = f"{self.name}.every must be a whole number of samples"
        counted = () if at.values.every == 1 else (Condition(whole_number_margin(at.values.every), message),)
        return (*super().constraints(at), *counted)

    def measures(self, at: Mounted) -> sp.Basic:
        """Return the condition for a measurement at a sample: it is due, and not lost."""
        conditions = []
        if at.values.every != 1:
            count = sp.floor(TIME.symbol / at.craft.period + HALF)
            turn = at.define(
                "turn", count - at.values.every * sp.floor((count + HALF) / at.values.every), "samples since", "1"
            )
            conditions.append(turn < HALF)
        if self.lots:
            square = sp.Add(*(q.symbol**2 for q in self.lots))
            conditions.append(sp.exp(-square / 2) >= at.values.dropout)
        return sp.And(*conditions)

    def before(self) -> tuple[float, ...]:
        """Return the values that a law receives before the first measurement."""
        return (0.0,) * len(self.seen())

    @abstractmethod
    def seen(self) -> tuple[Quantity, ...]:
        """Return the measured quantities."""

    @property
    def symbols(self) -> tuple[sp.Symbol, ...]:
        """Symbols of the measured quantities, for laws."""
        return tuple(q.symbol for q in self.seen())

    def errors(self, at: Mounted) -> Sequence[Expr]:
        """Return the standard deviation of each error at a sample; zero for none."""
        return (sp.S.Zero,) * len(AXES)

    @abstractmethod
    def measured(self, at: Mounted, errors: Sequence[Expr]) -> Sequence[Expr]:
        """Return the measured quantities with their errors."""

    def shown(self) -> tuple[Quantity, ...]:
        """Return what laws receive: the measured quantities, after the flag of a sensor that skips samples."""
        return self.seen() if self.steady else (self.new, *self.seen())

    def queue(self) -> tuple[tuple[Quantity, ...], ...]:
        """Return the states that keep measurements until they arrive, the newest first; none without delay."""
        ages = range(self.delay + 1) if self.delay else ()
        return tuple(
            tuple(Quantity(f"{q.name}_ago{age}", q.unit, f"{q.description}, {age} samples ago") for q in self.shown())
            for age in ages
        )

    def own_states(self, scenario: Parameters) -> tuple[State, ...]:
        """Return the states of the sensor besides its queue."""
        return ()

    def states(self, scenario: Parameters) -> tuple[State, ...]:
        begin = [sp.sympify(value) for value in ((0.0,) * (not self.steady) + self.before())]
        rows = (map(State, row, begin) for row in self.queue())
        return (*self.own_states(scenario), *(state for row in rows for state in row))

    def own_rates(self, at: Mounted, motion: Motion) -> tuple[Expr, ...]:
        """Return the rates of these states."""
        return ()

    def rates(self, at: Mounted, motion: Motion) -> tuple[Expr, ...]:
        waiting = sum(len(row) for row in self.queue())
        return (*self.own_rates(at, motion), *(sp.S.Zero,) * waiting)


@dataclass(frozen=True)
class Triad(Instrument):
    """A sensor of a vector's three components in hub axes."""

    def seen(self) -> tuple[Quantity, ...]:
        return tuple(Quantity(f"{self.name}_{axis}", *self._kind(axis)) for axis in AXES)

    @abstractmethod
    def _kind(self, axis: str) -> tuple[str, str]:
        """Return unit and description of the component along an axis."""


@dataclass(frozen=True)
class StarTracker(Instrument):
    """A star tracker: it measures the attitude as a unit quaternion.

    Parameters
    ----------
    name, every, dropout, delay
        As of a `Part` and an `Instrument`; it measures NAME_q0, ..., NAME_q3, scalar first.
    sigma : three numbers, optional
        Standard deviations of the angles about the axes of the hub, rad; that about the line of sight is the largest.
    blind : number, optional
        Rate of the hub above which it does not measure, rad/s.
    boresight : three numbers, optional
        Line of sight in the axes of the hub, any length.
    exclusion : number, optional
        Angle between the line of sight and the Sun below which it does not measure, rad. It needs `boresight` and an
        orbit; in the shadow of the Earth the Sun does not disturb.
    """

    sigma: Annotated[Vector | None, vector("sigma", "rad", "standard deviation of an angle", absent=0)] = None
    blind: Annotated[Number | None, scalar("blind", "rad/s", "rate above which it does not measure")] = None
    boresight: Annotated[Vector | None, direction("b", "line of sight")] = None
    exclusion: Annotated[
        Number | None, scalar("excl", "rad", "angle to the Sun below which it does not measure", HALF_TURN)
    ] = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if (self.boresight is None) != (self.exclusion is None):
            raise ModelError(f"{self.name}.exclusion, boresight: give both, or neither")

    @property
    def steady(self) -> bool:
        return super().steady and self.blind is None and self.exclusion is None

    def measures(self, at: Mounted) -> sp.Basic:
        conditions = [super().measures(at)]
        if at.values.blind is not None:
            conditions.append(at.frame.rate.dot(at.frame.rate) <= at.values.blind**2)
        if at.values.exclusion is not None:
            here = sky(at)
            glare = at.define("glare", at.values.boresight.dot(here.sun), "cosine of the Sun's angle", "1")
            conditions.append(sp.Or(glare <= sp.cos(at.values.exclusion), here.light < HALF))
        return sp.And(*conditions)

    def before(self) -> tuple[float, ...]:
        return (1.0, 0.0, 0.0, 0.0)

    def seen(self) -> tuple[Quantity, ...]:
        return quaternion(f"{self.name}_q", f"quaternion that {self.name} measures")

    def errors(self, at: Mounted) -> Sequence[Expr]:
        return list(at.values.sigma)

    def measured(self, at: Mounted, errors: Sequence[Expr]) -> Sequence[Expr]:
        true = at.craft.quaternion
        if not any(errors):
            return true
        half = sp.Matrix(errors) / 2
        size = at.define("off", sp.sqrt(1 + half.dot(half)), "length of the quaternion of the errors", "1")
        return list(quaternion_product(true, (1 / size, *(half / size))))


@dataclass(frozen=True)
class SunSensor(Triad):
    """A Sun sensor: it measures the direction to the Sun in hub axes, times the visible share of the Sun.

    It thus measures zero in the Earth's shadow, and a length below 1 in the penumbra of `Orbit(shadow="cone")`.

    Parameters
    ----------
    name, every, dropout, delay
        As of a `Part` and an `Instrument`; it measures NAME_x, NAME_y and NAME_z.
    sigma : number, optional
        Standard deviation of each component.
    """

    sigma: Annotated[Number | None, scalar("sigma", "1", "standard deviation", "[0, inf)", absent=0)] = None

    def _kind(self, axis: str) -> tuple[str, str]:
        return "1", f"direction to the Sun along {axis} that {self.name} measures"

    def errors(self, at: Mounted) -> Sequence[Expr]:
        return (at.values.sigma,) * len(AXES)

    def measured(self, at: Mounted, errors: Sequence[Expr]) -> Sequence[Expr]:
        here = sky(at)
        return list(here.light * (here.sun + sp.Matrix(errors)))


@dataclass(frozen=True)
class Magnetometer(Triad):
    """A magnetometer: it measures the Earth's field in hub axes.

    Parameters
    ----------
    name, every, dropout, delay
        As of a `Part` and an `Instrument`; it measures NAME_x, NAME_y and NAME_z, Wb/m^2.
    noise : number, optional
        Density of the white noise, Wb s^(1/2)/m^2.
    """

    noise: Annotated[Number | None, scalar("noise", "Wb s^(1/2)/m^2", "density of the noise", "[0, inf)", absent=0)] = (
        None
    )

    def _kind(self, axis: str) -> tuple[str, str]:
        return "Wb/m^2", f"magnetic field along {axis} that {self.name} measures"

    def errors(self, at: Mounted) -> Sequence[Expr]:
        return density(at.values.noise, at)

    def measured(self, at: Mounted, errors: Sequence[Expr]) -> Sequence[Expr]:
        return list(sky(at).field + sp.Matrix(errors))


@dataclass(frozen=True)
class Tachometer(Instrument):
    """A tachometer: it measures the speed of a wheel, or of another part with one degree of freedom.

    Parameters
    ----------
    name, every, dropout, delay
        As of a `Part` and an `Instrument`; the name is that of what it measures too.
    of : Part
        The part.
    sigma : number, optional
        Standard deviation, in the unit of the speed.
    """

    of: Part
    sigma: Annotated[Number | None, scalar("sigma", "rad/s", "standard deviation", "[0, inf)", absent=0)] = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if not isinstance(self.of, Part) or len(self.of.coordinates()) != 1:
            raise ModelError(f"{self.name}.of = {self.of!r}: must be a part of one degree of freedom, such as a Wheel")

    def seen(self) -> tuple[Quantity, ...]:
        (coordinate,) = self.of.coordinates()
        return (Quantity(self.name, coordinate.speed.unit, f"{coordinate.speed.description} that it measures"),)

    def errors(self, at: Mounted) -> Sequence[Expr]:
        return (at.values.sigma,)

    def measured(self, at: Mounted, errors: Sequence[Expr]) -> Sequence[Expr]:
        if all(part != self.of for part, _ in at.craft.parts):
            raise ModelError(f"{self.name}.of: {self.of.name} is not on the craft; add it too")
        (coordinate,), (error,) = self.of.coordinates(), errors
        return (coordinate.speed.symbol + error,)


def density(noise: Expr, at: Mounted) -> Sequence[Expr]:
    """Return the standard deviation of a sample of white noise with a density, along each axis."""
    return (noise / sp.sqrt(at.values.every * at.craft.period),) * len(AXES)
