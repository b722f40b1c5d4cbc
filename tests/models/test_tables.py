# SPDX-License-Identifier: Apache-2.0
"""Strict tables: everything that is not understood is refused with the place and a suggestion."""

import re

import pytest

from mehvar.codegen.generate import installed_tree
from mehvar.models.system import ModelError
from mehvar.models.tables import parse_interval, read_parameters, read_scenarios

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
        (('unit = "kg", ', ""), r"\[plant.mass\]: 'unit' is missing"),
        (('unit = "kg"', 'unit = "kg*m"'), "unit 'kg\\*m' is not written like"),
        (("default = 2", "default = -2"), r"default = -2 is outside its bounds \(0, inf\)"),
        (("default = 2", "default = nan"), "is outside its bounds"),
        (("default = 2", "defalt = 2"), r"unknown key 'defalt' \(did you mean 'default'\?\)"),
        (("default = 2", "default = true"), "default"),
        (('bounds = "(0, inf)"', 'bounds = "0..1"'), "bounds '0..1' are not an interval"),
        (('bounds = "(0, inf)"', 'bounds = "(1, 0)"'), "are empty"),
        (('source = "paper Table 1"', 'source = "somewhere"'), "source 'somewhere' must begin with"),
        (("[plant]", "[plant"), "is not valid TOML: Expected"),
        (('bounds = "[0, 5]"', 'bounds = "[0, 5'), r"parameters.toml:5: is not valid TOML"),
        (("[sliding]", "[plant]"), r"parameters.toml:4: is not valid TOML: Cannot declare"),
        (("[sliding]", "mass = 1\n[sliding]"), r"parameters.toml:4: is not valid TOML: Cannot overwrite"),
        (("default = 2", "default = 2, default = 3"), r"parameters.toml:3: is not valid TOML: Duplicate"),
        (("[plant]", "gain = 3\n[plant]"), "'gain' stands outside a group"),
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
            r"unknown key 'scenarios.paper.durations' \(did you mean 'duration'\?\)",
        ),
        (('kind = "max"', 'kind = "maximum"'), "kind"),
        (("step = 0.01", ""), "'scenarios.paper.step' is missing"),
    ],
)
def test_a_bad_scenario_is_refused(tmp_path, change, message):
    with pytest.raises(ModelError, match=message) as refusal:
        read_scenarios(write(tmp_path, SCENARIO.replace(*change), "scenarios.toml"))
    assert re.match(rf"{tmp_path}/scenarios.toml:[2-9]: ", str(refusal.value))


TABLES = sorted((installed_tree().root / "models").glob("*/*.toml"))


@pytest.mark.parametrize("table", TABLES, ids=lambda path: f"{path.parent.name}-{path.stem}")
def test_whatever_line_of_a_table_is_damaged_it_is_named(table, tmp_path):
    """A key that is not known in each line that holds an entry of its own, or that begins a table of entries."""
    lines = table.read_text(encoding="utf-8").splitlines()
    read = read_parameters if table.name == "parameters.toml" else read_scenarios
    rows = [k for k, line in enumerate(lines) if re.search(r"\{ unit|\{ kind", line)]
    assert len(rows) > 5
    for k in rows:
        damaged = [*lines[:k], lines[k].replace("{ ", "{ nonsense = 1, ", 1), *lines[k + 1 :]]
        with pytest.raises(ModelError, match=rf"{table.name}:{k + 1}: .*unknown key '[\w.]*nonsense'"):
            read(write(tmp_path, "\n".join(damaged), table.name))


def test_intervals_say_what_they_hold():
    assert 0 not in parse_interval("(0, 1]")
    assert 1 in parse_interval("(0, 1]")
    assert parse_interval("(0, inf)").positive
    assert not parse_interval("[0, inf)").positive
    assert float("nan") not in parse_interval("(-inf, inf)")


def test_a_table_saved_on_windows_is_read(tmp_path):
    """With a byte order mark and its line ends."""
    path = tmp_path / "parameters.toml"
    path.write_bytes(b"\xef\xbb\xbf" + GOOD.replace("\n", "\r\n").encode())
    assert list(read_parameters(path)) == ["plant", "sliding"]
