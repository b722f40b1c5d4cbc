# SPDX-License-Identifier: Apache-2.0
"""Parts for every gate: each kind, in a general position and along axes, with all options."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from mehvar.models.check import check
from mehvar.parts import (
    Bob,
    Chain,
    ControlMomentGyro,
    Engine,
    ExternalForce,
    Hinge,
    Hub,
    Link,
    Mode,
    Modes,
    Part,
    Pendulum,
    PointMass,
    Rod,
    Slider,
    Spacecraft,
    SprungMass,
    Tank,
    Tether,
    Torquer,
    UnbalancedWheel,
    Wheel,
)
from mehvar.physics.balances import Balances

FULL = ((10.0, 0.1, 0.2), (0.1, 12.0, 0.3), (0.2, 0.3, 15.0))
SMALL = ((1.0, 0.1, 0.2), (0.1, 1.5, 0.05), (0.2, 0.05, 2.0))
HUB = Hub("hub", mass=100.0, inertia=FULL, centre=(0.01, 0.02, 0.1))
PUSH, TURN = ExternalForce("push", at=(0.1, 0.2, -1.0)), Torquer("turn")
BODY = {"mass": 5.0, "inertia": SMALL}
JOINT = {"axis": (0.3, 1.0, -0.4), "at": (0.1, 0.5, 0.2), "centre": (0.2, 0.7, 0.1)}
SKEW = (0.3, -0.5, 0.7)
GYRO = {"spin": (1.0, 0.0, 0.2), "inertia": 0.2, "gimbal_inertia": 0.3}
BEAM = {"mass": 20.0, "length": 0.3, "at": (0.1, 0.2, 0.5)}
BESIDE = {"mass": 30.0, "inertia": SMALL, "at": (0.1, 0.2, 0.3), "length": 0.5, "start": (0.0, 0.0, 1.0)}
FUEL = {"mass": 30.0, "nozzle": (-1.0, 0.4, -0.2), "thrust": (1.0, 0.1, 0.2), "exhaust": 200.0, "at": (0.3, 0.2, 0.1)}
MODES = [
    Mode(frequency=2.0, damping=0.01, linear=(0.1, 0.2, 1.0), angular=(1.0, 0.2, 0.1)),
    Mode(frequency=5.0, damping=0.02, linear=(0.1, 0.2, 0.5), angular=(0.5, 0.1, 0.2)),
]
LINKS = [
    Link(**BODY, **JOINT, stiffness=3.0, damping=0.2, motor=True),
    Link(mass=3.0, inertia=SMALL, joint="slider", axis=(1, 0, 0), at=(0.5, 0, 0.1), centre=(0.2, 0, 0), stiffness=2.0),
    Link(mass=2.0, inertia=(1.0, 1.2, 1.5), joint="ball", at=(0.2, 0, 0.3), centre=(0, 0.3, 0.1), damping=0.1),
    Link(mass=1.0, inertia=SMALL, axis=(0, 0, 1), at=(0.1, 0.4, 0), centre=(0.1, 0.3, 0), damping=0.3),
]
PARTS: dict[str, Part] = {
    "point": PointMass("a", mass=3.0, at=(0.0, 1.0, 0.3)),
    "wheel along an axis": Wheel("a", axis=(1, 0, 0), inertia=0.1),
    "wheel": Wheel("a", axis=SKEW, inertia=0.2, friction=0.05),
    "unbalanced wheel": UnbalancedWheel(
        "a", axis=SKEW, inertia=0.2, mass=3.0, across=0.12, static=0.05, dynamic=0.02, at=(0.1, 0.2, 0.3), friction=0.1
    ),
    "unbalanced wheel along an axis": UnbalancedWheel(
        "a", axis=(0, 0, 1), inertia=0.2, mass=3.0, across=0.12, static=0.05, at=(0.1, 0, 0.3)
    ),
    "gyro of variable speed": ControlMomentGyro(
        "a", gimbal=SKEW, **GYRO, across=0.27, frame=0.05, friction=0.1, gimbal_friction=0.2
    ),
    "gyro of fixed speed": ControlMomentGyro("a", gimbal=SKEW, **GYRO, speed=50.0),
    "gyro of fixed speed at a rate": ControlMomentGyro("a", gimbal=SKEW, **GYRO, across=0.25, speed=5.0, lag=0.1),
    "gyro of variable speed at a rate": ControlMomentGyro("a", gimbal=(0, 0.6, 1), **GYRO, lag=0.1),
    "modes": Modes("a", modes=MODES),
    "bob": Bob("a", **BEAM, damping=0.1),
    "stout bob": Bob("a", **BEAM, damping=0.1, inertia=0.7),
    "pendulum by one angle": Pendulum("a", **BEAM, axis=(0.1, 0.2, 0.3), rest=(1, 0, 0), damping=0.1, inertia=0.7),
    "pendulum by two angles": Pendulum("a", **BEAM, axis=(0.1, 0.2, 0.3), rest=(1, 0, 0), angles=2, damping=0.1),
    "sprung mass": SprungMass("a", mass=3.0, axis=(0.1, 0.4, 0.3), stiffness=3.0, at=(0.1, 0.2, 0.5), damping=0.1),
    "hinge": Hinge("a", **BODY, **JOINT, stiffness=3.0, damping=0.2, motor=True),
    "hinge along an axis": Hinge("a", mass=5.0, inertia=(1.0, 1.5, 2.0), axis=(1, 0, 0), centre=(0, 0.7, 0)),
    "hinge, prescribed": Hinge("a", **BODY, **JOINT, motion="prescribed"),
    "hinge, locked": Hinge("a", **BODY, **JOINT, motion="locked", locked=0.3),
    "slider": Slider("a", **BODY, **JOINT, stiffness=3.0, damping=0.2, motor=True),
    "slider, prescribed": Slider("a", **BODY, **JOINT, motion="prescribed"),
    "slider, locked": Slider("a", **BODY, **JOINT, motion="locked", locked=0.3),
    "ball joint": Chain("a", [Link(**BODY, joint="ball", at=(0.1, 0.5, 0.2), centre=(0.2, 0.7, 0.1), damping=0.2)]),
    "chain": Chain("a", LINKS),
    "tank": Tank("a", **FUEL),
    "tank with a bob": Tank("a", **FUEL, share=0.6, length=0.3, damping=2.0, rest=(0, 0, -1)),
    "tank that feeds an engine": Tank("a", **FUEL | {"thrust": None, "exhaust": None}),
    "engine": Engine("a", direction=SKEW, axis=(0.1, 1.0, 0.3), lag=0.2, at=(-1.0, 0.2, 0.1), rate_limit=2.0),
    "rod": Rod("a", **BESIDE, stiffness=20.0, damping=0.3, mount=(0.3, 0.2, 0.1)),
    "tether": Tether("a", **BESIDE, stiffness=20.0, damping=0.3, mount=(0.3, 0.2, 0.1)),
}
LOSSY = ("wheel", "unbalanced wheel", "gyro of variable speed", "modes", "bob", "stout bob", "pendulum by one angle",
         "pendulum by two angles", "sprung mass", "hinge", "slider", "ball joint", "chain", "rod")  # fmt: skip
"""Parts with dampers."""


def craft_of(*parts: Part, name: str = "craft", **options: Any) -> Spacecraft:
    """Assemble a craft."""
    craft = Spacecraft(name, **options)
    for part in parts:
        craft.add(part)
    return craft


def assembled(parts: Sequence[Part], checked: bool = True, **options: str) -> Balances:
    """Assemble a craft, check its system unless its parts are in another craft, and return its functions."""
    system = craft_of(*parts, **options).system()
    if checked:
        check(system)
    return Balances(system)
