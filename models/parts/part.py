# SPDX-License-Identifier: Apache-2.0
"""Interface of a part, and derivation of its equations from its energy.

The kinetic energy of a part that is mounted on a hub is quadratic in the velocity V of the hub's origin O, in the rate
W of its axes, and in the part's own speeds:

    T = m V.V/2 + V.(W x s + p) + W.J W/2 + W.h + T_own.

Mass m, first moment s, inertia J, relative momentum p, relative angular momentum h (all about O, in hub axes) and
T_own are the `Aggregates` of the part. They determine the part's `Contribution` to the hub's equations and the part's
own equations, with row i

    G_i . (a, W') + sum_j D_ij q_j'' = Q_i - k_i,    G_i = (dp/dq_i', dh/dq_i'),

with the acceleration a = V' + W x V of O.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import MISSING, dataclass, field, replace
from dataclasses import fields as dataclass_fields
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Self

import sympy as sp

from ..derivation import Expr, free_symbols
from ..events import Event
from ..geometry import Shape
from ..mechanics import cross_matrix
from ..quantities import ModelError, Quantity
from ..system import Condition
from .frame import AXES, ZERO, Frame
from .table import read_table
from .values import Complete, Parameters, conditions, kinds


@dataclass(frozen=True)
class Coordinate:
    """A degree of freedom of a part.

    Attributes
    ----------
    speed : Quantity
        Its rate, a state.
    place : Quantity, optional
        The coordinate, a state; None if nothing depends on it, as for a wheel.
    """

    speed: Quantity
    place: Quantity | None = None


@dataclass(frozen=True)
class Moments:
    """Mass of a body and its moments about O.

    Attributes
    ----------
    mass : Expr
        kg.
    first : sympy.Matrix
        First moment s about O, kg m, a function of the coordinates.
    inertia : sympy.Matrix
        J about O, kg m^2.
    momentum, angular : sympy.Matrix
        Relative momentum p = s', kg m/s, and relative angular momentum h about O, kg m^2/s; linear in the speeds.
    """

    mass: Expr = sp.S.Zero
    first: sp.Matrix = field(default_factory=lambda: ZERO)
    inertia: sp.Matrix = field(default_factory=lambda: sp.zeros(3, 3))
    momentum: sp.Matrix = field(default_factory=lambda: ZERO)
    angular: sp.Matrix = field(default_factory=lambda: ZERO)

    @classmethod
    def whole(cls, each: Iterable[Moments]) -> Moments:
        """Return the moments of several bodies as one."""
        bodies = list(each)
        mass = sp.Add(*(of.mass for of in bodies))
        first, momentum, angular = (
            sum((getattr(of, name) for of in bodies), ZERO) for name in ("first", "momentum", "angular")
        )
        return Moments(mass, first, sum((of.inertia for of in bodies), sp.zeros(3, 3)), momentum, angular)


@dataclass(frozen=True)
class Aggregates(Moments):
    """Masses, momenta and energies that determine the motion of a part and its effect on the hub.

    Attributes
    ----------
    energy : Expr
        Kinetic energy relative to the hub, J; quadratic in the speeds.
    potential : Expr
        Potential energy of springs, J.
    forces : tuple of Expr
        Generalised force of dampers and motors on each coordinate.
    prescribed : tuple of (Expr or None)
        Prescribed acceleration of each coordinate, or None for a free one; empty if all are free.
    power : Expr
        Power of dampers and motors that are not in `forces`, W.
    """

    energy: Expr = sp.S.Zero
    potential: Expr = sp.S.Zero
    forces: tuple[Expr, ...] = ()
    prescribed: tuple[Expr | None, ...] = ()
    power: Expr = sp.S.Zero


@dataclass(frozen=True)
class Row:
    """Equation of a coordinate: G . (a, W') + D q'' = right.

    Attributes
    ----------
    linear, angular : sympy.Matrix
        The two parts of G.
    coupling : tuple of Expr
        Row of D.
    right : Expr
        Q - k.
    """

    linear: sp.Matrix
    angular: sp.Matrix
    coupling: tuple[Expr, ...]
    right: Expr


@dataclass(frozen=True)
class Load:
    """A force at a point of the hub, N, and a couple, N m."""

    force: sp.Matrix = field(default_factory=lambda: ZERO)
    at: sp.Matrix = field(default_factory=lambda: ZERO)
    couple: sp.Matrix = field(default_factory=lambda: ZERO)


@dataclass(frozen=True)
class Follower:
    """A mass that follows a point P of the hub along e. Its force on the hub at P is (pull - mass e . a_P) e.

    Attributes
    ----------
    mass : Expr
        kg.
    along, at : sympy.Matrix
        e, of length one, and P from O, m.
    pull : Expr
        N.
    """

    mass: Expr
    along: sp.Matrix
    at: sp.Matrix
    pull: Expr = sp.S.Zero


@dataclass(frozen=True)
class Contribution(Moments):
    """Terms that a part adds to the equations of the hub; the assembly forms those of a rigid body from its moments.

    Attributes
    ----------
    loads : tuple of Load
        Forces between part and hub, and the terms of p', h' and J' W without accelerations.
    rows : tuple of Row
        Equations of the part's coordinates, which the assembly eliminates.
    held : tuple of Row
        Equations of prescribed coordinates, which determine the motor's force.
    followers : tuple of Follower
        Masses that follow the hub along one direction each.
    matrix : sympy.Matrix
        Symmetric (6, 6): additional resistance to a and W', beyond that of a rigid body.
    """

    loads: tuple[Load, ...] = ()
    rows: tuple[Row, ...] = ()
    held: tuple[Row, ...] = ()
    followers: tuple[Follower, ...] = ()
    matrix: sp.Matrix = field(default_factory=lambda: sp.zeros(6, 6))


@dataclass(frozen=True)
class Motion:
    """Accelerations of an assembly.

    Attributes
    ----------
    frame : Frame
        The axes of the hub.
    centre : sympy.Matrix
        Point of the hub for which `linear` holds, from O.
    linear, angular : sympy.Matrix
        Acceleration of that point, and W', in the axes of the hub.
    own : tuple of Expr
        q'' of the part's rows, in their order.
    pulls : tuple of Expr
        mass e . a_P - pull of the part's followers, N, in their order.
    """

    frame: Frame
    centre: sp.Matrix
    linear: sp.Matrix
    angular: sp.Matrix
    own: tuple[Expr, ...] = ()
    pulls: tuple[Expr, ...] = ()

    @property
    def origin(self) -> sp.Matrix:
        """Acceleration of O."""
        return self.at(ZERO, "aO", "O")

    def at(self, point: sp.Matrix, name: str, title: str) -> sp.Matrix:
        """Return the acceleration of a point of the hub; names of its steps begin with `name`."""
        arm = self.frame.vector(f"{name}_arm_", point - self.centre, f"{title}: place from the centre", "m")
        result = self.linear + transport(self.frame, self.angular, "turn_", arm)
        return self.frame.vector(name, result, f"acceleration of {title}", "m/s^2")


def transport(frame: Frame, angular: sp.Matrix, name: str, arm: sp.Matrix) -> sp.Matrix:
    """Return W' x r + W x (W x r): the relative acceleration of two points of the hub.

    The result is a matrix times r. Its columns are named once for all points; `name` is the start of their names.
    """
    products, result = rate_products(frame), ZERO
    turning = cross_matrix(angular) + products - products.trace() * sp.eye(3)
    for k, axis in enumerate(AXES):
        if arm[k] != 0:
            title = f"acceleration of a point per distance along {axis}"
            result += arm[k] * frame.vector(f"{name}{axis}_", turning[:, k], title, "1/s^2")
    return result


def rate_products(frame: Frame) -> sp.Matrix:
    """Return the matrix W W' with a name for each product."""
    w = frame.rate
    entry = {
        (i, j): frame.define(f"w{AXES[i]}w{AXES[j]}", w[i] * w[j], "product of rates", "rad^2/s^2")
        for i in range(3)
        for j in range(i, 3)
    }
    return sp.Matrix(3, 3, lambda i, j: entry[min(i, j), max(i, j)])


def gyroscopic(frame: Frame, inertia: sp.Matrix, angular: sp.Matrix) -> sp.Matrix:
    """Return W x (J W + h), with shared products of rates if J depends only on parameters."""
    w = frame.rate
    if any(e != 0 and not frame.is_constant(e) for e in inertia) or not angular.is_zero_matrix:
        spin = frame.vector("total_H", inertia * w + angular, "angular momentum", "kg m^2/s")
        return w.cross(spin)
    products = rate_products(frame)
    result = []
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        parts = [
            frame.define(f"gyro_J{AXES[i]}", inertia[k, k] - inertia[j, j], "difference of inertias", "kg m^2")
            * products[j, k],
            inertia[k, i] * products[i, j] - inertia[j, i] * products[i, k],
            inertia[j, k] * (products[j, j] - products[k, k]),
        ]
        result.append(sp.Add(*parts))
    return sp.Matrix(result)


@dataclass(frozen=True)
class State:
    """A state of a part, and its initial value as a function of plant and scenario parameters."""

    quantity: Quantity
    start: Expr = sp.S.Zero


@dataclass(frozen=True)
class Jump:
    """A state's value after a sample: `after`, and a normal number of standard deviation `size`."""

    state: Quantity
    after: Expr = sp.S.Zero
    size: Expr = sp.S.Zero


_TURNING = sp.Rational(1, 1000)
"""Torque scale divided by the trace of the inertia, rad/s^2: wheels of small spacecraft turn them by thousandths. A
tenth or ten times this value makes the arrows of pictures longer or shorter."""


@dataclass(frozen=True)
class Craft:
    """Assembly as a part sees it.

    Attributes
    ----------
    frame : Frame
        The axes of the hub.
    turn : sympy.Matrix
        From inertial axes to those of the hub; empty where no part depends on the attitude.
    quaternion : sequence of Expr
        Quaternion of the attitude, scalar first; empty in the same case.
    period : Expr
        Period of laws and sensors, s.
    parts : list of (Part, Mounted)
        All parts, in their order.
    """

    frame: Frame
    turn: sp.Matrix = field(default_factory=lambda: sp.zeros(0, 0))
    quaternion: Sequence[Expr] = ()
    period: sp.Symbol = field(default_factory=lambda: sp.Symbol("Ts", real=True))
    parts: list[tuple[Part, Mounted]] = field(default_factory=list)

    @property
    def rotation(self) -> sp.Matrix:
        """Matrix `turn` with a name for each entry."""
        return self.frame.matrix("turn_", self.turn, "inertial axes to those of the hub", "1")

    def whole(self) -> Moments:
        """Return the moments of all parts."""
        return Moments.whole(part.aggregates(at) for part, at in self.parts)

    @property
    def _body(self) -> Aggregates:
        """Mass and inertia of the first part that has them at all times, from which the picture takes its scales."""
        for part, at in self.parts:
            of = part.aggregates(at)
            if of.mass != 0 and all(self.frame.is_constant(entry) for entry in of.inertia):
                return of
        return Aggregates(sp.Integer(12), inertia=sp.eye(3))

    @property
    def reach(self) -> Expr:
        """Length of arrows in the picture, m: twice a radius of gyration."""
        return 2 * sp.sqrt(self._body.inertia.trace() / self._body.mass)

    @property
    def strength(self) -> Expr:
        """Scale of torques in the picture, N m: such a torque turns the body with about 0.003 rad/s^2."""
        return self._body.inertia.trace() * _TURNING

    def loads(self) -> list[Load]:
        """Return the external loads on the parts."""
        return [load for part, at in self.parts for load in part.loads(at)]

    def picture(self, known: set[sp.Symbol], defaults: Mapping[sp.Symbol, float]) -> tuple[Shape, ...]:
        """Return the shapes of all parts in inertial axes, with O at rest.

        Parameters
        ----------
        known : set of Symbol
            States, inputs and parameters of the system.
        defaults : mapping of Symbol to number
            Defaults of all parameters; the picture uses them for parameters that the equations lack.
        """
        idle = {symbol: value for symbol, value in defaults.items() if symbol not in known}
        shapes = []
        for shape in (shape for part, at in self.parts for shape in part.shapes(at)):
            places = [self.turn.T * sp.Matrix(point).xreplace(idle) for point in shape.points]
            if free_symbols([e for place in places for e in place], self.frame.derivation.definitions) <= known:
                shapes.append(replace(shape, points=points(*places)))
        return tuple(shapes)


@dataclass(frozen=True)
class Mounted:
    """A part within an assembly.

    Attributes
    ----------
    name : str
        Name of the part, and start of the names of its parameters, states and steps.
    values : namespace
        Symbols or numbers of the part's fields.
    craft : Craft
        The assembly.
    """

    name: str
    values: SimpleNamespace
    craft: Craft

    @property
    def frame(self) -> Frame:
        """Hub axes of the assembly."""
        return self.craft.frame

    def define(self, name: str, expr: Expr, title: str, unit: str = "") -> Expr:
        """Name an expression after the part."""
        return self.frame.define(f"{self.name}_{name}", expr, f"{self.name}: {title}", unit)

    def vector(self, name: str, entries: sp.Matrix, title: str, unit: str = "") -> sp.Matrix:
        """Name the components of a vector of the part."""
        return self.frame.vector(f"{self.name}_{name}", entries, f"{self.name}: {title}", unit)

    def matrix(self, name: str, entries: sp.Matrix, title: str, unit: str = "") -> sp.Matrix:
        """Name the entries of a matrix of the part."""
        return self.frame.matrix(f"{self.name}_{name}", entries, f"{self.name}: {title}", unit)


@dataclass(frozen=True)
class Part(metaclass=Complete):
    """A part of a spacecraft.

    A user's part overrides `coordinates` and `aggregates`; the equations follow.

    Parameters
    ----------
    name : str
        Start of the names of its parameters, states, inputs and steps.
    """

    name: str

    @classmethod
    def read(cls, name: str, table: str | Path, **fields: Any) -> Self:
        """Create a part with numbers from a TOML table.

        Parameters
        ----------
        name : str
            As of the part.
        table : str or Path
            A TOML file with an entry for each field: `mass = { unit = "kg", default = 8.0, source = "paper ..." }`.
        **fields
            Further fields.

        Raises
        ------
        ModelError
            If the table has an unknown field or a wrong unit, or lacks a required field.
        """
        given = read_table(table, cls, cls.lists())
        if both := given.keys() & fields.keys():
            raise ModelError(f"{name}.{min(both)} is given twice: in {table} and in the call")
        needed = {f.name for f in dataclass_fields(cls) if f.init and f.default is MISSING and f.name != "name"}
        if missing := needed - given.keys() - fields.keys():
            raise ModelError(f"{name}.{min(missing)} is missing: write it into {table} or into the call")
        label = next(f for f in dataclass_fields(cls) if f.name == "name")
        if label.init:
            return cls(name=name, **given, **fields)
        if name != label.default:
            raise ModelError(f"name = {name!r}: must be {label.default!r}, the name of every {cls.__name__}")
        return cls(**given, **fields)

    @classmethod
    def lists(cls) -> Mapping[str, type]:
        """Return the list fields of a table with the class of their entries."""
        return {}

    def texts(self) -> Mapping[str, str]:
        """Return the fields that a description of the craft shows in words of their own."""
        return {}

    def doubles(self, other: Part) -> bool:
        """Return True if another part has the same effect on the whole craft, so that a craft may have only one."""
        return False

    def values(self, parameters: Parameters) -> SimpleNamespace:
        """Declare the part's parameters and return the symbols or numbers of its fields."""
        return parameters.of(self, self.name)

    def inputs(self) -> tuple[Quantity, ...]:
        """Return the commands of the part."""
        return ()

    def coordinates(self) -> tuple[Coordinate, ...]:
        """Return the degrees of freedom of the part."""
        return ()

    def aggregates(self, at: Mounted) -> Aggregates:
        """Return masses, momenta and energies, which determine the part's motion; None for a pure load."""
        return Aggregates()

    def loads(self, at: Mounted) -> tuple[Load, ...]:
        """Return the external load on the part."""
        return ()

    def mean_loads(self, at: Mounted) -> tuple[Load, ...]:
        """Return the mean loads of a sample period, which are linear in the inputs, for laws."""
        return self.loads(at)

    def states(self, scenario: Parameters) -> tuple[State, ...]:
        """Return the states of the part with initial values from scenario parameters."""
        places = [c.place for c in self.coordinates() if c.place is not None]
        return tuple(start(q, scenario) for q in (*places, *(c.speed for c in self.coordinates())))

    def contribution(self, at: Mounted) -> Contribution:
        """Return the part's contribution to the equations of the hub."""
        return contribution(self.aggregates(at), self.coordinates(), at)

    def rates(self, at: Mounted, motion: Motion) -> tuple[Expr, ...]:
        """Return the rates of the part's states."""
        places = [c.speed.symbol for c in self.coordinates() if c.place is not None]
        return (*places, *_accelerations(self.aggregates(at).prescribed, motion.own))

    def power(self, at: Mounted, motion: Motion) -> Expr:
        """Return the power of the part's motors and dampers, W."""
        of, coordinates = self.aggregates(at), self.coordinates()
        speeds = [c.speed.symbol for c in coordinates]
        result = of.power + sp.Add(*(f * s for f, s in zip(of.forces, speeds, strict=bool(of.forces))))
        if any(of.prescribed):
            origin, own = motion.origin, _accelerations(of.prescribed, motion.own)
            for row, speed in zip(contribution(of, coordinates, at).held, _held(of.prescribed, speeds), strict=True):
                missing = row.linear.dot(origin) + row.angular.dot(motion.angular) - row.right
                result += (missing + sp.Matrix(row.coupling).dot(sp.Matrix(own))) * speed
        return result

    def carried(self, at: Mounted, velocity: sp.Matrix) -> tuple[Load, Expr]:
        """Return the momentum (as a load) and the power that outflowing mass removes from the part.

        Parameters
        ----------
        at : Mounted
            The part in its assembly.
        velocity : sympy.Matrix
            Of O, m/s.
        """
        return Load(), sp.S.Zero

    def events(self, at: Mounted) -> tuple[Event, ...]:
        """Return the events that switch the part's equations."""
        return ()

    def jumps(self, at: Mounted) -> Sequence[Jump]:
        """Return the changes of the part's states at a sample, before it measures."""
        return ()

    def projection(self) -> Mapping[sp.Symbol, Expr]:
        """Return states that each step projects to a manifold, with their projected values."""
        return {}

    def constraints(self, at: Mounted) -> tuple[Condition, ...]:
        """Return the constraints on the part's parameters in addition to their bounds."""
        return conditions(self.name, at.values, kinds(self))

    def limits(self, at: Mounted) -> tuple[Condition, ...]:
        """Return the part's physical limits; a run ends when a margin is no longer positive."""
        return ()

    def applied(self, at: Mounted, commanded: Sequence[sp.Symbol]) -> tuple[Expr, ...]:
        """Return the acting inputs for the commanded ones; without limits they are equal."""
        return tuple(commanded)

    def shapes(self, at: Mounted) -> tuple[Shape, ...]:
        """Return the part's shapes in hub axes: a ball at its centre of mass, and a rod from its mount."""
        of = self.aggregates(at)
        if of.mass == 0:
            return ()
        centre = (of.first / of.mass).applyfunc(sp.expand)
        ball, mount = Shape(self.name, "ball", points(centre), "orange"), getattr(at.values, "at", centre)
        if mount == centre:
            return (ball,)
        return Shape(f"{self.name} mount", "rod", points(mount, centre), "orange"), ball


def unit_of(part: str, field: str) -> str:
    """Return the unit of a field of a class of parts, by names; empty if it is unknown or has none."""
    classes: list[type[Part]] = [Part]
    for each in classes:
        classes += each.__subclasses__()
    declared = next((kinds(each) for each in classes if each.__name__ == part), {})
    unit = declared[field].unit if field in declared else "1"
    return "" if unit == "1" else unit


def points(*places: sp.Matrix) -> tuple[tuple[Expr, Expr, Expr], ...]:
    """Return places as the points of a shape."""
    return tuple((place[0], place[1], place[2]) for place in places)


def start(quantity: Quantity, scenario: Parameters, default: float = 0.0) -> State:
    """Return a state whose initial value is the scenario parameter NAME_0."""
    meaning = f"{quantity.description} at the start"
    return State(quantity, scenario.add(f"{quantity.name}_0", default, quantity.unit, meaning, "(-inf, inf)"))


def _accelerations(prescribed: Sequence[Expr | None], own: Sequence[Expr]) -> tuple[Expr, ...]:
    """Return the accelerations of all coordinates, prescribed or solved."""
    rest = iter(own)
    return tuple(next(rest) if value is None else value for value in prescribed) if prescribed else tuple(own)


def _held(prescribed: Sequence[Expr | None], values: Sequence[Expr]) -> list[Expr]:
    return [v for v, given in zip(values, prescribed, strict=True) if given is not None]


def _check_degrees(of: Aggregates, speeds: Sequence[sp.Symbol], name: str) -> None:
    """Refuse energies that are not quadratic in the speeds, and momenta that are not linear in the speeds."""

    def depends(slopes: sp.Matrix) -> bool:
        return any(slope.has(*speeds) and sp.simplify(slope).has(*speeds) for slope in slopes)

    if speeds and depends(sp.hessian(of.energy, speeds)):
        raise ModelError(f"{name}.energy = {of.energy}: must be quadratic in the speeds {', '.join(map(str, speeds))}")
    for what, momentum in (("momentum", of.momentum), ("angular", of.angular)):
        if speeds and depends(momentum.jacobian(speeds)):
            raise ModelError(
                f"{name}.{what} = {tuple(momentum)}: must be linear in the speeds {', '.join(map(str, speeds))}"
            )


def contribution(of: Aggregates, coordinates: Sequence[Coordinate], at: Mounted) -> Contribution:
    """Derive a part's contribution to the hub's equations from its masses, momenta and energies."""
    frame, w = at.frame, at.frame.rate
    places = [c.place.symbol if c.place else None for c in coordinates]
    speeds = [c.speed.symbol for c in coordinates]

    def by(expr: Expr, place: sp.Symbol | None) -> Expr:
        return sp.S.Zero if place is None else frame.slope(expr, place)

    def along(expr: Expr) -> Expr:
        """Differentiate along the motion with constant speeds."""
        return sp.Add(*(by(expr, q) * v for q, v in zip(places, speeds, strict=True)))

    _check_degrees(of, speeds, at.name)
    prescribed = of.prescribed or (None,) * len(speeds)
    drive = dict(pair for pair in zip(speeds, prescribed, strict=True) if pair[1] is not None)
    rows, held, swelling = [], [], ZERO
    for i, (q, v) in enumerate(zip(places, speeds, strict=True)):
        linear, angular, own = of.momentum.diff(v), of.angular.diff(v), of.energy.diff(v)
        gyro = angular.applyfunc(along) - of.angular.applyfunc(lambda e, q=q: by(e, q))
        spin = of.inertia.applyfunc(lambda e, q=q: by(e, q))
        turned = at.vector(f"JW{i + 1}_", spin * w, f"slope of the inertia by coordinate {i + 1}, times the rate")
        swelling += turned * v
        bias = (
            w.dot(gyro.applyfunc(sp.expand)) - w.dot(turned) / 2 + along(own) - by(of.energy, q) + by(of.potential, q)
        )
        forces = of.forces[i] if of.forces else sp.S.Zero
        if prescribed[i] is not None:
            held.append(Row(linear, angular, tuple(own.diff(other) for other in speeds), forces - bias))
            continue
        if own.diff(v) == 0:
            text = (
                f"no mass and no inertia moves with {v}: give {at.name} an inertia about its axis, or a centre off it"
            )
            raise ModelError(f"{at.name}: {text}")
        coupling = tuple(own.diff(other) for other in speeds if other not in drive)
        driven = sp.Add(*(own.diff(other) * value for other, value in drive.items()))
        rows.append(Row(linear, angular, coupling, forces - bias - driven))
    force, couple = -of.momentum.applyfunc(along), -of.angular.applyfunc(along) - swelling
    for speed, value in drive.items():
        force, couple = force - of.momentum.diff(speed) * value, couple - of.angular.diff(speed) * value
    load = Load(force, ZERO, couple)
    return Contribution(of.mass, of.first, of.inertia, of.momentum, of.angular, (load,), tuple(rows), tuple(held))
