# SPDX-License-Identifier: Apache-2.0
"""Names of the states, inputs and outputs of the spacecraft with sloshing fuel."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import sympy as sp

from ..system import Expr, Group, Interval, Parameter, Quantity

VELOCITY = tuple(
    Quantity(f"v{axis}", "m/s", f"velocity of the tank centre O along body {axis}", f"v_{axis}") for axis in "xyz"
)
RATE = tuple(
    Quantity(f"w{axis}", "rad/s", f"body rate about {axis}", rf"\Omega_{k}") for k, axis in enumerate("xyz", 1)
)
ATTITUDE = tuple(Quantity(f"att{k}", "rad", f"attitude angle {k}", rf"a_{k}") for k in (1, 2, 3))
QUATERNION = tuple(
    Quantity(f"q{k}", "1", f"attitude quaternion, component {k}, scalar first", f"q_{k}") for k in range(4)
)
MOMENTS = tuple(Quantity(f"M{axis}", "N m", f"control moment about body {axis}", f"M_{axis}") for axis in "xyz")
GIMBALS = (
    Quantity("delta1", "rad", "gimbal angle of the thrust in the x-z plane", r"\delta_1"),
    Quantity("delta2", "rad", "gimbal angle of the thrust towards y", r"\delta_2"),
)
INPUTS = Group("u", MOMENTS + GIMBALS)
DEMAND = Group(
    "reduced",
    (
        Quantity("ay", "m/s^2", "acceleration a_y of O, the paper's u1", "u_1"),
        Quantity("az", "m/s^2", "acceleration a_z of O, the paper's u2", "u_2"),
        Quantity("alpha1", "rad/s^2", "angular acceleration about x, the paper's u3", "u_3"),
        Quantity("alpha2", "rad/s^2", "angular acceleration about y, the paper's u4", "u_4"),
        Quantity("alpha3", "rad/s^2", "angular acceleration about z, the paper's u5", "u_5"),
    ),
)
"""Inputs of the reduced model (20)-(26): the accelerations that physical inputs produce."""

velocity = sp.Matrix([q.symbol for q in VELOCITY])
rate = sp.Matrix([q.symbol for q in RATE])


def _member(family: str, k: int, quantity: Quantity) -> Quantity:
    return dataclasses.replace(quantity, family=family, index=k)


def angle_quantities(k: int) -> tuple[Quantity, Quantity]:
    """Return the angles of pendulum k."""
    return (
        _member("phi", k, Quantity(f"phi{k}", "rad", f"angle of pendulum {k} from -x", rf"\varphi_{k}")),
        _member("theta", k, Quantity(f"theta{k}", "rad", f"azimuth of pendulum {k}, from z towards y", rf"\theta_{k}")),
    )


def angle_rate_quantities(k: int) -> tuple[Quantity, Quantity]:
    """Return the angle rates of pendulum k."""
    return (
        _member("phi_dot", k, Quantity(f"phi{k}_dot", "rad/s", f"rate of phi{k}", rf"\dot\varphi_{k}")),
        _member("theta_dot", k, Quantity(f"theta{k}_dot", "rad/s", f"rate of theta{k}", rf"\dot\theta_{k}")),
    )


def direction_quantities(k: int) -> tuple[Quantity, ...]:
    """Return the unit vector from the pivot to bob k, in body axes."""
    return _vector(k, "s", "1", f"direction of bob {k} from its pivot", "s")


def arm_rate_quantities(k: int) -> tuple[Quantity, ...]:
    """Return the inertial rate of the direction of bob k, in body axes."""
    return _vector(k, "sigma", "1/s", f"inertial rate of s{k}", r"\sigma")


def _vector(k: int, name: str, unit: str, meaning: str, latex: str) -> tuple[Quantity, ...]:
    components = (
        (axis, Quantity(f"{name}{k}{axis}", unit, f"{meaning}, body {axis}", f"{latex}_{{{k}{axis}}}"))
        for axis in "xyz"
    )
    return tuple(_member(f"{name}{axis}", k, q) for axis, q in components)


def rod(phi: Expr, theta: Expr) -> sp.Matrix:
    """Return the unit vector from pivot to bob (7), in body axes."""
    return sp.Matrix([-sp.cos(phi), sp.sin(phi) * sp.sin(theta), sp.sin(phi) * sp.cos(theta)])


@dataclass(frozen=True)
class Pendulum:
    """Parameters of one pendulum.

    Attributes
    ----------
    name : str
        Number of the pendulum, or "i" for the generic one.
    mass, length, pivot, inertia, damping : Expr
        m_i, l_i, h_i, I_i and eps_i.
    """

    name: str
    mass: Expr
    length: Expr
    pivot: Expr
    inertia: Expr
    damping: Expr


def pendulum_parameters(k: int, like: Group) -> tuple[Parameter, ...]:
    """Return the parameters of pendulum k, with defaults of pendulum 1 or, for k >= 2, of pendulum 2."""
    model = min(k, 2)
    parameters = []
    for q in like:
        if isinstance(q, Parameter):
            family = q.name.replace(str(model), "")
            parameters.append(dataclasses.replace(renumbered(q, model, k), family=family, index=k))
    return tuple(parameters)


def renumbered(parameter: Parameter, old: int, new: int) -> Parameter:
    """Return a parameter of pendulum `old` with the number of pendulum `new`."""
    if old is new:
        return parameter
    return dataclasses.replace(
        parameter,
        name=parameter.name.replace(str(old), str(new)),
        description=parameter.description.replace(f"pendulum {old}", f"pendulum {new}"),
        latex=parameter.latex.replace(str(old), f"{{{new}}}"),
        source=f"addition: pendulums beyond the second start from the numbers of pendulum {old}",
    )


def point_allowed(inertia: Parameter) -> Parameter:
    """Return a bob's moment of inertia as a parameter that may be zero, for ball joints."""
    return dataclasses.replace(
        inertia,
        positive=False,
        bounds=Interval(0.0, float("inf"), False, True),
        description=inertia.description.partition(" (")[0],
    )
