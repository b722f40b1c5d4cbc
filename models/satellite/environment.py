# SPDX-License-Identifier: Apache-2.0
"""Additions to the paper: torques of the environment, wheel friction and limits, sensor noise and quantisation."""

from __future__ import annotations

import sympy as sp

from ..mechanics import quaternion_of_turns
from ..system import Actuator, Derivation, Expr, Group, Quantity, Sensor
from .dynamics import ANGLES, RATES, TORQUES, angles, latitude, rates, torques, wheels

COMMANDED = Group(
    "u_cmd", tuple(Quantity(f"{q.name}_cmd", q.unit, f"commanded {q.description}", f"{q.latex}^c") for q in TORQUES)
)
NOISE = Group(
    "e",
    (
        *(Quantity(f"e_{q.name}", "1", f"noise of the measured {q.name}") for q in ANGLES),
        *(Quantity(f"e_{q.name}", "1", f"noise of the measured {q.name}") for q in RATES),
    ),
)


def environment_torque(rotation: sp.Matrix, plant: Group, d: Derivation) -> sp.Matrix:
    """Define the torques of the Earth's field on a dipole, of the air and of sunlight; zero by default.

    Returns
    -------
    sympy.Matrix
        Their sum in body axes, N m.
    """
    arm = sp.Matrix([plant.arm_x, plant.arm_y, plant.arm_z])
    dipole = sp.Matrix([plant.dipole_x, plant.dipole_y, plant.dipole_z])
    light = -plant.solar_pressure * (1 + plant.reflectance) * plant.area * _sun(plant, d)
    force = rotation * (light - sp.Matrix([_air_force(plant, d), 0, 0]))
    names = [
        d.define(f"F_{i}", force[k], "", f"force of air and sunlight along body {i}", "N", f"F_{i}")
        for k, i in enumerate("xyz")
    ]
    total = dipole.cross(rotation * _field(plant, d)) + arm.cross(sp.Matrix(names))
    return sp.Matrix(
        [
            d.define(f"Tenv_{i}", total[k], "", f"dipole, drag and sunlight about {i}", "N m", f"T_{{env,{i}}}")
            for k, i in enumerate("xyz")
        ]
    )


def _field(plant: Group, d: Derivation) -> sp.Matrix:
    """Return the Earth's field in orbit axes: a dipole along the axis of rotation."""
    tilt = plant.inclination
    strength = plant.field_moment / plant.orbit_radius**3
    parts = (sp.cos(latitude) * sp.sin(tilt), -sp.cos(tilt), 2 * sp.sin(latitude) * sp.sin(tilt))
    return sp.Matrix(
        [
            d.define(f"B_{i}", strength * part, "", f"magnetic field along orbit {i}", "Wb/m^2", f"B_{{o,{i}}}")
            for i, part in zip("xyz", parts, strict=True)
        ]
    )


def _air_force(plant: Group, d: Derivation) -> Expr:
    speed = plant.omega0 * plant.orbit_radius
    force = plant.air_density * speed**2 * plant.drag_coefficient * plant.area / 2
    return d.define("F_air", force, "", "drag", "N", r"F_{air}")


def _sun(plant: Group, d: Derivation) -> sp.Matrix:
    """Return the direction of the Sun in orbit axes: above the orbit plane, and overhead at a given latitude."""
    along = plant.sun_latitude - latitude
    up = plant.sun_elevation
    parts = (sp.cos(up) * sp.sin(along), -sp.sin(up), -sp.cos(up) * sp.cos(along))
    return sp.Matrix(
        [
            d.define(f"sun_{i}", part, "", f"direction of the Sun along orbit {i}", "1", f"s_{i}")
            for i, part in zip("xyz", parts, strict=True)
        ]
    )


def wheel_torque(speeds: tuple[Expr, ...], plant: Group, d: Derivation) -> sp.Matrix:
    """Define the torque of motor and bearing friction on the body."""
    return sp.Matrix(
        [
            d.define(
                f"Tw_{i}",
                torques[k] + plant.wheels * plant.wheel_friction * speeds[k],
                "",
                f"torque of wheel {i} on the body: motor and friction",
                "N m",
                f"T_{{w,{i}}}",
            )
            for k, i in enumerate("xyz")
        ]
    )


def actuator(plant: Group, d: Derivation) -> Actuator:
    """Limit the momentum that the wheels reach within a sample, then the torque.

    The torque comes last, so that nothing passes umax. Both leave zero torque to a wheel within hmax, which is all that
    a run may start with or come to, and then their order makes no difference: both limits hold.
    """
    d.section("Wheels and sensor")
    applied = []
    for k, i in enumerate("xyz"):
        wanted = COMMANDED.symbols[k]
        lower, upper = (wheels[k] - plant.hmax) / plant.Ts, (wheels[k] + plant.hmax) / plant.Ts
        inside = sp.Piecewise((sp.Max(lower, sp.Min(upper, wanted)), plant.wheels > sp.Rational(1, 2)), (wanted, True))
        inside = d.define(f"T{i}_inside", inside, "", f"torque about {i} within hmax", "N m", f"T_{{{i},1}}")
        applied.append(sp.Max(-plant.umax, sp.Min(plant.umax, inside)))
    return Actuator(COMMANDED, tuple(applied))


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
        measurement[quantity.name] = rate + plant.noise_rate * getattr(NOISE, f"e_{quantity.name}")
    if chart == "quaternion":
        turns = [(axis, measurement[name]) for axis, name in ((2, "yaw"), (1, "pitch"), (0, "roll"))]
        measurement |= {f"q{k}": part for k, part in enumerate(quaternion_of_turns(turns))}
    return Sensor(NOISE, tuple(measurement.get(q.name, q.symbol) for q in states))
