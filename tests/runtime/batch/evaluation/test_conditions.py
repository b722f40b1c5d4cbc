# SPDX-License-Identifier: Apache-2.0
"""Conditions mean what they mean in Python, also chained ones."""

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mehvar.base.errors import InputError
from mehvar.runtime.batch.evaluation.conditions import Criterion, Number

NUMBERS = st.sampled_from(("T_x", "abs(T_x)", "-T_x + 1", "0.5", "1", "2", "3"))
CHAINS = st.builds(
    lambda first, rest: " ".join((first, *(f"{op} {number}" for op, number in rest))),
    NUMBERS,
    st.lists(st.tuples(st.sampled_from(("<", "<=", ">", ">=")), NUMBERS), min_size=1, max_size=4),
)
VALUES = np.array([-2.0, 0.0, 0.5, 1.0, 2.0, 3.0, np.inf])


@given(CHAINS, CHAINS, st.sampled_from(("{}", "not ({})", "{} and {}", "{} or not {}")))
def test_a_chain_of_comparisons_means_what_it_means_in_python(one, other, form):
    text = form.format(one, other)
    if "T_x" not in text:
        return
    expected = [bool(eval(text, {"abs": abs, "T_x": value})) for value in VALUES]
    assert Criterion(text)({"T_x": VALUES}).tolist() == expected


CONNECTIVES = st.recursive(
    st.sampled_from(("T_x < 1", "T_y > 0.5", "0 < T_x <= 2")),
    lambda part: st.one_of(
        part.map("not ({})".format),
        st.builds("({}) {} ({})".format, part, st.sampled_from(("and", "or")), part),
    ),
    max_leaves=6,
)


@given(CONNECTIVES)
def test_a_number_that_does_not_exist_fulfils_nothing_that_depends_on_it(text):
    """A run with NaN fulfils a condition at most where every number in place of the NaN would."""
    criterion = Criterion(text)
    x, y = np.meshgrid([-1.0, 0.5, 1.0, 1.5, 2.0, 3.0], [0.0, 0.5, 1.0])
    unknown = criterion({"T_x": np.full(3, np.nan), "T_y": y[:, 0]})
    holds = criterion({"T_x": x, "T_y": y})
    assert not (unknown & ~holds.all(axis=1)).any()
    if "T_y" not in text:
        assert not unknown.any()


@pytest.mark.parametrize(
    "text",
    [
        *("(T_x < 1) < 2", "T_x < (1 < 2)", "T_x == 1 < 2", "T_x < 1 is 2", "1 < 2 < 3"),
        *("T_x", "T_x <", "1", "-T_x", "__import__('os').system('x') < 1"),
    ],
)
def test_what_is_no_comparison_of_numbers_is_refused(text):
    with pytest.raises(InputError, match="must be a condition"):
        Criterion(text)


def test_numbers_that_are_compared_have_one_unit_and_words_of_a_status_have_none():
    units = {"T_x": "s", "T_y": "s", "rho": "m"}
    Criterion("T_x < T_y and status == done").check(units, {})
    for condition, bare in (
        ("T_x < 20 and rho < 5 cm", "T_x in s"),  # a unit somewhere hid those of all
        ("T_x < 20 s and rho < 5 cm", ""),
        ("not (rho < 5 cm) or abs(T_y) < 3 and rho > 0.1", "T_y in s, rho in m"),
        ("T_x < T_y", "T_x in s, T_y in s"),
        ("3 < T_x < 3 s", ""),  # equal numbers, of which one has a unit
        ("status == done and T_x < 1 h", ""),
    ):
        assert Criterion(condition).units(units) == bare
    with pytest.raises(InputError, match="T_x is in s, rho in m"):
        Criterion("status == done and T_x < rho").check(units, {})


UNITS = {"T_x": "s", "roll": "rad", "wx": "rad/s", "F": "N"}
QUANTITIES = [
    ("T_x < 2 min", "T_x < 120"),
    ("T_x<2min and roll < 12 deg", f"T_x < 120 and roll < {np.pi / 15!r}"),
    ("wx < 3 rpm or not T_x < 1 h", f"wx < {3 * 2 * np.pi / 60!r} or not T_x < 3600"),
    ("abs(F) < 5e2 mN", "abs(F) < 0.5"),
    ("roll < -12 deg + 2*3 deg", f"roll < {-np.pi / 30!r}"),
    ("wx*T_x < 30 deg", f"wx*T_x < {np.pi / 6!r}"),
    ("T_x < 1e2 and -1e2<T_x", "T_x < 100 and -100 < T_x"),
]


@pytest.mark.parametrize(("text", "plain"), QUANTITIES)
def test_a_number_with_a_unit_is_that_number_in_the_si(text, plain):
    one, other = Criterion(text), Criterion(plain)
    one.check(UNITS, {})
    assert one.names == other.names
    values = {name: np.linspace(-4, 4, 4001) * (100 if name == "T_x" else 1) for name in UNITS}
    assert one(values).tolist() == other(values).tolist()
    assert 0 < one(values).sum() < 4001


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("T_x < 12 deg", "T_x is in s, 12 deg in rad"),
        ("wx < 5 Hz", "wx is in rad/s, 5 Hz in 1/s"),
        ("wx < 5 deg deg/s", "wx is in rad/s, 5 deg deg/s in rad.2/s"),
        ("F < 5 mN m", "F is in N, 5 mN m in kg m.2/s.2"),
        ("T_x < 5 smoots", "must be numbers in known units: 'smoots' is unknown"),
        ("T_x < 1e999 min", "with numbers up to"),
        ("1e999 < T_x", "with numbers up to"),
        ("1 min < 2 min", "does not contain a result of a run"),
    ],
)
def test_a_unit_of_another_kind_is_refused(text, words):
    with pytest.raises(InputError, match=words):
        Criterion(text).check(UNITS, {})


@pytest.mark.parametrize("number", ["1e-3", "2.5e-4", "1E-3", "1e+3", ".5e-2", "1.e-5", "3e4", "0.25", "12"])
@pytest.mark.parametrize("form", ["off < {}", "off<{}", "off < {} and off > -1", "2 * off < {} * 2", "off < {} rad"])
def test_a_number_is_read_as_python_reads_it(number, form):
    condition = Criterion(form.format(number), "success")
    condition.check({"off": "rad"}, {})
    limit = float(number)
    below = np.array([0.0, limit * (1 - 1e-9), limit * (1 + 1e-9)])
    np.testing.assert_array_equal(condition({"off": below}), [True, True, False])


@pytest.mark.parametrize("text", ["T_x**2", "T_x < 1 or 2", "2"])
def test_a_text_that_is_no_number_is_refused_as_it_was_written(text):
    with pytest.raises(InputError, match=rf"^cost = '{re.escape(text)}'.*: must be a number such as"):
        Number(text, "cost")


@pytest.mark.parametrize(
    ("condition", "limit"),
    [
        ("T < -20 degC", 253.15),
        ("T < 20 degC", 293.15),
        ("-300 K < T < -1 degC", 272.15),
        ("T < -4 degF", 253.15),
        ("T < --20 degC", 293.15),
        ("T < -20 dB", 0.01),
        ("T < -20 K", -20.0),
    ],
)
def test_a_sign_before_a_level_belongs_to_the_level(condition, limit):
    assert Criterion(condition)({"T": np.array([limit - 1e-6, limit + 1e-6])}).tolist() == [True, False]


@pytest.mark.parametrize(
    "condition",
    [
        "T - T_y < 5 degC",
        "abs(T - 5 degC) < 1 K",
        "2 * 5 degC > T",
        "abs(T) < 5 degC",
        "-T < 5 degC",
        "T < 1 K + 0 degC",
    ],
)
def test_arithmetic_with_a_level_is_refused(condition):
    with pytest.raises(InputError, match=r"levels such as \d degC only beside a name"):
        Criterion(condition)
