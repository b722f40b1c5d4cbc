# SPDX-License-Identifier: Apache-2.0
"""Additions to the paper: torques of the environment, wheel friction, sensor noise and quantisation."""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp

from ..mechanics import quaternion_of_turns
from ..system import Derivation, Expr, Group, Quantity, Sensor
from .drive import coils
from .dynamics import ANGLES, RATES, angles, rates
from .orbit import Orbit
from .wheels import Wheels

NOISE = Group(
    "e",
    (
        *(Quantity(f"e_{q.name}", "1", f"noise of the measured {q.name}") for q in ANGLES),
        *(Quantity(f"e_{q.name}", "1", f"noise of the measured {q.name}") for q in RATES),
    ),
)


def environment_torque(rotation: sp.Matrix, orbit: Orbit, plant: Group, d: Derivation) -> sp.Matrix:
    """Define the torques of magnetic field, air and sunlight; zero by default.

    Returns
    -------
    sympy.Matrix
        Their sum in body axes, N m.
    """
    arm = sp.Matrix([plant.arm_x, plant.arm_y, plant.arm_z])
    dipole = sp.Matrix([plant.dipole_x, plant.dipole_y, plant.dipole_z])
    light = -plant.solar_pressure * (1 + plant.reflectance) * plant.area * orbit.light * _sun(orbit, d)
    force = rotation * (light - _air_force(orbit, plant, d) * orbit.ahead)
    names = [
        d.define(f"F_{i}", force[k], "", f"force of air and sunlight along body {i}", "N", f"F_{i}")
        for k, i in enumerate("xyz")
    ]
    total = dipole.cross(rotation * _field(orbit, d)) + arm.cross(sp.Matrix(names))
    return sp.Matrix(
        [
            d.define(f"Tenv_{i}", total[k], "", f"dipole, drag and sunlight about {i}", "N m", f"T_{{env,{i}}}")
            for k, i in enumerate("xyz")
        ]
    )


def _field(orbit: Orbit, d: Derivation) -> sp.Matrix:
    """Name the Earth's field in orbit axes."""
    return sp.Matrix(
        [
            d.define(f"B_{i}", part, "", f"magnetic field along orbit {i}", "Wb/m^2", f"B_{{o,{i}}}")
            for i, part in zip("xyz", orbit.field, strict=True)
        ]
    )


def body_field(rotation: sp.Matrix, orbit: Orbit, d: Derivation) -> tuple[Expr, ...]:
    """Define the Earth's field in body axes."""
    field = rotation * sp.Matrix(orbit.field)
    return tuple(
        d.define(f"B_body_{i}", field[k], "", f"magnetic field along body {i}", "Wb/m^2", f"B_{i}")
        for k, i in enumerate("xyz")
    )


def coil_torque(field: Sequence[Expr], d: Derivation) -> sp.Matrix:
    """Define the torque of the magnetic torquers."""
    torque = coils.cross(sp.Matrix(field))
    return sp.Matrix(
        [
            d.define(f"Tc_{i}", torque[k], "", f"torque of the torquers about {i}", "N m", f"T_{{c,{i}}}")
            for k, i in enumerate("xyz")
        ]
    )


def _air_force(orbit: Orbit, plant: Group, d: Derivation) -> Expr:
    force = orbit.density * orbit.speed**2 * plant.drag_coefficient * plant.area / 2
    return d.define("F_air", force, "", "drag", "N", r"F_{air}")


def _sun(orbit: Orbit, d: Derivation) -> sp.Matrix:
    """Name the direction to the Sun in orbit axes."""
    return sp.Matrix(
        [
            d.define(f"sun_{i}", part, "", f"direction of the Sun along orbit {i}", "1", f"s_{i}")
            for i, part in zip("xyz", orbit.sun, strict=True)
        ]
    )


def wheel_torque(speeds: tuple[Expr, ...], wheels: Wheels, plant: Group, d: Derivation) -> sp.Matrix:
    """Define the torque of each wheel on the body: motor and bearing friction."""
    return sp.Matrix(
        [
            d.define(
                f"Tw_{i}",
                wheels.torques[k] + wheels.share * plant.wheel_friction * speeds[k],
                "",
                f"torque of wheel {i} on the body: motor and friction",
                "N m",
                f"T_{{w,{i}}}",
            )
            for k, i in enumerate(wheels.labels)
        ]
    )


def sensor(states: Group, chart: str, plant: Group, d: Derivation) -> Sensor:
    """Add noise to angles and rates and round the angles to the sensor's step."""
    step = d.define(
        "sensor_step",
        sp.Piecewise((plant.quantum, plant.quantum > 0), (1, True)),
        "",
        "rounding step of the sensor, 1 when it does not round",
        "rad",
    )
    measurement = {}
    for quantity, angle in zip(ANGLES, angles, strict=True):
        noisy = d.define(
            f"{quantity.name}_noisy",
            angle + plant.noise * getattr(NOISE, f"e_{quantity.name}"),
            "",
            f"{quantity.name} with noise",
            "rad",
        )
        rounded = step * sp.floor(noisy / step + sp.Rational(1, 2))
        measurement[quantity.name] = sp.Piecewise((rounded, plant.quantum > 0), (noisy, True))
    for quantity, rate in zip(RATES, rates, strict=True):
        size = plant.noise_rate / sp.sqrt(plant.Ts)
        measurement[quantity.name] = rate + size * getattr(NOISE, f"e_{quantity.name}")
    if chart == "quaternion":
        turns = [(axis, measurement[name]) for axis, name in ((2, "yaw"), (1, "pitch"), (0, "roll"))]
        measurement |= {f"q{k}": part for k, part in enumerate(quaternion_of_turns(turns))}
    return Sensor(NOISE, tuple(measurement.get(q.name, q.symbol) for q in states))
