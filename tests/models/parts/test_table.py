# SPDX-License-Identifier: Apache-2.0
"""Parts whose numbers are in a table: the same parts, and wrong tables refused by file and field."""

import pytest

from mehvar.base.errors import MehvarError
from mehvar.models.parts import Hub, Mode, Modes, Wheel

from .table import craft_of

HUB = """
mass = { unit = "kg", default = 120.0, bounds = "(100, 150)", source = "paper: data sheet" }
inertia = { unit = "kg m^2", default = [12.0, 14.0, 10.0], source = "assumption: any" }
"""
PANEL = """
[[modes]]
frequency = { unit = "rad/s", default = 2.0, source = "paper: modal test" }
damping = { unit = "1", default = 0.01, source = "paper: modal test" }
linear = { unit = "kg^(1/2)", default = [0.0, 0.0, 1.0], source = "paper: modal test" }
angular = { unit = "kg^(1/2) m", default = [1.0, 0.2, 0.0], source = "paper: modal test" }
"""


def written(tmp_path, text):
    path = tmp_path / "part.toml"
    path.write_text(text, encoding="utf-8")
    return path


def parameters(*parts):
    return {q.name: q for q in craft_of(*parts).system().parameters}


def test_a_table_gives_the_same_part(tmp_path):
    hub = Hub.read("hub", written(tmp_path, HUB), centre=(0, 0, 0.1))
    panel = Modes.read("panel", written(tmp_path, PANEL))
    read = parameters(hub, panel)
    mode = Mode(frequency=2.0, damping=0.01, linear=(0, 0, 1.0), angular=(1.0, 0.2, 0))
    typed = parameters(Hub("hub", mass=120.0, inertia=(12.0, 14.0, 10.0), centre=(0, 0, 0.1)), Modes("panel", [mode]))
    assert {n: (q.default, q.unit) for n, q in read.items()} == {n: (q.default, q.unit) for n, q in typed.items()}
    assert read["hub_m"].source == "paper: data sheet"
    assert str(read["hub_m"].bounds) == "(100, 150)"


def test_a_direction_along_an_axis_stays_structure(tmp_path):
    text = """axis = { unit = "1", default = [0, 0, 2], source = "assumption: any" }
inertia = { unit = "kg m^2", default = 0.1, source = "assumption: any" }"""
    wheel = Wheel.read("wheel", written(tmp_path, text))
    assert [n for n in parameters(Hub("hub", mass=1.0, inertia=(1.0, 1.0, 1.0)), wheel) if "wheel" in n] == ["wheel_Js"]


@pytest.mark.parametrize(
    ("kind", "text", "words"),
    [
        (Hub, HUB.replace('"kg"', '"g"'), r"part.toml:2: mass: unit 'g' has 'g', which is not one of"),
        (Hub, HUB.replace('"kg"', '"m"'), r"part.toml:2: mass: unit = 'm': must be 'kg'"),
        (
            Hub,
            HUB.replace("inertia", "inertias"),
            r"part.toml:3: 'inertias' is not a field of Hub \(did you mean",
        ),
        (Hub, HUB.replace("source", "sources"), r"part.toml:2: mass: sources is not known \(did you mean 'source'"),
        (Hub, "mass = 3.0", r"part.toml:1: mass = 3.0: must be \{ unit = 'kg', default = ..., source = ... \}"),
        (Hub, 'mass = { unit = "kg", default = 3.0 }', "mass: source is missing"),
        (Hub, "mass = ", "part.toml:1: is not valid TOML"),
        (
            Hub,
            HUB.split("inertia", maxsplit=1)[0],
            "hub.inertia is missing: write it into .*part.toml or",
        ),
        (Modes, PANEL.replace("rad/s", "Hz"), "modes 1, frequency: unit = 'Hz': must be 'rad/s'"),
        (Modes, PANEL.replace("angular", "turning"), "modes 1: 'angular' is missing"),
        (Modes, PANEL.replace("[[modes]]", "[modes]"), r"modes: must be a list of tables, \[\[modes\]\]"),
    ],
)
def test_a_wrong_table_is_refused(kind, text, words, tmp_path):
    with pytest.raises(MehvarError, match=words):
        kind.read("hub", written(tmp_path, text))


def test_a_number_is_given_once(tmp_path):
    with pytest.raises(MehvarError, match=r"hub.mass is given twice: in .*part.toml and in the call"):
        Hub.read("hub", written(tmp_path, HUB), mass=3.0)
    with pytest.raises(MehvarError, match=r"cannot read .*absent.toml"):
        Hub.read("hub", tmp_path / "absent.toml")


@pytest.mark.parametrize(
    "default", ['[0, "1", 0]', "[0, true, 0]", "[0, nan, 0]", "[1, inf, 0]", "[0, 0, false]", "1" * 400]
)
def test_a_table_with_an_entry_that_is_not_a_finite_number_is_refused_by_line(default, tmp_path):
    text = f"""inertia = {{ unit = "kg m^2", default = 0.1, source = "assumption: any" }}
axis = {{ unit = "1", default = {default}, source = "assumption: any" }}"""
    with pytest.raises(MehvarError, match=r"part.toml:2: axis = .*: must be numbers in \(-inf, inf\), 1 \(axis\)"):
        Wheel.read("wheel", written(tmp_path, text))


def test_bounds_of_a_table_are_within_those_of_the_field(tmp_path):
    hub = Hub.read("hub", written(tmp_path, HUB.replace("(100, 150)", "(-1, 150)")))
    with pytest.raises(MehvarError, match=r"hub_m: bounds \(-1, 150\): must lie within \(0, inf\), kg \(mass\)"):
        parameters(hub)
