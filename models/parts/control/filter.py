# SPDX-License-Identifier: Apache-2.0
"""Multiplicative extended Kalman filter of attitude and gyro bias from a gyro and a star tracker.

The attitude error is three small angles a about inertial axes and the bias error is db. From sample to sample

    a -> a - B db - T A' e,    db -> db + w,    B = integral of A' over the period T,

where A maps inertial axes to hub axes, e is the gyro's white noise and w the step of its bias. The integrating gyro
measures the turn phi of a period. For a constant rate, B = T A_m' (I + [phi x]^2/24) to fourth order in phi, where A_m
is A halfway. The gyro's noise is equal about all axes, hence also about inertial ones. The transition matrix is
triangular like U. After each tracker measurement the angles are added to the quaternion and reset to zero.

Sources: Lefferts, Markley and Shuster, J. Guidance 5 (1982) 417; Markley and Crassidis, Fundamentals of Spacecraft
Attitude Determination and Control, Springer 2014; for angles about inertial axes Sola, arXiv 1711.02508.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Annotated, Protocol

import sympy as sp

from ...derivation import Expr
from ...estimation.factors import Define, Factors
from ...forms.samples import whole_number_margin
from ...mechanics import quaternion_product, quaternion_rotation
from ...quantities import ModelError, Quantity
from ...system import Condition, Output
from ..frame import AXES
from ..part import Mounted, Part
from ..sensors import Gyro, StarTracker
from ..values import Number, scalar

HALF = sp.Rational(1, 2)
_SIZE = 6
"""Of the error vector: three angles, three biases."""
_LOST = 3
"""Consecutive rejections after which a filter counts as diverged; a sound filter rejects one in a million."""


def _tangent(square: Expr) -> Expr:
    """Return tan(x)/(2 x) to fourth order, given x^2, where x is a half-angle."""
    return HALF + square * (sp.Rational(1, 6) + square / 15)


class Keeper(Protocol):
    """Interface of a law that a filter uses: name, memory and reports."""

    name: str

    def keep(self, name: str, unit: str = ..., meaning: str = ..., start: Expr | float = ...) -> sp.Symbol: ...
    def update(self, kept: sp.Symbol, value: Expr) -> None: ...
    def update_all(self, kept: Iterable[sp.Symbol], values: Iterable[Expr]) -> None: ...
    def report(self, output: Output) -> None: ...


@dataclass(frozen=True)
class Estimate:
    """Estimates at a sample.

    Attributes
    ----------
    attitude : tuple of Expr
        Unit quaternion from the axes of the hub to inertial axes, scalar first.
    rates : tuple of Expr
        Rate of the hub, rad/s: the gyro's mean over the last period, minus its bias.
    """

    attitude: tuple[Expr, ...]
    rates: tuple[Expr, ...]


@dataclass(frozen=True)
class AttitudeFilter(Part):
    """A multiplicative extended Kalman filter of attitude and gyro bias.

    The laws of its craft receive the estimates in place of measurements. The filter reads noise parameters from its
    sensors.

    Parameters
    ----------
    name : str
        As of a `Part`; start of the names in the law's memory.
    gyro : Gyro
        Integrating, with noise and walk.
    tracker : StarTracker
        With sigma.
    every : number
        Samples between tracker measurements, for a tracker without `every`.
    attitude, bias : number
        Standard deviations before the first measurement, of each angle, rad, and of each bias, rad/s.
    gate : number
        Largest accepted normalised innovation squared, a sum of three squares; measurements above it are rejected.
    """

    gyro: Gyro
    tracker: StarTracker
    every: Annotated[Number, scalar("every", "1", "samples a measurement of the tracker", "[1, inf)")] = 1.0
    attitude: Annotated[Number, scalar("attitude", "rad", "standard deviation of an angle at the start")] = 0.1
    bias: Annotated[Number, scalar("bias", "rad/s", "standard deviation of a bias at the start")] = 1e-3
    gate: Annotated[Number, scalar("gate", "1", "largest squared innovation over its variance")] = 30.0

    def __post_init__(self) -> None:
        for field, kind in (("gyro", Gyro), ("tracker", StarTracker)):
            if not isinstance(getattr(self, field), kind):
                raise ModelError(f"{self.name}.{field} = {getattr(self, field)!r}: must be a {kind.__name__}")
        for field, of in (("noise", self.gyro), ("walk", self.gyro), ("sigma", self.tracker)):
            if getattr(of, field) is None:
                raise ModelError(f"{self.name}: {of.name}.{field} = None: must be given for a filter")
        if not self.gyro.integrating:
            name = self.gyro.name
            raise ModelError(f"{self.name}: {name}.integrating = False: a filter needs integrating=True")
        for sensor in (self.gyro, self.tracker):
            if sensor.delay:
                raise ModelError(f"{self.name}: {sensor.name}.delay = {sensor.delay}: must be 0 for a filter")
        if not self.tracker.steady and self.every != 1:
            raise ModelError(
                f"{self.name}.every = {self.every!r}: must be left out, {self.tracker.name} has its own rate"
            )

    def constraints(self, at: Mounted) -> tuple[Condition, ...]:
        message = f"{self.tracker.name}.sigma must be above zero for {self.name}"
        sigma = (Condition(entry, message) for entry in self.of(self.tracker, at).sigma)
        counted = Condition(
            whole_number_margin(at.values.every), f"{self.name}.every must be a whole number of samples"
        )
        return (*super().constraints(at), counted, *sigma)

    def of(self, sensor: Part, at: Mounted) -> SimpleNamespace:
        """Return the symbols of a sensor's fields."""
        for part, mounted in at.craft.parts:
            if part == sensor:
                return mounted.values
        raise ModelError(f"{self.name}: {sensor.name} is not on the craft; add it too")

    def estimate(self, at: Mounted, law: Keeper) -> Estimate:
        """Define one step of the filter in a law, and extend the law's memory.

        Parameters
        ----------
        at : Mounted
            The filter on its craft.
        law : Keeper
            The law that uses the filter.
        """
        return _Sample(self, at, law).estimate()


class _Sample:
    """One step of a filter under construction."""

    def __init__(self, of: AttitudeFilter, at: Mounted, law: Keeper) -> None:
        self.of, self.at, self.law = of, at, law
        self.gyro, self.tracker = of.of(of.gyro, at), of.of(of.tracker, at)
        self.period = at.craft.period
        self.q = [self._keep(f"q{k}", "1", f"quaternion, {k}", int(k == 0)) for k in range(4)]
        self.bias = sp.Matrix([self._keep(f"bias_{axis}", "rad/s", f"bias of the gyro, {axis}") for axis in AXES])
        variances = (at.values.attitude**2,) * 3 + (at.values.bias**2,) * 3
        self.factors = Factors.kept(self._keep, ("1",) * 3 + ("1/s",) * 3, variances)
        self.count = self._keep("count", "1", "samples since the last measurement; -1 before the first", -1)
        self.nis = self._keep("nis", "1", "squared innovation of the last measurement over its variance")
        self.rejected = self._keep("rejected", "1", "measurements rejected in a row")
        tracker = of.tracker
        self.due: sp.Rel = self.count < HALF if tracker.steady else tracker.new.symbol > HALF

    def _keep(self, name: str, unit: str, meaning: str, begin: Expr | float = 0) -> sp.Symbol:
        return self.law.keep(f"{self.of.name}_{name}", unit, f"{self.of.name}: {meaning}", begin)

    def define(self, name: str, expr: Expr, title: str) -> Expr:
        """Name a step."""
        return self.at.frame.define(f"{self.law.name}_{self.of.name}_{name}", expr, f"{self.of.name}: {title}")

    def stage(self, prefix: str) -> Define:
        """Return the function that names the steps of a stage."""
        return lambda name, expr, title: self.define(f"{prefix}_{name}", expr, title)

    def vector(self, name: str, entries: Iterable[Expr], title: str) -> sp.Matrix:
        """Name the components of a vector."""
        return sp.Matrix([self.define(f"{name}{k}", entry, title) for k, entry in enumerate(entries)])

    def unit(self, name: str, entries: Iterable[Expr], title: str) -> sp.Matrix:
        """Name the components of a quaternion after normalisation."""
        raw = self.vector(f"{name}_raw", entries, f"{title}, of any length")
        over = self.define(f"{name}_over", 1 / sp.sqrt(raw.dot(raw)), f"{title}: one over its length")
        return self.vector(name, over * raw, title)

    def turned(self, name: str, q: Sequence[Expr], angle: sp.Matrix) -> sp.Matrix:
        """Return a quaternion after a small turn, not normalised; the error has seventh order in the angle."""
        square = self.define(f"{name}_square", angle.dot(angle) / 4, "square of half the angle")
        longer = self.define(f"{name}_longer", _tangent(square), "tangent of half the angle over the angle")
        return quaternion_product(list(q), (1, *(longer * angle)))

    def rotation(self, name: str, q: Sequence[Expr]) -> sp.Matrix:
        """Return the matrix from inertial axes to hub axes."""
        start = f"{self.law.name}_{self.of.name}_{name}_"
        return self.at.frame.matrix(start, quaternion_rotation(list(q)), f"{self.of.name}: rotation")

    def transition(self, middle: sp.Matrix, angle: sp.Matrix) -> sp.Matrix:
        """Return the error's transition over a period from the attitude halfway and half the turn."""
        bend = self.define("bend", 1 - angle.dot(angle) / 6, "share of a bias across the turn")
        across = [self.define(f"along{i}", angle.dot(middle[:, i]) / 6, "of a bias along it") for i in range(3)]
        entries = sp.Matrix(3, 3, lambda i, j: -self.period * (bend * middle[j, i] + across[i] * angle[j]))
        transition = sp.eye(_SIZE)
        transition[:3, 3:] = sp.Matrix(
            3, 3, lambda i, j: self.define(f"B{i + 1}{j + 1}", entries[i, j], "angle by a bias")
        )
        return transition

    def estimate(self) -> Estimate:
        """Define the filter step and return the estimates."""
        measured = sp.Matrix(self.of.gyro.symbols)
        angle = self.vector("angle", self.period / 2 * (measured - self.bias), "half the turn since the last sample")
        middle = self.unit("middle", self.turned("to", self.q, angle), "quaternion halfway")
        now = self.unit("now", self.turned("on", middle, angle), "quaternion before the measurement")
        seen, first = self.seen(now), self.count < -HALF
        choice = [sp.Piecewise((s, first), (q, True)) for s, q in zip(seen, now, strict=True)]
        now = self.vector("before", choice, "quaternion before the measurement, or the first one")
        transition = self.transition(self.rotation("mid", middle), angle)
        prior = self.factors.propagated(self.stage("to"), transition, transition, self.noise())
        correction, factors = self.corrected(now, seen, prior)
        attitude = self.unit("after", quaternion_product((1, *(correction[:3, 0] / 2)), list(now)), "quaternion")
        bias = self.vector("bias", self.bias + correction[3:, 0], "bias of the gyro")
        rate = self.vector("rate", measured - bias, "rate without the bias, after the measurement")
        self.law.update_all(self.q, attitude)
        self.law.update_all(self.bias, bias)
        self.law.update_all(self.factors.entries, factors.entries)
        self.report()
        return Estimate(tuple(attitude), tuple(rate))

    def seen(self, now: sp.Matrix) -> Sequence[Expr]:
        """Return the tracker's quaternion; without a new measurement, the expected one."""
        symbols: tuple[sp.Symbol, ...] = self.of.tracker.symbols
        if self.of.tracker.steady:
            return symbols
        entries = [sp.Piecewise((s, self.due), (q, True)) for s, q in zip(symbols, now, strict=True)]
        return list(self.vector("seen", entries, "measured quaternion, or the expected one"))

    def noise(self) -> tuple[Expr, ...]:
        """Return the variances by which noise of the gyro changes angles and biases in a period."""
        white = self.define("white", self.gyro.noise**2 * self.period, "variance of an angle by a period")
        walk = self.define("walk", self.gyro.walk**2 * self.period, "variance of a bias by a period")
        return (white,) * 3 + (walk,) * 3

    def corrected(self, now: sp.Matrix, seen: Sequence[Expr], prior: Factors) -> tuple[sp.Matrix, Factors]:
        """Return correction and factors after a measurement of three angles; a rejected measurement changes nothing."""
        scalar, *off = quaternion_product((now[0], *(-now[1:, 0])), seen)
        over = self.define("over", 2 / scalar, "angle over half its sine, nearly")
        turn = self.rotation("turn", list(now))
        correction, factors, terms = prior.corrected(
            self.stage,
            (
                (f"angle_{axis}", [*turn.row(k), 0, 0, 0], self.tracker.sigma[k] ** 2, over * off[k])
                for k, axis in enumerate(AXES)
            ),
        )
        nis = self.define("nis_now", terms, "squared innovation over its variance")
        due = self.due
        flag = sp.Piecewise((1, sp.And(due, nis <= self.at.values.gate)), (0, True))
        taken = self.define("taken", flag, "1 where there is a measurement that is not rejected") > HALF
        self.count_on(due, taken, nis)
        chosen = [sp.Piecewise((entry, taken), (0, True)) for entry in correction]
        return self.vector("x", chosen, "correction"), prior.chosen(self.stage("taken"), factors, taken)

    def count_on(self, due: sp.Rel, taken: sp.Rel, nis: Expr) -> None:
        """Update the counters of samples and rejected measurements, and the stored NIS."""
        since, update = sp.Max(self.count, 0), self.law.update
        if self.of.tracker.steady:
            update(self.count, sp.Piecewise((0, since + 3 * HALF > self.at.values.every), (since + 1, True)))
        else:
            update(self.count, sp.Piecewise((0, due), (self.count, self.count < -HALF), (self.count + 1, True)))
        update(self.nis, sp.Piecewise((nis, due), (self.nis, True)))
        rejected = sp.Piecewise((0, taken), (self.rejected + 1, due), (self.rejected, True))
        update(self.rejected, rejected)

    def report(self) -> None:
        """Report the errors of the stored estimates, which are of the last sample, a period ago."""
        name, turn = self.of.name, -self.period / 2 * sp.Matrix(self.of.gyro.means)
        true = self.turned("half", self.turned("true", self.at.craft.quaternion, turn), turn)
        scalar, *off = quaternion_product(list(true), (self.q[0], *(-q for q in self.q[1:])))
        angles = [self.define(f"off{k}", 2 * entry / scalar, "error of the attitude") for k, entry in enumerate(off)]
        biases = sp.Matrix(self.of.gyro.biases) - self.bias
        walked = self.factors.widened(self.stage("walked"), (0, 0, 0, *self.noise()[3:]))
        nees = walked.distance(self.stage("nees"), [*angles, *biases])
        lost = sp.Piecewise((1, self.rejected > _LOST - HALF), (0, True))
        size = sp.sqrt(sp.Matrix(angles).dot(sp.Matrix(angles)))
        self.law.report(Output(Quantity(f"{name}_error", "rad", f"{name}: error of the attitude"), size))
        self.law.report(Output(Quantity(f"{name}_nees", "1", f"{name}: squared error over its covariance"), nees))
        what = f"{name} is lost (1): {_LOST} measurements or more rejected in a row"
        self.law.report(Output(Quantity(f"{name}_lost", "1", what), lost, at_most=0))
