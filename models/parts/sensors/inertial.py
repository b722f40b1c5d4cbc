# SPDX-License-Identifier: Apache-2.0
"""Gyros and accelerometers: white noise, a bias with a random walk, and integration over a period.

An integrating sensor has three more states for the integral since the last sample, which are zero again after it, and
three for the mean of the last period.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Annotated, ClassVar

import sympy as sp

from ...derivation import Expr
from ...quantities import ModelError, Quantity
from ..frame import AXES, symbols, triple
from ..motion import Motion
from ..part import Mounted, start
from ..terms import Jump, State
from ..values import Number, Parameters, Vector, place, scalar, vector
from .instruments import HALF, Triad, density

NONE = (sp.S.Zero,) * len(AXES)


@dataclass(frozen=True)
class Inertial(Triad):
    """A sensor with white noise and a bias that walks, which may integrate."""

    unit: ClassVar[str]
    quantity: ClassVar[str]
    """Name of what it measures, which an axis follows."""
    integral: ClassVar[tuple[str, str, str]]
    """Name, unit and meaning of its integral over time."""

    noise: Annotated[Number | None, scalar("noise", "1", "density of the noise")] = None
    walk: Annotated[Number | None, scalar("walk", "1", "random walk of the bias")] = None
    integrating: bool = field(default=False, kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.integrating and (self.every is not None or self.dropout is not None):
            raise ModelError(f"{self.name} integrates from sample to sample: leave out every and dropout")
        if self.integrating and self.walk is None:
            raise ModelError(f"{self.name}.walk = None: must be given for a sensor that integrates; 0 is allowed")

    @property
    def continuous(self) -> bool:
        return super().continuous and not self.integrating

    def _kind(self, axis: str) -> tuple[str, str]:
        return self.unit, f"{self.quantity} {axis} that {self.name} measures"

    def _own(self, what: str, unit: str, meaning: str) -> tuple[Quantity, ...]:
        return triple(f"{self.name}_{what}_", unit, f"{meaning} {self.name}")

    def _biases(self) -> tuple[Quantity, ...]:
        return () if self.walk is None else self._own("bias", self.unit, "bias of")

    def _means(self) -> tuple[Quantity, ...]:
        return self._own("mean", self.unit, "mean over the last period, of") if self.integrating else ()

    def _integrals(self) -> tuple[Quantity, ...]:
        name, unit, meaning = self.integral
        return self._own(name, unit, f"{meaning} since the last sample, of") if self.integrating else ()

    @property
    def biases(self) -> tuple[sp.Symbol, ...]:
        """Symbols of the biases; none without `walk`."""
        return tuple(q.symbol for q in self._biases())

    @property
    def means(self) -> tuple[sp.Symbol, ...]:
        """Symbols of the means over the last period, without errors; none if it does not integrate."""
        return tuple(q.symbol for q in self._means())

    def begin(self, scenario: Parameters) -> Sequence[Expr]:
        """Return the means at the start."""
        return NONE

    def own_states(self, scenario: Parameters) -> tuple[State, ...]:
        means = map(State, self._means(), self.begin(scenario))
        return (*(start(q, scenario) for q in self._biases()), *map(State, self._integrals()), *means)

    @abstractmethod
    def gathered(self, at: Mounted, motion: Motion) -> Sequence[Expr]:
        """Return the rates of the integrals."""

    def own_rates(self, at: Mounted, motion: Motion) -> tuple[Expr, ...]:
        integrated = (*self.gathered(at, motion), *NONE) if self.integrating else ()
        return (*(NONE if self._biases() else ()), *integrated)

    def errors(self, at: Mounted) -> Sequence[Expr]:
        return density(at.values.noise, at)

    def jumps(self, at: Mounted) -> Sequence[Jump]:
        walk, period = at.values.walk, at.craft.period
        return (
            *(Jump(q, q.symbol, walk * sp.sqrt(period)) for q in self._biases()),
            *(Jump(q, whole.symbol / period) for q, whole in zip(self._means(), self._integrals(), strict=True)),
            *map(Jump, self._integrals()),
        )


@dataclass(frozen=True)
class Gyro(Inertial):
    """Three gyros along the hub axes.

    Parameters
    ----------
    name, every, dropout, delay
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
    integrating : bool
        Whether it measures the turn since the last sample over the period, as a rotation vector, in place of the rate
        at the sample. It needs `walk`, which may be zero, and no `every` and `dropout`. The turn so far and that of the
        last period are states then, NAME_angle_x, ... and NAME_mean_x, ...
    """

    unit, quantity = "rad/s", "rate about"
    integral = "angle", "rad", "angle"

    noise: Annotated[Number | None, scalar("noise", "rad/s^(1/2)", "angle random walk", "[0, inf)", absent=0)] = None
    walk: Annotated[Number | None, scalar("walk", "rad/s^(3/2)", "rate random walk", "[0, inf)")] = None
    scale: Annotated[Vector | None, vector("scale", "1", "relative error of the scale factor", absent=0)] = None
    misalignment: Annotated[Vector | None, vector("turn", "rad", "turn of the gyros against the hub", absent=0)] = None
    step: Annotated[Number | None, scalar("step", "rad/s", "quantisation of a rate")] = None

    def begin(self, scenario: Parameters) -> Sequence[Expr]:
        rates = [scenario.quantities.get(f"w{axis}_0") for axis in AXES]
        return [sp.S.Zero if rate is None else rate.symbol for rate in rates]

    def gathered(self, at: Mounted, motion: Motion) -> Sequence[Expr]:
        """Return the rate of the rotation vector, to third order in its size.

        (Bortz, IEEE Transactions on Aerospace and Electronic Systems 7 (1971) 61.)
        """
        turn, rate = symbols(self._integrals()), at.frame.rate
        across = at.vector("across_", turn.cross(rate), "turn times rate", "rad^2/s")
        return tuple(rate + across / 2 + turn.cross(across) / 12)

    def measured(self, at: Mounted, errors: Sequence[Expr]) -> Sequence[Expr]:
        v, rate = at.values, sp.Matrix(self.means) if self.integrating else at.frame.rate
        rate -= v.misalignment.cross(rate)
        rate += v.scale.multiply_elementwise(rate)
        shown = rate + sp.Matrix(self.biases or NONE) + sp.Matrix(errors)
        return list(shown if v.step is None else shown.applyfunc(lambda w: v.step * sp.floor(w / v.step + HALF)))


@dataclass(frozen=True)
class Accelerometer(Inertial):
    """Three accelerometers along the hub axes, at a place of the hub.

    They measure the mean over the last period of the specific force: the acceleration of their place without gravity,
    which has no part in it. Where the hub turns, this is a mean of components in hub axes. Before the first period has
    passed they show their errors.

    Parameters
    ----------
    name, delay
        As of a `Part` and an `Instrument`; it measures NAME_x, NAME_y and NAME_z, m/s^2. It takes no `every` and no
        `dropout`.
    noise : number, optional
        Velocity random walk: density of the white noise, m/s^(3/2).
    walk : number
        Random walk of the bias: density of its change, m/s^(5/2); the biases are states, NAME_bias_x, ...
    at : three numbers
        Their place from O in the axes of the hub, m.
    """

    unit, quantity = "m/s^2", "specific force along"
    integral = "speed", "m/s", "integral of the specific force"

    noise: Annotated[Number | None, scalar("noise", "m/s^(3/2)", "velocity random walk", "[0, inf)", absent=0)] = None
    walk: Annotated[Number | None, scalar("walk", "m/s^(5/2)", "random walk of the bias", "[0, inf)")] = 0.0
    at: Annotated[Vector, place("at", "place of the accelerometers")] = (0.0, 0.0, 0.0)
    integrating: bool = field(default=True, init=False)

    def gathered(self, at: Mounted, motion: Motion) -> Sequence[Expr]:
        return tuple(motion.at(at.values.at, f"{self.name}_a", f"the place of {self.name}"))

    def measured(self, at: Mounted, errors: Sequence[Expr]) -> Sequence[Expr]:
        return list(sp.Matrix(self.means) + sp.Matrix(self.biases) + sp.Matrix(errors))
