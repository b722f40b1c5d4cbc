# SPDX-License-Identifier: Apache-2.0
"""Numbers of two versions' runs: an infinite one, as of a loop that never settles, equals only itself."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

import mehvar
from mehvar import Controller, Event, Group, Metric, Parameter, Quantity, Scenario, System
from mehvar.comparison.runs import MetricChange, RunChange, difference


@given(st.floats(), st.floats())
def test_numbers_of_which_one_is_not_finite_are_equal_only_if_both_are_the_same(old, new):
    size = difference(old, new)
    assert size == difference(new, old) >= 0.0
    assert difference(old, old) == 0.0
    if not (math.isfinite(old) and math.isfinite(new)):
        assert size == (0.0 if old == new or (math.isnan(old) and math.isnan(new)) else math.inf)


@pytest.mark.parametrize(
    ("old", "new"), [(2.65, math.inf), (math.inf, 2.65), (math.inf, -math.inf), (math.nan, 1.0), (0.0, math.nan)]
)
def test_a_run_that_no_longer_settles_has_an_infinite_change(old, new):
    assert RunChange("law", "scenario", "", "", (MetricChange("T", "s", old, new),), 1).size == math.inf


def slowed(gain=1.0, ends=False, metric="peak"):
    """Return a rate that a law brings to rest from 0.5, and its largest value, which the start decides."""
    x, u = Quantity("w", "rad/s", ""), Quantity("u", "rad/s^2", "")
    g, s = Parameter("g", "1/s", "", default=gain), Parameter("w_0", "rad/s", "", default=0.5)
    p = Parameter("least", "rad/s", "", default=0.1)
    return System(
        name="slowed",
        states=Group("x", (x,)),
        inputs=Group("u", (u,)),
        parameters=Group("p", (p,)),
        scenario_parameters=Group("s", (s,)),
        rhs=(u.symbol,),
        initial=(s.symbol,),
        controllers=(Controller("damp", "", Group("c", (g,)), (-g.symbol * x.symbol,)),),
        scenarios=(Scenario("slow", "", 3.0, 0.1),),
        metrics=(Metric(metric, "max_abs", ("w",), "rad/s", ""),),
        events=(Event("calm", x.symbol - p.symbol, "falling", {}, ends=ends),),
    )


def test_equal_metrics_are_not_told_as_equal_runs():
    """Another gain moves the whole run, and its largest value stays the initial one."""
    found = str(mehvar.diff(slowed(), slowed(gain=2.0)))
    assert "no difference" not in found
    assert "all metrics equal in 1 run, largest relative difference 0: slow under damp" in found


def test_a_run_that_an_event_ends_earlier_differs():
    """The rate exp(-t)/2 falls to 0.1 at ln 5."""
    found = str(mehvar.diff(slowed(), slowed(ends=True)))
    assert f"slow under damp: the new one ended: the event calm ends the run at t = {math.log(5):.6g} s" in found
    assert "0 of 1 metrics differ" in found


def test_runs_without_a_common_metric_are_compared_by_their_states():
    found = str(mehvar.diff(slowed(), slowed(gain=2.0, metric="top")))
    assert "last w  0.024894 -> 0.0012394 rad/s" in found
