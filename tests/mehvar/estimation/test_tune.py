# SPDX-License-Identifier: Apache-2.0
"""Tuned gains: the minimum that another search finds, held-out runs, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats
from scipy.optimize import minimize_scalar

import mehvar
from mehvar.base.errors import InputError
from mehvar.models.quantities import Group, Parameter, Quantity
from mehvar.models.system import Controller, Scenario, System

COST = "final(theta) * final(theta) + 0.3 * max_rate"
RUNS = {"vary": {"theta_0": "uniform(0.8, 1.2)"}, "n": 16, "t_end": 5.0}


@pytest.mark.soak
def test_the_gain_is_the_one_that_a_search_without_gradients_finds() -> None:
    def cost(gain: float) -> float:
        runs = mehvar.batch("triangle", "path", k_phi=float(gain), **RUNS)
        return float((runs.final.sel(state="theta") ** 2 + 0.3 * runs.max_rate).mean())

    tuning = mehvar.tune("triangle", "path", ["k_phi"], COST, **RUNS)
    best = minimize_scalar(cost, bounds=(0.3, 4.0), method="bounded", options={"xatol": 1e-4})
    assert tuning.gains["k_phi"] == pytest.approx(best.x, rel=1e-3)
    assert tuning.cost[1] <= best.fun * (1 + 1e-6)
    assert tuning.cost[0] == pytest.approx(cost(0.5), rel=1e-12)
    assert tuning.answer == "better"
    assert tuning.low < tuning.gain < tuning.high
    assert "held-out runs: better" in repr(tuning)


def test_a_gain_that_acts_on_nothing_is_not_called_better() -> None:
    tuning = mehvar.tune("triangle", "path", ["k_phi"], "theta_0 * theta_0", **RUNS)
    assert tuning.gains == tuning.start
    assert tuning.answer == "undecided"


def decay(least: str) -> mehvar.Model:
    """A place that a gain brings to zero, y' = -k y, so that y(2) = y_0 exp(-2 k)."""
    x, u = Group("x", (Quantity("y", "m", "place"),)), Group("u", (Quantity("v", "m/s", "push"),))
    c = Group("c", (Parameter("k", "1/s", "gain", default=0.5, bounds=least),))
    s = Group("s", (Parameter("y_0", "m", "start", default=1.0),))
    law = Controller("pull", "proportional", c, (-c.k * x.y,))
    return mehvar.build(
        System(
            name="decay", title="a place", states=x, inputs=u, scenario_parameters=s, rhs=(u.v,), initial=(s.y_0,),
            controllers=(law,), scenarios=(Scenario("go", "go", 2.0, 0.1),),
        )
    )  # fmt: skip


@pytest.mark.parametrize("least", ["[0.5, 0.8]", "[0, 0.8]", "[0, 0.8)", "[-1, 0.8]"])
@pytest.mark.parametrize("n", [2, 5])
@pytest.mark.share(3)
def test_the_interval_is_students_and_a_bound_is_told(n: int, least: str) -> None:
    """The start may be at a bound, as the least cost is; few runs have a wide interval."""
    model, runs = decay(least), {"vary": {"y_0": "uniform(0.5, 1.5)"}, "n": n}
    tuning = mehvar.tune(model, "pull", ["k"], "final(y) * final(y)", seed=4, **runs)
    assert tuning.gains["k"] == pytest.approx(0.8, rel=2e-4)
    assert tuning.bounded == ("k",)
    assert "k is at a bound" in repr(tuning)
    old, new = (
        mehvar.batch(model, "pull", seed=5, k=k, **runs).final.sel(state="y").values ** 2
        for k in (0.5, tuning.gains["k"])
    )
    interval = stats.ttest_1samp(old - new, 0.0).confidence_interval(0.95)
    np.testing.assert_allclose([tuning.low, tuning.high], interval, rtol=1e-9)


@pytest.mark.parametrize("unit", ["1e-9", "1e9"])
def test_the_unit_of_a_cost_does_not_matter(unit: str) -> None:
    cost, runs = f"{unit} * final(y) * final(y)", {"vary": {"y_0": "uniform(0.5, 1.5)"}, "n": 2}
    assert mehvar.tune(decay("[0, 0.8]"), "pull", ["k"], cost, **runs).bounded == ("k",)


def test_a_cost_without_a_minimum_is_refused() -> None:
    with pytest.raises(InputError, match="has no minimum: it falls until k are infinite"):
        mehvar.tune(
            decay("(-inf, inf)"), "pull", ["k"], "-1 * final(y) * final(y)", vary={"y_0": "uniform(0.5, 1.5)"}, n=2
        )


@pytest.mark.parametrize(
    ("free", "cost", "part"),
    [
        ([], COST, "free"),
        (["k_psi"], COST, "k_psi"),
        (["k_phi", "k_phi"], COST, "free: k_phi is given twice"),
        (["k_phi"], "final(psi)", "psi"),
        (["k_phi"], "final(theta) < 1", "cost"),
        (["k_phi"], "T_length * 1e999", "cost"),
    ],
)
def test_what_cannot_be_tuned_is_refused(free: list[str], cost: str, part: str) -> None:
    with pytest.raises(InputError, match=part):
        mehvar.tune("triangle", "path", free, cost, **RUNS)


@pytest.mark.parametrize(
    ("change", "part"),
    [
        ({"vary": {"theta_0": [0.9, 1.1]}, "n": 2}, "theta_0.*listed values allow no verdict"),
        ({"sampling": "sobol"}, "sobol design"),
        ({"success": "T_length < 1"}, "success = .*left out"),
        ({"until": "ci(success) < 0.1"}, "until = .*left out"),
        ({"save": 0.5}, "save = 0.5.*left out"),
        ({"vary": None}, "all runs are the same"),
    ],
)
def test_runs_that_could_not_judge_are_refused(change: dict, part: str) -> None:
    """Listed values would be the search's own runs again."""
    with pytest.raises(InputError, match=part):
        mehvar.tune("triangle", "path", ["k_phi"], COST, **{**RUNS, **change})


def test_the_period_of_a_law_is_no_gain() -> None:
    """Period and step of the result would have to fit in each trial."""
    with pytest.raises(InputError, match=r"free = 'Ts'.*other than the period of the law"):
        mehvar.tune("satellite", "pd", ["Ts"], "final(roll)", vary={"roll": "uniform(0, 0.1)"}, n=2, t_end=5.0)
