# SPDX-License-Identifier: Apache-2.0
"""Interface of a part, and the assembly as a part sees it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import MISSING, dataclass, field, replace
from dataclasses import fields as dataclass_fields
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Self

import sympy as sp

from ..derivation import Derivation, Expr, free_symbols
from ..events import Event
from ..geometry import Shape
from ..quantities import ModelError, Quantity
from ..system import Condition
from .equations import contribution, refuse_terms, slopes_of
from .frame import ZERO, Frame, Labels
from .motion import Motion
from .table import read_table
from .terms import Aggregates, Contribution, Coordinate, Jump, Load, Moments, Particle, State, expressions
from .values import Complete, Parameters, conditions, generic, kinds, records

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
    contributions : list of Contribution
        Terms of the parts, once they are derived.
    """

    frame: Frame
    turn: sp.Matrix = field(default_factory=lambda: sp.zeros(0, 0))
    quaternion: Sequence[Expr] = ()
    period: sp.Symbol = field(default_factory=lambda: sp.Symbol("Ts", real=True))
    parts: list[tuple[Part, Mounted]] = field(default_factory=list)
    contributions: list[Contribution] = field(default_factory=list)

    @property
    def rotation(self) -> sp.Matrix:
        """Matrix `turn` with a name for each entry."""
        return self.frame.matrix("turn_", self.turn, "inertial axes to those of the hub", "1")

    def whole(self) -> Moments:
        """Return the moments of all parts."""
        return Moments.whole(part.total(at) for part, at in self.parts)

    @property
    def _body(self) -> Aggregates:
        """Mass and inertia of the first part that has them at all times, from which the picture takes its scales."""
        for part, at in self.parts:
            of = part.total(at)
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
class Mounted(Labels):
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

    values: SimpleNamespace
    craft: Craft

    @property
    def frame(self) -> Frame:
        """Hub axes of the assembly."""
        return self.craft.frame


@dataclass(frozen=True)
class Part(metaclass=Complete):
    """A part of a spacecraft.

    A user's part overrides `coordinates`, and `particle` or `aggregates` or both; the equations follow.

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
        return records(cls)

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

    def particle(self, at: Mounted) -> Particle | None:
        """Return the point mass that moves with the coordinates, if the part has one."""
        return None

    def aggregates(self, at: Mounted) -> Aggregates:
        """Return masses, momenta and energies besides those of the particle, which determine the part's motion."""
        return Aggregates()

    def total(self, at: Mounted) -> Aggregates:
        """Return the aggregates including those of the particle."""
        of, particle = self.aggregates(at), self.particle(at)
        refuse_terms(of, self.coordinates(), particle, self.name)
        if particle is None:
            return of
        m, r, slopes = particle.mass, particle.place, slopes_of(particle.place, self.coordinates(), at)
        v = sum((slope * c.speed.symbol for slope, c in zip(slopes, self.coordinates(), strict=True)), ZERO)
        squared = v.dot(v) if particle.squared is None else particle.squared
        return of + replace(Aggregates.body(m, r, velocity=v), energy=m * squared / 2)

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
        particle = self.particle(at)
        if particle is None or any(self.aggregates(at).prescribed):
            return contribution(self.total(at), self.coordinates(), at)
        return contribution(self.aggregates(at), self.coordinates(), at, particle)

    def rates(self, at: Mounted, motion: Motion) -> tuple[Expr, ...]:
        """Return the rates of the part's states."""
        places = [c.speed.symbol for c in self.coordinates() if c.place is not None]
        return (*places, *_accelerations(self.aggregates(at).prescribed, motion.own))

    def power(self, at: Mounted, motion: Motion) -> Expr:
        """Return the power of the part's motors and dampers, W."""
        of, coordinates = self.total(at), self.coordinates()
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
        return conditions(self, self.name, at.values)

    def limits(self, at: Mounted) -> tuple[Condition, ...]:
        """Return the part's physical limits; a run ends when a margin is no longer positive."""
        return ()

    def applied(self, at: Mounted, commanded: Sequence[sp.Symbol]) -> tuple[Expr, ...]:
        """Return the acting inputs for the commanded ones; without limits they are equal."""
        return tuple(commanded)

    def ignored(self, at: Mounted) -> list[str]:
        """Return the names of given fields that no term of the part contains, whatever the zeros among its numbers.

        Rates and powers are left out, as they need the solution of the craft's equations.
        """
        values, symbols = generic(at.values, kinds(self))
        frame = replace(at.frame, derivation=Derivation(), names={}, slopes={}, constants=set(at.frame.constants))
        own = replace(at, values=values, craft=replace(at.craft, frame=frame))  # the craft's steps have other numbers
        terms = (self.total(own), self.contribution(own), self.loads(own), self.mean_loads(own), self.events(own),
                 self.jumps(own), self.limits(own), self.applied(own, [q.symbol for q in self.inputs()]),
                 self.shapes(own), set(self.constraints(own)) - set(Part.constraints(self, own)))  # fmt: skip
        used = free_symbols(expressions(terms), frame.derivation.definitions)
        return [name for name, of in symbols.items() if not of & used]

    def shapes(self, at: Mounted) -> tuple[Shape, ...]:
        """Return the part's shapes in hub axes: a ball at its centre of mass, and a rod from its mount."""
        of = self.total(at)
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


def clipped(value: Expr, limit: Expr) -> Expr:
    """Return a value within a limit of its size."""
    return sp.Max(-limit, sp.Min(limit, value))


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
