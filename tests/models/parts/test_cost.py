# SPDX-License-Identifier: Apache-2.0
"""Cost of an assembly: operations of a call that depend on state or input, and lines of C."""

from __future__ import annotations

import pytest

from mehvar.codegen.code.files import PrintedFunction, printed_functions
from mehvar.codegen.functions.graphs import generate_functions
from mehvar.models.parts import Bob, Hinge, Hub, Mode, Modes, Part, SprungMass, Tank, Wheel

from .table import FULL, HUB, MODES, craft_of


def rhs(*parts: Part) -> PrintedFunction:
    hub = Hub("hub", mass=100.0, inertia=FULL, centre=(0.01, 0, 0.1))
    functions = [f for f in generate_functions(craft_of(hub, *parts).system()) if f.name == "rhs"]
    return next(f for f in printed_functions(functions) if f.name == "rhs_prepared")


def test_a_craft_of_sixteen_degrees_of_freedom_takes_740_operations():
    pyramid = enumerate([(1, 1, 1), (1, -1, 1), (-1, 1, 1), (-1, -1, 1)], 1)
    wheels = [Wheel(f"wheel{k}", axis=axis, inertia=0.1) for k, axis in pyramid]
    panels = [Modes(name, modes=MODES) for name in ("left", "right")]
    craft = rhs(*wheels, *panels, Bob("tank", mass=20.0, length=0.3, at=(0.1, 0.2, 0.5), damping=0.1))
    assert craft.operations <= 740


MODE = [Mode(frequency=2.0, damping=0.01, linear=(0.1, 0.2, 1.0), angular=(1.0, 0.2, 0.1))]
KINDS = {
    "wheel": (lambda k: Wheel(f"a{k}", axis=(0.3, 0.1 * k, 0.7), inertia=0.1), 20),
    "mode": (lambda k: Modes(f"a{k}", modes=MODE), 50),
    "bob": (lambda k: Bob(f"a{k}", mass=2.0, length=0.3, at=(0.1 * k, 0.2, 0.5), damping=0.1), 200),
    "sprung mass": (
        lambda k: SprungMass(f"a{k}", mass=2.0, axis=(0.3, 0.1, 0.7), at=(0.1 * k, 0.2, 0.5), stiffness=1.0), 120,
    ),
    "tank": (
        lambda k: Tank(f"a{k}", 2.0, nozzle=(-1, 0, 0), thrust=(1, 0, 0), exhaust=100.0, at=(0.1 * k, 0.2, 0.5)), 50,
    ),
    "hinge": (
        lambda k: Hinge(f"a{k}", 2.0, (0.1, 0.2, 0.25), (0.3, 0.1, 0.7), (0.1 * k, 0.2, 0.5), (0.5, 0.1, 0.2)), 310,
    ),
}  # fmt: skip
"""Makers of parts, and the operations that one more may cost."""


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.share(7)
def test_operations_are_linear_in_the_number_of_parts_and_the_text_does_not_grow(kind):
    make, most = KINDS[kind]
    crafts = [rhs(*(make(k) for k in range(1, count + 1))) for count in (8, 9, 10)]
    few, more, many = (craft.operations for craft in crafts)
    assert more - few == many - more <= most
    few_lines, many_lines = ([line for line in craft.c_lines if "enum" not in line] for craft in (crafts[0], crafts[2]))
    sums = 2 * 2 if kind == "tank" else 0  # of two more tanks: one sum over them is no loop, with two terms a tank
    assert len(many_lines) - len(few_lines) == sums  # names of elements aside: there are four on a line


def test_constraints_of_modes_are_linear_in_their_number():
    """Expanded determinants grew with the cube, and eight appendages took 14 s."""

    def operations(count):
        craft = craft_of(HUB, *(Modes(f"a{k}", modes=MODE) for k in range(count)))
        return sum(c.margin.count_ops() for c in craft.system().constraints)

    two, three, four = map(operations, (2, 3, 4))
    assert 0 < three - two == four - three
