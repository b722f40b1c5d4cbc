# SPDX-License-Identifier: Apache-2.0
"""The table of a run's options: every row against its own bounds, the docs and the vocabulary."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path
from typing import get_args

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mehvar.base.errors import InputError
from mehvar.base.manifest import METRIC_KINDS
from mehvar.runtime.batch.plan import CAMPAIGN_OPTIONS
from mehvar.runtime.batch.sampling import DESIGNS, OPEN_DESIGNS
from mehvar.runtime.model.catalogue import find_model
from mehvar.runtime.run import metrics
from mehvar.runtime.run.options import OPTIONS, Option, Place, RunOptions, read_options, split_settings
from mehvar.runtime.units import read_value
from mehvar.settings import read_values

ROOT = Path(__file__).parents[3]
PAGE = ROOT / "docs" / "reference" / "batch-store.md"
ROWS = [*OPTIONS.values(), *CAMPAIGN_OPTIONS.values()]


def allowed(row: Option) -> st.SearchStrategy[object]:
    """Return values that a row allows."""
    if row.words:
        return st.sampled_from(row.words)
    if row.kind == "count":
        return st.integers(int(row.least or 0), int(row.below or 2**31) - 1)
    low = row.least if row.least is not None else row.above
    return st.floats(low, row.below, exclude_min=row.least is None, exclude_max=row.below is not None,
                     allow_infinity=False, allow_nan=False)  # fmt: skip


def refused(row: Option) -> list[object]:
    """Return values that a row does not allow."""
    bounds = [value for value in (row.above, row.below) if value is not None]
    bounds += [] if row.least is None else [row.least - 1]
    return [*bounds, "no such word", float("nan"), float("inf"), *([0.5] if row.kind == "count" else [])]


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.name)
@given(data=st.data())
def test_a_row_takes_what_it_allows_also_from_a_command_line(row, data):
    value = data.draw(allowed(row))
    assert row.check(value, "here") == value
    assert row.check(read_value(str(value)), "here") == value
    assert type(row.check(read_value(str(value)), "here")) is type(value)


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.name)
def test_a_row_refuses_the_rest_and_says_what_where_and_why(row):
    for value in refused(row):
        with pytest.raises(InputError, match=rf"^{row.name} = .* \(from here\): must be "):
            row.check(value, "here")
    assert row.text
    assert (row.default is None) == bool(row.otherwise), "what holds unless given is said once"


@pytest.mark.parametrize("place", get_args(Place))
@pytest.mark.parametrize("row", OPTIONS.values(), ids=lambda row: row.name)
def test_a_place_takes_an_option_or_says_what_to_do_instead(row, place):
    value = row.words[0] if row.words else 1 if row.kind == "count" else 0.5
    if place in row.refused:
        with pytest.raises(InputError, match=re.escape(row.refused[place])):
            read_options({row.name: value}, place, "here")
        return
    options, others = read_options({row.name: value, "k_p": 3.0}, place, "here")
    assert getattr(options, row.name) == value
    assert others == {"k_p": 3.0}
    assert options.changes() == ({} if value == row.default else {row.name: value})


def test_defaults_stand_in_the_table_alone():
    assert RunOptions().changes() == {}
    assert {f.name for f in dataclasses.fields(RunOptions)} == OPTIONS.keys()
    with pytest.raises(InputError, match="rtol = 2"):
        RunOptions(rtol=2)
    with pytest.raises(dataclasses.FrozenInstanceError):
        RunOptions().rtol = 1e-3


def test_settings_are_sorted_into_parameters_and_options_with_choices():
    settings = read_values(
        ["m=2.5", "name=big", "plant=reduced", "rtol=1e-9", "max_steps=100000"], find_model("triangle")
    )
    parameters, options = split_settings(settings, ["plant", "attitude"], "run", "--set")
    assert parameters == {"m": 2.5, "name": "big"}, "a text that is no number is refused where its name is known"
    assert options == {"rtol": 1e-9, "max_steps": 100_000, "plant": "reduced"}, "what is given stays given"


def test_designs_are_named_once():
    assert set(OPEN_DESIGNS) <= set(DESIGNS) == set(CAMPAIGN_OPTIONS["sampling"].words)
    assert all(f"`{design}`" in PAGE.read_text(encoding="utf-8") for design in DESIGNS)


def test_every_kind_of_metric_is_computed():
    assert (*metrics._KINDS, metrics.COUNT) == METRIC_KINDS
