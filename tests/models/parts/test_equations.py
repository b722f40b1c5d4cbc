# SPDX-License-Identifier: Apache-2.0
"""A part as a particle beside the same part by sums over its mass."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
import pytest
import sympy as sp

from mehvar.codegen.functions.graphs import generate_functions
from mehvar.models.parts import Aggregates, Coordinate, Hub, Number, Part, Particle, UnbalancedWheel, Value, scalar
from mehvar.models.quantities import ModelError, Quantity

from .table import HUB, craft_of

ROUNDING = 1e-12
"""Over the largest rate: some hundred operations."""


@dataclass(frozen=True)
class Bead(Part):
    """A bead on a curved surface that two coordinates describe, with a body of its own on the first of them."""

    mass: Annotated[Number, scalar("m", "kg", "mass")] = 0.3
    own: Annotated[Number | None, scalar("mb", "kg", "mass of the body")] = 0.2
    length: Annotated[Number, scalar("l", "m", "length of the surface")] = 1.7
    stiffness: Annotated[Number, scalar("k", "N/m", "stiffness")] = 0.5
    split: bool = True
    short: bool = False

    def coordinates(self):
        pairs = ((f"{self.name}_{axis}", Quantity(f"{self.name}_{axis}", "m", axis)) for axis in "ab")
        return tuple(Coordinate(Quantity(f"{name}_dot", "m/s", "speed"), place) for name, place in pairs)

    def particle(self, at):
        (a, da), (b, db) = ((c.place.symbol, c.speed.symbol) for c in self.coordinates())
        place = sp.Matrix([a, b, at.values.length + a * b / at.values.length])
        squared = da**2 + db**2 + (da * b + a * db) ** 2 / at.values.length**2
        return Particle(at.values.mass, place, squared if self.short else None) if self.split else None

    def aggregates(self, at):
        (a, da), _ = ((c.place.symbol, c.speed.symbol) for c in self.coordinates())
        spring = (-at.values.stiffness * a, sp.S.Zero)
        body = Aggregates(forces=spring)
        if self.own is not None:
            place, speed, mass = sp.Matrix([0, 0, a]), sp.Matrix([0, 0, da]), at.values.own
            inertia = mass * (place.dot(place) * sp.eye(3) - place * place.T)
            momentum = mass * speed
            energy = mass * da**2 / 2
            body = Aggregates(mass, mass * place, inertia, momentum, place.cross(momentum), energy, forces=spring)
        return body if self.split else replace(self, split=True).total(at)


def rates(bead: Bead, motion: str, x: np.ndarray) -> np.ndarray:
    hub = Hub("hub", 2.0, ((1.0, 0.1, 0.0), (0.1, 1.5, 0.0), (0.0, 0.0, 2.0)), (0.1, 0.2, 0.3))
    system = craft_of(hub, bead, motion=motion).system()
    graph = next(f.graph for f in generate_functions(system) if f.name == "rhs")
    p = [float(q.default) for q in system.parameters]
    return graph(x[: graph.size1_in(0)], np.zeros(graph.size1_in(1)), p).full().ravel()


@pytest.mark.parametrize(("motion", "own"), [("free", None), ("attitude", 0.2), ("plane", 0.2)])
def test_a_particle_moves_as_its_sums_do(motion, own):
    x = np.random.default_rng(3).uniform(-1, 1, 21)
    by_sums = rates(Bead("bead", split=False, own=own), motion, x)
    for short in (False, True):
        by_place = rates(Bead("bead", short=short, own=own), motion, x)
        assert np.abs(by_place - by_sums).max() < ROUNDING * np.abs(by_sums).max()


def test_a_particle_with_a_wrong_speed_breaks_the_laws_of_mechanics():
    @dataclass(frozen=True)
    class Wrong(Bead):
        def particle(self, at):
            own = super().particle(at)
            return replace(own, squared=own.squared * 2)

    with pytest.raises(ModelError, match="energy"):
        craft_of(HUB, Wrong("bead", short=True)).check()


def test_a_coordinate_that_moves_no_mass_is_refused():
    @dataclass(frozen=True)
    class Idle(Bead):
        def particle(self, at):
            return Particle(at.values.mass, sp.Matrix([self.coordinates()[0].place.symbol, 0, 0]))

    with pytest.raises(ModelError, match="no mass and no inertia moves with bead_b_dot"):
        craft_of(HUB, Idle("bead", own=None)).system()


@pytest.mark.parametrize("axis", [np.array([3, 1, 2]), np.float32([3, 1, 2]), [Value(3, source="drawing"), 1, 2]])
def test_an_imbalance_points_in_the_same_direction_for_every_kind_of_number(axis):
    """By default away from the wheel's axis, hence towards y."""

    def equations(axis):
        wheel = UnbalancedWheel("wheel", axis=axis, inertia=0.1, mass=1.0, across=0.1, static=1e-3)
        return craft_of(HUB, wheel, motion="attitude").system()

    system, other = equations((3, 1, 2)), equations(axis)
    assert (system.rhs, system.definitions) == (other.rhs, other.definitions)
