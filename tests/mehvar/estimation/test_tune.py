# SPDX-License-Identifier: Apache-2.0
"""Tuned gains: the minimum that another search finds, held-out runs, and what is refused."""

from __future__ import annotations

import pytest
from scipy.optimize import minimize_scalar

import mehvar
from mehvar.base.errors import InputError

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


@pytest.mark.parametrize(
    ("free", "cost", "part"),
    [
        ([], COST, "free"),
        (["k_psi"], COST, "k_psi"),
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
        ({"vary": {"theta_0": [0.9, 1.1]}, "n": 2}, "listed design"),
        ({"sampling": "sobol"}, "sobol design"),
        ({"vary": None}, "all runs are the same"),
    ],
)
def test_runs_that_could_not_judge_are_refused(change: dict, part: str) -> None:
    """Listed values would be the search's own runs again."""
    with pytest.raises(InputError, match=part):
        mehvar.tune("triangle", "path", ["k_phi"], COST, **{**RUNS, **change})
