# SPDX-License-Identifier: Apache-2.0
"""Extensions of the paper: environment torques, wheel friction, sensor noise and quantisation."""

from __future__ import annotations

import sympy as sp

from ..derivation import vector
from ..system import Derivation, Expr, Group, Quantity, Sensor
from .dynamics import ANGLES, CHARTS, RATES, angles, rates
from .orbit import magnetic_field, sun
from .wheels import Wheels

NOISE = Group(
    "e",
    (
        *(Quantity(f"e_{q.name}", "1", f"noise of the measured {q.name}") for q in ANGLES),
        *(Quantity(f"e_{q.name}", "1", f"noise of the measured {q.name}") for q in RATES),
    ),
)


def environment_torque(rotation: sp.Matrix, plant: Group, d: Derivation) -> sp.Matrix:
    """Define the torques of magnetic field, air and sunlight; zero by default.

    Returns
    -------
    sympy.Matrix
        Their sum in body axes, N m.
    """
    arm = sp.Matrix([plant.arm_x, plant.arm_y, plant.arm_z])
    dipole = sp.Matrix([plant.dipole_x, plant.dipole_y, plant.dipole_z])
    direction = vector("sun_*", sun(plant), "direction of the Sun along orbit *", "1", "s_*", d)
    light = -plant.solar_pressure * (1 + plant.reflectance) * plant.area * direction
    speed = plant.omega0 * plant.orbit_radius
    drag = plant.air_density * speed**2 * plant.drag_coefficient * plant.area / 2
    drag = d.define("F_air", drag, "", "drag", "N", r"F_{air}")
    force = rotation * (light - drag * sp.Matrix([1, 0, 0]))
    force = vector("F_*", force, "force of air and sunlight along body *", "N", "F_*", d)
    field = vector("B_*", magnetic_field(plant), "magnetic field along orbit *", "Wb/m^2", "B_{o,*}", d)
    total = dipole.cross(rotation * field) + arm.cross(force)
    return vector("Tenv_*", total, "dipole, drag and sunlight about *", "N m", "T_{env,*}", d)


def wheel_torque(speeds: tuple[Expr, ...], wheels: Wheels, plant: Group, d: Derivation) -> sp.Matrix:
    """Define the torque of each wheel on the body: motor and bearing friction."""
    torques = sp.Matrix(wheels.torques.symbols) + wheels.share * plant.wheel_friction * sp.Matrix(speeds)
    title = "torque of wheel * on the body: motor and friction"
    return vector("Tw_*", torques, title, "N m", "T_{w,*}", d, labels=wheels.labels)


def sensor(states: Group, chart: str, plant: Group, d: Derivation) -> Sensor:
    """Return a sensor that adds noise to angles and rates and rounds angles to a step."""
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
    turned = CHARTS[chart].of_angles([measurement[q.name] for q in ANGLES])
    measurement |= dict(zip((q.name for q in CHARTS[chart].states), turned, strict=True))
    return Sensor(NOISE, tuple(measurement.get(q.name, q.symbol) for q in states))
