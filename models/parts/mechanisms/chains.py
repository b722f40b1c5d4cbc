# SPDX-License-Identifier: Apache-2.0
"""Chains of rigid bodies, solved from tip to hub and back at a cost linear in the number of bodies.

Let x = (acceleration of joint P_k, absolute angular acceleration) of body k, which needs the wrench A x + b at P_k.
The joint adds S q'' + z to the x of the previous body, and the force along S is Q:

    D q'' = Q - S.(A z + b) - U.x,   U = A S,   D = S.U,

The previous body gets the terms A - U U'/D and b + A z + U (Q - S.(A z + b))/D at P_k. All vectors are in hub axes.
The recursion is that of Featherstone: Rigid body dynamics algorithms. Springer 2008, chapter 7.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Annotated

import sympy as sp

from mehvar.base.errors import value_text

from ...derivation import Expr
from ...geometry import Shape
from ...mechanics import cross_matrix, quaternion_product, quaternion_rotation
from ...quantities import ModelError, Quantity
from ..frame import ZERO, point_inertia, quaternion, triple
from ..motion import Motion
from ..part import Mounted, Part, points, start
from ..terms import Aggregates, Contribution, Load, State
from ..values import Complete, Number, Parameters, Rows, Tensor, Vector, direction, place, scalar, tensor
from .joints import freedom

JOINTS = ("hinge", "slider", "ball")


@dataclass(frozen=True)
class Link(metaclass=Complete):
    """A rigid body of a chain with its joint. All vectors are in hub axes with every coordinate at zero.

    Parameters
    ----------
    mass : number
        kg.
    inertia : three numbers, or three rows
        About its own centre of mass, kg m^2.
    joint : {"hinge", "slider", "ball"}
        Its connection to the previous body; for the first link, to the hub.
    axis : three numbers
        Axis of a hinge or slider, of any length.
    at : three numbers
        Position of the joint from the previous joint, for the first link from O, m.
    centre : three numbers
        Centre of mass from the joint, m.
    stiffness, damping : number, optional
        Of a hinge, N m/rad and N m s/rad, or a slider, N/m and N s/m; a ball joint has damping only.
    motor : bool
        True if a law commands a torque or force; not for a ball joint.
    """

    mass: Annotated[Number, scalar("m", "kg", "mass")]
    inertia: Annotated[Tensor, tensor("J", "moment of inertia about its centre of mass")]
    joint: str = "hinge"
    axis: Annotated[Vector | None, direction("a", "axis")] = None
    at: Annotated[Vector, place("r", "joint from the one before")] = (0, 0, 0)
    centre: Annotated[Vector, place("c", "centre of mass from the joint, at zero")] = (0, 0, 0)
    stiffness: Annotated[Number | None, scalar("k", "N m/rad", "stiffness", "[0, inf)", absent=0)] = None
    damping: Annotated[Number | None, scalar("d", "N m s/rad", "damping", "[0, inf)", absent=0)] = None
    motor: bool = False

    def __post_init__(self) -> None:
        if self.joint not in JOINTS:
            raise ModelError(f"joint = {value_text(self.joint)}: must be one of {', '.join(JOINTS)}")
        if (self.axis is None) != (self.joint == "ball"):
            raise ModelError(
                f"axis = {value_text(self.axis)}: give an axis to a hinge or slider, and none to a ball joint"
            )
        if self.joint == "ball" and (self.motor or self.stiffness is not None):
            raise ModelError("a ball joint cannot have a motor or a stiffness; leave them out")

    @property
    def units(self) -> dict[str, str]:
        """Units of fields that depend on the joint."""
        return {"stiffness": "N/m", "damping": "N s/m"} if self.joint == "slider" else {}


@dataclass(frozen=True)
class _Body:
    """A link in motion.

    Attributes
    ----------
    k, name : int and str
        Its number from the hub, and start of the names of its states.
    link, values : Link and namespace
        The link, and the symbols of its fields.
    rotation : sympy.Matrix
        From the axes at zero.
    arm : sympy.Matrix
        P_k from the P of the body before it, m.
    before_rate, rate : sympy.Matrix
        Rate of the body before it and its own, relative to the hub, rad/s.
    columns : list of sympy.Matrix
        S of each speed of the joint.
    slip : sympy.Matrix
        S q', of which a slider moves P_k.
    centre : sympy.Matrix
        Centre of mass from P_k, m.
    inertia : sympy.Matrix
        About the centre of mass, kg m^2.
    """

    k: int
    name: str
    link: Link
    values: SimpleNamespace
    rotation: sp.Matrix
    arm: sp.Matrix
    before_rate: sp.Matrix
    rate: sp.Matrix
    columns: list[sp.Matrix]
    slip: sp.Matrix
    centre: sp.Matrix
    inertia: sp.Matrix

    @property
    def speeds(self) -> list[sp.Symbol]:
        """Symbols of the joint's speeds."""
        return [q.symbol for q in speeds_of(self.name, self.link)]

    @property
    def place(self) -> sp.Symbol:
        """Symbol of the coordinate of a hinge or slider."""
        return places_of(self.name, self.link)[0].symbol

    @property
    def drive(self) -> Expr:
        """Force or torque of the motor."""
        return _motor(self.name, self.link).symbol if self.link.motor else sp.S.Zero

    @property
    def forces(self) -> list[Expr]:
        """Force of motor, damper and spring along each speed."""
        spring = self.values.stiffness * self.place
        return [self.drive - self.values.damping * speed - spring for speed in self.speeds]

    def bias(self, before: sp.Matrix) -> sp.Matrix:
        """Return z, the joint's contribution to x that does not depend on its acceleration."""
        turned = before.cross(self.slip)
        return sp.Matrix([*(2 * turned), *ZERO]) if self.link.joint == "slider" else sp.Matrix([*ZERO, *turned])


@dataclass(frozen=True)
class _Step:
    """An eliminated speed: q'' = free - share.x, with x the acceleration of the body nearer to the hub."""

    column: sp.Matrix
    free: Expr
    share: sp.Matrix


@dataclass(frozen=True)
class Chain(Part):
    """Rigid bodies in a row, connected by hinges, sliders and ball joints.

    Parameters
    ----------
    name : str
        As of a `Part`. The states of link k are NAME_k_angle and NAME_k_rate of a hinge, NAME_k_place and NAME_k_speed
        of a slider and, of a ball joint, the quaternion NAME_k_q0, ... from its axes to those of the body before it and
        the rate NAME_kx, ... relative to that body, in that body's axes. The input of a motor is NAME_k_motor.
    links : sequence of Link
        From the hub to the tip.
    """

    links: Annotated[Sequence[Link], Rows(Link)] = ()

    def _named(self) -> list[tuple[str, Link]]:
        return [(f"{self.name}_{k}", link) for k, link in enumerate(self.links, 1)]

    def inputs(self) -> tuple[Quantity, ...]:
        return tuple(_motor(name, link) for name, link in self._named() if link.motor)

    def states(self, scenario: Parameters) -> tuple[State, ...]:
        result: list[State] = []
        for name, link in self._named():
            places = places_of(name, link)
            if link.joint == "ball":
                result += (State(q, sp.Integer(int(k == 0))) for k, q in enumerate(places))
            else:
                result += (start(q, scenario) for q in places)
            result += (start(q, scenario) for q in speeds_of(name, link))
        return tuple(result)

    def projection(self) -> dict[sp.Symbol, Expr]:
        result: dict[sp.Symbol, Expr] = {}
        for name, link in self._named():
            if link.joint == "ball":
                q = [place.symbol for place in places_of(name, link)]
                size = sp.sqrt(sp.Add(*(entry**2 for entry in q)))
                result |= {entry: entry / size for entry in q}
        return result

    def _bodies(self, at: Mounted) -> list[_Body]:
        rotation, rate, bodies = sp.eye(3), ZERO, list[_Body]()
        for k, ((name, link), v) in enumerate(zip(self._named(), at.values.links, strict=True), 1):
            bodies.append(_body(at, k, name, link, v, rotation, rate))
            rotation, rate = bodies[-1].rotation, bodies[-1].rate
        return bodies

    def aggregates(self, at: Mounted) -> Aggregates:
        joint, velocity, result = ZERO, ZERO, Aggregates()
        for body in self._bodies(at):
            k, v, speeds = body.k, body.values, body.speeds
            sliding = body.slip if body.link.joint == "slider" else ZERO
            velocity += body.before_rate.cross(body.arm) + sliding
            joint = at.vector(f"P{k}_", joint + body.arm, f"place of joint {k}", "m")
            velocity = at.vector(f"dP{k}_", velocity, f"speed of joint {k}", "m/s")
            centre = at.vector(f"C{k}_", joint + body.centre, f"centre of mass of body {k}", "m")
            moving = at.vector(f"dC{k}_", velocity + body.rate.cross(body.centre), f"its speed, body {k}", "m/s")
            power = body.drive * speeds[0] - v.damping * sp.Add(*(speed**2 for speed in speeds))
            result += Aggregates.body(v.mass, centre, body.inertia, moving, body.rate)
            result += Aggregates(potential=v.stiffness * body.place**2 / 2, power=power)
        return result

    def shapes(self, at: Mounted) -> tuple[Shape, ...]:
        """Return the joints and the centre of mass of each link."""
        joint, path, balls = ZERO, [], []
        for body in self._bodies(at):
            joint = joint + body.arm
            centre = joint + body.centre
            path.append(joint)
            balls.append(Shape(body.name, "ball", points(centre), "orange"))
        return Shape(f"{self.name} joints", "rod", points(*path, centre), "orange"), *balls

    def contribution(self, at: Mounted) -> Contribution:
        _, matrix, bias = self._steps(at)
        load = Load(-bias[:3, :], ZERO, -bias[3:, :])
        return Contribution(loads=(load,), matrix=matrix)

    def _steps(self, at: Mounted) -> tuple[list[list[_Step]], sp.Matrix, sp.Matrix]:
        """Eliminate from tip to hub; return the eliminated accelerations, and A and b at O."""
        w, matrix, bias, steps = at.frame.rate, sp.zeros(6, 6), sp.zeros(6, 1), []
        for body in reversed(self._bodies(at)):
            k = body.k
            rate = at.vector(f"W{k}_", w + body.rate, f"absolute rate of body {k}", "rad/s")
            own, free = _rigid(at, body, rate)
            matrix, bias = _matrix(at, f"A{k}_", matrix + own, k), _six(at, f"b{k}_", bias + free, k)
            before = _rate_before(at, body)
            bias = _six(at, f"z{k}_", bias + matrix * body.bias(before), k)
            solved = []
            for i, (column, force) in enumerate(zip(body.columns, body.forces, strict=True)):
                step, matrix, bias = _eliminated(at, f"{k}{'abc'[i]}", column, force, matrix, bias)
                solved.append(step)
            steps.append(solved)
            matrix, bias = _shifted(at, k, matrix, bias, body.arm, before)
        return steps[::-1], matrix, bias

    def rates(self, at: Mounted, motion: Motion) -> tuple[Expr, ...]:
        linear, angular, result = motion.origin, motion.angular, list[Expr]()
        for solved, body in zip(self._steps(at)[0], self._bodies(at), strict=True):
            k, before = body.k, _rate_before(at, body)
            linear = linear + angular.cross(body.arm) + before.cross(before.cross(body.arm))
            x = _six(at, f"x{k}_", sp.Matrix([*linear, *angular]), k)
            own: list[Expr] = []
            for i, step in reversed(list(enumerate(solved))):
                value = at.define(f"a{k}{'abc'[i]}", step.free - step.share.dot(x), f"acceleration of joint {k}")
                x += step.column * value
                own.insert(0, value)
            x = _six(at, f"y{k}_", x + body.bias(before), k)
            linear, angular = x[:3, :], x[3:, :]
            result += [*_place_rates(body), *own]
        return tuple(result)


def _rate_before(at: Mounted, body: _Body) -> sp.Matrix:
    k, rate = body.k - 1, at.frame.rate + body.before_rate
    return at.vector(f"W{k}_", rate, f"absolute rate of body {k}", "rad/s")


def places_of(name: str, link: Link) -> tuple[Quantity, ...]:
    """Return the coordinates of a joint: angle, position or quaternion."""
    if link.joint == "ball":
        return quaternion(f"{name}_q", f"quaternion of {name}")
    return (freedom(link.joint, name)[0],)


def speeds_of(name: str, link: Link) -> tuple[Quantity, ...]:
    """Return the speeds of a joint."""
    if link.joint == "ball":
        return triple(name, "rad/s", f"rate of {name}")
    return (freedom(link.joint, name)[1],)


def _motor(name: str, link: Link) -> Quantity:
    return Quantity(f"{name}_motor", freedom(link.joint, name)[2].unit, f"motor of {name}")


def _place_rates(body: _Body) -> list[Expr]:
    if body.link.joint != "ball":
        return list(body.speeds)
    q = [place.symbol for place in places_of(body.name, body.link)]
    return list(quaternion_product((sp.S.Zero, *body.speeds), q) / 2)


def _body(
    at: Mounted, k: int, name: str, link: Link, v: SimpleNamespace, before: sp.Matrix, before_rate: sp.Matrix
) -> _Body:
    """Define position and motion of link k from those of the previous body."""
    places, speeds = ([q.symbol for q in of(name, link)] for of in (places_of, speeds_of))
    arm, rotation, rate = before * v.at, before, before_rate
    if link.joint == "ball":
        columns = [before[:, i] for i in range(3)]
        rotation = before * at.matrix(f"Q{k}_", quaternion_rotation(places).T, f"rotation of joint {k}", "1")
    else:
        axis = at.vector(f"axis{k}_", v.axis, f"axis of joint {k} at zero, of length one", "1")
        columns = [at.vector(f"e{k}_", before * axis, f"axis of joint {k}", "1")]
    slip = sum((column * speed for column, speed in zip(columns, speeds, strict=True)), ZERO)
    if link.joint == "hinge":
        cosine, sine = at.frame.circle(places[0])
        along = axis * axis.T
        rotation = before * (along + cosine * (sp.eye(3) - along) + sine * cross_matrix(axis))
    if link.joint == "slider":
        arm = arm + places[0] * columns[0]
        columns = [sp.Matrix([*column, *ZERO]) for column in columns]
    else:
        rate = at.vector(f"w{k}_", before_rate + slip, f"rate of body {k} relative to the hub", "rad/s")
        columns = [sp.Matrix([*ZERO, *column]) for column in columns]
    rotation = at.matrix(f"R{k}_", rotation, f"rotation of body {k}", "1")
    inertia = at.tensor(f"J{k}_", rotation * v.inertia * rotation.T, f"inertia of body {k}", "kg m^2")
    centre = at.vector(f"c{k}_", rotation * v.centre, f"centre of mass of body {k} from its joint", "m")
    arm = at.vector(f"d{k}_", arm, f"joint {k} from the one before", "m")
    return _Body(k, name, link, v, rotation, arm, before_rate, rate, columns, slip, centre, inertia)


def _rigid(at: Mounted, body: _Body, rate: sp.Matrix) -> tuple[sp.Matrix, sp.Matrix]:
    """Return A and b of a free body about its joint."""
    k, mass = body.k, body.values.mass
    first = at.vector(f"s{k}_", mass * body.centre, f"first moment of body {k} about its joint", "kg m")
    inertia = body.inertia + point_inertia(mass, body.centre)
    inertia = at.tensor(f"I{k}_", inertia, f"inertia about joint {k}", "kg m^2")
    arm = cross_matrix(first)
    matrix = sp.Matrix(sp.BlockMatrix([[mass * sp.eye(3), -arm], [arm, inertia]]))
    return matrix, sp.Matrix([*rate.cross(rate.cross(first)), *rate.cross(inertia * rate)])


def _eliminated(
    at: Mounted, name: str, column: sp.Matrix, force: Expr, matrix: sp.Matrix, bias: sp.Matrix
) -> tuple[_Step, sp.Matrix, sp.Matrix]:
    """Eliminate a speed of a joint from the equations of the links beyond it."""
    row = _six(at, f"U{name}_", matrix * column, name)
    if column.dot(row) == 0:
        raise ModelError(f"{at.name}: no mass and no inertia moves with joint {name}: give a link beyond it an inertia")
    inverse = at.define(f"D{name}", 1 / column.dot(row), f"inverse inertia of joint {name}")
    share = _six(at, f"G{name}_", inverse * row, name)
    rest = at.define(f"Q{name}", force - column.dot(bias), f"force of joint {name}")
    reduced = _matrix(at, f"B{name}_", matrix - share * row.T, name)
    return _Step(column, inverse * rest, share), reduced, _six(at, f"f{name}_", bias + share * rest, name)


def _shifted(
    at: Mounted, k: int, matrix: sp.Matrix, bias: sp.Matrix, arm: sp.Matrix, rate: sp.Matrix
) -> tuple[sp.Matrix, sp.Matrix]:
    """Move A and b from joint k to the previous joint; `rate` is the rate of the body in between."""
    far = at.vector(f"cc{k}_", rate.cross(rate.cross(arm)), f"centripetal acceleration of joint {k}", "m/s^2")
    hat = cross_matrix(arm)
    wrench = bias + matrix * sp.Matrix([*far, *ZERO])
    wrench = sp.Matrix([*wrench[:3, :], *(wrench[3:, :] + arm.cross(wrench[:3, :]))])
    mass, mixed, inertia = matrix[:3, :3], matrix[:3, 3:], matrix[3:, 3:]
    moved = at.matrix(f"N{k}_", mixed - mass * hat, f"shift to joint {k - 1}")
    turned = inertia + hat * mixed - moved.T * hat
    result = sp.Matrix(sp.BlockMatrix([[mass, moved], [moved.T, turned]]))
    return _matrix(at, f"H{k}_", result, k), _six(at, f"h{k}_", wrench, k)


def _six(at: Mounted, name: str, entries: sp.Matrix, k: object) -> sp.Matrix:
    return sp.Matrix(
        [at.define(f"{name}{i}", entry, f"joint {k}, component {i}") for i, entry in enumerate(entries, 1)]
    )


def _matrix(at: Mounted, name: str, entries: sp.Matrix, k: object) -> sp.Matrix:
    """Name the entries of a symmetric matrix."""
    result = sp.zeros(6, 6)
    for i in range(6):
        for j in range(i + 1):
            entry = at.define(f"{name}{i + 1}{j + 1}", entries[i, j], f"inertia at joint {k}, {i + 1}{j + 1}")
            result[i, j] = result[j, i] = entry
    return result
