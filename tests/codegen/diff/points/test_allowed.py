# SPDX-License-Identifier: Apache-2.0
"""Differences at points that a model's constraints and limits forbid, where no run can be."""

import dataclasses

import pytest

from mehvar.codegen.diff import compare
from mehvar.codegen.diff.report import EquationVerdict
from tests.codegen.diff.documents import document
from tests.codegen.diff.pairs import manifest

CLIPPED = "v': Max(k, Min(v, J))"
OTHER = "v': Min(J, Max(k, v))"


def limited(rate: str, margin: str = "J - k", kind: str = "constraint"):
    """A rate, and a condition whose margin is positive in every run."""
    made = document(f"{rate}\nallowed: {margin}")
    rows = [dataclasses.replace(row, kind=kind) if row.name == "allowed" else row for row in made.results]
    return dataclasses.replace(made, results=tuple(rows))


def rate(old, new):
    """The verdict on the rate."""
    return next(row for row in compare(old, new).equations if row.name == "v'")


@pytest.mark.parametrize("kind", ["constraint", "limit"])
def test_a_difference_that_conditions_forbid_is_undecided(kind):
    """Of two orders of clipping, the limits decide only where the lower one is above the upper one."""
    assert rate(document(CLIPPED), document(OTHER)).verdict is EquationVerdict.CHANGED
    row = rate(limited(CLIPPED, kind=kind), limited(OTHER, kind=kind))
    assert row.verdict is EquationVerdict.UNDECIDED
    assert "that the constraints and limits allow" in row.how


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (limited(CLIPPED), limited("v': Max(k, Min(2*v, J))")),
        (limited("v': k*v"), limited("v': k*v + J")),
        (limited(CLIPPED), limited(OTHER, "v")),
        (limited("v': Piecewise((1, v > k), (0, True))", "v - k"), limited("v': 0*v", "v - k")),
    ],
    ids=["inside", "smooth", "one side allows it", "step"],
)
def test_a_difference_that_a_version_allows_is_a_change(old, new):
    """The point of difference lies where that version's condition holds."""
    row = rate(old, new)
    assert row.verdict is EquationVerdict.CHANGED
    at = {"J": 0.0, "k": 0.0, "v": 0.0} | {name: float(value) for name, value in _numbers(row)}
    assert at["J"] > at["k"] or at["v"] > 0


@pytest.mark.parametrize("forward", [True, False])
def test_a_difference_along_an_edge_is_found_between_its_sides(forward):
    """As of a sharp shadow and one with a penumbra: no drawn point is in a band of 1e-9."""
    sharp, band = "v': Piecewise((1, v > k), (0, True))", "10**9*(v - k)"
    ramp = f"v': Min(1, Max(0, {band}))"
    sides = [limited(text, "v - 3", "limit") for text in ((sharp, ramp) if forward else (ramp, sharp))]
    row = rate(*sides)
    assert row.verdict is EquationVerdict.CHANGED
    at = dict(_numbers(row))
    assert 0 <= at["v"] - at["k"] < 1e-9
    assert at["v"] > 3


def _numbers(row):
    return [(name, eval(value)) for name, value in row.counterexample.at]


def test_a_difference_between_whole_numbers_is_found():
    """As of delays in samples: defaults are equal, and hardly any drawn number is whole."""
    whole = "Rational(1, 10**9) - Abs(k - floor(k + Rational(1, 2))) - Abs(J - floor(J + Rational(1, 2)))"
    parameter = next(iter(manifest().parameters))
    rows = tuple(dataclasses.replace(parameter, name=name, default=1.0) for name in "kJ")
    numbers = dataclasses.replace(manifest(), parameters=rows)
    sides = (limited(text, whole) for text in ("v': k*v", "v': J*v"))
    assert rate(*(dataclasses.replace(side, manifest=numbers) for side in sides)).verdict is EquationVerdict.CHANGED


def test_a_change_of_a_condition_is_told_wherever_it_is():
    """A condition is compared at all points, also at those that it forbids."""
    changes = {row.name: row.verdict for row in compare(limited("v': v"), limited("v': v", "2*J - k")).equations}
    assert changes["allowed"] is EquationVerdict.CHANGED


def test_a_point_of_difference_is_inside_open_bounds():
    """A simple number such as 1 is left out where the bounds exclude it."""
    share = {"m": {"bounds": "[0, 1)", "sign": "nonnegative"}}
    row = rate(document("v': Piecewise((1, m > 1/2), (0, True))", **share), document("v': 0*m", **share))
    assert row.verdict is EquationVerdict.CHANGED
    assert dict(_numbers(row))["m"] < 1
