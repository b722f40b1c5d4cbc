# SPDX-License-Identifier: Apache-2.0
"""Physical laws as gates that wrong terms should violate; a model declares applicable ones and their quantities.

A gate compares two sides at random points. Balances differentiate a quantity along the motion and compare its rate
with the supply. Symmetries transform point and right-hand side together. Limits compare with a smaller system.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from mehvar.physics.machine import Array, Machine, Points, points

TOLERANCE = 1e-9
"""Relative tolerance. The shipped equations have errors up to 1.2e-12, mostly from differences along the motion.
Terms below 1e-9 of their equation remain undetected.
"""
PointFunction = Callable[[Points], Array | float]
Change = Callable[[Points], Points]


@dataclass(frozen=True)
class Gate:
    """Two sides that are equal for correct equations.

    Attributes
    ----------
    name : str
        Statement that must hold.
    sides : callable
        Points -> both sides, each of shape (n,) or (n, size), or a number.
    """

    name: str
    sides: Callable[[Points], tuple[Array | float, Array | float]]

    def error(self, at: Points) -> float:
        """Return the largest difference over the points, relative to the larger side if that exceeds 1."""
        with np.errstate(all="ignore"):
            left, right = map(_columns, self.sides(at))
            scale = np.maximum(1, np.maximum(np.abs(left).max(axis=1), np.abs(right).max(axis=1)))
            error = (np.abs(left - right).max(axis=1) / scale).max()
        return float(error) if np.isfinite(error) else float("inf")


@dataclass(frozen=True)
class Symmetry:
    """Transformation of points that also transforms the right-hand side.

    Attributes
    ----------
    name : str
        Its name.
    signs : frozenset of str
        States, inputs and parameters that change sign.
    swaps : mapping of str to str
        Quantities that take the value of another.
    shifts : mapping of str to float
        Amounts that are added afterwards.
    """

    name: str
    signs: frozenset[str] = frozenset()
    swaps: Mapping[str, str] | None = None
    shifts: Mapping[str, float] | None = None

    def moved(self, at: Points) -> Points:
        """Return the transformed points."""
        swaps, shifts = self.swaps or {}, self.shifts or {}
        names = {*self.signs, *swaps, *shifts}
        return at.moved(**{k: self._sign(k) * at[swaps.get(k, k)] + shifts.get(k, 0.0) for k in names})

    def image(self, rate: Array, names: list[str]) -> Array:
        """Return the transformed rates of the states."""
        places = [names.index((self.swaps or {}).get(k, k)) for k in names]
        return np.asarray(rate[:, places] * np.array([self._sign(k) for k in names]))

    def _sign(self, name: str) -> int:
        return -1 if name in self.signs else 1


def gates(declared: list[Gate], subject: Machine) -> dict[str, float]:
    """Return the error of each gate."""
    at = points(subject)
    return {gate.name: gate.error(at) for gate in declared}


def balance(
    name: str, quantity: PointFunction, supply: PointFunction, flow: str = "rhs", where: Change | None = None
) -> Gate:
    """Require that a quantity, such as energy, changes at the stated rate, such as power.

    Parameters
    ----------
    name : str
        Name of the gate.
    quantity, supply : callable
        Points -> values, shape (n,) or (n, size), or a number.
    flow : str
        Name of the right-hand side that moves the points.
    where : callable, optional
        Points -> points at which it holds.
    """

    def sides(at: Points) -> tuple[Array, Array]:
        here = at if where is None else where(at)
        return here.along(lambda p: _columns(quantity(p)), flow), _columns(supply(here))

    return Gate(name, sides)


def never_rises(name: str, quantity: PointFunction, where: Change) -> Gate:
    """Require that a quantity does not grow at the chosen points, such as energy without inputs."""

    def sides(at: Points) -> tuple[Array, Array]:
        rate = where(at).along(lambda p: _columns(quantity(p)))
        return np.maximum(rate, 0), np.zeros_like(rate)

    return Gate(name, sides)


def symmetric(symmetry: Symmetry, flow: str = "rhs") -> Gate:
    """Require that the right-hand side at transformed points is the transformed right-hand side."""

    def sides(at: Points) -> tuple[Array, Array]:
        names = [q.name for q in at.machine.system.states]
        return symmetry.moved(at).call(flow), symmetry.image(at.call(flow), names)

    return Gate(symmetry.name, sides)


def smaller(
    name: str, part: Machine, source: Callable[[str], str], values: Mapping[str, float | PointFunction]
) -> Gate:
    """Require that a system moves like a smaller one.

    Parameters
    ----------
    name : str
        Name of the gate.
    part : Machine
        The smaller system.
    source : callable
        Maps the name of a quantity to the quantity of the smaller system that it copies, or "".
    values : mapping
        Other quantities: numbers, or functions of the smaller system's points.
    """

    def sides(at: Points) -> tuple[Array, Array]:
        small = points(part, len(at.values["x"]))
        names = [q.name for g in (at.machine.system.states, at.machine.system.inputs) for q in g]
        names += [q.name for q in at.machine.system.parameters]
        copied = {k: small[source(k)] for k in names if source(k) and k not in values}
        settings = {k: v(small) if callable(v) else v for k, v in values.items()}
        large = at.moved(**copied, **settings)
        shared = [q.name for q in at.machine.system.states if source(q.name)]
        return large.result("rhs", *shared), small.result("rhs", *(source(k) for k in shared))

    return Gate(name, sides)


def identity(name: str, left: PointFunction, right: PointFunction) -> Gate:
    """Require that two quantities agree."""
    return Gate(name, lambda at: (left(at), right(at)))


MEASUREMENTS = "measurements without noise"


def measures(truth: PointFunction, of: Callable[[Array], Array] = np.asarray, where: Change | None = None) -> Gate:
    """Require that a sensor without noise measures the true value.

    Parameters
    ----------
    truth : callable
        Points -> true value of the measurement.
    of : callable
        Extracts the value to compare from the vector that laws receive, shape (n, size).
    where : callable, optional
        Points -> points at which it holds, such as those without rounding.
    """

    def sides(at: Points) -> tuple[Array, Array]:
        here, sensor = at if where is None else where(at), at.machine.system.sensor
        assert sensor is not None
        none = np.zeros((len(here.values["x"]), max(len(sensor.noise), 1)))
        shown = at.machine("measure", here.values["x"], none, here.values["p"])
        return _columns(of(shown)), _columns(truth(here))

    return Gate(MEASUREMENTS, sides)


def derived_equations() -> Gate:
    """Require that the evaluated rates fulfil the derived equations, as generation does."""

    def left(at: Points) -> Array:
        rates = at.result("rhs", *at.machine.system.rates)
        return at.machine("residual", at.values["x"], at.values["u"], at.values["p"], rates)

    return identity(
        "derived equations", left, lambda at: np.zeros((len(at.values["x"]), len(at.machine.system.residual)))
    )


def dot(a: Array, b: Array) -> Array:
    """Return scalar products point by point."""
    return np.asarray(np.sum(a * b, axis=-1))


def _columns(values: Array | float) -> Array:
    """Return one row per point; a number, such as the power 0, is the same at each."""
    array = np.asarray(values)
    return array.reshape(len(array) if array.ndim else 1, -1)
