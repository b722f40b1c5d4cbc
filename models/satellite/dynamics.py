# SPDX-License-Identifier: Apache-2.0
"""Attitude of a rigid satellite with reaction wheels on an orbit, equations (1)-(7).

The paper's body axes are principal axes, its orbit a circle. C takes components from orbit to body axes; the attitude
is three angles (turns about z, y, x in this order) or a quaternion.
"""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from ..mechanics import angle_rates, frame_turn, quaternion_of_turns, quaternion_rates, quaternion_rotation
from ..system import Derivation, Expr, Group, Quantity
from .orbit import Orbit
from .wheels import Wheels, extra_energy, extra_momentum
from .wheels import accelerations as shaken

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


@dataclass(frozen=True)
class Chart:
    """A chart of the attitude with the expressions that the model needs.

    Attributes
    ----------
    states : tuple of Quantity
        Coordinates of the chart.
    rotation : sympy.Matrix
        C, orbit axes to body axes.
    omega : sympy.Matrix
        Omega, rate relative to the orbit axes, in body axes.
    rate : tuple of Expr
        Rates of the coordinates.
    quaternion : tuple of Expr
        The attitude as a quaternion.
    """

    states: tuple[Quantity, ...]
    rotation: sp.Matrix
    omega: sp.Matrix
    rate: tuple[Expr, ...]
    quaternion: tuple[Expr, ...]


def euler_rotation() -> sp.Matrix:
    """Return C = R1(roll) R2(pitch) R3(yaw)."""
    roll, pitch, yaw = angles
    return frame_turn(0, roll) * frame_turn(1, pitch) * frame_turn(2, yaw)


def attitude(chart: str, turning: sp.Matrix, d: Derivation) -> Chart:
    """Define C, Omega and the kinematics in a chart.

    Parameters
    ----------
    chart : {"euler", "quaternion"}
        Three angles, or a unit quaternion with the angles as derived quantities.
    turning : sympy.Matrix
        Rate of the orbit axes in these (3): about -y, because z is nadir and x is velocity; rad/s.
    d : Derivation
        Receives the steps.
    """
    d.section("Attitude and kinematics")
    quaternion = chart == "quaternion"
    states = QUATERNION if quaternion else ANGLES
    coordinates = tuple(q.symbol for q in states)
    rotation = _named_rotation(quaternion_rotation(coordinates) if quaternion else euler_rotation(), d)
    if quaternion:
        _define_angles(rotation, d)
    omega = rates - rotation * turning
    names = [
        d.define(f"rate_{i}", omega[k], "(4)", f"rate relative to the orbit axes about {i}", "rad/s", rf"\Omega_{i}")
        for k, i in enumerate("xyz")
    ]
    turning = angle_rates(euler_rotation(), angles, names)
    for quantity, rate, number in zip(ANGLES, turning, ("(5)", "(6)", "(7)"), strict=True):
        d.show(f"{quantity.latex}'", rate, number, f"rate of {quantity.name}, from C' = -[Omega x] C", "rad/s")
    rate = quaternion_rates(coordinates, names) if quaternion else turning
    turns = coordinates if quaternion else quaternion_of_turns([(axis, angles[axis]) for axis in (2, 1, 0)])
    return Chart(states, rotation, sp.Matrix(names), tuple(rate), tuple(turns))


def _named_rotation(rotation: sp.Matrix, d: Derivation) -> sp.Matrix:
    title = "orbit axes to body axes"
    return sp.Matrix(
        3,
        3,
        lambda i, j: d.define(f"C{i + 1}{j + 1}", rotation[i, j], "(3)", title, "1", f"C_{{{i + 1}{j + 1}}}"),
    )


def _define_angles(rotation: sp.Matrix, d: Derivation) -> None:
    """Define three angles from C, as measurements of laws if the state is a quaternion."""
    sine = sp.Max(-1, sp.Min(1, rotation[0, 2]))
    values = (
        sp.atan2(rotation[1, 2], rotation[2, 2]),
        -sp.asin(sine),
        sp.atan2(rotation[0, 1], rotation[0, 0]),
    )
    for quantity, expr in zip(ANGLES, values, strict=True):
        d.define(quantity.name, expr, "", quantity.description, "rad", quantity.latex)


def gravity_gradient(rotation: sp.Matrix, inertia: sp.Matrix, pull: Expr) -> sp.Matrix:
    """Return 3 (mu/r^3) n x (I n), with nadir direction n in body axes and total inertia I."""
    nadir = rotation[:, 2]
    return 3 * pull * nadir.cross(inertia * nadir)


def torque_excess(inertia: sp.Matrix, rate: sp.Matrix, acceleration: sp.Matrix, momentum: sp.Matrix) -> sp.Matrix:
    """Return the left side of (1) and (2): J w' + w x (J w + h)."""
    return inertia * acceleration + rate.cross(inertia * rate + momentum)


def inertia_matrix(plant: Group) -> sp.Matrix:
    """Return J, the inertia of body and wheels without the wheels' axial inertias, which are part of h."""
    if plant.elements("I"):
        return plant.I
    return sp.diag(plant.I_x, plant.I_y, plant.I_z)


def total_inertia(plant: Group, wheels: Wheels) -> sp.Matrix:
    """Return I = J + Iw, the inertia with locked wheels, on which gravity acts."""
    return inertia_matrix(plant) + wheels.locked


def gradient_torque(rotation: sp.Matrix, inertia: sp.Matrix, pull: Expr, d: Derivation) -> sp.Matrix:
    """Define the gravity gradient torque; for principal axes, each component has one product of nadir components."""
    torque = gravity_gradient(rotation, inertia, pull)
    return sp.Matrix(
        [
            d.define(
                f"Tgg_{i}",
                sp.factor(torque[k]) if inertia.is_diagonal() else torque[k],
                "(8)-(10)",
                f"gravity gradient about {i}",
                "N m",
                f"T_{{gg,{i}}}",
            )
            for k, i in enumerate("xyz")
        ]
    )


def accelerations(torque: sp.Matrix, wheels: Wheels, plant: Group, d: Derivation) -> tuple[Expr, Expr, Expr]:
    """Solve the momentum balance (1) for w', given the torque on the body and the wheels' momentum.

    Notes
    -----
    h' = -u and H = J w + h, so u acts on the body as an external torque would and h enters through w x h only. With
    locked wheels h = Iw w and u = -Iw w', which leaves Euler's equations of the total inertia J + Iw.
    """
    inertia = inertia_matrix(plant)
    if plant.elements("I"):
        return _coupled_accelerations(inertia, torque, wheels, d)
    unknown = sp.Matrix(sp.symbols("wx' wy' wz'", real=True))
    balance = torque_excess(inertia, rates, unknown, wheels.momentum) - torque
    names = []
    for k in range(3):
        rest, coefficient = balance[k].subs(unknown[k], 0), balance[k].coeff(unknown[k])
        names.append(_acceleration(k, -rest / coefficient, d))
    return tuple(names)


def _coupled_accelerations(inertia: sp.Matrix, torque: sp.Matrix, wheels: Wheels, d: Derivation) -> tuple[Expr, ...]:
    """Solve the balance with a full inertia tensor, whose inverse depends on parameters only."""
    inverse = inertia.inv(method="ADJ")
    named = sp.zeros(3)
    for i in range(3):
        for j in range(i, 3):
            title = "inverse of the inertia"
            named[i, j] = named[j, i] = d.define(
                f"K{i + 1}{j + 1}", inverse[i, j], "(1)", title, "1/kg/m^2", f"K_{{{i + 1}{j + 1}}}"
            )
    net = torque - torque_excess(inertia, rates, sp.zeros(3, 1), wheels.momentum)
    net = sp.Matrix(
        [
            d.define(f"N_{i}", net[k], "(1)", f"torque less w x H about {i}", "N m", f"N_{i}")
            for k, i in enumerate("xyz")
        ]
    )
    return tuple(_acceleration(k, (named * net)[k], d) for k in range(3))


def motion_of_the_whole(
    outside: sp.Matrix, motors: sp.Matrix, wheels: Wheels, plant: Group, d: Derivation
) -> tuple[tuple[Expr, ...], tuple[Expr, ...]]:
    """Solve for w' and the rates of the wheels' momenta, given external torques and motor torques."""
    if wheels.imbalance:
        turning, stored = shaken(inertia_matrix(plant), outside, tuple(motors), rates, wheels.imbalance, d)
        return tuple(turning), stored
    turned = accelerations(outside + wheels.axes * motors, wheels, plant, d)
    return turned, tuple(-wheels.share * torque for torque in motors)


def _acceleration(k: int, value: Expr, d: Derivation) -> Expr:
    i = "xyz"[k]
    return d.define(f"w{i}_rate", value, "(1)", f"angular acceleration about {i}", "rad/s^2", rf"\omega_{i}'")


def wheel_speeds(wheels: Wheels, d: Derivation) -> tuple[Expr, ...]:
    """Return the wheel speeds relative to the body: h = Iw (Omega_w + w)."""
    along = wheels.axes.T * rates
    return tuple(
        d.define(
            f"wheel_{i}",
            wheels.momenta[k] / wheels.inertia[k] - along[k],
            "",
            f"speed of wheel {i} relative to the body",
            "rad/s",
            rf"\Omega_{{w{i}}}",
        )
        for k, i in enumerate(wheels.labels)
    )


def energy(rotation: sp.Matrix, pull: Expr, wheels: Wheels, plant: Group) -> Expr:
    """Return the rotational energy of body and wheels, and the potential of the gravity gradient."""
    nadir = rotation[:, 2]
    spin = sp.Add(*(h**2 / i for h, i in zip(wheels.momenta, wheels.inertia, strict=True)))
    potential = 3 * pull * nadir.dot(total_inertia(plant, wheels) * nadir)
    balanced = (rates.dot(inertia_matrix(plant) * rates) + spin + potential) / 2
    return balanced + extra_energy(rates, wheels.imbalance) if wheels.imbalance else balanced


def inertial_momentum(rotation: sp.Matrix, orbit: Orbit, wheels: Wheels, plant: Group) -> sp.Matrix:
    """Return J w + h in inertial axes, which coincide with the orbit axes at latitude zero of a circle."""
    in_body = inertia_matrix(plant) * rates + wheels.momentum
    if wheels.imbalance:
        in_body += extra_momentum(rates, wheels.imbalance)
    return orbit.axes.T * (rotation.T * in_body)
