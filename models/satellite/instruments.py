# SPDX-License-Identifier: Apache-2.0
"""Instruments in place of measured states: gyro with random-walk bias, magnetometer, Sun sensor.

A star tracker measures the attitude, with noise and step of the measured angles. Wheel momenta and orbital position
are known. White noise of gyro and magnetometer is a density, as in data sheets: each sample's deviation is the
density over the square root of the sample period. Errors of a star tracker or a Sun sensor are standard deviations
per measurement, independent of the period.
"""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp

from ..system import Expr, Group, Quantity, RandomStep, Sensor

BIAS = tuple(Quantity(f"bias_{i}", "rad/s", f"bias of the gyro about {i}", f"b_{i}") for i in "xyz")
FIELD = tuple(
    Quantity(f"mag_{i}", "Wb/m^2", f"measured magnetic field along body {i}", rf"\tilde B_{i}") for i in "xyz"
)
SUN = tuple(
    Quantity(f"sensed_{i}", "1", f"measured direction of the Sun along body {i}, zero in shadow", rf"\tilde s_{i}")
    for i in "xyz"
)

_DRIFT = Group("e", tuple(Quantity(f"e_{q.name}", "1", f"change of the {q.description}") for q in BIAS))


def instruments(sensor: Sensor, states: Group, field: Sequence[Expr], sun: Sequence[Expr], plant: Group) -> Sensor:
    """Return the sensor of the state with biased rates, magnetometer and Sun sensor.

    Parameters
    ----------
    sensor : Sensor
        Of the state without bias.
    states : Group
        States, of which the bias is last and not measured.
    field, sun : sequence of Expr
        True values in body axes.
    plant : Group
        Parameters.
    """
    noise = {q.name: Quantity(f"e_{q.name}", "1", f"noise of {q.description}") for q in (*FIELD, *SUN)}
    bias = dict(zip(("wx", "wy", "wz"), (q.symbol for q in BIAS), strict=True))
    seen = states.quantities[: -len(BIAS)]
    measured = [row + bias.get(q.name, 0) for q, row in zip(seen, sensor.measured, strict=False)]
    of_field = plant.field_noise / sp.sqrt(plant.Ts)
    for quantities, values, size in ((FIELD, field, of_field), (SUN, sun, plant.sun_noise)):
        measured += [value + size * noise[q.name].symbol for q, value in zip(quantities, values, strict=True)]
    return Sensor(
        Group("e", (*sensor.noise.quantities, *noise.values())), tuple(measured), Group("seen", (*seen, *FIELD, *SUN))
    )


def drift(states: Group, plant: Group) -> RandomStep:
    """Return the random walk of the bias."""
    size = plant.bias_noise * sp.sqrt(plant.Ts)
    change = {q.name: q.symbol + size * e for q, e in zip(BIAS, _DRIFT.symbols, strict=True)}
    return RandomStep(_DRIFT, tuple(change.get(q.name, q.symbol) for q in states))
