# SPDX-License-Identifier: Apache-2.0
"""Strict tables: everything that is not understood is refused with the place and a suggestion."""

import contextlib
import dataclasses
import re
from pathlib import Path

import pytest

from mehvar.base.intervals import Interval
from mehvar.codegen.generate import installed_tree
from mehvar.codegen.new_numbers import shapes
from mehvar.models.check import check_tables
from mehvar.models.system import ModelError
from mehvar.models.tables import read_parameters, read_scenarios
from tests.models.edits import cart

GOOD = """
[plant]
mass = { unit = "kg", default = 2, bounds = "(0, inf)", source = "paper Table 1", description = "a mass" }
[sliding]
eta = { unit = "1/s", default = "mass/2", bounds = "[0, 5]", source = "assumption: half", description = "a rate" }
"""
SCENARIO = """
[scenarios.paper]
title = "a run"
duration = 35.0
step = 0.01
[metrics.top]
kind = "max"
of = ["rho"]
unit = "1"
description = "largest"
"""


def write(tmp_path, text, name="parameters.toml"):
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    return path


def test_a_good_table_is_read_in_order(tmp_path):
    groups = read_parameters(write(tmp_path, GOOD))
    assert list(groups) == ["plant", "sliding"]
    (mass,) = groups["plant"]
    assert (mass.name, mass.unit, mass.default, str(mass.bounds)) == ("mass", "kg", 2.0, "(0, inf)")
    assert mass.symbol.is_positive
    assert groups["sliding"].quantities[0].default == "mass/2"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (('unit = "kg", ', ""), r"plant.mass.unit is missing"),
        (('unit = "kg"', 'unit = "kg*m"'), "unit 'kg\\*m' is not written like"),
        (("default = 2", "default = -2"), r"default = -2 is outside its bounds \(0, inf\)"),
        (("default = 2", "default = nan"), "is outside its bounds"),
        (("default = 2", "defalt = 2"), r"plant.mass.defalt is not known \(did you mean 'default'\?\)"),
        *(
            (("default = 2", f"default = {value}"), "must be a number, a formula or a list of numbers")
            for value in ("true", "1979-05-27", "[true]", "{ a = 1 }", "1" * 400, f"[{'1' * 400}]")
        ),
        *(
            (("default = 2", f"default = {value}"), "must be numbers, or rows of numbers of equal length")
            for value in ("[1.0, [2.0]]", "[[1.0], 2.0]", "[[1.0], [2.0, 3.0]]")
        ),
        (('bounds = "(0, inf)"', 'bounds = "0..1"'), "bounds '0..1' must be an interval"),
        (('bounds = "(0, inf)"', 'bounds = "(1, 0)"'), "are an empty interval"),
        (('bounds = "(0, inf)"', 'bounds = "(0, 1_0)"'), "bounds '\\(0, 1_0\\)' must be an interval"),
        (("[plant]", "[plant"), "is not valid TOML: Expected"),
        (('bounds = "[0, 5]"', 'bounds = "[0, 5'), r"parameters.toml:5: is not valid TOML"),
        (("[sliding]", "[plant]"), r"parameters.toml:4: is not valid TOML: Cannot declare"),
        (("[sliding]", "mass = 1\n[sliding]"), r"parameters.toml:4: is not valid TOML: Cannot overwrite"),
        (("default = 2", "default = 2, default = 3"), r"parameters.toml:3: is not valid TOML: Duplicate"),
        (("[plant]", "gain = 3\n[plant]"), "'gain' is outside of a group"),
    ],
)
def test_a_bad_table_is_refused(tmp_path, change, message):
    with pytest.raises(ModelError, match=message) as refusal:
        read_parameters(write(tmp_path, GOOD.replace(*change)))
    assert re.match(rf"{tmp_path}/parameters.toml:[2345]: ", str(refusal.value))


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(ModelError, match=r"cannot read .*nowhere.toml: No such file"):
        read_parameters(tmp_path / "nowhere.toml")


def test_bytes_that_are_not_text_are_refused(tmp_path):
    path = tmp_path / "parameters.toml"
    path.write_bytes(b"[plant]\n\xff\xfe\x00")
    with pytest.raises(ModelError, match=r"parameters.toml:2: is not UTF-8 text"):
        read_parameters(path)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("duration = 35.0", "duration = -1.0"), "duration"),
        (
            ("duration = 35.0", "durations = 35.0"),
            r"scenarios.paper.durations is not known \(did you mean 'duration'\?\)",
        ),
        (('kind = "max"', 'kind = "maximum"'), "kind"),
        (("step = 0.01", ""), "scenarios.paper.step is missing"),
    ],
)
def test_a_bad_scenario_is_refused(tmp_path, change, message):
    with pytest.raises(ModelError, match=message) as refusal:
        read_scenarios(write(tmp_path, SCENARIO.replace(*change), "scenarios.toml"))
    assert re.match(rf"{tmp_path}/scenarios.toml:[2-9]: ", str(refusal.value))


TABLES = sorted((installed_tree().root / "models").glob("*/*.toml"))


@pytest.mark.parametrize("table", TABLES, ids=lambda path: f"{path.parent.name}-{path.stem}")
@pytest.mark.share(3)
def test_whatever_line_of_a_table_is_damaged_it_is_named(table, tmp_path):
    """A key that is not known in each line that holds an entry of its own, or that begins a table of entries."""
    lines = table.read_text(encoding="utf-8").splitlines()
    read = read_parameters if table.name == "parameters.toml" else read_scenarios
    rows = [k for k, line in enumerate(lines) if re.search(r"\{ unit|\{ kind", line)]
    assert len(rows) > 5
    for k in rows:
        damaged = [*lines[:k], lines[k].replace("{ ", "{ nonsense = 1, ", 1), *lines[k + 1 :]]
        with pytest.raises(ModelError, match=rf"{table.name}:{k + 1}: [\w.-]*nonsense is not known; known: "):
            read(write(tmp_path, "\n".join(damaged), table.name))


VALUES = (
    "true",
    "[1]",
    "{}",
    "1979-05-27",
    "07:32:00",
    "-1",
    "1e400",
    "nan",
    '"x"',
    "9" * 30,
    "[[1]]",
    '""',
    '"\\u0000"',
)


@pytest.mark.parametrize("value", VALUES)
@pytest.mark.parametrize(("name", "text"), [("parameters.toml", GOOD), ("scenarios.toml", SCENARIO)])
def test_whatever_value_stands_in_a_table_is_read_or_refused(name, text, value, tmp_path):
    """By its reader, and by what asks whether numbers alone have changed, which reads it first."""
    read = read_parameters if name == "parameters.toml" else read_scenarios
    for entry in re.finditer(r'(?<== )(?:\d[\d.]*|"[^"]*"|\["rho"\])', text):
        write(tmp_path, text[: entry.start()] + value + text[entry.end() :], name)
        assert list(shapes(tmp_path)) == [name]
        with contextlib.suppress(ModelError):
            read(tmp_path / name)


def test_intervals_say_what_they_hold():
    assert 0 not in Interval.parse("(0, 1]")
    assert 1 in Interval.parse("(0, 1]")
    assert Interval.parse("(0, inf)").positive
    assert not Interval.parse("[0, inf)").positive
    assert float("nan") not in Interval.parse("(-inf, inf)")


def test_a_table_saved_on_windows_is_read(tmp_path):
    """With a byte order mark and its line ends."""
    path = tmp_path / "parameters.toml"
    path.write_bytes(b"\xef\xbb\xbf" + GOOD.replace("\n", "\r\n").encode())
    assert list(read_parameters(path)) == ["plant", "sliding"]


CHOICES = {"spring": ("one", "two")}
"""As a model's STRUCTURE: "one" is the default."""
ROW = '= { unit = "kg", default = 2, bounds = "(0, inf)", source = "paper Table 1", description = "a mass" }'


@pytest.mark.parametrize(
    ("group", "structure", "refused"),
    [
        ("plant", {}, True),
        ("nobody", {}, True),
        ("plant", {"spring": "one"}, True),
        ("nobody", {"spring": "one"}, True),
        ("spring_one", {"spring": "one"}, True),
        ("spring_two", {"spring": "one"}, False),
        ("spring_three", {"spring": "one"}, True),
        ("plant", {"spring": "two"}, False),
        ("spring_one", {"spring": "two"}, False),
        ("spring_two", {"spring": "two"}, True),
    ],
)
def test_a_parameter_that_no_structure_reads_is_refused_in_one_of_them(tmp_path, group, structure, refused):
    write(tmp_path, f"[{group}]\nmass {ROW}\nmas {ROW}\n")
    system = dataclasses.replace(cart(), structure=structure)
    choices = CHOICES if structure else {}
    if not refused:
        check_tables(system, tmp_path, choices)
        return
    with pytest.raises(ModelError, match=rf"toml:3: \[{group}.mas\] would be ignored: .*'mas' \(did you mean 'mass'"):
        check_tables(system, tmp_path, choices)


@pytest.mark.parametrize(
    ("text", "name"), [(SCENARIO.replace("paper", "plain"), "metrics.top"), (SCENARIO, "scenarios.paper")]
)
def test_a_scenario_or_metric_that_the_system_has_not_is_refused(tmp_path, text, name):
    write(tmp_path, text, "scenarios.toml")
    with pytest.raises(ModelError, match=rf"\[{name}\] would be ignored: it is not in the system"):
        check_tables(cart(), tmp_path, {})


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("duration = 35.0", "duration = inf", r":3: scenario 'paper': duration = inf: must be finite and above zero"),
        ("band = 0.01", "band = -1.0", r":73: metric 'T_theta': band = -1: must be above zero"),
        ("band = 0.01", "band = nan", r":73: metric 'T_theta': band = nan: must be above zero"),
        ("band = 0.001", "band = inf", r":79: metric 'flips': band = inf: must be zero or above"),
        ("band = 0.01", "band = 0.01, since = 2.0, until = 1.0", r":73: metric 'T_theta': since = 2 and until = 1"),
    ],
)
def test_numbers_of_scenarios_and_metrics_are_refused_where_they_are_read(tmp_path, old, new, message):
    """Also those that change without a derivation: a band of -1 went into the manifest, one of nan broke it."""
    text = (Path(__file__).parents[2] / "models" / "triangle" / "scenarios.toml").read_text(encoding="utf-8")
    path = tmp_path / "scenarios.toml"
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(ModelError, match=rf"scenarios\.toml{message}"):
        read_scenarios(path)
