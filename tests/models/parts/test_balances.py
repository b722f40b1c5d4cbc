# SPDX-License-Identifier: Apache-2.0
"""Momentum changes by the applied loads alone, and energy by their power and by dampers."""

import numpy as np
import pytest

from mehvar.models.check import check
from mehvar.models.parts import (
    Bob,
    ExternalForce,
    Hinge,
    Hub,
    Mode,
    Modes,
    PointMass,
    Slider,
    Spacecraft,
    Torquer,
    Wheel,
)

from .balances import Balances

FULL = ((10.0, 0.1, 0.2), (0.1, 12.0, 0.3), (0.2, 0.3, 15.0))
HUB = Hub("hub", mass=100.0, inertia=FULL, centre=(0.01, 0.02, 0.1))
PUSH, TURN = ExternalForce("push", at=(0.1, 0.2, -1.0)), Torquer("turn")
MODES = [
    Mode(frequency=2.0, damping=0.01, linear=(0.1, 0.2, 1.0), angular=(1.0, 0.2, 0.1)),
    Mode(frequency=5.0, damping=0.02, linear=(0.1, 0.2, 0.5), angular=(0.5, 0.1, 0.2)),
]
CASES = {
    "hub": [],
    "point": [PointMass("tip", mass=3.0, at=(0.0, 1.0, 0.3))],
    "wheels": [
        Wheel("wheel1", axis=(1, 0, 0), inertia=0.1),
        Wheel("wheel2", axis=(0.3, -0.5, 0.7), inertia=0.2, friction=0.05),
    ],
    "modes": [Modes("panel", modes=MODES)],
    "bob": [Bob("tank", mass=20.0, length=0.3, at=(0.1, 0.2, 0.5), damping=0.1)],
    "stout bob": [Bob("tank", mass=20.0, length=0.3, at=(0.1, 0.0, 0.5), damping=0.1, inertia=0.7)],
    "hinge": [
        Hinge(
            "panel",
            mass=5.0,
            inertia=FULL,
            axis=(0.3, 1.0, -0.4),
            at=(0.1, 0.5, 0.2),
            centre=(0.2, 0.7, 0.1),
            stiffness=3.0,
            damping=0.2,
            motor=True,
        )
    ],
    "slider": [Slider("mover", mass=5.0, inertia=FULL, axis=(0.3, 1.0, -0.4), at=(0.1, 0.5, 0.2), damping=0.3)],
    "all": [
        Wheel("wheel1", axis=(0.3, -0.5, 0.7), inertia=0.2, friction=0.05),
        Modes("panel", modes=MODES),
        Bob("tank1", mass=20.0, length=0.3, at=(0.1, 0.2, 0.5), damping=0.1),
        Bob("tank2", mass=5.0, length=0.5, at=(0.0, 0.0, 0.4), inertia=0.2),
    ],
}


@pytest.mark.parametrize(
    ("case", "attitude"), [*((case, "quaternion") for case in CASES), ("hub", "euler"), ("hub", "mrp")]
)
def test_momentum_and_energy_balance(case, attitude):
    craft = Spacecraft("craft", attitude=attitude)
    for part in (HUB, PUSH, TURN, *CASES[case]):
        craft.add(part)
    system = craft.system()
    check(system)
    balances, rng = Balances(system), np.random.default_rng(1)
    for _ in range(5):
        x, u = balances.state(rng), rng.normal(size=len(system.inputs))
        assert balances.residual(x, u) < 1e-13


@pytest.mark.parametrize("case", CASES)
def test_energy_and_angular_momentum_balance_about_the_centre_of_mass(case):
    """Where the attitude alone is a state."""
    craft = Spacecraft("craft", motion="attitude")
    for part in (HUB, PUSH, TURN, *CASES[case]):
        craft.add(part)
    system = craft.system()
    check(system)
    balances, rng = Balances(system), np.random.default_rng(2)
    for _ in range(3):
        x, u = balances.state(rng), rng.normal(size=len(system.inputs))
        assert balances.residual(x, u) < 1e-13
