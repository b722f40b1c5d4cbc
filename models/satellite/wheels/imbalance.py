# SPDX-License-Identifier: Apache-2.0
"""Unbalanced wheels: their rotation disturbs the body, and the reverse.

A wheel has its balanced masses, a first moment q across its axis (static imbalance) and products of inertia a phi' +
phi a' with its axis a (dynamic imbalance), all about its centre, which lies at r from the centre of mass of the whole
at balance, O. Both vectors turn with the wheel. In free flight the centre of mass of all, not O, is where gravity takes
it; O has the acceleration beta beside that. With t = a x q, s the absolute rate of a wheel about its axis and w its
rate as a vector, the momentum of all, their moment of momentum about O, and that of each wheel about its axis give

    E beta + B w' = -n_l,   A w' + B' beta = T - n,   h' = eta + lambda . w' - t . beta

with lambda = phi - r x t and kappa = a - lambda/I_w. Without imbalance B, lambda and t are zero, and Euler's equation
and h' = -T are left. To eliminate the wheels first, which leaves six equations for any number of them, is the way of
Alcorn, Allard, Schaub: Fully coupled reaction wheel static and dynamic imbalance for spacecraft jitter modeling. J.
Guid. Contr. Dyn. 41(6), 2018; there the hub is apart, and here the whole at balance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp

from ...mechanics import cross_matrix
from ...system import Derivation, Expr, Group, Quantity
from .. import naming
from ..naming import angular_acceleration, matrix, symmetric


@dataclass(frozen=True)
class Rotor:
    """An unbalanced wheel; vectors are in body axes.

    Attributes
    ----------
    label : str
        What it is called in names.
    axis, place : sympy.Matrix
        a, and r of its centre, m.
    inertia, momentum : Expr
        I_w, and h of the balanced masses: I_w s.
    offset, across : sympy.Matrix
        q, and t = a x q, kg m.
    skew : sympy.Matrix
        phi, kg m^2.
    """

    label: str
    axis: sp.Matrix
    place: sp.Matrix
    inertia: Expr
    momentum: Expr
    offset: sp.Matrix
    across: sp.Matrix
    skew: sp.Matrix

    def spin(self, rate: sp.Matrix) -> Expr:
        """Return the speed relative to the body."""
        return self.momentum / self.inertia - self.axis.dot(rate)

    def slip(self, rate: sp.Matrix) -> sp.Matrix:
        """Return w x q, the imbalance's contribution to the momentum."""
        return rate.cross(self.offset) + self.spin(rate) * self.across


@dataclass(frozen=True)
class Imbalance:
    """A set of unbalanced wheels.

    Attributes
    ----------
    rotors : tuple of Rotor
        The wheels.
    mass : Expr
        Of body and wheels, kg.
    states : tuple of Quantity
        The angles that they have turned, rad.
    start : tuple of Expr
        These at the start.
    """

    rotors: tuple[Rotor, ...]
    mass: Expr
    states: tuple[Quantity, ...]
    start: tuple[Expr, ...]


def imbalance(
    plant: Group, s: Group, axes: sp.Matrix, inertia: Sequence[Expr], momenta: Sequence[Expr], d: Derivation
) -> Imbalance:
    """Define the directions of the imbalances of wheels along the columns of `axes`."""
    labels = [str(k + 1) for k in range(axes.cols)]
    states = tuple(Quantity(f"angle{k}", "rad", f"angle that wheel {k} has turned", rf"\theta_{k}") for k in labels)
    rotors = tuple(_rotor(k, plant, axes[:, k], inertia[k], momenta[k], states[k].symbol, d) for k in range(axes.cols))
    return Imbalance(rotors, plant.mass, states, tuple(s.wheel_angle_0))


def _rotor(k: int, plant: Group, axis: sp.Matrix, inertia: Expr, momentum: Expr, angle: Expr, d: Derivation) -> Rotor:
    label = str(k + 1)
    first, second = _across(axis, label, d)
    turned = angle + plant.imbalance_phase[k]
    q = plant.static_imbalance[k] * (sp.cos(angle) * first + sp.sin(angle) * second)
    t = plant.static_imbalance[k] * (sp.cos(angle) * second - sp.sin(angle) * first)
    phi = plant.dynamic_imbalance[k] * (sp.cos(turned) * first + sp.sin(turned) * second)
    return Rotor(
        label,
        axis,
        plant.wheel_places[:, k],
        inertia,
        momentum,
        vector(f"q{label}", q, f"static imbalance of wheel {label}", "kg m", f"q_{label}", d),
        vector(f"t{label}", t, f"static imbalance of wheel {label}, a quarter turn ahead", "kg m", f"t_{label}", d),
        vector(f"skew{label}", phi, f"dynamic imbalance of wheel {label}", "kg m^2", rf"\phi_{label}", d),
    )


def _across(axis: sp.Matrix, label: str, d: Derivation) -> tuple[sp.Matrix, sp.Matrix]:
    """Return two directions normal to an axis, each turned into the other by a quarter turn.

    Notes
    -----
    Duff, Burgess, Christensen, Hery, Kensler, Liani, Villemin: Building an orthonormal basis, revisited. Journal of
    Computer Graphics Techniques 6(1), 2017. It has a value for every axis.
    """
    x, y, z = axis
    side = sp.Piecewise((sp.S.One, z >= 0), (-sp.S.One, True))
    side = d.define(f"side{label}", side, "", f"side of the body's z to which axis {label} points", latex=f"s_{label}")
    share = d.define(f"share{label}", -1 / (side + z), "", f"of axis {label}", latex=f"c_{label}")
    first = sp.Matrix([1 + side * x**2 * share, side * x * y * share, -side * x])
    second = sp.Matrix([x * y * share, side + y**2 * share, -y])
    title = f"across axis {label}"
    return (
        vector(f"across{label}", first, f"{title}, where its angle is zero", "1", f"b_{label}", d),
        vector(f"ahead{label}", second, f"{title}, a quarter turn ahead", "1", f"c_{label}", d),
    )


def vector(name: str, value: sp.Matrix, title: str, unit: str, latex: str, d: Derivation) -> sp.Matrix:
    """Name the components of a vector in body axes."""
    return naming.vector(f"{name}_*", value, f"{title}, along *", unit, f"{latex.replace('_', '_{')},*}}", d)


def accelerations(
    inertia: sp.Matrix, torque: sp.Matrix, motors: Sequence[Expr], rate: sp.Matrix, wheels: Imbalance, d: Derivation
) -> tuple[sp.Matrix, tuple[Expr, ...]]:
    """Solve the momentum balances of the whole and of the wheels.

    Parameters
    ----------
    inertia : sympy.Matrix
        J, of body and wheels at balance, less what each wheel has about its own axis; kg m^2.
    torque : sympy.Matrix
        On the whole from outside, N m.
    motors : sequence of Expr
        Torques of the wheels' motors and bearings on the body, N m.
    rate : sympy.Matrix
        Inertial rate of the body, rad/s.
    wheels : Imbalance
        The wheels.
    d : Derivation
        Receives the steps.

    Returns
    -------
    sympy.Matrix
        Angular acceleration, rad/s^2.
    tuple of Expr
        Rates of the momenta h, N m.
    """
    A, B, E = inertia, sp.zeros(3), wheels.mass * sp.eye(3)
    n, shaken = rate.cross(inertia * rate), sp.zeros(3, 1)
    answers = []
    for rotor, motor in zip(wheels.rotors, motors, strict=True):
        a, r, q, t, label = rotor.axis, rotor.place, rotor.offset, rotor.across, rotor.label
        lever = vector(f"rt{label}", r.cross(t), f"r x t of wheel {label}", "kg m^2", f"l_{label}", d)
        answer = vector(f"lambda{label}", rotor.skew - lever, "what w' gives to h'", "kg m^2", rf"\lambda_{label}", d)
        kappa = a - answer / rotor.inertia
        eta, nu = _forces(rotor, motor, rate, d)
        A += (
            2 * r.dot(q) * sp.eye(3) - q * r.T - r * q.T - a * lever.T - lever * a.T - answer * answer.T / rotor.inertia
        )
        B -= cross_matrix(q) + t * kappa.T
        E -= t * t.T / rotor.inertia
        n += kappa * eta + r.cross(nu) + q.cross(rate.cross(rate.cross(r))) + _turning(rotor, rate)
        shaken += nu + t * eta / rotor.inertia
        answers.append((eta, answer, t))
    A = symmetric("A", A, "inertia at these angles of the wheels", "kg m^2", "A", d)
    E = symmetric("E", E, "mass less what the wheels take up", "kg", "E", d)
    inverse = symmetric("G", E.inv(method="ADJ"), "inverse of E", "1/kg", "G", d)
    B = matrix("B", B, "first moment", "kg m", d)
    n = vector("n", n, "moments that no acceleration makes", "N m", "n_", d)
    shaken = vector("nl", shaken, "forces that no acceleration of the body makes", "N", r"n_l", d)
    whole = symmetric("whole", A - B.T * inverse * B, "inertia about the centre of mass of all", "kg m^2", "S", d)
    inverted = symmetric("K", whole.inv(method="ADJ"), "inverse of the inertia", "1/kg/m^2", "K", d)
    net = vector("N", torque - n + B.T * inverse * shaken, "torque less what rates make", "N m", "N_", d)
    alpha = angular_acceleration(inverted * net, d)
    beta = vector("beta", -inverse * (B * alpha + shaken), "acceleration of O", "m/s^2", r"\beta_", d)
    return alpha, tuple(eta + answer.dot(alpha) - t.dot(beta) for eta, answer, t in answers)


def _forces(rotor: Rotor, motor: Expr, rate: sp.Matrix, d: Derivation) -> tuple[Expr, sp.Matrix]:
    """Define the torque on a wheel about its axis, and q'' without accelerations."""
    a, q, t, label = rotor.axis, rotor.offset, rotor.across, rotor.label
    pull = rate.cross(rate.cross(rotor.place))
    eta = -motor - t.dot(pull) - a.dot(rate) * a.cross(rotor.skew).dot(rate)
    eta = d.define(f"eta{label}", eta, "", f"torque on wheel {label}", "N m", rf"\eta_{label}")
    spin = rotor.spin(rate)
    nu = spin * rate.cross(a).cross(q) + (rate + spin * a).cross(rotor.slip(rate))
    return eta, vector(f"nu{label}", nu, f"centrifugal force of wheel {label}", "N", rf"\nu_{label}", d)


def _turning(rotor: Rotor, rate: sp.Matrix) -> sp.Matrix:
    """Return the rate of -(s phi + (w . phi) a) at constant rates."""
    a, phi, spin = rotor.axis, rotor.skew, rotor.spin(rate)
    carried = rate.cross(a)
    momentum = carried * rotor.momentum
    turned = (rate + spin * a).cross(phi) * rotor.momentum / rotor.inertia
    return momentum - turned - spin * rate.dot(a.cross(phi)) * a - rate.dot(phi) * carried


def extra_energy(rate: sp.Matrix, wheels: Imbalance) -> Expr:
    """Return the imbalances' contribution to the rotational energy."""
    slip = _slip(rate, wheels)
    own = sp.Add(
        *(
            rate.cross(rotor.place).dot(rotor.slip(rate)) - rotor.momentum / rotor.inertia * rate.dot(rotor.skew)
            for rotor in wheels.rotors
        )
    )
    return own - slip.dot(slip) / (2 * wheels.mass)


def extra_momentum(rate: sp.Matrix, wheels: Imbalance) -> sp.Matrix:
    """Return the imbalances' contribution to the angular momentum about the centre of mass, in body axes."""
    total = -sum((rotor.offset for rotor in wheels.rotors), sp.zeros(3, 1)).cross(_slip(rate, wheels)) / wheels.mass
    for rotor in wheels.rotors:
        total += rotor.place.cross(rotor.slip(rate)) + rotor.offset.cross(rate.cross(rotor.place))
        total -= rotor.momentum / rotor.inertia * rotor.skew + rate.dot(rotor.skew) * rotor.axis
    return total


def _slip(rate: sp.Matrix, wheels: Imbalance) -> sp.Matrix:
    return sum((rotor.slip(rate) for rotor in wheels.rotors), sp.zeros(3, 1))
