# SPDX-License-Identifier: Apache-2.0
"""Attitude of a rigid satellite with reaction wheels on an orbit, equations (1)-(7).

The paper uses principal axes and a circular orbit. C transforms components from orbit axes to body axes. The attitude
is three angles (rotations about z, y, x in this order) or a quaternion.
"""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from ..derivation import matrix, vector
from ..parts import Hub, Load
from ..parts.assembly import mount, moved
from ..parts.charts import Chart, EulerChart, QuaternionChart, turn_angles
from ..parts.frame import Frame
from ..parts.part import Craft
from ..system import Derivation, Expr, Group, Quantity
from .orbit import circular_turning, from_inertial
from .wheels import Wheels

ANGLES = (
    Quantity("roll", "rad", "roll, the last turn, about x", r"\varphi"),
    Quantity("pitch", "rad", "pitch, the second turn, about y", r"\theta"),
    Quantity("yaw", "rad", "yaw, the first turn, about z", r"\psi"),
)
QUATERNION = tuple(
    Quantity(f"q{k}", "1", f"quaternion of the body axes in the orbit axes, {part}", f"q_{k}")
    for k, part in enumerate(("scalar", "x", "y", "z"))
)
RATES = tuple(Quantity(f"w{i}", "rad/s", f"inertial rate about body {i}", rf"\omega_{i}") for i in "xyz")

angles = tuple(q.symbol for q in ANGLES)
rates = sp.Matrix([q.symbol for q in RATES])

AXES = ("roll", "pitch", "yaw")
SPEED = "speed of wheel {} relative to the body"


CHARTS: dict[str, Chart] = {"euler": EulerChart(ANGLES), "quaternion": QuaternionChart(QUATERNION)}
"""Charts of the attitude in the orbit axes."""


@dataclass(frozen=True)
class Placed:
    """The attitude with the expressions that the model needs.

    Attributes
    ----------
    rotation : sympy.Matrix
        C, orbit axes to body axes.
    omega : sympy.Matrix
        Omega, rate relative to the orbit axes, in body axes.
    rate : tuple of Expr
        Rates of the chart's coordinates.
    """

    rotation: sp.Matrix
    omega: sp.Matrix
    rate: tuple[Expr, ...]


def euler_rotation() -> sp.Matrix:
    """Return C = R1(roll) R2(pitch) R3(yaw)."""
    return CHARTS["euler"].rotation()


def attitude(chart: str, omega0: Expr, d: Derivation) -> Placed:
    """Define C, Omega and the kinematics in a chart.

    Parameters
    ----------
    chart : {"euler", "quaternion"}
        Three angles, or a unit quaternion with the angles as derived quantities.
    omega0 : Expr
        Rate of the orbit axes, rad/s.
    d : Derivation
        Receives the steps.
    """
    d.section("Attitude and kinematics")
    rotation = matrix("C", CHARTS[chart].rotation(), "orbit axes to body axes", "1", d, "(3)")
    if chart != "euler":
        for quantity, expr in zip(ANGLES, turn_angles(rotation), strict=True):
            d.define(quantity.name, expr, "", quantity.description, "rad", quantity.latex)
    omega = rates - rotation * circular_turning(omega0)
    names = vector("rate_*", omega, "rate relative to the orbit axes about *", "rad/s", r"\Omega_*", d, "(4)")
    turning = CHARTS["euler"].rates(Frame(d, names))
    for quantity, rate, number in zip(ANGLES, turning, ("(5)", "(6)", "(7)"), strict=True):
        d.show(f"{quantity.latex}'", rate, number, f"rate of {quantity.name}, from C' = -[Omega x] C", "rad/s")
    return Placed(rotation, names, tuple(turning if chart == "euler" else CHARTS[chart].rates(Frame(d, names))))


def gravity_gradient(rotation: sp.Matrix, inertia: sp.Matrix, pull: Expr) -> sp.Matrix:
    """Return 3 (mu/r^3) n x (I n), with nadir direction n in body axes and total inertia I."""
    nadir = rotation[:, 2]
    return 3 * pull * nadir.cross(inertia * nadir)


def torque_excess(inertia: sp.Matrix, rate: sp.Matrix, acceleration: sp.Matrix, momentum: sp.Matrix) -> sp.Matrix:
    """Return the left side of (1) and (2): J w' + w x (J w + h)."""
    return inertia * acceleration + rate.cross(inertia * rate + momentum)


def inertia_matrix(plant: Group) -> sp.Matrix:
    """Return J, the inertia of body and wheels minus the wheels' axial inertias, which h includes."""
    if plant.elements("I"):
        return plant.I
    return sp.diag(plant.I_x, plant.I_y, plant.I_z)


def total_inertia(plant: Group, wheels: Wheels) -> sp.Matrix:
    """Return I = J + Iw, the inertia with locked wheels, on which gravity acts."""
    return inertia_matrix(plant) + wheels.locked


def gradient_torque(rotation: sp.Matrix, inertia: sp.Matrix, pull: Expr, d: Derivation) -> sp.Matrix:
    """Define the gravity gradient torque; for principal axes each component is one product of nadir components."""
    torque = gravity_gradient(rotation, inertia, pull)
    if inertia.is_diagonal():
        torque = torque.applyfunc(sp.factor)
    return vector("Tgg_*", torque, "gravity gradient about *", "N m", "T_{gg,*}", d, "(8)-(10)")


def motion_of_the_whole(
    outside: sp.Matrix, motors: sp.Matrix, wheels: Wheels, plant: Group, d: Derivation
) -> tuple[tuple[Expr, ...], tuple[Expr, ...]]:
    """Solve (1) for w' and the rates of the wheels' momenta, given external torques and motor torques.

    Notes
    -----
    From h' = -u and H = J w + h follows: u acts on the body like an external torque, and h enters only through w x h.
    With locked wheels h = Iw w and u = -Iw w' give Euler's equations of the total inertia J + Iw.
    """
    hub = Hub("body", sp.S.One, inertia_matrix(plant).tolist())  # the mass plays no part
    craft = Craft(Frame.of(plant.symbols, rates, d))
    mount(craft, (hub, *wheels.parts(motors)))
    motions = moved(craft, [Load(couple=outside)])
    stored = [part.rates(at, motion) for (part, at), motion in zip(craft.parts, motions, strict=True)]
    title = "angular acceleration about *"
    turning = vector("w*_rate", motions[0].angular, title, "rad/s^2", r"\omega_*'", d, "(1)")
    return tuple(turning), tuple(entry for of in stored for entry in of)


def wheel_speeds(wheels: Wheels, d: Derivation) -> tuple[Expr, ...]:
    """Return the wheel speeds Omega_w relative to the body, from h = Iw (Omega_w + w)."""
    turning = zip(wheels.momenta, wheels.inertia, wheels.axes.T * rates, strict=True)
    speeds = [momentum / inertia - along for momentum, inertia, along in turning]
    return tuple(vector("wheel_*", speeds, SPEED.format("*"), "rad/s", r"\Omega_{w*}", d, labels=wheels.labels))


def energy(rotation: sp.Matrix, wheels: Wheels, plant: Group) -> Expr:
    """Return the rotational energy of body and wheels, and the potential of the gravity gradient."""
    nadir = rotation[:, 2]
    spin = sp.Add(*(h**2 / i for h, i in zip(wheels.momenta, wheels.inertia, strict=True)))
    potential = 3 * plant.omega0**2 * nadir.dot(total_inertia(plant, wheels) * nadir)
    return (rates.dot(inertia_matrix(plant) * rates) + spin + potential) / 2


def inertial_momentum(rotation: sp.Matrix, wheels: Wheels, plant: Group) -> sp.Matrix:
    """Return J w + h in inertial axes, which coincide with the orbit axes at latitude zero."""
    return from_inertial().T * (rotation.T * (inertia_matrix(plant) * rates + wheels.momentum))
