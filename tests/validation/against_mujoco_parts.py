# SPDX-License-Identifier: Apache-2.0
"""Twelve random assemblies of hinges, sliders, ball joints and chains against MuJoCo."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np
import pytest

from mehvar.models.parts import Chain, ExternalForce, Hinge, Hub, Link, Part, Slider, Torquer
from tests.models.parts.table import assembled
from tests.models.parts.worlds import accelerations, engine
from tests.validation.table import record

SAMPLES = 20
BOUND = 1e-12
"""Relative to the largest acceleration: rounding of both; masses and moments span a factor of a hundred."""


def inertia(rng: np.random.Generator, size: float) -> tuple[tuple[float, ...], ...]:
    """Return the inertia of eight point masses, which form a body."""
    points = rng.normal(size=(8, 3)) * size
    points -= points.mean(axis=0)
    moments = sum(((p @ p) * np.eye(3) - np.outer(p, p) for p in points), np.zeros((3, 3)))
    return tuple(map(tuple, ((moments + moments.T) / 2).tolist()))


def place(rng: np.random.Generator) -> tuple[float, ...]:
    return tuple(rng.uniform(-1, 1, 3).tolist())


def link(rng: np.random.Generator) -> Link:
    joint = str(rng.choice(["hinge", "slider", "ball"]))
    one = joint != "ball"
    return Link(
        mass=rng.uniform(0.5, 8), inertia=inertia(rng, 0.4), joint=joint, axis=place(rng) if one else None,
        at=place(rng), centre=place(rng), stiffness=rng.uniform(0, 5) if one else None, damping=rng.uniform(0, 1),
        motor=one and bool(rng.integers(2)),
    )  # fmt: skip


def assembly(seed: int) -> tuple[Hub, list[Part]]:
    """Return a hub and one to three parts: single joints, and chains of up to four bodies."""
    rng = np.random.default_rng(seed)
    hub = Hub("hub", mass=rng.uniform(20, 60), inertia=inertia(rng, 1.0), centre=place(rng))
    parts: list[Part] = []
    for name in "abc"[: rng.integers(1, 4)]:
        kind = rng.choice([Hinge, Slider, Chain, Chain])
        if kind is Chain:
            parts.append(Chain(name, [link(rng) for _ in range(rng.integers(1, 5))]))
        else:
            given = {"mass": rng.uniform(0.5, 8), "inertia": inertia(rng, 0.4), "axis": place(rng)}
            parts.append(kind(name, at=place(rng), centre=place(rng), damping=rng.uniform(0, 1), **given))
    return hub, parts


def kinds(parts: Sequence[Part]) -> str:
    texts = []
    for part in parts:
        joints = f" ({', '.join(each.joint for each in part.links)})" if isinstance(part, Chain) else ""
        texts.append(type(part).__name__.lower() + joints)
    return " + ".join(texts)


@pytest.mark.parametrize("seed", range(12))
def test_random_assemblies(seed: int) -> None:
    hub, parts = assembly(seed)
    balances = assembled((hub, ExternalForce("push"), Torquer("turn"), *parts))
    model, rng, errors = engine(hub, parts), np.random.default_rng(seed), []
    for _ in range(SAMPLES):
        x, u = balances.sample(rng)
        expected, results = accelerations(model, hub, parts, x, u), balances.rates(x, u)
        size = max(1.0, *map(abs, expected.values()))
        errors.append([(results[name] - value) / size for name, value in expected.items()])
    record(
        f"parts: accelerations of assembly {seed + 1}, hub with {kinds(parts)}, {SAMPLES} random points",
        "MuJoCo", mujoco.__version__, errors, BOUND, "of the largest", "rounding of both"
    )  # fmt: skip
