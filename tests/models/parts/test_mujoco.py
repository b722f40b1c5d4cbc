# SPDX-License-Identifier: Apache-2.0
"""Accelerations of hinges, sliders, ball joints and unequal chains against MuJoCo."""

import numpy as np
import pytest

from mehvar.models.parts import Bob, Chain, ExternalForce, Hinge, Hub, Slider, Torquer

from .table import FULL, JOINT, LINKS, PARTS, SMALL, assembled
from .worlds import accelerations, engine

HUB = Hub("hub", mass=30.0, inertia=FULL, centre=(0.01, 0.02, 0.1))
CASES = {
    "hinge": [PARTS["hinge"]],
    "slider": [PARTS["slider"]],
    "bob": [Bob("a", mass=5.0, length=0.4, at=(0.1, 0.5, 0.2))],
    "ball": [PARTS["ball joint"]],
    "chain": [Chain("a", LINKS)],
    "three": [
        Hinge("a", mass=5.0, inertia=SMALL, axis=(1, 0, 0), at=(0, 0.5, 0), centre=(0, 0.7, 0), stiffness=1.0),
        Hinge("b", mass=4.0, inertia=SMALL, axis=(1, 0, 0), at=(0, -0.5, 0), centre=(0, -0.7, 0), damping=0.1),
        Slider("c", mass=2.0, inertia=SMALL, axis=(0, 0, 1), at=(0.2, 0, 0)),
    ],
    "hinge and chain": [Hinge("b", mass=2.0, inertia=SMALL, **JOINT), Chain("a", LINKS[::-1])],
}


@pytest.mark.parametrize("case", CASES)
@pytest.mark.share(8)
def test_accelerations_agree(case):
    balances = assembled((HUB, ExternalForce("push"), Torquer("turn"), *CASES[case]), checked=False)
    model, rng = engine(HUB, CASES[case]), np.random.default_rng(3)
    for _ in range(5):
        x, u = balances.sample(rng)
        expected, results = accelerations(model, HUB, CASES[case], x, u), balances.rates(x, u)
        size = max(1.0, *map(abs, expected.values()))
        worst = max(abs(results[name] - value) for name, value in expected.items()) / size
        assert worst < 1e-9, (worst, expected, {n: results[n] for n in expected})
