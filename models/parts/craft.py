# SPDX-License-Identifier: Apache-2.0
"""Spacecraft assembled from parts, which determine its equations."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from numbers import Real
from typing import TypeVar

import sympy as sp

from mehvar.base.errors import value_text
from mehvar.base.manifest import Metric, Scenario
from mehvar.base.parts import part_changes

from ..check.branches import no_branching
from ..derivation import Definition, Derivation, Equation, Expr, free_symbols, used_definitions
from ..geometry import Shape
from ..quantities import Group, ModelError, Parameter, Quantity, caller
from ..system import Actuator, Condition, Controller, System
from ..tables import check_names
from .assembly import contributions, mount, moved
from .charts import ANGLES, CHARTS, Chart, PlaneChart
from .control import Law, LawText
from .environment import Orbit
from .frame import AXES, Frame, triple
from .hub import Pulsed
from .motion import Motion
from .part import Craft, Mounted, Part, points, start, unit_of
from .readings import readings
from .sensors import drifting, measuring, watching
from .terms import State, expressions
from .values import Parameters, Value, kinds

AnyPart = TypeVar("AnyPart", bound=Part)
MOTIONS = {"free": range(6), "attitude": range(6), "plane": (0, 1, 5)}
"""Unknown accelerations of the hub. If only the attitude is a state, the parts determine the acceleration of O."""
_VELOCITY = triple("v", "m/s", "velocity of O")
_RATE = tuple(Quantity(f"w{axis}", "rad/s", f"rate of the hub, {axis}", latex=rf"\omega_{axis}") for axis in AXES)


class Spacecraft:
    """A spacecraft: a hub with mounted parts.

    Equations are written in the axes of the hub, about their origin O.

    Parameters
    ----------
    name : str
        Identifier of the model.
    title : str
        A one-line description.
    attitude : {"quaternion", "euler", "mrp"}
        Chart of the attitude.
    motion : {"free", "attitude", "plane"}
        Free in space with the velocity of O as a state, attitude only, or free in a plane.
    orbit : Orbit, optional
        Orbit about the Earth. Position and velocity of the centre of mass then replace the velocity of O as states.
    period : float
        Default of the parameter Ts, the period of laws and sensors, s.
    """

    def __init__(
        self, name: str, title: str = "", attitude: str = "quaternion", motion: str = "free",
        orbit: Orbit | None = None, period: float = 0.1,
    ) -> None:  # fmt: skip
        _one_of("attitude", attitude, CHARTS)
        _one_of("motion", motion, MOTIONS)
        self.name = _name("name", name)
        self.title = title or f"spacecraft {name}"
        self.motion = motion
        self.chart: Chart = PlaneChart() if motion == "plane" else CHARTS[attitude]()
        self.parts: list[Part] = []
        self._origin = caller()
        self._laws: dict[str, tuple[str, LawText, bool, str]] = {}
        self._plant, self._scenario = Parameters(), Parameters()
        self.period = self._plant.add("Ts", period, "s", "period of laws and sensors", "(0, inf)")
        if orbit is not None:
            if not isinstance(orbit, Orbit) or motion != "free":
                raise ModelError(
                    f"{name}: orbit = {value_text(orbit)}: must be an Orbit, of a craft with motion = 'free'"
                )
            self.motion = "attitude"
            self.parts.append(orbit)

    @property
    def attitude(self) -> tuple[sp.Symbol, ...]:
        """Symbols of the attitude."""
        return self.chart.symbols

    @property
    def rates(self) -> tuple[sp.Symbol, ...]:
        """Symbols of the rate of the hub, rad/s."""
        return tuple(q.symbol for q in self._rate)

    @property
    def velocity(self) -> tuple[sp.Symbol, ...]:
        """Symbols of the velocity of O in hub axes, m/s; none if only the attitude is a state."""
        return tuple(q.symbol for q in self._velocity)

    @property
    def _velocity(self) -> tuple[Quantity, ...]:
        return {"free": _VELOCITY, "attitude": (), "plane": _VELOCITY[:2]}[self.motion]

    @property
    def _rate(self) -> tuple[Quantity, ...]:
        return _RATE[2:] if self.motion == "plane" else _RATE

    def add(self, part: AnyPart) -> AnyPart:
        """Mount a part and return it.

        Raises
        ------
        ModelError
            If its name is no identifier or already in use, a number of it is out of bounds, an inertia is that of no
            body, or it doubles the effect of another part on the whole craft.
        """
        if not isinstance(part, Part):
            raise ModelError(f"{self.name}: {part!r} is not a part: add a Hub, a Wheel or another part")
        if isinstance(part, Orbit):
            raise ModelError(f"{self.name}: an orbit cannot be added as a part: write Spacecraft(..., orbit=Orbit())")
        _name("name", part.name)
        if any(other.name == part.name for other in self.parts):
            raise ModelError(f"{self.name}: a part named {part.name!r} is mounted already; parts need different names")
        if double := next((other for other in self.parts if part.doubles(other)), None):
            raise ModelError(
                f"{self.name}: the {type(part).__name__} {part.name!r} would double {double.name!r}, which acts on the "
                "whole craft already: leave one of both out"
            )
        parameters = Parameters(self._plant.quantities)  # a copy: deriving the craft declares those of its parts
        others = [value for f in fields(part) if isinstance(value := getattr(part, f.name), Part)]  # as of a filter
        craft = self._mounted(Derivation(), [*others, part], parameters)
        self._check_defaults(part.constraints(craft.parts[-1][1]), parameters)
        self.parts.append(part)
        return part

    def parameter(
        self, name: str, default: float, unit: str = "1", meaning: str = "", bounds: str = "(-inf, inf)",
        source: str = "",
    ) -> sp.Symbol:  # fmt: skip
        """Declare a parameter that several fields share, and return its symbol."""
        return self._plant.add(name, Value(default, bounds, source), unit, meaning or name, bounds)

    def changes(self, newer: Spacecraft) -> tuple[str, ...]:
        """List the differences to another craft part by part, such as "wheel2: axis (1, 0, 0) -> (0, 0, 1)".

        Parameters
        ----------
        newer : Spacecraft
            Newer version of this craft.
        """
        return part_changes(self._described(), newer._described(), unit_of)

    def _described(self) -> dict[str, dict[str, str]]:
        """Return the fields of the parts as texts, without addresses, so that equal crafts have equal texts."""
        laws = ", ".join(self._laws) or "none"
        described = {"": {"attitude": self.chart.name, "motion": self.motion, "laws": laws}}
        for part in self.parts:
            texts = {f.name: _text(getattr(part, f.name)) for f in fields(part) if f.name != "name"}
            described[part.name] = {"": type(part).__name__, **texts, **part.texts()}
        return described

    def law(self, name: str, write: LawText, title: str = "", sampled: bool = True) -> None:
        """Give the craft a control law.

        Parameters
        ----------
        name : str
            Of the law.
        write : callable
            Receives a `Law` and returns its commands by the names of the parts.
        title : str
            A one-line description.
        sampled : bool
            True for a law that commands once per period Ts; False for a continuous law.

        Raises
        ------
        ModelError
            If another law has the name.
        """
        if _name("law", name) in self._laws:
            raise ModelError(f"{self.name}: a law named {name!r} exists already; laws need different names")
        self._laws[name] = title or name, write, sampled, caller()

    def shapes(self, **values: float) -> tuple[Shape, ...]:
        """Return the shapes of the parts and the centre of mass, with numbers as points; derives no motion.

        Parameters
        ----------
        **values
            States, inputs and parameters that differ from start and defaults.

        Raises
        ------
        ModelError
            If a name is unknown, or the craft has no parts.
        """
        derivation = Derivation()
        craft, numbers = self._whole(derivation), self._numbers(values)
        whole, shapes = craft.whole(), craft.picture(set(numbers), {})
        if whole.mass != 0:
            centre = craft.turn.T * whole.first / whole.mass
            shapes += (Shape(f"{self.name}: centre of mass", "ball", points(centre), "black"),)
        values_of = iter(_evaluated([e for shape in shapes for p in shape.points for e in p], derivation, numbers))
        return tuple(
            replace(s, points=points(*(sp.Matrix([next(values_of) for _ in p]) for p in s.points))) for s in shapes
        )

    def numbers(
        self, terms: Callable[[Part, Mounted], Sequence[Expr]], given: Iterable[Mapping[str, float]]
    ) -> list[list[list[float]]]:
        """Return the numbers of expressions by point and part, without deriving the motion.

        Parameters
        ----------
        terms : callable
            Returns the expressions of a part.
        given : iterable of mapping
            For each point, states, inputs and parameters that differ from start and defaults.
        """
        derivation = Derivation()
        rows = [terms(part, at) for part, at in self._whole(derivation).parts]
        flat = [entry for row in rows for entry in row]
        points = (iter(_evaluated(flat, derivation, self._numbers(values))) for values in given)
        return [[[float(next(results)) for _ in row] for row in rows] for results in points]

    def _numbers(self, values: Mapping[str, float]) -> dict[sp.Symbol, Expr]:
        """Return given values, starts of states, defaults of parameters, and zero for inputs."""
        states = self._states()
        inputs = [q for part in self.parts for q in part.inputs()]
        parameters = [*self._plant.quantities.values(), *self._scenario.quantities.values()]
        known = {q.name: q for q in (*inputs, *parameters, *(state.quantity for state in states))}
        check_names(values, known, f"{self.name}: quantity")
        given = {}
        for name, value in values.items():
            q = known[name]
            bounds = str(q.bounds) if isinstance(q, Parameter) else "(-inf, inf)"
            Parameters().add(name, value, q.unit, q.description, bounds)  # refuses other values
            given[q.symbol] = sp.Float(value)
        result = {q.symbol: sp.S.Zero for q in inputs} | {q.symbol: sp.Float(q.default) for q in parameters} | given
        return result | {s.quantity.symbol: s.start.xreplace(result) for s in states} | given

    @no_branching()
    def system(
        self,
        scenarios: Sequence[Scenario] = (),
        metrics: Sequence[Metric] = (),
    ) -> System:
        """Derive the equations of motion.

        Parameters
        ----------
        scenarios, metrics : sequence of Scenario and of Metric
            As `mehvar.read_scenarios` reads them; a scenario of 100 s without them.

        Raises
        ------
        ModelError
            If the assembly, or the body that a joint moves, has no mass or no inertia, a number is outside of its
            bounds, or a law branches on a symbol.
        """
        derivation = Derivation()
        craft = self._whole(derivation)
        rhs, motions = self._rhs(craft)
        states = self._states()
        actuator, controllers = self._actuator(craft), self._controllers(craft)
        constraints = tuple(c for part, at in craft.parts for c in part.constraints(at))
        self._check_defaults(constraints, self._plant)
        events = tuple(e for part, at in craft.parts for e in part.events(at))
        limits = (*(c for part, at in craft.parts for c in part.limits(at)), *self.chart.limits())
        sensor, random = measuring(craft.parts), drifting(craft.parts, states)
        if sensor:
            controllers += (
                watching(sensor, self.parts, sum(len(part.inputs()) for part in self.parts), self.period.name),
            )
        periods = {law.period for law in controllers}
        pulsed = [part.name for part in self.parts if isinstance(part, Pulsed) and part.pulses]
        if pulsed and not any(periods):
            raise ModelError(f"{self.name}: the pulses of {pulsed[0]} need a sampled law: add one by craft.law")
        users = (actuator, controllers, sensor, random, events, limits)
        self._refuse_idle(free_symbols((*rhs, *expressions(users)), derivation.definitions))
        self._refuse_across()
        velocity = self._components(self._velocity) if self._velocity else None
        functions = readings(craft, motions, velocity, self.motion == "plane")
        used = free_symbols((*rhs, *expressions((users, functions))), derivation.definitions)
        self._refuse_unused(used)
        x, u, p = families(
            self.parts,
            Group("x", tuple(state.quantity for state in states)),
            Group("u", tuple(q for part in self.parts for q in part.inputs())),
            Group("p", tuple(q for q in self._plant.quantities.values() if q.symbol in used or q.name in periods)),
        )
        known, groups = {*x.symbols, *u.symbols, *p.symbols}, {group.name: group for group in (x, u, p)}
        functions = tuple(replace(f, arguments=tuple(groups[g.name] for g in f.arguments)) for f in functions)
        defaults = {q.symbol: float(q.default) for q in self._plant.quantities.values()}
        geometry = craft.picture(known, defaults)
        return System(
            name=self.name, title=self.title, states=x, inputs=u, parameters=p,
            scenario_parameters=Group("s", tuple(self._scenario.quantities.values())),
            rhs=rhs, steps=_needed(derivation, rhs, functions, geometry, *users),
            initial=tuple(state.start for state in states),
            constraints=tuple(c for c in constraints if free_symbols([c.margin], {}) <= set(p.symbols)),
            functions=functions, controllers=controllers,
            scenarios=tuple(scenarios), metrics=tuple(metrics), projection=self._projection(states),
            geometry=geometry, actuator=actuator, sensor=sensor, random_step=random, events=events, limits=limits,
            parts=self._described(),
        ).written_at(self._origin)  # fmt: skip

    def _refuse_idle(self, used: set[sp.Symbol]) -> None:
        """Refuse a part whose input has no effect, such as a torque about an axis in the plane of motion."""
        for part in self.parts:
            if idle := [q.name for q in part.inputs() if q.symbol not in used]:
                where = f"{self.name}: {', '.join(idle)} of the {type(part).__name__} {part.name!r}"
                raise ModelError(
                    f"{where} would have no effect in a craft with motion = {self.motion!r}; use parts with one "
                    "direction, such as Thruster and Wheel"
                )

    def _refuse_across(self) -> None:
        """Refuse a load that moves nothing in the plane of motion, such as a nozzle's force across it."""
        derivation = Derivation()
        for part, at in self._whole(derivation).parts if self.motion == "plane" else ():
            for load in part.loads(at):
                twist = load.couple + load.at.cross(load.force)
                if any((*load.force[:2], twist[2])) or not any((load.force[2], *load.couple)):
                    continue
                held = free_symbols((*load.force, *load.couple), derivation.definitions)
                scalars = (name for name, kind in kinds(part).items() if kind.form == "scalar")
                names = [name for name in scalars if held & free_symbols(expressions(getattr(at.values, name)), {})]
                where = f"{self.name}: {', '.join(names) or 'a load'} of the {type(part).__name__} {part.name!r}"
                raise ModelError(
                    f"{where} would have no effect in a craft with motion = 'plane': no force along x or "
                    "y, no torque about z; turn it, or leave it out"
                )

    def _refuse_unused(self, used: set[sp.Symbol]) -> None:
        """Refuse a field whose numbers no term of its part contains, and a shared parameter that nothing uses."""
        idle = {q.symbol for q in self._plant.quantities.values()} - used - {self.period}
        if not idle:
            return
        derivation = Derivation()
        spent: set[sp.Symbol] = set()
        for part, at in self._whole(derivation).parts:
            given = {name: free_symbols(expressions(v), derivation.definitions) for name, v in vars(at.values).items()}
            spent |= free_symbols(expressions(vars(part)), {}).union(*given.values())
            lost = {name for name, of in given.items() if of and of <= idle}
            for name in (name for name in (part.ignored(at) if lost else ()) if name in lost):
                raise ModelError(
                    f"{self.name}: {part.name}.{name} would be ignored: no term of the {type(part).__name__} contains "
                    f"at.values.{name}; use it there, or leave the field out"
                )
        if unused := sorted(map(str, idle - spent)):
            raise ModelError(f"{self.name}: parameter {unused[0]!r} is used by no part and no law; remove it or use it")

    def _check_defaults(self, constraints: Iterable[Condition], parameters: Parameters) -> None:
        """Refuse defaults that violate a constraint."""
        names = {q.name: float(q.default) for q in parameters.quantities.values()}
        symbols = {q.symbol: sp.Float(names[q.name]) for q in parameters.quantities.values()}
        for condition in constraints:
            if condition.margin.free_symbols <= symbols.keys() and not condition.margin.xreplace(symbols) > 0:
                shown = [float(value.xreplace(symbols)) for value in condition.shown]
                raise ModelError(f"{self.name}: {condition.message.format(*shown, **names)}")

    def _rhs(self, craft: Craft) -> tuple[tuple[Expr, ...], list[Motion]]:
        """Derive the rates of all states, and the motion of the parts."""
        frame, added = craft.frame, contributions(craft)
        if all(c.mass == 0 for c in added):
            raise ModelError(f"{self.name} has no mass: add a Hub")
        for axis in (k - 3 for k in MOTIONS[self.motion] if k > 2):
            if all(c.inertia[axis, axis] == 0 and c.matrix.is_zero_matrix and not c.followers for c in added):
                text = "give the Hub one, or mount mass off the axis"
                raise ModelError(f"{self.name} has no inertia about {AXES[axis]}: {text}")
        motions = moved(craft, unknowns=MOTIONS[self.motion])
        frame.derivation.section("Rates")
        own = [part.rates(at, motion) for (part, at), motion in zip(craft.parts, motions, strict=True)]
        linear = motions[0].origin - frame.rate.cross(self._components(self._velocity))
        angular = motions[0].angular
        hub = dict(zip((q.name for q in (*_VELOCITY, *_RATE)), (*linear, *angular), strict=True))
        rates = [hub[q.name] for q in (*self._velocity, *self._rate)]
        return (*rates, *self.chart.rates(frame), *(entry for entries in own for entry in entries)), motions

    def _whole(self, derivation: Derivation) -> Craft:
        if not self.parts:
            raise ModelError(f"{self.name} has no parts: add a Hub first")
        return self._mounted(derivation, self.parts, self._plant)

    def _mounted(self, derivation: Derivation, parts: Sequence[Part], parameters: Parameters) -> Craft:
        frame = Frame(derivation, self._components(self._rate))
        craft = Craft(frame, self.chart.rotation(), self.chart.quaternion(), self.period)
        mount(craft, parts, parameters)
        return craft

    def _actuator(self, craft: Craft) -> Actuator | None:
        """Return the acting inputs after the limits of the parts."""
        commands: list[Quantity] = []
        acting: list[Expr] = []
        for part, at in craft.parts:
            own = [replace(q, name=f"{q.name}_cmd", description=f"commanded {q.description}") for q in part.inputs()]
            commands += own
            acting += part.applied(at, [q.symbol for q in own])
        group = Group("u_cmd", tuple(commands))
        return None if tuple(acting) == group.symbols else Actuator(group, tuple(acting))

    def _controllers(self, craft: Craft) -> tuple[Controller, ...]:
        craft.frame.derivation.section("Laws")
        inputs = {part.name: len(part.inputs()) for part in self.parts if part.inputs()}
        laws = []
        for name, (title, write, sampled, origin) in self._laws.items():
            law = Law(name, craft, self.attitude, self.rates, self._plant.quantities)
            laws.append(law.controller(title, write(law), inputs, sampled).written_at(origin))
        return tuple(laws)

    def _components(self, quantities: Iterable[Quantity]) -> sp.Matrix:
        by_axis = {q.name[-1]: q.symbol for q in quantities}
        return sp.Matrix([by_axis.get(axis, sp.S.Zero) for axis in AXES])

    def _states(self) -> list[State]:
        """Return the states of hub, chart and parts, whose starts become parameters of the scenario."""
        hub = [start(q, self._scenario) for q in (*self._velocity, *self._rate)]
        names = ("yaw",) if self.motion == "plane" else ANGLES
        at = {
            name: self._scenario.add(f"{name}_0", 0.0, "rad", f"{name} angle at the start", "(-inf, inf)")
            for name in names
        }
        angles = [at.get(name, sp.S.Zero) for name in ANGLES]
        chart = [State(q, v) for q, v in zip(self.chart.states, self.chart.of_angles(angles), strict=True)]
        return [*hub, *chart, *(state for part in self.parts for state in part.states(self._scenario))]

    def _projection(self, states: Sequence[State]) -> tuple[Expr, ...]:
        placed = dict(zip(self.chart.symbols, self.chart.projection(), strict=False))
        for part in self.parts:
            placed |= part.projection()
        return tuple(placed.get(s.quantity.symbol, s.quantity.symbol) for s in states) if placed else ()


def _evaluated(exprs: Sequence[Expr], derivation: Derivation, numbers: Mapping[sp.Symbol, Expr]) -> list[Expr]:
    """Return the values of expressions, by way of the steps that they use."""
    known, used = dict(numbers), used_definitions(exprs, derivation.definitions)
    for symbol, expr in derivation.definitions.items():
        if symbol in used:
            known[symbol] = expr.xreplace(known)
    return [sp.sympify(expr).xreplace(known).evalf() for expr in exprs]


def _text(value: object) -> str:
    """Return a field of a part as text: equal numbers alike, whatever their types, and another part by its name."""
    if isinstance(value, Value):
        return _text(value.default)
    if isinstance(value, Part):
        return repr(value.name)
    if isinstance(value, Real) and not isinstance(value, bool):
        return repr(float(value)).removesuffix(".0")
    if hasattr(value, "tolist"):  # of NumPy
        return _text(value.tolist())
    if isinstance(value, tuple | list):
        return f"({', '.join(map(_text, value))})"
    if is_dataclass(value) and not isinstance(value, type):
        return (
            f"{type(value).__name__}({', '.join(f'{f.name}={_text(getattr(value, f.name))}' for f in fields(value))})"
        )
    return re.sub(r" at 0x\w+", "", repr(value))


def _needed(derivation: Derivation, *users: object) -> tuple[Definition | Equation, ...]:
    """Return the steps of a derivation that the system uses, directly or indirectly."""
    used = used_definitions(expressions(users), derivation.definitions)
    return tuple(step for step in derivation.steps if isinstance(step, Equation) or step.symbol in used)


def families(parts: Sequence[Part], *groups: Group) -> tuple[Group, ...]:
    """Return groups whose quantities record kind and number of their part, so that code can loop over equal parts.

    Parts are equal if they have the same class and quantities with the same names.
    """
    names = {part.name: part for part in parts}
    own: dict[str, list[str]] = {name: [] for name in names}
    for q in (q for group in groups for q in group):
        pieces = q.name.split("_")
        owners = ("_".join(pieces[:k]) for k in range(len(pieces) - 1, 0, -1))
        name = next((name for name in owners if name in names), None)
        if name is not None:
            own[name].append(q.name)
    kinds: dict[tuple[type, tuple[str, ...]], list[str]] = {}
    for name, quantities in own.items():
        kinds.setdefault((type(names[name]), tuple(q.removeprefix(name) for q in quantities)), []).append(name)
    member = {
        f"{name}{suffix}": (f"{kind.__name__}{number}{suffix}", k)
        for number, ((kind, suffixes), equal) in enumerate(kinds.items())
        if len(equal) > 1
        for k, name in enumerate(equal, 1)
        for suffix in suffixes
    }

    def with_family(q: Quantity) -> Quantity:
        family, index = member.get(q.name, ("", 0))
        return replace(q, family=family, index=index)

    return tuple(replace(group, quantities=tuple(map(with_family, group))) for group in groups)


def _one_of(field: str, value: str, allowed: Iterable[str]) -> None:
    if value not in allowed:
        raise ModelError(f"{field} = {value_text(value)}: must be one of {', '.join(allowed)}")


def _name(field: str, value: str) -> str:
    if not isinstance(value, str) or not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", value, re.ASCII):
        raise ModelError(
            f"{field} = {value_text(value)}: must be letters, digits and underscores, beginning with a letter"
        )
    return value
