# SPDX-License-Identifier: Apache-2.0
"""Own parts with a wrong term break a law of mechanics, which the check names."""

from dataclasses import dataclass, replace
from typing import Annotated

import pytest
import sympy as sp

from mehvar import ModelError, Quantity
from mehvar.parts import (
    Aggregates,
    Coordinate,
    Drag,
    ExternalForce,
    GravityGradient,
    Hub,
    Magnetorquer,
    Number,
    Orbit,
    Part,
    Particle,
    Spacecraft,
    SprungMass,
    Wheel,
    point_inertia,
    scalar,
)
from mehvar.physics.gates import TOLERANCE

HUB = Hub("hub", mass=30.0, inertia=(2.0, 2.5, 3.0), centre=(0.1, 0, 0))


@dataclass(frozen=True)
class Slide(Part):
    """A mass on a spring along x, beside O; one of its terms may be wrong."""

    mass: Annotated[Number, scalar("m", "kg", "mass")] = 1.5
    stiffness: Annotated[Number, scalar("k", "N/m", "stiffness")] = 2.0
    damping: Annotated[Number, scalar("d", "N s/m", "damping")] = 0.3
    beside: Annotated[Number, scalar("b", "m", "distance from the x axis")] = 0.4
    wrong: str = ""
    factor: float = -1.0

    def coordinates(self):
        place = Quantity(f"{self.name}_x", "m", "place")
        return (Coordinate(Quantity(f"{self.name}_v", "m/s", "speed"), place),)

    def aggregates(self, at):
        v, (c,) = at.values, self.coordinates()
        place, speed = sp.Matrix([c.place.symbol, v.beside, 0]), sp.Matrix([c.speed.symbol, 0, 0])
        true = Aggregates(
            v.mass, v.mass * place, point_inertia(v.mass, place), v.mass * speed, v.mass * place.cross(speed),
            v.mass * speed.dot(speed) / 2, v.stiffness * c.place.symbol**2 / 2, (-v.damping * c.speed.symbol,),
        )  # fmt: skip
        if self.wrong not in vars(true):
            return true
        value = getattr(true, self.wrong)
        other = tuple(self.factor * e for e in value) if isinstance(value, tuple) else self.factor * value
        return replace(true, **{self.wrong: other})

    def rates(self, at, motion):
        speed, acceleration = super().rates(at, motion)
        return (self.factor * speed if self.wrong == "rates" else speed, acceleration)

    def power(self, at, motion):
        return super().power(at, motion) * (self.factor if self.wrong == "power" else 1)


def craft_of(part):
    craft = Spacecraft("own")
    for each in (HUB, ExternalForce("push", at=(0.1, 0.2, 0.3)), part):
        craft.add(each)
    return craft


def test_a_true_part_keeps_all_laws():
    errors = craft_of(Slide("a")).check()
    assert max(errors.values()) < 1e-13
    assert list(errors) == [
        "energy changes by the power of loads, motors and dampers",
        "momentum changes by the loads",
        "the order of parts has no effect",
        "a constant velocity has no effect",
        "hub: its kinetic energy is never negative",
        "hub: its inertia is that of a body with its mass and first moment",
        "push: its kinetic energy is never negative",
        "a: its momentum is the rate of its first moment",
        "a: its dampers take energy",
        "a: its kinetic energy is never negative",
        "a: its inertia is that of a body with its mass and first moment",
    ]


@pytest.mark.parametrize(
    ("wrong", "factor", "law"),
    [
        ("mass", -1.0, "a: its kinetic energy is never negative"),
        ("first", -1.0, "a: its momentum is the rate of its first moment"),
        ("inertia", -1.0, "a: its kinetic energy is never negative"),
        ("inertia", 0.5, "a: its inertia is that of a body"),
        ("momentum", -1.0, "momentum changes by the loads .*a: its momentum is the rate"),
        ("angular", -1.0, "a: its kinetic energy is never negative"),
        ("energy", 0.5, "a: its kinetic energy is never negative"),
        ("forces", -1.0, "a: its dampers take energy"),
        ("rates", -1.0, "energy changes by the power .*; momentum changes by the loads"),
        (
            "power",
            2.0,
            r"own: not true: energy changes by the power of loads, motors and dampers \(error \S+\); at",
        ),
    ],
)
@pytest.mark.share(2)
def test_a_part_with_a_wrong_term_is_refused(wrong, factor, law):
    with pytest.raises(ModelError, match=law):
        craft_of(Slide("a", wrong=wrong, factor=factor)).check()


def test_friction_without_the_sign_of_its_speed_is_refused():
    class Rubbing(Slide):
        def aggregates(self, at):
            constant, (force,) = at.values.stiffness * at.values.beside, super().aggregates(at).forces
            return replace(super().aggregates(at), forces=(force - constant,))

    craft = Spacecraft("own")
    for part in (HUB, Rubbing("a")):  # without an input the speed of the part is positive at every random state
        craft.add(part)
    with pytest.raises(ModelError, match="not true: a: its dampers take energy"):
        craft.check()


def test_a_part_that_depends_on_the_order_is_refused():
    class First(SprungMass):
        def aggregates(self, at):
            of = super().aggregates(at)
            return of if at.craft.parts[0][0] == HUB else replace(of, potential=2 * of.potential)

    with pytest.raises(ModelError, match="not true: the order of parts has no effect"):
        craft_of(First("a", mass=1.0, axis=(1, 0, 0), stiffness=5.0)).check()


def test_a_massless_part_with_a_negative_energy_is_refused():
    class Odd(Wheel):
        def aggregates(self, at):
            of = super().aggregates(at)
            return replace(of, energy=-of.energy)

    with pytest.raises(ModelError, match="a: its kinetic energy is never negative"):
        craft_of(Odd("a", axis=(1, 2, 0), inertia=0.1)).check()


@dataclass(frozen=True)
class Bead(Part):
    """A mass on a spring along x, as a particle; its squared speed may have a factor, and its loss lack a force."""

    mass: Annotated[Number, scalar("m", "kg", "mass")] = 1.5
    loss: Annotated[Number, scalar("c", "N s/m", "loss")] = 0.4
    factor: float = 1.0
    false: bool = False

    def coordinates(self):
        place = Quantity(f"{self.name}_x", "m", "place")
        return (Coordinate(Quantity(f"{self.name}_v", "m/s", "speed"), place),)

    def particle(self, at):
        (c,) = self.coordinates()
        return Particle(at.values.mass, sp.Matrix([c.place.symbol, 0, 0]), self.factor * c.speed.symbol**2)

    def aggregates(self, at):
        speed, loss = self.coordinates()[0].speed.symbol, at.values.loss
        return Aggregates(power=-loss * speed**2) if self.false else Aggregates(forces=(-loss * speed,))


@pytest.mark.parametrize(
    ("part", "law"),
    [
        (Bead("a", factor=2.0), "not true: a: the speed of its particle is that of its place"),
        (Bead("a", factor=0.5), "a: the speed of its particle is that of its place"),
        (Bead("a", false=True), "not true: energy changes by the power"),
    ],
)
def test_a_particle_with_a_wrong_energy_is_refused(part, law):
    """On a hub centred at O, whose mass no rate needs: the laws were left out where a parameter is in no rate."""
    craft = Spacecraft("own")
    craft.add(replace(HUB, centre=(0, 0, 0)))
    craft.add(part)
    with pytest.raises(ModelError, match=law):
        craft.check()


def test_a_craft_that_nothing_moves_has_its_energy():
    craft = Spacecraft("one")
    craft.add(Hub("hub", mass=2.0, inertia=(1.0, 1.0, 1.0)))
    assert {"energy", "momentum", "power", "loads"} <= {f.name for f in craft.system().functions}
    assert "energy changes by the power of loads, motors and dampers" in craft.check()


@pytest.mark.parametrize("kind", ["motion=attitude", "motion=plane", "attitude=mrp", "attitude=euler"])
def test_every_kind_of_craft_is_checked(kind):
    craft = Spacecraft("craft", **dict([kind.split("=")]))
    craft.add(HUB)
    craft.add(Slide("a"))
    craft.add(Wheel("w", axis=(0, 0, 1), inertia=0.1, friction=0.01))
    assert max(craft.check().values()) <= TOLERANCE


def test_a_craft_in_orbit_is_checked():
    craft = Spacecraft("polar", orbit=Orbit("J2", size=6.9e6, inclination=1.7))
    for part in (HUB, GravityGradient(), Drag("front", area=0.06, at=(0.15, 0, 0), normal=(1, 0, 0)), Slide("a")):
        craft.add(part)
    craft.add(Magnetorquer("coil", axis=(1, 0, 0), limit=0.4))
    assert max(craft.check().values()) < 1e-12
    craft.parts[-2] = Slide("a", wrong="momentum")
    with pytest.raises(ModelError, match=r"polar: not true: energy changes by .*; momentum changes by the loads"):
        craft.check()


def test_a_hub_alone_is_checked():
    craft = Spacecraft("bare")
    craft.add(HUB)
    assert max(craft.check().values()) <= TOLERANCE
