# SPDX-License-Identifier: Apache-2.0
"""Rates, energy and momentum of crafts against those of particles, which share no equation with the parts."""

from __future__ import annotations

import numpy as np
import pytest

from mehvar.models.parts import Hub
from tests.reference.reference_parts import Particles

from . import drawn
from .table import FULL, PARTS

CHEAP = ("wheel along an axis", "gyro of variable speed at a rate", "tank that feeds an engine", "engine")
"""Parts that are derived together in half a second."""
HUB = Hub("hub", mass=30.0, inertia=FULL, centre=(0.01, 0.02, 0.1))


def apart(parts, motion="free", orbit=None, seed=1):
    """Return how far the rates and readings are apart at five points, over the largest."""
    balances, world = drawn.balances(parts, motion, orbit), Particles(parts, motion, orbit)
    rng, worst = np.random.default_rng(seed), 0.0
    for _ in range(5):
        x, u = balances.sample(rng)
        results, expected = balances.rates(x, u), world.rates(x, u)
        size = max(1.0, *(abs(expected[name]) for name in results))
        worst = max(worst, *(abs(value - expected[name]) / size for name, value in results.items()))
        if motion != "plane":  # its readings are those in the plane
            held, wanted = balances.readings(x, u), world.readings(x, u)
            worst = max(worst, np.abs(held - wanted).max() / max(1.0, np.abs(wanted).max()))
    return worst


def test_a_craft_moves_as_particles():
    parts = [HUB, *(drawn.named(PARTS[case], f"part{k}") for k, case in enumerate(CHEAP))]
    assert apart(parts) < drawn.ROUNDING


@pytest.mark.soak
@pytest.mark.parametrize("case", PARTS)
def test_each_part_moves_as_particles(case):
    assert apart([HUB, PARTS[case]]) < drawn.ROUNDING


@pytest.mark.soak
@pytest.mark.parametrize("seed", range(50))
def test_random_crafts_move_as_particles(seed):
    parts, motion, orbit = drawn.craft(seed)
    assert apart(parts, motion, orbit, seed) < drawn.ROUNDING


def test_a_wrong_number_is_noticed():
    """As far as the mass of one part in a thousand."""
    parts = [HUB, PARTS["point"]]
    balances = drawn.balances(parts, "free", None)
    x, u = balances.sample(np.random.default_rng(1))
    world = Particles([HUB, drawn.named(PARTS["point"], "a", mass=3.003)])
    results, expected = balances.rates(x, u), world.rates(x, u)
    assert max(abs(results[name] - expected[name]) for name in results) > 1e6 * drawn.ROUNDING


@pytest.mark.soak
def test_random_crafts_have_every_kind_and_joint():
    crafts = [drawn.craft(seed) for seed in range(50)]
    dealt = {type(part) for parts, _, _ in crafts for part in parts}
    assert dealt == {Hub, *drawn.KINDS}
    links = {link.joint for parts, _, _ in crafts for part in parts for link in getattr(part, "links", ())}
    assert links == {"hinge", "slider", "ball"}
    assert {motion for _, motion, _ in crafts} == {"free", "attitude", "plane"}
