# SPDX-License-Identifier: Apache-2.0
"""Random crafts of all kinds of parts against particles under Newton's law, differentiated by CasADi."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from tests.models.parts import drawn
from tests.reference.reference_parts import Particles
from tests.validation.table import record

CRAFTS, POINTS = 10, 5
REASON = "rounding of both: condition of the mass matrix, 9e4 at most, times 2^-53 is 1e-11; the mean is 1e-13"


@pytest.mark.parametrize("first", range(0, 50, CRAFTS))
def test_random_crafts(first: int) -> None:
    errors = []
    for seed in range(first, first + CRAFTS):
        parts, motion, orbit = drawn.craft(seed)
        balances, world = drawn.balances(parts, motion, orbit), Particles(parts, motion, orbit)
        rng = np.random.default_rng(seed)
        for _ in range(POINTS):
            x, u = balances.sample(rng)
            results, expected = balances.rates(x, u), world.rates(x, u)
            size = max(1.0, *(abs(expected[name]) for name in results))
            errors += [(value - expected[name]) / size for name, value in results.items()]
    record(
        f"parts: accelerations of random crafts {first + 1} to {first + CRAFTS}, of all kinds of parts",
        "particles by Newton's law", f"CasADi {ca.__version__}", errors, drawn.ROUNDING, "of the largest", REASON,
    )  # fmt: skip
