# SPDX-License-Identifier: Apache-2.0
"""Gyros, star trackers, Sun sensors, magnetometers and tachometers.

White noise of a gyro or a magnetometer is a density, as data sheets print it: a sample has it over the root of the
sampling period, so that a mean over a time does not depend on how often one samples. What a camera or a Sun sensor gets
wrong in one picture is a standard deviation, whatever the period. Without noise a sensor shows the truth.

A sensor with a rate of its own, or whose measurements get lost, has one more number to show: NAME_new, 1 where it has
measured. All others are zero where it has not.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Annotated

import sympy as sp

from ...derivation import Expr
from ...forms.samples import whole
from ...mechanics import quaternion_product
from ...quantities import TIME, ModelError, Quantity
from ...system import Condition
from ..environment import sky
from ..frame import AXES
from ..part import Motion, Mounted, Part, State, start
from ..values import Number, Parameters, Vector, direction, scalar, vector

HALF = sp.Rational(1, 2)
HALF_TURN = "(0, 3.141592653589794)"


@dataclass(frozen=True)
class Instrument(Part):
    """A sensor of the quantities `seen`; `errors` has the standard deviations of their Gaussian errors.

    Parameters
    ----------
    every : number, optional
        Samples from one measurement to the next; default: it measures at each.
    dropout : number, optional
        Share of the measurements that get lost, at random.
    """

    every: Annotated[Number | None, scalar("every", "1", "samples from one measurement to the next", "[1, inf)")] = (
        field(default=None, kw_only=True)
    )
    dropout: Annotated[Number | None, scalar("dropout", "1", "share of measurements that get lost", "[0, 1)")] = field(
        default=None, kw_only=True
    )

    @property
    def steady(self) -> bool:
        """True if it measures at each sample."""
        return self.every is None and self.dropout is None

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
        counted = () if at.values.every is None else (Condition(whole(at.values.every), message),)
        return (*super().constraints(at), *counted)

    def measures(self, at: Mounted) -> sp.Basic:
        """Return the condition for a measurement at a sample: it is due, and not lost."""
        conditions = []
        if at.values.every is not None:
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

    def drifts(self, at: Mounted) -> Sequence[tuple[Quantity, Expr]]:
        """Return the states with random walk, each with the standard deviation of its change per sample."""
        return ()


@dataclass(frozen=True)
class _Triad(Instrument):
    """A sensor of a vector's three components in hub axes."""

    def seen(self) -> tuple[Quantity, ...]:
        return tuple(Quantity(f"{self.name}_{axis}", *self._kind(axis)) for axis in AXES)

    @abstractmethod
    def _kind(self, axis: str) -> tuple[str, str]:
        """Return unit and description of the component along an axis."""


@dataclass(frozen=True)
class Gyro(_Triad):
    """Three gyros along the hub axes.

    Parameters
    ----------
    name, every, dropout
        As of a `Part` and an `Instrument`; it measures NAME_x, NAME_y and NAME_z, rad/s.
    noise : number, optional
        Angle random walk: density of the white noise, rad/s^(1/2).
    walk : number, optional
        Rate random walk: density of the change of the bias, rad/s^(3/2); the biases are states then, NAME_bias_x, ...
    scale : three numbers, optional
        Relative errors of the scale factors: 0.001 shows a rate 0.1 % too large.
    misalignment : three numbers, optional
        Small turn of the gyros against the hub, rad: they feel w - misalignment x w.
    step : number, optional
        Quantisation: the difference between two numbers that the gyro can show, rad/s.
    """

    noise: Annotated[Number | None, scalar("noise", "rad/s^(1/2)", "angle random walk", "[0, inf)")] = None
    walk: Annotated[Number | None, scalar("walk", "rad/s^(3/2)", "rate random walk", "[0, inf)")] = None
    scale: Annotated[Vector | None, vector("scale", "1", "relative error of the scale factor")] = None
    misalignment: Annotated[Vector | None, vector("turn", "rad", "turn of the gyros against the hub")] = None
    step: Annotated[Number | None, scalar("step", "rad/s", "quantisation of a rate")] = None

    def _kind(self, axis: str) -> tuple[str, str]:
        return "rad/s", f"rate about {axis} that {self.name} measures"

    def _biases(self) -> tuple[Quantity, ...]:
        if self.walk is None:
            return ()
        return tuple(
            Quantity(f"{self.name}_bias_{axis}", "rad/s", f"bias of {self.name} about {axis}") for axis in AXES
        )

    @property
    def biases(self) -> tuple[sp.Symbol, ...]:
        """Symbols of the biases; none without `walk`."""
        return tuple(q.symbol for q in self._biases())

    def states(self, scenario: Parameters) -> tuple[State, ...]:
        return tuple(start(q, scenario) for q in self._biases())

    def rates(self, at: Mounted, motion: Motion) -> tuple[Expr, ...]:
        return (sp.S.Zero,) * len(self._biases())

    def errors(self, at: Mounted) -> Sequence[Expr]:
        return _density(at.values.noise, at)

    def measured(self, at: Mounted, errors: Sequence[Expr]) -> Sequence[Expr]:
        v, rate = at.values, at.frame.rate
        if v.misalignment is not None:
            rate = rate - v.misalignment.cross(rate)
        if v.scale is not None:
            rate = rate + v.scale.multiply_elementwise(rate)
        shown = rate + sp.Matrix(self.biases or [0, 0, 0]) + sp.Matrix(errors)
        return list(shown if v.step is None else shown.applyfunc(lambda w: v.step * sp.floor(w / v.step + HALF)))

    def drifts(self, at: Mounted) -> Sequence[tuple[Quantity, Expr]]:
        return [(q, at.values.walk * sp.sqrt(at.craft.period)) for q in self._biases()]


@dataclass(frozen=True)
class StarTracker(Instrument):
    """A star tracker: it measures the attitude as a unit quaternion.

    Parameters
    ----------
    name, every, dropout
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

    sigma: Annotated[Vector | None, vector("sigma", "rad", "standard deviation of an angle")] = None
    blind: Annotated[Number | None, scalar("blind", "rad/s", "rate above which it does not measure")] = None
    boresight: Annotated[Vector | None, direction("b", "line of sight")] = None
    exclusion: Annotated[
        Number | None, scalar("excl", "rad", "angle to the Sun below which it does not measure", HALF_TURN)
    ] = None

    def __post_init__(self) -> None:
        if (self.boresight is None) != (self.exclusion is None):
            raise ModelError(
                f"{self.name}.exclusion needs boresight, and boresight serves exclusion: give both or none"
            )

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
        return tuple(
            Quantity(f"{self.name}_q{k}", "1", f"quaternion that {self.name} measures, component {k}") for k in range(4)
        )

    def errors(self, at: Mounted) -> Sequence[Expr]:
        return (sp.S.Zero,) * 3 if at.values.sigma is None else list(at.values.sigma)

    def measured(self, at: Mounted, errors: Sequence[Expr]) -> Sequence[Expr]:
        true = at.craft.quaternion
        if not any(errors):
            return true
        half = sp.Matrix(errors) / 2
        size = at.define("off", sp.sqrt(1 + half.dot(half)), "length of the quaternion of the errors", "1")
        return list(quaternion_product(true, (1 / size, *(half / size))))


@dataclass(frozen=True)
class SunSensor(_Triad):
    """A Sun sensor: it measures the direction to the Sun in hub axes, and zero in the Earth's shadow.

    Parameters
    ----------
    name, every, dropout
        As of a `Part` and an `Instrument`; it measures NAME_x, NAME_y and NAME_z.
    sigma : number, optional
        Standard deviation of each component.
    """

    sigma: Annotated[Number | None, scalar("sigma", "1", "standard deviation", "[0, inf)")] = None

    def _kind(self, axis: str) -> tuple[str, str]:
        return "1", f"direction to the Sun along {axis} that {self.name} measures"

    def errors(self, at: Mounted) -> Sequence[Expr]:
        return (sp.S.Zero if at.values.sigma is None else at.values.sigma,) * len(AXES)

    def measured(self, at: Mounted, errors: Sequence[Expr]) -> Sequence[Expr]:
        here = sky(at)
        return list(here.light * (here.sun + sp.Matrix(errors)))


@dataclass(frozen=True)
class Magnetometer(_Triad):
    """A magnetometer: it measures the Earth's field in hub axes.

    Parameters
    ----------
    name, every, dropout
        As of a `Part` and an `Instrument`; it measures NAME_x, NAME_y and NAME_z, Wb/m^2.
    noise : number, optional
        Density of the white noise, Wb s^(1/2)/m^2.
    """

    noise: Annotated[Number | None, scalar("noise", "Wb s^(1/2)/m^2", "density of the noise", "[0, inf)")] = None

    def _kind(self, axis: str) -> tuple[str, str]:
        return "Wb/m^2", f"magnetic field along {axis} that {self.name} measures"

    def errors(self, at: Mounted) -> Sequence[Expr]:
        return _density(at.values.noise, at)

    def measured(self, at: Mounted, errors: Sequence[Expr]) -> Sequence[Expr]:
        return list(sky(at).field + sp.Matrix(errors))


@dataclass(frozen=True)
class Tachometer(Instrument):
    """A tachometer: it measures the speed of a wheel, or of another part with one degree of freedom.

    Parameters
    ----------
    name, every, dropout
        As of a `Part` and an `Instrument`; the name is that of what it measures too.
    of : Part
        The part.
    sigma : number, optional
        Standard deviation, in the unit of the speed.
    """

    of: Part
    sigma: Annotated[Number | None, scalar("sigma", "rad/s", "standard deviation", "[0, inf)")] = None

    def __post_init__(self) -> None:
        if not isinstance(self.of, Part) or len(self.of.coordinates()) != 1:
            raise ModelError(f"{self.name}.of = {self.of!r}: must be a part of one degree of freedom, such as a Wheel")

    def seen(self) -> tuple[Quantity, ...]:
        (coordinate,) = self.of.coordinates()
        return (Quantity(self.name, coordinate.speed.unit, f"{coordinate.speed.description} that it measures"),)

    def errors(self, at: Mounted) -> Sequence[Expr]:
        return (sp.S.Zero if at.values.sigma is None else at.values.sigma,)

    def measured(self, at: Mounted, errors: Sequence[Expr]) -> Sequence[Expr]:
        if all(part != self.of for part, _ in at.craft.parts):
            raise ModelError(f"{self.name}.of: {self.of.name} is not on the craft; add it too")
        (coordinate,), (error,) = self.of.coordinates(), errors
        return (coordinate.speed.symbol + error,)


def _density(density: Expr | None, at: Mounted) -> Sequence[Expr]:
    """Return the standard deviation of a white noise sample along each axis."""
    every = sp.S.One if at.values.every is None else at.values.every
    size = sp.S.Zero if density is None else density / sp.sqrt(every * at.craft.period)
    return (size,) * len(AXES)
