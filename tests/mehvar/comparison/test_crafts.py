# SPDX-License-Identifier: Apache-2.0
"""Two spacecraft that Python code has made: what changed is said part by part, then equation by equation."""

import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import sympy as sp

import mehvar
from mehvar import Controller, Group, Parameter, Quantity, System
from mehvar.base.errors import MehvarError
from mehvar.base.manifest import Scenario
from mehvar.base.parts import exchanged_parts
from mehvar.comparison.runs import _Trial
from mehvar.comparison.sides import Side
from mehvar.parts import Gyro, Hinge, Hub, Orbit, PointMass, Spacecraft, Tachometer, Torquer, Wheel
from tests.mehvar.comparison.projects import Project


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


def test_parts_that_exchanged_their_names_are_others_if_a_law_still_means_the_former_ones():
    def craft(names):
        result = Spacecraft("survey", motion="attitude")
        result.add(Hub("hub", mass=100.0, inertia=(10.0, 12.0, 15.0)))
        for name, axis, inertia in zip(names, ((1, 0, 0), (0, 1, 0)), (0.1, 0.2), strict=True):
            result.add(Wheel(name, axis=axis, inertia=inertia))

        def damp(law):
            kd = law.parameter("kd", 1.0, "N m s")
            return {name: kd * rate for name, rate in zip(("wheel1", "wheel2"), law.rates, strict=False)}

        result.law("damp", damp)
        return result

    found = mehvar.diff(craft(("wheel1", "wheel2")), craft(("wheel2", "wheel1")))
    assert found.status == "changed"
    assert found.parts != ("wheel1: renamed to wheel2", "wheel2: renamed to wheel1")


WHEELS = {"a": {"": "Wheel", "axis": "x"}, "b": {"": "Wheel", "axis": "y"}}


@pytest.mark.parametrize(
    ("wheels", "sensors"), [("ba", "st"), ("ab", "ts"), ("ba", "ts"), ("ba", "su"), ("bc", "tu"), ("ca", "su")]
)
def test_names_of_parts_that_name_others_are_told_after_those(wheels, sensors):
    """A sensor names its wheel, whose new name was a change of the sensor."""

    def parts(wheels, sensors):
        of = {s: {"": "Tachometer", "of": f"'{w}'", "sigma": "1"} for w, s in zip(wheels, sensors, strict=True)}
        return dict(zip(wheels, WHEELS.values(), strict=True)) | of

    names = {old: new for old, new in zip("abst", wheels + sensors, strict=True) if old != new}
    assert exchanged_parts(parts("ab", "st"), parts(wheels, sensors)) == names


def test_a_number_that_becomes_that_of_another_part_is_no_exchange():
    masses = [{name: {"": "PointMass", "at": "0", "m": m} for name, m in zip("ab", given, strict=True)}
              for given in ("12", "23")]  # fmt: skip
    assert exchanged_parts(*masses) == {}


@pytest.fixture(scope="module")
def heavier():
    return mehvar.diff(craft_of(), craft_of(mass=120.0))


def test_a_mass_that_only_the_picture_shows_is_told_so(heavier):
    """Of a craft without translation the hub's mass sets the size of its box, and no rate."""
    found = heavier
    assert found.status == "picture changed"
    assert found.parts == ("hub: mass 100 kg -> 120 kg",)
    assert "survey: physics the SAME, picture CHANGED" in str(found)
    assert "compensate" not in str(found)
    assert found.changed == ()
    assert {equation.kind for equation in found.comparison.pictured} == {"geometry"}


@pytest.fixture
def repository(tmp_path) -> Project:
    """An empty git repository."""
    project = Project(tmp_path)
    project.git("init", "--quiet")
    return project


def test_a_craft_in_a_file_has_a_page(repository):
    text = """from mehvar.parts import Hinge, Hub, Spacecraft, Value, Wheel


def craft():
    result = Spacecraft("survey", motion="attitude")
    result.add(Hub("hub", mass=Value(100.0, source="drawing (1)"), inertia=(10.0, 12.0, 15.0)))
    result.add(Wheel("wheel", axis=(0, 1, 0), inertia=0.1))
    result.add(Hinge("panel", mass=1.0, inertia=(1.0, 1.0, 1.0), axis=(0, 1, 0), stiffness=15.0))
    return result
"""
    before, after = repository.root / "craft.py", repository.root / "newer.py"
    before.write_text(text, encoding="utf-8")
    repository.commit("first")
    after.write_text(text.replace("(0, 1, 0), inertia", "(0, 0, 1), inertia").replace("15.0)", "20.0)"))
    status, output = repository.diff("craft.py", "newer.py", "--out", "page.html")
    assert status == 1, output
    page = (repository.root / "page.html").read_text(encoding="utf-8")
    assert len(page) < 100_000
    assert "wheel: axis (0, 1, 0) → (0, 0, 1)" in page
    assert "panel: stiffness 15 N m/rad → 20 N m/rad" in page
    assert page.count("data:image/png") == 1  # rates and eigenvalues
    assert '<td class="old" data-column="old">15.0</td>' in page
    sides = re.findall(r'<div class="side new">.*?</div>\n</div>', page, re.DOTALL)
    torque = next(side for side in sides if "torque" in side)
    (added,) = re.findall(r'class="term mark">(.*?)</span>', torque)
    assert "torque" in added
    after.rename(before)
    for versions in (["craft.py"], ["HEAD:craft.py", "craft.py"]):
        status, output = repository.diff(*versions)
        assert status == 1
        assert "wheel: axis (0, 1, 0) -> (0, 0, 1)" in output
        assert "hub: mass" not in output
    for missing in ("none.py", "HEAD:none.py"):
        assert "is no Python file" in repository.refused(missing)
    before.write_text("x = 1 / 0\n", encoding="utf-8")
    assert "craft.py:1: ZeroDivisionError" in repository.refused("craft.py")
    before.write_text("x = 1\n", encoding="utf-8")
    assert "no function system() or craft()" in repository.refused("craft.py")


def test_a_file_of_a_revision_reads_tables_and_modules_of_that_revision(repository, monkeypatch):
    """Both versions read the table and the module of the working folder, and so were the same."""
    text = """from mehvar.parts import Hub, PointMass, Spacecraft
import spare


def craft():
    result = Spacecraft("survey", motion="attitude")
    result.add(Hub.read("hub", "hub.toml"))
    result.add(PointMass("spare", mass=spare.MASS, at=(1, 0, 0)))
    return result
"""
    table = 'mass = { unit = "kg", default = 4.0, source = "assumption" }\n'
    table += 'inertia = { unit = "kg m^2", default = [1.0, 1.0, 1.0], source = "assumption" }\n'
    root = repository.root
    craft, hub, spare = root / "craft.py", root / "hub.toml", root / "spare.py"
    for path, content in ((craft, text), (hub, table), (spare, "MASS = 2.0\n")):
        path.write_text(content, encoding="utf-8")
    repository.commit("first")
    hub.write_text(table.replace("1.0]", "1.5]"), encoding="utf-8")
    spare.write_text("MASS = 3.0\n", encoding="utf-8")
    status, output = repository.diff("HEAD:craft.py", "craft.py")
    assert status == 1, output
    assert "hub: inertia (1, 1, 1) kg m^2 -> (1, 1, 1.5) kg m^2" in output
    assert "spare: mass 2 kg -> 3 kg" in output
    below = Project(root / "sub")
    below.root.mkdir()
    for path in ("craft.py", "../craft.py"):  # as git has it, and from this folder
        assert "hub.toml" in below.refused(f"HEAD:{path}", "../craft.py")  # a path from the folder, which has none
    assert f"HEAD has it neither in {below.root} nor in {root}" in below.refused("HEAD:none.py", "../craft.py")

    def refuse(text: str, read: Path) -> None:
        craft.write_text(text, encoding="utf-8")
        repository.commit("with a file of today")
        message = repository.refused("HEAD:craft.py", "craft.py")
        assert f"reads {read}, which is the file of today" in message

    refuse(text.replace('"hub.toml"', repr(str(hub))), hub)
    outside, linked, base = root.parent / f"{root.name}.toml", root / "linked.toml", root / "gains.db"
    outside.write_text(table, encoding="utf-8")
    linked.symlink_to(outside)
    refuse(text.replace('"hub.toml"', repr(str(linked))), linked)
    base.touch()
    refuse(f"import sqlite3\nsqlite3.connect({str(base)!r}).close()\n{text}", base)
    (root / "src").mkdir()
    spare.rename(root / "src" / "spare.py")
    monkeypatch.setenv("PYTHONPATH", str(root / "src"))
    refuse(text, root / "src" / "spare.py")


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


def test_eigenvalues_name_the_point_of_each_version():
    """A pendulum that starts elsewhere: s^2 + d s + cos(angle) = 0 at the start of each version."""

    def started(angle):
        x, u = (Quantity("angle", "rad", ""), Quantity("rate", "rad/s", "")), Quantity("u", "rad/s^2", "")
        p, s = Parameter("k", "1/s^2", "", default=1.0), Parameter("start", "rad", "", default=angle)
        d = Parameter("d", "1/s", "", default=0.5)
        return System(
            name="pendulum",
            states=Group("x", x),
            inputs=Group("u", (u,)),
            parameters=Group("p", (p,)),
            scenario_parameters=Group("s", (s,)),
            rhs=(x[1].symbol, u.symbol - p.symbol * sp.sin(x[0].symbol)),
            initial=(s.symbol, 0),
            controllers=(Controller("damp", "", Group("c", (d,)), (-d.symbol * x[1].symbol,)),),
        )

    found = str(mehvar.diff(started(0.1), started(1.2)))
    old, new = ((np.cos(angle) - 0.25**2) ** 0.5 for angle in (0.1, 1.2))
    assert "eigenvalues under damp at angle = 0.1, the rest 0 -> angle = 1.2, the rest 0\n" in found
    assert f"-0.25 ± {old:.4g}i -> -0.25 ± {new:.4g}i" in found


def test_parts_that_come_and_go():
    older, newer = craft_of(), craft_of((0, 1, 0), Torquer("turn"))
    assert older.changes(newer) == ("turn: added, a Torquer",)
    assert newer.changes(older) == ("turn: removed",)
    assert craft_of((0, 1, 0), PointMass("turn", mass=1.0)).changes(newer) == ("turn: a PointMass -> a Torquer",)
    assert Spacecraft("a").changes(Spacecraft("b", attitude="mrp")) == ("attitude: quaternion -> mrp",)
    first, later = (Spacecraft("a", orbit=Orbit(epoch=epoch)) for epoch in ("2026-11-28 12:00", 849225600.0))
    assert first.changes(later) == ("orbit: epoch 2026-11-28 12:00:00 -> 2026-11-29 12:00:00",)


def test_wrong_arguments_are_refused():
    with pytest.raises(MehvarError, match="leave new and structures out"):
        mehvar.diff(craft_of(), craft_of(), "work~1")
    with pytest.raises(MehvarError, match=r"model = .*must be a text"):
        mehvar.diff(craft_of(), "HEAD")
    with pytest.raises(MehvarError, match="must be a System, a Spacecraft, or a function"):
        mehvar.diff(1, 2)


AXES = {"wheel1": (1, 0, 0), "wheel2": (0, 1, 0), "wheel3": (0, 0, 1)}


def three(names=None, order=(0, 1, 2, 3, 4), law="pd", panel="panel", start=0.1, more=(), scenario="turn", gain=0.4):
    """Return a craft with three wheels, a panel if it has a name, a law and a start."""
    craft = Spacecraft("survey", motion="attitude", period=0.1)
    wheels = [Wheel((names or {}).get(n, n), axis=a, inertia=0.1, torque_limit=0.5) for n, a in AXES.items()]
    flap = Hinge(panel, mass=8.0, inertia=(1.0, 0.2, 1.0), axis=(0, 1, 0), centre=(0, 0.9, 0), stiffness=15.0)
    parts = [Hub((names or {}).get("hub", "hub"), mass=100.0, inertia=(10.0, 12.0, 15.0)), *wheels, flap]
    for part in (*(parts[k] for k in order if parts[k].name), *more):
        craft.add(part)

    def feedback(text):
        kp, kd = text.parameter("kp", gain, "N m"), text.parameter("kd", 1.2, "N m s")
        (_, *q), w = text.attitude, text.rates
        return text.torque([-kp * a - kd * b for a, b in zip(q, w, strict=True)], wheels)

    craft.law(law, feedback, "feedback")
    moves = Scenario(scenario, "a turn", 5.0, 0.1, values={"roll_0": start, "yaw_0": start})
    return craft.system(scenarios=(moves,))


EDITS = {
    "wheel": {"names": {"wheel1": "w1"}},
    "hub": {"names": {"hub": "body"}},
    "scenario": {"scenario": "slew"},
    "law": {"law": "pid"},
    "order": {"order": (0, 4, 3, 1, 2)},
    "third": {"names": {"wheel1": "wheel2", "wheel2": "wheel1", "wheel3": "w3"}},
    "with hub": {"names": {"hub": "wheel1", "wheel1": "wheel2", "wheel2": "x", "wheel3": "hub"}, "scenario": "slew"},
    "all": {"names": {"wheel1": "a", "wheel2": "x", "wheel3": "wx"}, "panel": "m"},
    "chain": {"names": {"wheel1": "wheel2", "wheel2": "wheel3", "wheel3": "w4"}, "law": "pid", "scenario": "slew"},
    "exchanged": {
        "names": {"wheel1": "wheel3", "wheel3": "wheel2", "wheel2": "wheel1"}, "order": (4, 2, 0, 3, 1), "panel": "m",
    },
}  # fmt: skip
QUICK = ("all", "chain", "exchanged")


@pytest.mark.parametrize("name", [pytest.param(n, marks=() if n in QUICK else pytest.mark.soak) for n in EDITS])
def test_new_names_and_another_order_change_no_physics(name):
    """Exchanged names were recognised alone, and new ones alone; together they were CHANGED."""
    edit = EDITS[name]
    found = mehvar.diff(three(), three(**edit))
    text = str(found)
    assert found.status == "names changed", text
    assert {e.verdict.value for e in found.comparison} <= {"same", "rearranged", "renamed"}, text
    names = edit.get("names", {}) | ({"panel": edit["panel"]} if "panel" in edit else {})
    assert {line for line in found.parts if ": renamed" in line} == {f"{a}: renamed to {b}" for a, b in names.items()}
    law, scenario = edit.get("law", "pd"), edit.get("scenario", "turn")
    assert ("law  pid  renamed  pd -> pid" in text) == ("laws: pd -> pid" in text) == (law == "pid")
    assert ("scenario  slew  renamed  turn -> slew" in text) == (scenario == "slew")
    arrays = "arrays: hub, wheel1, wheel2, wheel3, panel -> hub, panel, wheel3, wheel1, wheel2"
    assert (arrays in text) == (name == "order")
    assert "survey: physics the SAME, names or order CHANGED" in text
    assert re.search(rf"all metrics equal in 1 run, largest relative difference \S+: {scenario} under {law}\n", text)
    assert "rates equal at 512 random states" in text
    assert "{" not in text  # as in templates of messages
    assert "order:" not in text.replace("order of parts", "")


def test_a_renamed_part_that_was_edited_too_is_told_as_both():
    found = mehvar.diff(three(), three(names={"wheel2": "w2"}, panel="flap", start=0.2))
    assert found.status == "parameters changed"
    assert [change.name for change in found.parameters if change.what == "value"] == ["roll_0", "yaw_0"]
    before, after = craft_of(), craft_of((0, 1, 0), mass=110.0)
    after.parts[1] = Wheel("w1", axis=(1, 0, 0), inertia=0.3)
    found = mehvar.diff(before, after)
    assert found.parts == (
        "wheel1: renamed to w1",
        "hub: mass 100 kg -> 110 kg",
        "w1: inertia 0.1 kg m^2 -> 0.3 kg m^2",
    )
    assert found.status == "parameters changed", str(found)
    assert before.changes(after) == found.parts


def test_another_part_of_the_same_class_is_no_new_name():
    before, after = (craft_of((0, 1, 0), PointMass(name, mass=m, at=at)) for name, m, at in OTHERS)
    assert before.changes(after) == ("ballast: removed", "camera: added, a PointMass")


OTHERS = (("ballast", 1.0, (1, 0, 0)), ("camera", 2.0, (0, 0, 1)))


def test_equal_numbers_of_other_types_are_no_change():
    numbers = PointMass("m", mass=np.float64(2), at=np.array([0.1, 0, 0]))
    before, after = craft_of((0.0, 1, np.int64(0)), numbers), craft_of((0, 1, 0), PointMass("m", 2.0, at=(0.1, 0, 0)))
    assert before.changes(after) == ()
    heavy = craft_of((0, 1, 0), PointMass("m", mass=np.float32(2.5), at=np.array([0.1, 0, 0.25])))
    assert before.changes(heavy) == ("m: mass 2 kg -> 2.5 kg", "m: at (0.1, 0, 0) m -> (0.1, 0, 0.25) m")
    tested = [craft_of((0, 1, 0), Tachometer("tacho", of=Wheel("fine", (1, 0, 0), inertia=j))) for j in (0.1, 0.2)]
    assert tested[0].changes(tested[1]) == ()


def test_rounding_of_a_state_is_no_metric():
    state, options = Quantity("w", "rad/s", "a rate"), {"atol": 1e-11}
    for noise in (2e-12, 0.0):
        manifest = SimpleNamespace(states=(state,))
        x, law = np.array([[noise], [-noise]]), SimpleNamespace(memory=())
        run = SimpleNamespace(manifest=manifest, x=x, z=x[:, :0], controller=law, options=options)
        renamed = Side(SimpleNamespace(), {"w": "v"})
        assert _Trial(renamed, run).extremes() == {
            "largest |v|": (0.0, "rad/s"),
            "last v": (0.0, "rad/s"),
        }


def seen(noise=1e-4, turned=False):
    """A craft whose state nothing moves, with two gyros."""
    gyros = [Gyro("gyro", noise=noise), Gyro("spare", noise=2e-4)]
    return craft_of((0, 1, 0), *(reversed(gyros) if turned else gyros))


def test_measurements_are_compared_where_no_state_moves():
    """Twice the noise of a gyro showed nothing, since no state moved."""
    text = str(mehvar.diff(seen(), seen(noise=2e-4)))
    (largest,) = re.findall(r"largest \|gyro_x_shown\|.*  (.*) %", text)
    assert float(largest) == pytest.approx(100)
    assert "spare_x_shown" not in text
    assert "shows nothing" not in text


def test_other_random_numbers_are_said():
    """Sensors in another order draw other random numbers; runs changed without a reason."""
    text = str(mehvar.diff(seen(), seen(turned=True)))
    assert "physics the SAME, names or order CHANGED" in text
    assert "the order of noise changed, so that runs have other random numbers: gyro_e1" in text


def test_that_no_run_is_compared_is_said(heavier):
    text = str(heavier)
    assert "no run compared: the versions have no law and scenario in common" in text


def test_states_of_one_side_are_named():
    more = Hinge("flap", mass=1.0, inertia=(1.0, 1.0, 1.0), axis=(1, 0, 0))
    before, after = (three(panel="", more=parts) for parts in ((), (more, Wheel("spare", (1, 0, 0), inertia=0.1))))
    text = str(mehvar.diff(before, after))
    why = "only the new version has the states flap_angle, flap_rate, spare_speed; only the new version has the input"
    assert f"runs not compared: {why} spare_torque" in text
    assert text.count("is the inertia of no body") == 1
    assert "constraint: flap.inertia, with flap_Jxx, flap_Jyy, flap_Jzz, is the inertia of no body" in text


def test_a_loop_that_became_unstable_at_rest_is_said_to_be_so():
    """Its margins were "not defined", and no state of a craft at rest moved."""
    text = str(mehvar.diff(*(three(panel="", start=0.0, gain=gain) for gain in (0.4, -0.4))))
    assert re.search(r"gain margin \S+ \(factor\), phase margin \S+ deg -> the loop is unstable", text)
    assert "the loop became unstable; eigenvalues under pd at" in text
    assert "no state moves, so that the run shows nothing: turn under pd" in text
    assert "metrics equal" not in text
