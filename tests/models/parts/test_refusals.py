# SPDX-License-Identifier: Apache-2.0
"""Wrong assemblies are refused in the words of parts."""

import copy
import dataclasses
import math
import pickle
import sys
from typing import Annotated

import numpy as np
import pytest
import sympy as sp

import mehvar
from mehvar.base.errors import MehvarError
from mehvar.models.check import check
from mehvar.models.geometry import Shape
from mehvar.models.parts import (
    Aggregates,
    Bob,
    Cable,
    Chain,
    ControlMomentGyro,
    Coordinate,
    Engine,
    Hinge,
    Hub,
    Instrument,
    Joint,
    Link,
    Load,
    Mode,
    Modes,
    Number,
    Part,
    Particle,
    Pendulum,
    Slider,
    Spacecraft,
    SprungMass,
    Tank,
    Tensor,
    Tether,
    Thruster,
    Torquer,
    UnbalancedWheel,
    Value,
    Vector,
    Wheel,
    direction,
    place,
    point_inertia,
    scalar,
    tensor,
    vector,
)
from mehvar.models.quantities import TIME, ModelError, Quantity

from .table import PARTS, craft_of

BALL = (1.0, 1.0, 1.0)
HUB = Hub("hub", mass=1.0, inertia=BALL)
LINE = {"length": 1.0, "stiffness": 1.0}
BODY, OTHER = (Tether(n, mass=1.0, inertia=BALL, start=(0, 0, 1), **LINE) for n in ("body", "other"))


def assembled(*parts, **options):
    return craft_of(*parts, **options).system()


def flexible(linear, angular=(0, 0, 0)):
    """A hub of 10 kg with two equal panels."""
    modes = [Mode(2.0, 0.01, linear, angular)]
    return assembled(Hub("hub", mass=10.0, inertia=BALL), Modes("left", modes), Modes("right", modes))


def pulsing(along):
    """A plane craft whose law commands a pulsed thruster."""
    craft = craft_of(HUB, Thruster("jet", along, at=(0, 1, 0), limit=2.0, pulsed=True), motion="plane")
    craft.law("push", lambda law: {"jet": law.parameter("mean", 0.7, "N")})
    return craft.system()


def test_a_number_out_of_bounds_is_refused_when_its_part_is_mounted():
    craft = Spacecraft("craft")
    with pytest.raises(ModelError, match=r"hub_m = -5.0: must be a number in \(0, inf\), kg \(mass\)"):
        craft.add(Hub("hub", mass=-5.0, inertia=BALL))
    assert craft.parts == []


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: assembled(), "has no parts: add a Hub"),
        (lambda: assembled(Wheel("w", axis=(1, 0, 0), inertia=0.1)), "has no mass: add a Hub"),
        (
            lambda: assembled(HUB, Torquer("t"), motion="plane"),
            "craft: tx, ty of the Torquer 't' would have no effect in a craft with "
            "motion = 'plane'; use parts with one",
        ),
        (
            lambda: assembled(HUB, Tank("t", 3.0, (-1, 0, 0), (0, 0, 1), exhaust=9.0, at=(0, 1, 0)), motion="plane"),
            "craft: exhaust of the Tank 't' would have no effect in a craft with motion = 'plane'",
        ),
        (lambda: pulsing((0, 0, 1)), "craft: limit of the Thruster 'jet' would have no effect in a craft with motion"),
        (
            lambda: assembled(HUB, Thruster("jet", (1, 0, 0), limit=0.1, least=0.1), period=0.5),
            "jet.least, with Ts = 0.5, jet_Fmax = 0.1, jet_Imin = 0.1: must not exceed limit times Ts, or",
        ),
        (
            lambda: Tank("t", 3.0, (-1, 0, 0), reserve=Value(3.0)),
            "t.reserve = 3.0: must be less than mass = 3.0, or the valve never opens",
        ),
        (lambda: assembled(Hub("hub", mass=1.0, inertia=(0, 0, 0))), "craft has no inertia about x: give the Hub one"),
        (
            lambda: assembled(HUB, Hinge("panel", 1.0, (1, 0, 1), axis=(0, 1, 0), centre=(0, 1, 0))),
            "panel: no mass and no inertia moves with panel_rate: give panel an inertia about its axis",
        ),
        (lambda: assembled(Hub("hub", mass=0.0, inertia=BALL)), r"hub_m = 0.0: must be a number in \(0, inf\), kg"),
        (lambda: assembled(Hub("hub", mass=1.0, inertia=1.0)), "hub.inertia = 1.0: must be three moments"),
        (lambda: assembled(Hub("hub", mass=1.0, inertia=((1, 2, 0), (0, 1, 0), (0, 0, 1)))), "must be symmetric"),
        (lambda: assembled(Hub("hub", mass=1.0, inertia=BALL, centre=(0, 1))), "hub.centre = .*: must be 3 numbers"),
        (lambda: assembled(Hub("hub", mass=Value(1.0, bounds="3..5"), inertia=BALL)), "hub_m: bounds '3..5'"),
        (lambda: assembled(Hub("hub", mass=Value(1.0, bounds=3), inertia=BALL)), "hub_m: bounds 3 must be an interval"),
        (lambda: assembled(Hub("hub", mass=1.0, inertia=BALL), Hub("hub", mass=1.0, inertia=BALL)), "mounted already"),
        (lambda: assembled(Hub("my hub", mass=1.0, inertia=BALL)), "name = 'my hub': must be letters"),
        (lambda: assembled("hub"), "'hub' is not a part"),
        (lambda: assembled(Thruster("jet", direction=(0, 0, 0))), "jet.direction: must not be zero"),
        (
            lambda: assembled(Thruster("jet", direction=(1e200, 1e200, 0))),
            r"jet.direction = \(1e\+200, 1e\+200, 0\): must have a length from 1e-150 to 1e\+150",
        ),
        (
            lambda: assembled(Wheel("w", axis=(1e-320, 0, 0), inertia=0.1)),
            r"w.axis = \(1e-320, 0, 0\): must have a length",
        ),
        *(
            (lambda rest=rest: Bob("b", mass=1.0, length=1.0, rest=rest), r"b.rest = .*: must be an axis of the hub")
            for rest in ((0, 0, True), (0, 0, 1j), (0, 0, "1"), (0, 0, sp.nan), (0, 0, math.inf), 1.0, "z")
        ),
        (lambda: Bob("tank", mass=1.0, length=1.0, rest=(0, 0, -2)), r"tank.rest = \(0, 0, -2\): must be an axis"),
        (
            lambda: Hinge("h", 1.0, BALL, axis=(1, 0, 0), motion="free-wheeling"),
            "h.motion = 'free-wheeling': must be one",
        ),
        (lambda: Hinge("h", 1.0, BALL, axis=(1, 0, 0), motion="locked", damping=1.0), "h.damping: motion is locked"),
        (
            lambda: Link(1.0, BALL, joint="ball", axis=(1, 0, 0)),
            "give an axis to a hinge or slider, and none to a ball joint",
        ),
        (lambda: Link(1.0, BALL, joint="ball", stiffness=1.0), "a ball joint cannot have a motor or a stiffness"),
        (lambda: Link(1.0, BALL, joint="screw", axis=(1, 0, 0)), "joint = 'screw': must be one of hinge"),
        (lambda: Chain("arm"), "arm.links: must have at least one link"),
        (lambda: Modes("boom"), "boom.modes: must have at least one mode"),
        (lambda: flexible((2.5, 2.5, 0)), "linear participations of left, right exceed hub, which includes the modes"),
        (lambda: flexible((0, 0, 0), (0, 0, 0.8)), "angular participations of left, right exceed hub"),
        (lambda: Pendulum("p", 1.0, 1.0, axis=(1, 0, 0), rest=([1, [2]], 0, 0)), "p.rest = .*: must be numbers in"),
        (lambda: Pendulum("p", 1.0, 1.0, axis=(1, 0, 0), rest=(0, 0, 1), angles=True), "p.angles = True: must be 1"),
        (
            lambda: assembled(HUB, Tether("t", mass=1.0, inertia=BALL, start=1.0, **LINE)),
            "t.start = 1.0: must be 3 numbers",
        ),
        (
            lambda: assembled(HUB, Tether("t", mass=1.0, inertia=BALL, start=(0, 0, math.nan), **LINE)),
            "t_z_0 = nan: must be a number",
        ),
        (lambda: Pendulum("p", 1.0, 1.0, axis=(1, 0, 0), rest=(0, 0, 1), angles=3), "p.angles = 3: must be 1 or 2"),
        (lambda: assembled(Pendulum("p", 1.0, 1.0, axis=(1, 0, 0), rest=(2, 0, 0))), "p.rest = .*: must not be along"),
        (lambda: UnbalancedWheel("w", None, 0.1, mass=1.0, across=0.1, static=0.1), "w.axis is missing"),
        (lambda: Thruster("t", direction=(1, 0, 0), at=None), "t.at is missing"),
        (lambda: assembled(ControlMomentGyro("g", (1, 0, 0), (1, 0, 0), 1.0, 1.0)), "g.spin = .*: must not be along"),
        (
            lambda: assembled(
                ControlMomentGyro("g", np.array([1, 0, 0]), (Value(1, source="drawing"), 0, 0), 1.0, 1.0)
            ),
            "g.spin = .*: must not be along",
        ),
        (
            lambda: ControlMomentGyro("g", (1, 0, 0), (0, 1, 0), 1.0, 1.0, speed=1.0, friction=1.0),
            "g.friction: a motor holds the constant speed",
        ),
        (lambda: Tank("t", 1.0, (0, 0, 0), (1, 0, 0), 1.0, share=0.5), "t: a bob needs both share and length"),
        (lambda: Tank("t", 1.0, (0, 0, 0), (1, 0, 0), 1.0, damping=0.5), "t.damping needs a bob"),
        (lambda: Tank("t", 1.0, (0, 0, 0), (1, 0, 0), 1.0, rest=(0, 0, True)), "t.rest needs a bob: give share and"),
        (lambda: Tank("t", 1.0, (0, 0, 0), exhaust=1.0), "t: an engine force needs both thrust and exhaust"),
        (lambda: assembled(Engine("e", (1, 0, 0), (2, 0, 0), 1.0)), "e.direction = .*: must not be along"),
        (lambda: assembled(HUB, BODY, Cable("c", between=(BODY, OTHER), **LINE)), "c.between: other is not mounted on"),
        (lambda: Cable("c", between=(BODY, BODY), **LINE), "c.between = body, body: must be two different bodies"),
        (lambda: Hinge("h", 1.0, BALL, axis=(1, 0, 0), locked=0.3), "h.locked = 0.3: motion is free; leave locked out"),
        (lambda: Spacecraft("craft", attitude="euler angles"), "attitude = 'euler angles': must be one of quaternion"),
        (lambda: Spacecraft("craft", motion="orbit"), "motion = 'orbit': must be one of free"),
    ],
)
def test_a_wrong_assembly_is_refused(make, words):
    with pytest.raises(MehvarError, match=words):
        make()


def margins(system, **changes):
    values = {q.symbol: changes.get(q.name, q.default) for q in system.parameters}
    return [float(condition.margin.subs(values)) for condition in system.constraints]


def test_the_inertia_of_a_hub_is_that_of_a_body():
    system = assembled(Hub("hub", mass=1.0, inertia=((1.0, 0.1, 0), (0.1, 1.0, 0), (0, 0, 1.9))))
    check(system)
    assert min(margins(system)) > 0
    assert min(margins(system, hub_Jzz=2.1)) < 0
    assert min(margins(system, hub_Jxy=5.0)) < 0


def test_a_flat_hub_is_a_body():
    assert min(margins(assembled(Hub("hub", mass=1.0, inertia=(1.0, 1.0, 2.0))))) > 0


def test_what_a_motion_does_not_need_is_no_parameter():
    hub = Hub("hub", mass=1.0, inertia=(1.0, 2.0, 2.5))
    wheel = Wheel("wheel", axis=(1, 1, 0), inertia=0.1)
    attitude = assembled(hub, wheel, motion="attitude")
    plane = assembled(hub, motion="plane")
    for system in (attitude, plane):
        check(system)
    assert "hub_m" not in [q.name for q in attitude.parameters]
    assert [q.name for q in plane.states] == ["vx", "vy", "wz", "theta"]


def test_the_derivation_has_a_section_for_each_part():
    """Before the sums over the parts, and their solution."""
    tank = Bob("tank", mass=2.0, length=0.3, damping=0.1)
    jet = Thruster("jet", direction=(1, 1, 0))
    system = assembled(Hub("hub", mass=10.0, inertia=BALL, centre=(0, 0.1, 0)), tank, jet)
    sections = list(dict.fromkeys(step.section for step in system.steps))
    assert sections == ["Mounts", "Part tank", "Accelerations", "Rates"]
    assert {s.symbol.name for s in system.steps if s.section == "Part tank"} >= {"tank_k", "tank_uu", "tank_dex"}


def test_hinge_and_slider_are_joints():
    assert all(isinstance(kind("j", 1.0, BALL, axis=(1, 0, 0)), Joint) for kind in (Hinge, Slider))


class Sprung(Part):
    """A mass on a spring, with an energy and a momentum in any power of its speed."""

    def __init__(self, energy, momentum):
        object.__setattr__(self, "name", "spring")
        object.__setattr__(self, "powers", (energy, momentum))

    def coordinates(self):
        return (Coordinate(Quantity("spring_v", "m/s", "speed"), Quantity("spring_x", "m", "place")),)

    def aggregates(self, at):
        (c,), (energy, momentum) = self.coordinates(), self.powers
        v = c.speed.symbol
        return Aggregates(sp.S.One, momentum=sp.Matrix([v**momentum, 0, 0]), energy=v**energy / 2)


@pytest.mark.parametrize(
    ("powers", "words"),
    [((4, 1), r"spring.energy = spring_v\*\*4/2: must be quadratic in"), ((2, 2), "spring.momentum = .*linear in")],
)
def test_a_part_whose_energy_is_not_kinetic_is_refused(powers, words):
    with pytest.raises(ModelError, match=words):
        assembled(Hub("hub", mass=1.0, inertia=BALL), Sprung(*powers))


class Odd(Sprung):
    """A spring with a particle at a given place, and given forces."""

    def __init__(self, place, forces=()):
        super().__init__(2, 1)
        object.__setattr__(self, "given", (place, forces))

    def particle(self, at):
        return Particle(sp.S.One, self.given[0])

    def aggregates(self, at):
        return Aggregates(forces=self.given[1])


@pytest.mark.parametrize(
    ("part", "words"),
    [
        (Odd(sp.Matrix([1, 0])), r"spring.place = Matrix\(\[\[1\], \[0\]\]\): must be a column of three"),
        (Odd([1, 0, 0]), r"spring.place = \[1, 0, 0\]: must be a column of three"),
        (Odd(sp.Matrix([TIME.symbol, 0, 0])), "spring.place = .*: depends on time"),
        (Odd(sp.Matrix([1, 0, 0]), (0, 0)), r"spring.forces = \(0, 0\): must have 1 entries"),
    ],
)
def test_terms_of_a_wrong_shape_or_in_time_are_refused(part, words):
    with pytest.raises(ModelError, match=words):
        assembled(Hub("hub", mass=1.0, inertia=BALL), part)


@dataclasses.dataclass(frozen=True)
class Loaded(Part):
    """A force and a mass, with a number of each form; the terms leave out the fields in `without`."""

    mass: Annotated[Number, scalar("m", "kg", "mass")] = 2.0
    at: Annotated[Vector, place("r", "place")] = (0, 1.0, 0)
    push: Annotated[Vector, vector("f", "N", "force")] = (1.0, 0, 0)
    along: Annotated[Vector, direction("a", "axis")] = (0, 1.0, 2.0)
    inertia: Annotated[Tensor, tensor("J", "moment of inertia")] = BALL
    gain: Annotated[Number | None, scalar("k", "1", "gain")] = 0.5
    size: Annotated[Number | None, scalar("l", "m", "size in the picture")] = None
    without: tuple[str, ...] = ()

    def _read(self, at, field, idle):
        return idle if field in self.without else getattr(at.values, field)

    def aggregates(self, at):
        m, r = self._read(at, "mass", 0), self._read(at, "at", sp.zeros(3, 1))
        return Aggregates(m, m * r, point_inertia(m, r) + self._read(at, "inertia", sp.eye(3)))

    def loads(self, at):
        push, along = self._read(at, "push", sp.eye(3)[:, 0]), self._read(at, "along", sp.eye(3)[:, 1])
        return (Load(couple=push.cross(along) * self._read(at, "gain", 1)),)

    def shapes(self, at):
        return () if self.size is None else (Shape("a", "ball", (tuple(at.values.at * at.values.size),), "orange"),)


@pytest.mark.parametrize("motion", ["free", "plane"])
@pytest.mark.parametrize("field", ["mass", "at", "push", "along", "inertia", "gain"])
def test_a_field_that_no_term_of_its_part_contains_is_refused(field, motion):
    """Its parameters vanished silently; zeros and the motion leave out the others."""
    words = rf"craft: a\.{field} would be ignored: no term of the Loaded contains at\.values\.{field}"
    with pytest.raises(ModelError, match=words):
        assembled(HUB, Loaded("a", without=(field,)), motion=motion)


@pytest.mark.parametrize(
    "numbers",
    [
        {},
        {"push": (0, 0, 0)},
        {"push": (0, 0.5, 1.0)},
        {"size": 3.0},
        {"gain": None, "without": ("gain",)},
    ],
    ids=str,
)
def test_a_field_that_only_zeros_or_the_picture_leave_out_is_no_error(numbers):
    """A force along the arm has no torque."""
    assembled(HUB, Loaded("a", **numbers))


def test_terms_that_are_numbers_of_python_are_terms():
    """They ended in an AttributeError."""

    class Idle(Part):
        def particle(self, at):
            return Particle(0, sp.Matrix([1, 0, 0]), 0)

        def aggregates(self, at):
            return Aggregates(0, energy=0.0, potential=0, power=0)

    check(assembled(HUB, Idle("a")))


@pytest.mark.parametrize("name", PARTS)
def test_no_shipped_part_ignores_a_field(name):
    craft, ignored = craft_of(HUB, PARTS[name]), []
    craft.numbers(lambda part, at: ignored.extend(part.ignored(at)) or [], [{}])
    assert set(ignored) <= {"lag", "rate_limit"}  # in the rates of an engine


def test_a_shared_number_that_no_part_uses_is_refused():
    craft = craft_of(HUB)
    craft.parameter("Js", 0.1, "kg m^2")
    with pytest.raises(ModelError, match="craft: parameter 'Js' is used by no part and no law; remove it or use it"):
        craft.system()


def test_links_without_inertia_about_their_axis_are_refused():
    links = [Link(1.0, (0, 0, 0), axis=(0, 1, 0), centre=(0, 0.3, 0)) for _ in range(2)]
    with pytest.raises(ModelError, match="arm: no mass and no inertia moves with joint"):
        assembled(Hub("hub", mass=1.0, inertia=BALL), Chain("arm", links=links))


@dataclasses.dataclass(frozen=True)
class Beads(Part):
    """A mass at the sum of two places, along x and one more axis, by its particle or its aggregates."""

    mass: Annotated[Number, scalar("m", "kg", "mass")] = 1.0
    more: Annotated[Number | None, scalar("n", "kg", "another mass")] = None
    apart: sp.Expr = sp.S.Zero
    points: bool = True

    def coordinates(self):
        return tuple(Coordinate(Quantity(f"o_v{k}", "m/s", "speed"), Quantity(f"o_x{k}", "m", "place")) for k in (1, 2))

    def _at(self, of):
        (a, b), turn = of, sp.sin(self.apart)
        return sp.Matrix([a + b * sp.cos(self.apart), b * turn, 0])

    def particle(self, at):
        return Particle(at.values.mass, self._at([c.place.symbol for c in self.coordinates()])) if self.points else None

    def aggregates(self, at):
        places, speeds = zip(*((c.place.symbol, c.speed.symbol) for c in self.coordinates()), strict=True)
        m, n = at.values.mass, sp.S.Zero if self.more is None else at.values.more
        own = n * speeds[1] ** 2 / 2
        if self.points:
            return Aggregates(energy=own)
        place, speed = self._at(places), self._at(speeds)
        return Aggregates(
            m, m * place, point_inertia(m, place), m * speed, m * place.cross(speed), m * speed.dot(speed) / 2 + own
        )


@pytest.mark.parametrize("points", [True, False])
def test_coordinates_that_depend_on_each_other_are_refused_by_name(points):
    """The message was that a definition o_D2 is always inf."""
    words = "o: the coordinate of o_v2 is determined by that of o_v1: their mass matrix is singular at every state"
    for apart in (sp.S.Zero, sp.pi):
        with pytest.raises(ModelError, match=words):
            assembled(HUB, Beads("o", points=points, apart=apart))
    for free in ({"more": 1e-9}, {"apart": sp.Rational(1, 10**6)}):
        assembled(HUB, Beads("o", points=points, **free))


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Hinge("panel"), "panel.mass is missing; write it into the call: mass, kg"),
        (lambda: Wheel("w", axis=(1, 0, 0)), r"w.inertia is missing; .*: moment of inertia about the axis, kg m\^2$"),
        (lambda: Wheel(name="w", inertia=1.0), "w.axis is missing; write it into the call: axis$"),
        (lambda: Hub(), "Hub.name is missing; write it into the call$"),
        (lambda: Link(1.0), r"Link.inertia is missing; .*: moment of inertia about its centre of mass, kg m\^2"),
        (lambda: Mode(2.0, damping=0.0), "Mode.linear is missing"),
        (lambda: Chain(), "Chain.name is missing"),
        (
            lambda: Wheel("w", (1, 0, 0), 1.0, fricton=0.1),
            r"w: 'fricton' is not a field of Wheel \(did you mean",
        ),
        (lambda: Hub("hub", 1.0, BALL, (0, 0, 0), 5.0), "hub: too many positional arguments"),
        (lambda: Hub("hub", 1.0, BALL, mass=2.0), "hub: multiple values for argument 'mass'"),
    ],
)
def test_a_call_with_other_fields_than_those_of_the_part_is_refused(make, words):
    with pytest.raises(ModelError, match=words):
        make()


def test_a_part_is_copied():
    assert copy.deepcopy(HUB) == pickle.loads(pickle.dumps(HUB)) == HUB


@pytest.mark.parametrize(
    ("base", "arguments", "method"),
    [(Joint, (1.0, BALL, (1, 0, 0)), "_freedom"), (Instrument, (), "measured")],
)
def test_a_part_that_lacks_a_method_is_refused_when_it_is_made(base, arguments, method):
    class Own(base):
        pass

    with pytest.raises(ModelError, match=f"Own is not a complete part: it lacks the method {method}; write it"):
        Own("own", *arguments)


NO_NUMBERS = [
    math.nan,
    math.inf,
    -math.inf,
    True,
    False,
    "1",
    1j,
    10**400,
    sp.nan,
    sp.oo,
    sp.I,
    Value(math.nan),
    np.bool_(1),
]


@pytest.mark.parametrize(
    ("make", "field"),
    [
        (lambda x: Wheel("p", axis=(0, x, 0), inertia=1.0), "p.axis"),
        (lambda x: Wheel("p", axis=(0, x, 1), inertia=1.0), "p.axis"),
        (lambda x: assembled(HUB, Wheel("p", axis=(0, 0, 1), inertia=x)), "p.inertia"),
        (lambda x: Hinge("p", 1.0, BALL, axis=(x, 0, 0)), "p.axis"),
        (lambda x: Slider("p", 1.0, (1.0, 1.0, x), axis=(1, 0, 0)), "p.inertia"),
        (lambda x: SprungMass("p", mass=1.0, axis=(x, 0, 0), stiffness=1.0), "p.axis"),
        (lambda x: Thruster("p", direction=(0, 0, x)), "p.direction"),
        (lambda x: ControlMomentGyro("p", (1, 0, 0), (0, x, 0), 1.0, 1.0), "p.spin"),
        (lambda x: Hub("p", 1.0, ((1, 0, x), (0, 1, 0), (x, 0, 1))), "p.inertia"),
        (lambda x: Mode(1.0, 0.0, (0, 0, x), (0, 0, 0)), "Mode.linear"),
    ],
)
def test_a_field_is_refused_with_its_name_if_an_entry_is_not_a_finite_number(make, field):
    for number in NO_NUMBERS:
        with pytest.raises(ModelError, match=rf"{field} = .*: must be (a number|numbers) in .*inf\), .+ \(.+\)"):
            make(number)


def test_an_angle_that_is_locked_is_finite():
    for number in (math.nan, True, sp.nan):
        with pytest.raises(ModelError, match=r"h_locked = .*: must be a number in \(-inf, inf\), rad"):
            assembled(HUB, Hinge("h", 1.0, BALL, axis=(1, 0, 0), motion="locked", locked=number))


def test_numbers_of_numpy_are_numbers():
    axis = [np.int64(0), np.float32(3.0), np.int64(4)]
    assert assembled(HUB, Wheel("w", axis=axis, inertia=np.float32(0.5))).parameters


def test_an_error_in_a_law_names_the_line_that_gives_it():
    """It named the file of mehvar that makes the law."""
    craft = craft_of(HUB, Torquer("turn"), motion="attitude")
    craft.law("wrong", lambda law: {"turn": tuple(rate - 1 for rate in law.rates)})
    line = sys._getframe().f_lineno - 1
    with pytest.raises(ModelError, match=rf"test_refusals\.py:{line}: command of law 'wrong', row 1 of 3"):
        mehvar.build(craft)
