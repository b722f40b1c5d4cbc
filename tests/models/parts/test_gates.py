# SPDX-License-Identifier: Apache-2.0
"""One table of parts, and a test for each law of mechanics over all of them."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Annotated, Any

import numpy as np
import pytest
import sympy as sp

from mehvar.base.units import dimension
from mehvar.models.parts import (
    Aggregates,
    Bob,
    Cable,
    Chain,
    Coordinate,
    Hinge,
    Hub,
    Link,
    Mode,
    Modes,
    Part,
    Pendulum,
    PointMass,
    Slider,
    SprungMass,
    Tether,
    UnbalancedWheel,
    Wheel,
    point_inertia,
)
from mehvar.models.parts.values import Number, kinds, scalar
from mehvar.models.system import Quantity
from mehvar.physics.balances import Balances, apart

from .table import BEAM, BODY, HUB, JOINT, LOSSY, PARTS, PUSH, TURN, assembled, craft_of

ROUNDING = 1e-12
"""Difference of two solutions of the same equations over the largest rate: some thousand operations on numbers near
one."""
PERMUTED = np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]])
TURNED = np.linalg.qr(np.array([[1.0, 0.2, 0.3], [-0.4, 1, 0.5], [0.3, -0.6, 1]]))[0]
TURNED *= np.sign(np.linalg.det(TURNED))


@functools.cache
def craft(case: str) -> Balances:
    return assembled((HUB, PUSH, TURN, PARTS[case]))


@functools.cache
def bare() -> Balances:
    return assembled((HUB, PUSH, TURN))


# without translation a craft has a subset of the equations
@pytest.mark.parametrize("motion", ["free", pytest.param("attitude", marks=pytest.mark.soak)])
@pytest.mark.parametrize("case", PARTS)
@pytest.mark.share(32)
def test_every_part_keeps_the_laws_of_mechanics(case, motion):
    assert max(craft_of(HUB, PUSH, TURN, PARTS[case], motion=motion).check().values()) < 1e-13


PLANAR = {case: (part,) for case, part in PARTS.items()}
PLANAR["two bobs and a wheel"] = Bob("b", **BEAM, rest=(0, 1, 0)), PARTS["bob"], Wheel("c", axis=(1, 0, 1), inertia=0.2)
BRIEF = "bob", "two bobs and a wheel", "unbalanced wheel along an axis"
"""Ways to solve in a plane: by the pulls of one bob, and of several; and a part that names steps by its numbers."""


@pytest.mark.parametrize("case", [c if c in BRIEF else pytest.param(c, marks=pytest.mark.soak) for c in PLANAR])
def test_every_part_keeps_the_laws_of_mechanics_in_a_plane(case):
    assert max(craft_of(HUB, *PLANAR[case], motion="plane").check().values()) < 1e-13


@pytest.mark.parametrize("case", LOSSY)
@pytest.mark.share(24)
def test_dampers_take_energy(case):
    balances, rng = craft(case), np.random.default_rng(2)
    for _ in range(10):
        x, u = balances.sample(rng)
        assert balances.power(x, dict.fromkeys(u, 0.0)) < 0


def scaled(quantities: Any, name: str, factor: float) -> dict[str, float]:
    """Return by which powers of a factor the numbers of a part go with its mass: those of the kg in their units."""
    return {
        q.name: factor ** float(dimension(q.unit).get("kg", 0)) if q.name.startswith(f"{name}_") else 1.0
        for q in quantities
    }


@functools.cache
def pair(case: str) -> Balances:
    """A part twice, and all in another order."""
    return assembled((PARTS[case], TURN, replace(PARTS[case], name="b"), PUSH, HUB), checked=False)


def paired(case: str, seed: int, first: float, second: float) -> tuple[dict[str, float], dict[str, float]]:
    """Return the rates of a craft with a part, and with two that have these shares of its mass."""
    whole = craft(case)
    x, u = whole.sample(np.random.default_rng(seed))
    values, given = {q.name: float(q.default) for q in whole.system.parameters}, []
    for group, of in ((whole.system.states, x), (whole.system.inputs, u), (whole.system.parameters, values)):
        shares = [scaled(group, "a", share) for share in (first, second)]
        other = {f"b{n[1:]}": of[n] * factor for n, factor in shares[1].items() if n.startswith("a_")}
        given.append({n: of[n] * factor for n, factor in shares[0].items()} | other)
    size = scaled(whole.system.states, "a", first)
    return {n: rate / size.get(n, 1.0) for n, rate in pair(case).rates(*given).items()}, whole.rates(x, u)


# two chains take ten times as long as two hinges, of which a chain is made
@pytest.mark.parametrize("case", [c if c != "chain" else pytest.param(c, marks=pytest.mark.soak) for c in PARTS])
@pytest.mark.share(16)
def test_two_halves_are_the_whole(case):
    results, expected = paired(case, 3, 0.5, 0.5)
    assert apart(results, expected) < ROUNDING


@pytest.mark.parametrize("case", [c if c != "chain" else pytest.param(c, marks=pytest.mark.soak) for c in PARTS])
@pytest.mark.share(16)
def test_a_part_without_mass_is_none_and_the_order_of_adding_does_not_matter(case):
    tiny = 1e-12
    results, expected = paired(case, 4, 1.0, tiny)
    assert apart(results, expected) < 1e4 * tiny  # inertias and speeds of the parts are below 10^4


def turned(thing: Any, turn: np.ndarray) -> Any:
    """Return a part whose vectors and tensors are turned."""
    values: dict[str, Any] = {}
    for name, kind in kinds(thing).items():
        value = getattr(thing, name)
        if value is None or kind.form == "scalar":
            continue
        array = np.array(value, dtype=float)
        if kind.form == "tensor":
            array = np.diag(array) if array.ndim == 1 else array
            array = turn @ array @ turn.T
            values[name] = tuple(map(tuple, (np.tril(array) + np.tril(array, -1).T).tolist()))
        else:
            values[name] = tuple((turn @ array).tolist())
    for field in fields(thing):
        value = getattr(thing, field.name)
        if isinstance(value, list) and value and is_dataclass(value[0]):
            values[field.name] = [turned(entry, turn) for entry in value]
    return replace(thing, **values)


def turned_numbers(values: Mapping[str, float], turn: np.ndarray) -> dict[str, float]:
    """Turn the triples of a state or an input: names that end in x, y, z, and the vectors of quaternions."""
    result = dict(values)
    for name in values:
        triple = [f"{name[:-1]}{end}" for end in ("xyz" if name.endswith("x") else "123")]
        if (name.endswith("x") or name.endswith("q1")) and all(n in values for n in triple):
            result |= dict(zip(triple, turn @ [values[n] for n in triple], strict=True))
    return result


@pytest.mark.parametrize("case", PARTS)
@pytest.mark.share(24)
def test_a_mount_turned_is_its_parameters_turned(case):
    part, rng = PARTS[case], np.random.default_rng(5)
    turn = PERMUTED if isinstance(part, UnbalancedWheel) else TURNED  # its angle zero is towards an axis of the hub
    around = assembled([turned(each, turn) for each in (HUB, PUSH, TURN, part)], checked=False)
    x, u = craft(case).sample(rng)
    results = around.rates(turned_numbers(x, turn), turned_numbers(u, turn))
    assert apart(results, turned_numbers(craft(case).rates(x, u), turn)) < ROUNDING


@dataclass(frozen=True)
class Driven(Part):
    """A point mass on two axes that are not across each other: an input prescribes the motion along the first."""

    mass: Annotated[Number, scalar("m", "kg", "mass")]

    def inputs(self):
        return (Quantity(f"{self.name}_input", "m/s^2", "acceleration"),)

    def coordinates(self):
        return tuple(
            Coordinate(Quantity(f"{self.name}_v{k}", "m/s", "speed"), Quantity(f"{self.name}_d{k}", "m", "place"))
            for k in "12"
        )

    def aggregates(self, at):
        axes = sp.Matrix([1, 0, 0]), sp.Matrix([1, 2, 0])
        places, speeds = zip(*((c.place.symbol, c.speed.symbol) for c in self.coordinates()), strict=True)
        place, velocity = (of[0] * axes[0] + of[1] * axes[1] for of in (places, speeds))
        m = at.values.mass
        return Aggregates(
            m, m * place, point_inertia(m, place), m * velocity, m * place.cross(velocity),
            m * velocity.dot(velocity) / 2, prescribed=(self.inputs()[0].symbol, None),
        )  # fmt: skip


def test_what_is_prescribed_moves_what_is_free():
    assert max(craft_of(HUB, PUSH, TURN, Driven("a", 3.0)).check().values()) < 1e-13


def body_at(part: Hinge | Slider, place: float) -> Hub:
    """Return the body of a joint at an angle or a place, as a hub of its own."""
    axis, at, centre = (np.array(v, dtype=float) for v in (part.axis, part.at, part.centre))
    axis /= np.linalg.norm(axis)
    if isinstance(part, Slider):
        return Hub("body", mass=part.mass, inertia=part.inertia, centre=tuple(at + centre + place * axis))
    hat = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    turn = np.eye(3) + np.sin(place) * hat + (1 - np.cos(place)) * hat @ hat
    inertia = turn @ np.array(part.inertia) @ turn.T
    inertia = (inertia + inertia.T) / 2
    return Hub("body", mass=part.mass, inertia=tuple(map(tuple, inertia.tolist())), centre=tuple(at + turn @ centre))


@pytest.mark.parametrize("case", ["hinge, locked", "slider, locked"])
@pytest.mark.share(2)
def test_a_locked_joint_is_a_composite_body(case):
    part = PARTS[case]
    composite = assembled((HUB, PUSH, TURN, body_at(part, part.locked)))
    x, u = craft(case).sample(np.random.default_rng(8))
    assert apart(craft(case).rates(x, u), composite.rates(x, u)) < ROUNDING


@pytest.mark.parametrize("case", ["hinge, prescribed", "slider, prescribed"])
@pytest.mark.share(2)
def test_a_prescribed_joint_at_rest_is_a_composite_body(case):
    part = PARTS[case]
    composite = assembled((HUB, PUSH, TURN, body_at(part, 0.7)))
    x, u = craft(case).sample(np.random.default_rng(9))
    own = {q.name for q in (*(c.speed for c in part.coordinates()), *part.inputs())}
    x, u = ({n: 0.0 if n in own else value for n, value in of.items()} for of in (x, u))
    x |= {c.place.name: 0.7 for c in part.coordinates()}
    assert apart(craft(case).rates(x, u), composite.rates(x, u)) < ROUNDING


@pytest.mark.parametrize("case", ["hinge", "slider"])
@pytest.mark.share(2)
def test_a_prescribed_joint_moves_as_a_free_one_with_its_acceleration(case):
    free, held = craft(case), craft(f"{case}, prescribed")
    x, u = free.sample(np.random.default_rng(10))
    rates = free.rates(x, u)
    (coordinate,) = PARTS[case].coordinates()
    assert apart(held.rates(x, u | {"a_acceleration": rates[coordinate.speed.name]}), rates) < ROUNDING


SPRUNG = {"mass": 3.0, "axis": (0.1, 0.4, 0.3), "stiffness": 3.0, "at": (0.1, 0.2, 0.5)}


def linear(balances: Balances, names: list[str]) -> np.ndarray:
    """Return accelerations of the hub per small displacement of coordinates."""
    rows = []
    for name in names:
        x = dict.fromkeys(balances.x_names, 0.0) | {"q0": 1.0}
        small = 1e-6
        ends = [balances.rates(x | {name: s}, dict.fromkeys(balances.u_names, 0.0)) for s in (small, -small)]
        rows.append([(ends[0][n] - ends[1][n]) / (2 * small) for n in ("vx", "vy", "vz", "wx", "wy", "wz")])
    return np.array(rows)


@pytest.mark.parametrize("kind", ["sprung mass", "hinge"])
@pytest.mark.share(2)
def test_small_motion_is_a_mode(kind):
    """Its frequency is sqrt(k/m), with a participation along the motion and about O."""
    if kind == "sprung mass":
        part, mass, k = SprungMass("a", **SPRUNG), 3.0, 3.0
        along, place, name = np.array(SPRUNG["axis"]), np.array(SPRUNG["at"]), "a_place"
        along, arm = along / np.linalg.norm(along), 1.0
    else:
        point = {"mass": 3.0, "inertia": (0.0, 0.0, 0.0), "axis": (0, 0, 1), "at": (0.1, 0.2, 0.5), "centre": (0, 2, 0)}
        part, mass, k, name = Hinge("a", **point, stiffness=12.0), 3.0, 12.0 / 4, "a_angle"
        along, place, arm = np.array([-1.0, 0, 0]), np.array([0.1, 2.2, 0.5]), 2.0
    root = mass**0.5
    mode = Mode((k / mass) ** 0.5, 0.0, tuple(root * along), tuple(root * np.cross(place, along)))
    exact = assembled((HUB, PUSH, TURN, part))
    flexible = assembled((HUB, PUSH, TURN, PointMass("tip", mass=mass, at=tuple(place)), Modes("m", modes=[mode])))
    # a displacement q of the mass is root q of the mode; differences over 1e-6 have 1e-10 of rounding
    assert np.allclose(linear(exact, [name]), linear(flexible, ["m_1"]) * root * arm, rtol=1e-7, atol=1e-9)


def test_a_pendulum_by_two_angles_is_a_bob():
    angles = assembled((HUB, PUSH, TURN, Pendulum("a", **BEAM, axis=(0, 1, 0), rest=(1, 0, 0), angles=2, damping=0.3)))
    ball = assembled((HUB, PUSH, TURN, Bob("a", **BEAM, damping=0.3)))
    x, u = angles.sample(np.random.default_rng(11))
    (c1, s1), (c2, s2) = ((np.cos(x[n]), np.sin(x[n])) for n in ("a_angle1", "a_angle2"))
    rod, side = np.array([c2 * c1, -s2, -c2 * s1]), np.array([-s1, 0, -c1])
    slip = x["a_rate1"] * c2 * side + x["a_rate2"] * np.array([-s2 * c1, -c2, s2 * s1])
    turning = slip + np.cross([x[f"w{a}"] for a in "xyz"], rod)
    given = {f"a_e{a}": e for a, e in zip("xyz", rod, strict=True)}
    given |= {f"a_u{a}": e for a, e in zip("xyz", turning, strict=True)}
    hub = [n for n in angles.x_names if not n.startswith("a_")]
    results, expected = angles.rates(x, u), ball.rates({n: x[n] for n in hub} | given, u)
    assert apart({n: results[n] for n in hub}, {n: expected[n] for n in hub}) < ROUNDING


@pytest.mark.parametrize(("joint", "case"), [("hinge", "hinge"), ("slider", "slider")])
@pytest.mark.share(2)
def test_a_chain_of_one_body_is_its_joint(joint, case):
    link = Link(**BODY, **JOINT, joint=joint, stiffness=3.0, damping=0.2, motor=True)
    chain = assembled((HUB, PUSH, TURN, Chain("a", [link])))
    x, u = craft(case).sample(np.random.default_rng(12))
    x, u = ({n.replace("a_", "a_1_"): value for n, value in of.items()} for of in (x, u))
    u["a_1_motor"] = next(value for n, value in u.items() if n.startswith("a_1_"))
    original = craft(case).rates(*({n.replace("a_1_", "a_"): v for n, v in of.items()} for of in (x, u)))
    assert apart(chain.rates(x, u), {n.replace("a_", "a_1_"): v for n, v in original.items()}) < ROUNDING


def test_an_unbalanced_wheel_without_imbalance_is_a_balanced_one():
    """With its mass, and its inertia across the axis, in the hub."""
    given = {"axis": (0, 0, 1), "inertia": 0.2}
    shaken = assembled(
        (HUB, PUSH, TURN, UnbalancedWheel("a", **given, mass=3.0, across=0.12, static=0.0, at=(0.1, 0, 0.3)))
    )
    rest = Hub("rest", mass=3.0, inertia=((0.12, 0, 0), (0, 0.12, 0), (0, 0, 1e-12)), centre=(0.1, 0, 0.3))
    even = assembled((HUB, PUSH, TURN, Wheel("a", **given), rest))
    x, u = shaken.sample(np.random.default_rng(13))
    expected = even.rates(x, u)
    assert apart({n: shaken.rates(x, u)[n] for n in expected}, expected) < 1e-11  # its inertia is 1e-12 of the rest


def test_an_unbalanced_wheel_is_a_body_on_a_hinge():
    """Whose centre of mass and products of inertia are those of its imbalances."""
    given = {"axis": (0, 0, 1), "at": (0.1, 0, 0.3), "mass": 3.0}
    wheel = UnbalancedWheel("a", **given, inertia=0.2, across=0.12, static=0.06, dynamic=0.03)
    inertia = ((0.12, 0, 0), (0, 0.12, 0.03), (0, 0.03, 0.2))
    body = Hinge("a", **given, inertia=inertia, centre=(0.02, 0, 0), motor=True)
    shaken, turning = assembled((HUB, PUSH, TURN, wheel)), assembled((HUB, PUSH, TURN, body))
    x, u = shaken.sample(np.random.default_rng(15))
    expected = turning.rates(x | {"a_rate": x["a_speed"]}, u)
    expected["a_speed"] = expected.pop("a_rate")
    assert apart(shaken.rates(x, u), expected) < ROUNDING


def test_bodies_on_lines_are_free_where_these_are_slack():
    slack, rng = craft("tether"), np.random.default_rng(14)
    x, u = slack.sample(rng)
    x |= {"a_x": 0.1, "a_y": 0.2, "a_z": 0.3}  # the mounts are 0.4 m apart, the tether has 0.5 m
    rates, hub = slack.rates(x, u), bare().rates(x, u)
    assert apart({n: rates[n] for n in hub}, hub) < ROUNDING
    assert {event.name for event in slack.system.events} == {"a_taut", "a_pulls"}


MASSES = {"a": 2.0, "b": 3.0, "c": 1.5}
LENGTHS = {"ab": 1.0, "ac": 1.2, "bc": 0.9}


@functools.cache
def joined(hub: str) -> Balances:
    """Return three masses that three tethers join, with one of them as the hub."""
    line = {"stiffness": 20.0, "damping": 0.3}
    bodies = [
        Tether(n, mass=MASSES[n], inertia=(1, 2, 2), start=(1, 1, 1), length=LENGTHS["".join(sorted(hub + n))], **line)
        for n in MASSES
        if n != hub
    ]
    between = "".join(body.name for body in bodies)
    cable = Cable("cable", between=(bodies[1], bodies[0]), length=LENGTHS[between], **line)
    return assembled((Hub(hub, mass=MASSES[hub], inertia=(1, 2, 2)), *bodies, cable))


@pytest.mark.soak
def test_three_masses_on_tethers_move_alike_whichever_is_the_hub():
    rng = np.random.default_rng(17)
    for _ in range(8):
        places, speeds = ({n: rng.normal(size=3) * 0.7 for n in MASSES} for _ in range(2))
        moved = []
        for hub in MASSES:
            x = dict.fromkeys(joined(hub).x_names, 0.0) | {"q0": 1.0}
            x |= {f"v{axis}": speed for axis, speed in zip("xyz", speeds[hub], strict=True)}
            others = [n for n in MASSES if n != hub]
            for n in others:
                for axis, place, speed in zip("xyz", places[n] - places[hub], speeds[n] - speeds[hub], strict=True):
                    x |= {f"{n}_q0": 1.0, f"{n}_{axis}": place, f"{n}_v{axis}": speed}
            rates = joined(hub).rates(x, {})
            own = np.array([rates[f"v{axis}"] for axis in "xyz"])
            relative = {n: np.array([rates[f"{n}_v{axis}"] for axis in "xyz"]) for n in others}
            moved.append({hub: own} | {n: own + more for n, more in relative.items()})
        for other in moved[1:]:
            assert all(np.abs(other[n] - moved[0][n]).max() < ROUNDING * 100 for n in MASSES)


def test_a_cable_keeps_the_balances():
    rng = np.random.default_rng(18)
    for _ in range(8):
        assert max(joined("a").errors(*joined("a").sample(rng))) < 1e-13
    assert {event.name for event in joined("a").system.events} >= {"cable_taut", "cable_pulls"}


@pytest.mark.soak
@pytest.mark.parametrize("seed", range(50))
def test_random_assemblies_keep_their_balances(seed):
    """One to six parts of the table, in any order; the hub is anywhere among them."""
    rng = np.random.default_rng(seed)
    names = rng.choice(list(PARTS), size=rng.integers(1, 7))
    parts: list[Part] = [replace(PARTS[name], name=f"part{k}") for k, name in enumerate(names)]
    order = rng.permutation(len(parts) + 3)
    pool = [HUB, PUSH, TURN, *parts]
    whole = craft_of(*(pool[k] for k in order), motion=str(rng.choice(["free", "attitude"])))
    assert max(whole.check().values()) < ROUNDING
