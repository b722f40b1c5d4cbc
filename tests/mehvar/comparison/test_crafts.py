# SPDX-License-Identifier: Apache-2.0
"""Two spacecraft that Python code has made: what changed is said part by part, then equation by equation."""

import re
import subprocess
from pathlib import Path

import pytest
from typer.testing import CliRunner

import mehvar
from mehvar.base.errors import MehvarError
from mehvar.cli.app import app
from mehvar.parts import Hinge, Hub, PointMass, Spacecraft, Torquer, Wheel


def craft_of(axis=(0, 1, 0), *more, mass=100.0):
    craft = Spacecraft("survey", motion="attitude")
    parts = (Hub("hub", mass=mass, inertia=(10.0, 12.0, 15.0)), Wheel("wheel1", axis=(1, 0, 0), inertia=0.1),
             Wheel("wheel2", axis=axis, inertia=0.1), *more)  # fmt: skip
    for part in parts:
        craft.add(part)
    return craft


def test_the_part_is_named():
    found = mehvar.diff(craft_of(), craft_of((0, 0, 1)))
    assert found.differs
    assert found.parts == ("wheel2: axis (0, 1, 0) -> (0, 0, 1)",)
    assert "wheel2: axis (0, 1, 0) -> (0, 0, 1)" in str(found)
    assert repr(found) == str(found)


def test_the_same_craft_is_the_same():
    found = mehvar.diff(craft_of(), craft_of())
    assert not found.differs
    assert not found.parts
    assert not found.notes


def test_a_mass_that_only_the_picture_shows_is_told_so():
    """Of a craft without translation the hub's mass sets the size of its box, and no rate."""
    found = mehvar.diff(craft_of(), craft_of(mass=120.0))
    assert found.status == "picture changed"
    assert found.parts == ("hub: mass 100.0 kg -> 120.0 kg",)
    assert "survey: physics the SAME, picture CHANGED" in str(found)
    assert "compensate" not in str(found)
    assert found.changed == ()
    assert {equation.kind for equation in found.comparison.pictured} == {"geometry"}


def test_a_craft_in_a_file_has_a_page(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = """from mehvar.parts import Hinge, Hub, Spacecraft, Value, Wheel


def craft():
    result = Spacecraft("survey", motion="attitude")
    result.add(Hub("hub", mass=Value(100.0, source="drawing (1)"), inertia=(10.0, 12.0, 15.0)))
    result.add(Wheel("wheel", axis=(0, 1, 0), inertia=0.1))
    result.add(Hinge("panel", mass=1.0, inertia=(1.0, 1.0, 1.0), axis=(0, 1, 0), stiffness=15.0))
    return result
"""
    before, after = Path("craft.py"), Path("newer.py")
    before.write_text(text, encoding="utf-8")
    me = ["-c", "user.name=me", "-c", "user.email=me@example.org"]
    for words in (["init", "-q"], ["add", "."], [*me, "commit", "-q", "-m", "first"]):
        subprocess.run(["git", *words], check=True)
    after.write_text(text.replace("(0, 1, 0), inertia", "(0, 0, 1), inertia").replace("15.0)", "20.0)"))
    done = CliRunner().invoke(app, ["diff", str(before), str(after), "--out", "page.html"])
    assert done.exit_code == 1, done.output
    page = Path("page.html").read_text(encoding="utf-8")
    assert len(page) < 100_000
    assert "wheel: axis (0, 1, 0) → (0, 0, 1)" in page
    assert "panel: stiffness 15.0 N m/rad → 20.0 N m/rad" in page
    assert page.count("data:image/png") == 1  # rates and eigenvalues
    assert '<td class="old" data-column="old">15.0</td>' in page
    sides = re.findall(r'<div class="side new">.*?</div>\n</div>', page, re.DOTALL)
    torque = next(side for side in sides if "torque" in side)
    (added,) = re.findall(r'class="term mark">(.*?)</span>', torque)
    assert "torque" in added
    after.rename(before)
    for versions in ([str(before)], ["HEAD:craft.py", str(before)]):
        told = CliRunner().invoke(app, ["diff", *versions])
        assert told.exit_code == 1
        assert "wheel: axis (0, 1, 0) -> (0, 0, 1)" in told.output
        assert "hub: mass" not in told.output
    for missing in ("none.py", "HEAD:none.py"):
        told = CliRunner().invoke(app, ["diff", missing])
        assert "is no Python file" in str(told.exception)
    before.write_text("x = 1 / 0\n", encoding="utf-8")
    assert "craft.py:1: ZeroDivisionError" in str(CliRunner().invoke(app, ["diff", str(before)]).exception)
    before.write_text("x = 1\n", encoding="utf-8")
    assert "no function system() or craft()" in str(CliRunner().invoke(app, ["diff", str(before)]).exception)


def test_eigenvalues_are_those_at_a_possible_state():
    """At zero the craft has no attitude; its panel swings at sqrt(k/I (1 + I/J)) about the hub."""

    def with_panel(stiffness):
        panel = Hinge("panel", mass=1e-6, inertia=(1.0, 1.0, 1.0), axis=(0, 1, 0), stiffness=stiffness)
        return craft_of((0, 1, 0), panel)

    found = str(mehvar.diff(with_panel(1.0), with_panel(4.0)))
    assert "eigenvalues at q0 = 1, the rest 0" in found
    hub = 12.0 - 0.1  # the wheel along the axis is free
    slow = (1 + 1 / hub) ** 0.5
    assert f"± {slow:.4g}i -> ± {2 * slow:.4g}i" in found


def test_parts_that_come_and_go():
    older, newer = craft_of(), craft_of((0, 1, 0), Torquer("turn"))
    assert older.changes(newer) == ("turn: added, a Torquer",)
    assert newer.changes(older) == ("turn: removed",)
    assert craft_of((0, 1, 0), PointMass("turn", mass=1.0)).changes(newer) == ("turn: a PointMass -> a Torquer",)
    assert Spacecraft("a").changes(Spacecraft("b", attitude="mrp")) == ("attitude: quaternion -> mrp",)


def test_wrong_arguments_are_refused():
    with pytest.raises(MehvarError, match="leave new and structures out"):
        mehvar.diff(craft_of(), craft_of(), "work~1")
    with pytest.raises(MehvarError, match=r"model = .*must be a text"):
        mehvar.diff(craft_of(), "HEAD")
    with pytest.raises(MehvarError, match="must be a System, a Spacecraft, or a function"):
        mehvar.diff(1, 2)
