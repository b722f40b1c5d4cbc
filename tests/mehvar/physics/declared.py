# SPDX-License-Identifier: Apache-2.0
"""Structures that are checked against physics, with their gates."""

from __future__ import annotations

from collections.abc import Callable

from mehvar.physics.gates import Gate
from mehvar.physics.machine import Machine
from tests.mehvar.physics import craft, pushed, satellite, slosh, triangle

Structure = tuple[tuple[str, str], ...]
Case = tuple[str, Structure]


def _slosh(pendulums: int, inertia: str, attitude: str = "angles") -> Case:
    return "slosh", (("pendulums", str(pendulums)), ("inertia", inertia), ("attitude", attitude))


CRAFT: Case = ("satellite", (("chart", "quaternion"), ("inertia", "full"), ("wheels", "any")))
"""Structure of the satellite with all extensions."""
CASES: tuple[Case, ...] = (
    ("triangle", ()),
    ("triangle", (("masses", "general"), ("model", "dynamic"))),
    ("triangle", (("masses", "general"), ("model", "dynamic"), ("rods", "uniform"))),
    ("satellite", ()),
    ("satellite", (("chart", "quaternion"),)),
    CRAFT,
    _slosh(2, "paper"),
    _slosh(1, "hinge"),
    _slosh(2, "ball", "quaternion"),
    _slosh(6, "ball"),
)
"""Structures with each value of each choice. The last one solves the hull's equations instead of the tensions."""
FURTHER: tuple[Case, ...] = (
    ("triangle", (("masses", "general"),)),
    ("triangle", (("model", "dynamic"),)),
    ("triangle", (("model", "dynamic"), ("rods", "uniform"))),
    _slosh(1, "paper"),
    _slosh(3, "paper"),
    _slosh(2, "hinge"),
    _slosh(3, "hinge"),
    _slosh(1, "ball"),
    _slosh(3, "ball"),
)
"""Other combinations of these values."""
EVERY = (*CASES, *FURTHER)


def _triangle(subject: Machine) -> list[Gate]:
    of_rates = subject.system.structure["model"] == "kinematic"
    return triangle.gates_of(subject) if of_rates else pushed.gates_of(subject)


_DECLARATIONS: dict[str, Callable[[Machine], list[Gate]]] = {
    "triangle": _triangle,
    "satellite": satellite.gates_of,
    "slosh": slosh.gates_of,
}


def gates_of(subject: Machine) -> list[Gate]:
    """Return the gates that a model declares for a structure."""
    if subject.system.structure == dict(CRAFT[1]):
        return craft.gates_of(subject)
    return _DECLARATIONS[subject.system.name](subject)


def title(case: Case) -> str:
    """Return the description of a case."""
    model, structure = case
    return ", ".join((model, *(f"{name} {value}" for name, value in structure)))
