# SPDX-License-Identifier: Apache-2.0
"""Random crafts: parts of every kind with random numbers and options."""

from __future__ import annotations

from dataclasses import MISSING, fields, replace
from typing import Any

import numpy as np

from mehvar.models import parts as of
from mehvar.models.parts.values import Kind, kinds
from mehvar.models.quantities import ModelError
from mehvar.physics.balances import Balances

from .table import craft_of

ROUNDING = 1e-12
"""Difference of two solutions of the same equations over the largest acceleration. The condition of the random crafts'
mass matrices is up to 9e4, 900 in the mean; times a rounding of double that is 1e-11 and 1e-13. The largest error of 50
crafts is 7e-14."""
LOADS = (
    of.GravityGradient, of.Dipole, of.Magnetorquer, of.Drag, of.SunPressure, of.ThirdBody, of.SunGravity,
)  # fmt: skip
"""Parts that need an orbit."""
KINDS = (
    of.PointMass, of.Wheel, of.UnbalancedWheel, of.ControlMomentGyro, of.Modes, of.Hinge, of.Slider, of.Chain, of.Bob,
    of.Pendulum, of.SprungMass, of.Tank, of.Engine, of.Rod, of.Tether, of.Cable, of.Thruster, of.Torquer,
    of.ExternalForce, *LOADS,
)  # fmt: skip
ENDS = tuple(tuple(sign * int(k == axis) for k in range(3)) for axis in range(3) for sign in (1, -1))
OPTIONS: dict[str, tuple[Any, ...]] = {
    "motor": (False, True), "motion": ("free", "prescribed", "locked"), "angles": (1, 2), "rest": ENDS,
    "joint": ("hinge", "slider", "ball"), "locked": (0.0, 0.7),
}  # fmt: skip
SCALES = {"mass": 4.0, "frame": 0.1, "dynamic": 0.1, "share": 0.5, "linear": 0.5, "angular": 0.5, "damping": 0.2}
"""Factors with which gyros and wheels are bodies, and modes have less mass and inertia than the hub."""


def tensor(rng: np.random.Generator, size: float = 0.4) -> tuple[tuple[float, ...], ...]:
    """Return the inertia of eight point masses, which form a body."""
    points = rng.normal(size=(8, 3)) * size
    points -= points.mean(axis=0)
    moments = sum(((p @ p) * np.eye(3) - np.outer(p, p) for p in points), np.zeros((3, 3)))
    return tuple(map(tuple, ((moments + moments.T) / 2).tolist()))


def number(field: str, kind: Kind, rng: np.random.Generator) -> Any:
    if kind.form == "tensor":
        return tensor(rng)
    size = SCALES.get(field, 1.0)
    return float(size * rng.uniform(0.6, 1)) if kind.form == "scalar" else tuple((size * rng.normal(size=3)).tolist())


def filled(kind: type, rng: np.random.Generator, **given: Any) -> Any:
    """Return an instance with random fields; options that exclude each other are drawn again."""
    declared = kinds(kind)
    for _ in range(100):
        values = {}
        for field in fields(kind):
            if not field.init or field.name in given:
                continue
            if field.name in OPTIONS and (field.name != "rest" or field.name not in declared):
                choices = OPTIONS[field.name]
                values[field.name] = choices[rng.integers(len(choices))]
            elif field.name in declared and (field.default is not None or rng.integers(2)):
                values[field.name] = number(field.name, declared[field.name], rng)
            elif field.default is MISSING and field.name not in declared:
                raise TypeError(f"{kind.__name__}.{field.name} needs a value")
        try:
            return kind(**given, **values)
        except ModelError as error:
            refused = error
    raise refused


def part(kind: type, name: str, rng: np.random.Generator, others: list[of.Part]) -> of.Part:
    """Return a part of a kind."""
    given: dict[str, Any] = {}
    if kind is of.Chain:
        given["links"] = [filled(of.Link, rng) for _ in range(rng.integers(1, 4))]
    if kind is of.Modes:
        given["modes"] = [filled(of.Mode, rng) for _ in range(rng.integers(1, 3))]
    if kind is of.Tank:
        given["mass"] = 1.0
    if kind is of.Magnetorquer:
        given["duty"] = None
    if kind is of.UnbalancedWheel:
        given["towards"] = str(rng.choice(["", "x", "y", "z"]))
    if issubclass(kind, of.Rod):
        given["start"] = (0.0, 0.0, 1.0)
    if kind is of.Cable:
        given["between"] = tuple(other for other in others if isinstance(other, of.Rod))[:2]
    return filled(kind, rng, name=name, **given)


def named(part: of.Part, name: str, **changes: Any) -> of.Part:
    return replace(part, name=name, **changes)


def hub(rng: np.random.Generator) -> of.Hub:
    return of.Hub("hub", mass=rng.uniform(10, 20), inertia=tensor(rng, 1.0), centre=tuple(rng.normal(size=3).tolist()))


def orbit(rng: np.random.Generator) -> of.Orbit:
    """Return an orbit of a few metres about a light Earth, on which every load is of the order of one."""
    names = ("size", "radius", "spin", "dipole", "tilt", "longitude", "density", "height", "thinning", "sunlight")
    given = {name: float(rng.uniform(0.3, 1)) for name in (*names, "mu", "ascension", "declination")}
    harmonics = {"two-body": (), "J2": ("oblateness",), "J4": ("oblateness", "third", "fourth")}
    gravity = str(rng.choice(list(harmonics)))
    return of.Orbit(gravity, **given, **{name: float(rng.uniform(0.05, 0.2)) for name in harmonics[gravity]})


def craft(seed: int, count: int = 0) -> tuple[list[of.Part], str, of.Orbit | None]:
    """Return parts, motion and orbit of a random craft; successive seeds deal all kinds."""
    deck = [kind for rng in (np.random.default_rng(100 + seed // 5),) for kind in rng.permutation(KINDS)]
    rng = np.random.default_rng(seed)
    dealt = deck[seed % 5 :: 5][: count or len(deck)]
    if of.Cable in dealt:
        dealt = [of.Rod, of.Tether, *dealt]
    if any(issubclass(kind, of.Rod) for kind in dealt):  # the gradient acts on one rigid body
        dealt = [kind for kind in dealt if kind is not of.GravityGradient]
    parts: list[of.Part] = [hub(rng)]
    for k, kind in enumerate(dealt):
        parts.append(part(kind, f"part{k}", rng, parts))
    if any(isinstance(each, LOADS) for each in parts):
        return parts, "free", orbit(rng)
    flat = not any(isinstance(each, of.Torquer | of.ExternalForce) for each in parts)
    return parts, str(rng.choice(["free", "attitude", "plane"] if flat else ["free", "attitude"])), None


def balances(parts: list[of.Part], motion: str, around: of.Orbit | None) -> Balances:
    """Return the functions of a craft."""
    return Balances(craft_of(*parts, motion=motion, orbit=around).system())
