# SPDX-License-Identifier: Apache-2.0
"""NAME=VALUE with units: pint's rules, in the unit of the name; whatever is typed ends in a number or a refusal."""

from __future__ import annotations

import contextlib
import math

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from mehvar.base.errors import InputError
from mehvar.runtime.model.catalogue import find_model, list_models
from mehvar.runtime.units import distribution, read_value, setting_units
from mehvar.settings import read_values


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("30deg", "rad", math.pi / 6),
        ("30 °", "rad", math.pi / 6),
        ("5ms", "s", 0.005),
        ("1e-3 km", "m", 1.0),
        ("-2.5 N m", "kg m^2/s^2", -2.5),
        ("3 rpm", "rad/s", math.pi / 10),
        ("2/ms", "1/s", 2000.0),
        ("5 rad/s", "1/s", 5.0),
        ("7 kg*m**2", "kg m^2", 7.0),
        ("9007199254740993", "s", 9007199254740993),
        ("1 mOhm", "Ohm", 0.001),
        ("60 deg/hour^(1/2)", "rad/s^(1/2)", math.pi / 180),
        ("2 m^(-1/2)", "1/m^(1/2)", 2.0),
        ("0.5", None, 0.5),
    ],
)
def test_a_number_is_turned_into_the_unit_of_its_name(text, unit, value):
    assert read_value(text, unit, "name", "--set") == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize("text", ["30 kg", "30 foo", "1e300 Gm^9", "20 degC/s"])
def test_a_unit_of_another_kind_is_refused(text):
    with pytest.raises(InputError, match="a number in m, or with a unit of that kind"):
        read_value(text, "m", "name", "--set")


@pytest.mark.parametrize(
    "text", ["1/0", "9**9**9m", "m", "0x10", "0,5", "1_0", "١", "1_0 m", "1 m^(9/99)", "1 m^(9*9)"]
)
def test_what_is_no_number_with_a_unit_stays_a_text(text):
    assert read_value(text, "m", "name", "--set") == text


@given(st.text(st.sampled_from("0123456789.eE+-*/^() mskgNdeginafµ°_")), st.sampled_from(["m", "rad", "1/s", "1"]))
@example("9**9**9m", "m")
@example("1m^9/m^9*s", "s")
def test_whatever_is_typed_ends_in_a_number_a_text_or_a_refusal(text, unit):
    with contextlib.suppress(InputError):
        assert isinstance(read_value(text, unit, "name", "--set"), float | int | str)


def test_every_unit_of_every_model_is_known_to_pint():
    for model in list_models():
        manifest = find_model(model)
        for name, unit in setting_units(manifest).items():
            if unit:
                assert read_value(f"2 {unit}" if unit != "1" else "2", unit, name, "") == 2.0, (model, name, unit)


@pytest.mark.parametrize(
    ("names", "text", "result"),
    [
        ("a", "uniform(-180deg, 1 turn)", f"uniform({-math.pi}, {math.tau})"),
        ("a", "normal(mean=0deg, sd = 90 deg)", f"normal(mean=0.0,{math.pi / 2})".replace(",", ", sd =")),
        ("a,b", "sphere(180deg)", f"sphere({math.pi})"),
        ("a", "choice(1e-3, 180deg)", f"choice(1e-3, {math.pi})".replace(", ", ",")),
        ("a", "uniform(1e-3, 2)", "uniform(1e-3, 2)"),
        ("a", "lognormal(1, 2)", "lognormal(1, 2)"),
        ("a,t", "sphere(1)", "sphere(1)"),
    ],
)
def test_a_distribution_may_have_units(names, text, result):
    converted = distribution(names, text, {"a": "rad", "b": "rad", "t": "s"}, "--vary")
    assert converted.replace(" ", "") == result.replace(" ", "")


def test_a_unit_of_another_kind_is_refused_in_a_distribution():
    with pytest.raises(InputError, match=r"t = '10deg' .from --vary.: must be a number in s"):
        distribution("t", "uniform(1s, 10deg)", {"t": "s"}, "--vary")
    for names, text in (
        ("a", "lognormal(1deg, 2)"),
        ("a,t", "sphere(1deg)"),
        ("a,b", "normal([0, 0], [[1deg, 0], [0, 1]])"),
    ):
        with pytest.raises(InputError, match=r"from --vary.: must be a distribution of numbers without units"):
            distribution(names, text, {"a": "rad", "b": "rad", "t": "s"}, "--vary")


def test_several_mistakes_are_refused_together():
    with pytest.raises(InputError, match=r"(?s)theta_0 = '1kg'.*H = '1s'"):
        read_values(["theta_0=1kg", "H=1s"], find_model("triangle"))


@pytest.mark.parametrize(
    ("text", "unit"),
    [("1Hz", "rad/s"), ("60/min", "rad/s"), ("1Bq", "rad/s"), ("0.1 count", "rad"), ("0.1bit", "rad"), ("10sr", "rad"),
     ("1000ppm", "rad"), ("1 N m/Hz", "N m s/rad"), ("30 deg deg", "rad"), ("30 deg^2/s", "rad/s")],
)  # fmt: skip
def test_what_is_no_angle_is_not_taken_for_radians(text, unit):
    with pytest.raises(InputError, match="unit that has an angle"):
        read_value(text, unit, "name", "--set")
