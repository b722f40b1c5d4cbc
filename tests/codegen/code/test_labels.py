# SPDX-License-Identifier: Apache-2.0
"""An edit of a model changes few lines of generated text beside those whose meaning it changes."""

import importlib
import re
from collections.abc import Mapping
from pathlib import Path
from types import ModuleType

import pytest

from mehvar.codegen.code.files import code_files, printed_functions
from mehvar.codegen.equations.graph import equations_json
from mehvar.codegen.functions.graphs import generate_functions
from mehvar.codegen.manifest import manifest_of
from mehvar.models import system as vocabulary

from ...models import edits as helpers

BENCHMARKS = Path(__file__).parents[3] / "benchmarks"
PENDULUM = """
x = Group("x", (quantity("place", "m"), quantity("angle", "rad"), quantity("speed", "m/s"), quantity("turn", "rad/s")))
u, r = Group("u", (quantity("force", "N"),)), Group("r", (quantity("goal", "m"),))
p = Group("p", tuple(parameter(*row) for row in (
    ("cart", "kg"), ("bob", "kg"), ("rod", "m"), ("gravity", "m/s^2"), ("drag", "kg/s"),
)))
s = Group("s", (parameter("angle_0", "rad"),))
c, c2 = (Group("c", tuple(parameter(name, "1") for name in names)) for names in (("kp", "kd"), ("k", "level")))
sin, cos = sp.sin(x.angle), sp.cos(x.angle)
d = Derivation()
pull = d.define("pull", u.force - p.drag * x.speed + p.bob * p.rod * x.turn**2 * sin, title="what drives the cart")
inertia = d.define("inertia", p.cart + p.bob * sin**2, title="inertia of both")
rate = d.define("rate", (pull + p.bob * p.gravity * sin * cos) / inertia, title="acceleration of the cart")
fall = d.define("fall", -(p.gravity * sin + rate * cos) / p.rod, title="acceleration of the rod")
energy = p.bob * (p.rod * x.turn)**2 / 2 + p.bob * p.gravity * p.rod * (1 - cos)
near = c.kp * (r.goal - x.place) - c.kd * x.speed
system = System(
    name="pendulum", title="a pendulum on a cart", source="test", structure={}, states=x, inputs=u, references=r,
    outputs=Group("y", (quantity("E", "J"),)), parameters=p, scenario_parameters=s, rhs=(x.speed, x.turn, rate, fall),
    output=(energy,), steps=tuple(d.steps), limits=(), initial=(0, s.angle_0, 0, 0), reference=(0,), constraints=(),
    functions=(Function("energy", (x, p), ((quantity("E", "J"), energy),), "energy"),),
    controllers=(Controller("near", "to a place", c, (near,)),
                 Controller("swing", "to a height", c2, (c2.k * (c2.level - energy) * x.turn * cos,))),
    scenarios=(Scenario("plain", "plain", 1.0, 0.1, {}, {}, {}),), metrics=(),
)
"""
EDITS = {
    "coefficient": ("x.turn**2 * sin", "2 * x.turn**2 * sin"),
    "coefficient of the energy": ("(p.rod * x.turn)**2 / 2", "(p.rod * x.turn)**2 / 3"),
    "sign": ("pull + p.bob", "pull - p.bob"),
    "term": (" - p.drag * x.speed", ""),
    "gain": ("- c.kd", "- 2 * c.kd"),
    "line of a law": ("c2.k * (c2.level - energy) * x.turn * cos", "c2.k * (c2.level - energy) * sp.sign(x.turn)"),
}
RENAMES = {"name": ('"pull"', '"push"'), "title": ("inertia of both", "inertia of cart and bob")}


@pytest.fixture(scope="module")
def measure() -> ModuleType:
    """The benchmark, whose count this is, of three large models."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(BENCHMARKS))
        return importlib.import_module("small_edits")


@pytest.fixture(scope="module")
def plain() -> dict[str, str]:
    return derived(PENDULUM)


def derived(text: str) -> dict[str, str]:
    names = {**vars(vocabulary), **vars(helpers)}
    exec(text, names)
    system = names["system"]
    functions = printed_functions(generate_functions(system))
    return {**code_files(manifest_of(system, functions, {}), functions), "equations.json": equations_json(system)}


def edited(old: str, new: str) -> dict[str, str]:
    assert PENDULUM.count(old) == 1
    return derived(PENDULUM.replace(old, new))


@pytest.mark.parametrize("edit", EDITS)
def test_lines_that_change_beside_those_whose_meaning_changes(edit: str, measure: ModuleType, plain: Mapping[str, str]):
    changed, meaning = measure.lines(plain, edited(*EDITS[edit]))
    assert 0 < changed <= measure.GOAL * meaning


def test_the_benchmark_edits_text_that_the_models_have(measure: ModuleType):
    files = {edit: measure.ROOT / "models" / edit.model / edit.file for edit in measure.EDITS}
    assert [edit for edit, file in files.items() if edit.old not in file.read_text(encoding="utf-8")] == []


@pytest.mark.parametrize("edit", RENAMES)
def test_a_rename_touches_only_the_name(edit: str, plain: Mapping[str, str]):
    old, new = (word.strip('"') for word in RENAMES[edit])
    after = edited(*RENAMES[edit])
    assert after != plain
    assert {name: anonymous(name, text.replace(old, new)) for name, text in plain.items()} == {
        name: anonymous(name, text) for name, text in after.items()
    }


def anonymous(file: str, text: str) -> list[str]:
    """Return the lines; of equations.json, whose nodes are called and sorted by their content, without such names."""
    return sorted(re.sub(r'"[0-9a-f]{10}"', "", text).splitlines()) if file.endswith(".json") else text.splitlines()
