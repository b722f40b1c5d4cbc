# SPDX-License-Identifier: Apache-2.0
"""Symbolic law of a spacecraft, with named measurements, parameters, memory and commands to parts."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Mapping, Sequence

import sympy as sp

from mehvar.base.errors import suggestion

from ...derivation import Expr, free_symbols
from ...quantities import Group, ModelError, Parameter, Quantity
from ...system import Controller, Output
from ..part import Craft, Part
from ..sensors import Gyro, Instrument, StarTracker
from ..terms import Moments
from ..values import Parameters, Value
from .allocation import allocated, check_effects, effects
from .filter import AttitudeFilter, Estimate

Commands = Mapping[str, Expr | Sequence[Expr]]


class Law:
    """A law under construction: `craft.law("pd", write)` calls `write` with it.

    Parameters
    ----------
    name : str
        Of the law.
    craft : Craft
        The assembly.
    attitude, rates : sequence of Symbol
        States of the hub.
    plant : mapping of str to Parameter
        Parameters of the parts.
    """

    def __init__(
        self, name: str, craft: Craft, attitude: Sequence[Expr], rates: Sequence[Expr], plant: Mapping[str, Parameter]
    ) -> None:
        self.name = name
        self._craft, self._plant = craft, plant
        self._attitude, self._rates = attitude, rates
        self._own = Parameters()
        self._memory: dict[Quantity, tuple[Expr, Expr]] = {}
        self._outputs: list[Output] = []
        self._last: dict[str, tuple[Expr, ...]] = {}

    @property
    def attitude(self) -> tuple[Expr, ...]:
        """Attitude coordinates: from the filter, the star tracker or, without sensors, the state."""
        if self._estimate:
            return self._estimate.attitude
        return self._seen(StarTracker, self._attitude, "the attitude")

    @property
    def rates(self) -> tuple[Expr, ...]:
        """Rate of the hub, rad/s: from the filter, the gyro or, without sensors, the state."""
        if self._estimate:
            return self._estimate.rates
        return self._seen(Gyro, self._rates, "the rates")

    @functools.cached_property
    def _estimate(self) -> Estimate | None:
        filters = [(part, at) for part, at in self._craft.parts if isinstance(part, AttitudeFilter)]
        if len(filters) > 1:
            names = ", ".join(part.name for part, _ in filters)
            raise ModelError(f"law {self.name}: the craft has several filters ({names}): only one is allowed")
        return filters[0][0].estimate(filters[0][1], self) if filters else None

    def _seen(self, kind: type[Instrument], state: Sequence[Expr], what: str) -> tuple[Expr, ...]:
        """Return the measurement of the craft's sensor of a kind; the state if the craft has no sensors at all."""
        sensors = [part for part, _ in self._craft.parts if isinstance(part, Instrument)]
        if not sensors:
            return tuple(state)
        seen = [part for part in sensors if isinstance(part, kind)]
        if len(seen) > 1:
            names = ", ".join(part.name for part in seen)
            raise ModelError(f"law {self.name}: several sensors measure {what} ({names}): use law.measured of one")
        if seen:
            return self.measured(seen[0])
        raise ModelError(f"law {self.name}: no sensor measures {what}: add a {kind.__name__}")

    def measured(self, sensor: Instrument) -> tuple[Expr, ...]:
        """Return a sensor's last measurement; if the sensor skips samples, the law's memory stores it."""
        if sensor.continuous:
            return sensor.symbols
        if sensor.name not in self._last:
            self._last[sensor.name] = sensor.symbols if sensor.steady else self._held(sensor)
        return self._last[sensor.name]

    def _held(self, sensor: Instrument) -> tuple[Expr, ...]:
        """Keep the last measurement of a sensor that skips samples."""
        new = sensor.new.symbol > sp.Rational(1, 2)
        pairs = list(zip(sensor.seen(), sensor.before(), strict=True))
        kept = [self.keep(f"{q.name}_last", q.unit, f"last {q.description}", start) for q, start in pairs]
        last = [sp.Piecewise((q.symbol, new), (k, True)) for (q, _), k in zip(pairs, kept, strict=True)]
        self.update_all(kept, last)
        return tuple(last)

    def parameter(
        self, name: str, default: float, unit: str = "1", meaning: str = "", bounds: str = "(-inf, inf)",
        source: str = "",
    ) -> sp.Symbol:  # fmt: skip
        """Declare a parameter of the law and return its symbol."""
        return self._own.add(name, Value(default, bounds, source), unit, meaning or name, bounds)

    def define(self, name: str, value: Expr | sp.Matrix, unit: str = "1", meaning: str = "") -> Expr | sp.Matrix:
        """Name an expression, or the entries of a matrix, as steps of the law and return their symbols.

        The derivation and the code stay short where later expressions use a long one several times.
        """
        frame, title = self._craft.frame, meaning or name
        if not isinstance(value, sp.MatrixBase):
            return frame.define(f"{self.name}_{name}", value, title, unit)
        return value.__class__(
            *value.shape,
            lambda i, j: self.define(f"{name}_{i + 1}_{j + 1}", value[i, j], unit, f"{title} {i + 1} {j + 1}"),
        )

    def keep(self, name: str, unit: str = "1", meaning: str = "", start: Expr | float = 0) -> sp.Symbol:
        """Declare a number in the law's memory and return its symbol; `update` sets its next value."""
        quantity = Quantity(name, unit, meaning or name)
        self._memory[quantity] = sp.sympify(start), quantity.symbol
        return quantity.symbol

    def update(self, kept: sp.Symbol, value: Expr) -> None:
        """Set the value of a stored number after the sample."""
        for quantity, (begin, _) in self._memory.items():
            if quantity.symbol == kept:
                self._memory[quantity] = begin, sp.sympify(value)
                return
        raise ModelError(f"law {self.name}: {kept} is not in the memory; declare it by keep()")

    def update_all(self, kept: Iterable[sp.Symbol], values: Iterable[Expr]) -> None:
        """Set the values of several stored numbers after the sample."""
        for symbol, value in zip(kept, values, strict=True):
            self.update(symbol, value)

    def report(self, output: Output) -> None:
        """Add an output to the run: a function of the state and the law's memory."""
        self._outputs.append(output)

    @property
    def period(self) -> sp.Symbol:
        """Period of the law, s."""
        return self._craft.period

    def torque(self, wanted: Sequence[Expr], by: Iterable[Part]) -> dict[str, tuple[Expr, ...]]:
        """Distribute a torque on the hub to actuators, within their limits.

        Parameters
        ----------
        wanted : sequence of Expr
            Torque about the axes of the hub, N m.
        by : iterable of Part
            Wheels or thrusters with at least three independent axes.

        Returns
        -------
        dict of str to tuple of Expr
            Commands by the names of the actuators.
        """
        return self._shared("torque", wanted, by, [3, 4, 5])

    def wrench(self, force: Sequence[Expr], torque: Sequence[Expr], by: Iterable[Part]) -> dict[str, tuple[Expr, ...]]:
        """Distribute a force, N, and a torque about the centre of mass, N m, to actuators, as `torque` does."""
        return self._shared("wrench", [*force, *torque], by, list(range(6)))

    def _shared(
        self, what: str, wanted: Sequence[Expr], by: Iterable[Part], rows: list[int]
    ) -> dict[str, tuple[Expr, ...]]:
        """Return the commands of actuators that produce `wanted`; `rows` are its components of force and torque."""
        chosen = list(by)
        names = [part.name for part in chosen]
        pairs = [(part, at) for part, at in self._craft.parts if part.name in names]
        where, frame = f"law {self.name}", self._craft.frame
        for part in chosen:
            if part not in [other for other, _ in pairs] or not part.inputs():
                raise ModelError(f"{where}: {part.name} is not an actuator of the craft")
        if len(wanted) != len(rows):
            raise ModelError(f"{where}: {what} has {len(wanted)} components; must have {len(rows)}")
        matrix = effects(pairs, self._centre()).extract(rows, list(range(sum(len(p.inputs()) for p, _ in pairs))))
        definitions = frame.derivation.definitions
        fixed = free_symbols(list(matrix), definitions) <= {q.symbol for q in self._plant.values()}
        if not fixed:
            raise ModelError(
                f"{where}: the effect of {', '.join(names)} depends on the state, so they cannot share a torque"
            )
        check_effects(where, matrix, [part for part, _ in pairs], self._numbers(matrix))
        limits = [_limit(at.values) for part, at in pairs for _ in part.inputs()]
        values = iter(allocated(frame, f"{self.name}_{what}", wanted, pairs, matrix, limits))
        return {part.name: tuple(next(values) for _ in part.inputs()) for part, _ in pairs}

    def _numbers(self, matrix: sp.Matrix) -> dict[sp.Symbol, float]:
        """Return the numbers of a matrix of parameters at their defaults."""
        definitions = self._craft.frame.derivation.definitions
        known = {q.symbol: float(q.default) for q in self._plant.values()}
        for symbol, expr in definitions.items():
            if expr.free_symbols <= known.keys():
                known[symbol] = float(expr.xreplace(known))
        return known

    def _centre(self) -> sp.Matrix:
        """Return the centre of mass of the parts that are fixed to the hub."""
        frame = self._craft.frame
        each = [part.total(at) for part, at in self._craft.parts]
        still = Moments.whole(of for of in each if all(map(frame.is_constant, (of.mass, *of.first))))
        return still.first / still.mass

    def controller(self, title: str, commands: Commands, inputs: Mapping[str, int], sampled: bool) -> Controller:
        """Return the law with commands to parts by name; other commands are zero."""
        given = {name: value if isinstance(value, tuple | list) else (value,) for name, value in commands.items()}
        for name, values in given.items():
            if name not in inputs:
                raise ModelError(
                    f"law {self.name} commands {name!r}{suggestion(str(name), inputs)}: no actuator has this name"
                )
            if len(values) != inputs[name]:
                raise ModelError(f"law {self.name}: {name} has {inputs[name]} inputs, but gets {len(values)} commands")
        if self.__dict__.get("_estimate") and not sampled:
            raise ModelError(
                f"law {self.name} is continuous, but a filter needs a sampled law: leave out sampled=False"
            )
        if self._last and not sampled:
            names = ", ".join(self._last)
            raise ModelError(f"law {self.name} is continuous, but {names} needs a sampled law: leave out sampled=False")
        command = [sp.sympify(u) for name, count in inputs.items() for u in given.get(name, (0,) * count)]
        memory = Group("z", tuple(self._memory))
        return Controller(
            self.name, title, Group("c", tuple(self._own.quantities.values())), tuple(command),
            period=self.period.name if sampled else "", memory=memory,
            start=tuple(begin for begin, _ in self._memory.values()),
            update=tuple(value for _, value in self._memory.values()) if sampled else (),
            rates=() if sampled else tuple(value for _, value in self._memory.values()),
            outputs=tuple(self._outputs),
        )  # fmt: skip


LawText = Callable[[Law], Commands]


def _limit(values: object) -> Expr:
    """Return the limit of an actuator as a parameter of the law; infinity without one."""
    limit: Expr = getattr(values, "torque_limit", getattr(values, "limit", sp.oo))
    return limit
