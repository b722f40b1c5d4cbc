# SPDX-License-Identifier: Apache-2.0
from dataclasses import replace

from mehvar.report.charts import chart
from mehvar.report.papers.study import run_study
from mehvar.reproduction.paper import load_reproduction
from mehvar.runtime.batch.evaluation.statistics import interval
from mehvar.runtime.model.model import load
from tests.mehvar.report.test_series import floats


def test_a_study_counts_successes_and_draws_its_bands_the_same_each_time():
    study, steps = replace(load_reproduction("triangle").study, runs=64), []
    first, second = (run_study(load("triangle"), study, lambda done, what: steps.append(done)) for _ in range(2))
    assert steps[-1] == 1.0
    for (title, found), (_, again) in zip(first.laws, second.laws, strict=True):
        assert title in study.laws.values()
        assert (found.stored, found.successes) == (64, again.successes)
        assert (found.low, found.high) == interval(found.successes, 64)
    assert {row.name for _, row in first.metrics} == {"T_theta", "T_rho"}
    assert chart(first.figure) == chart(second.figure)
    for panel in chart(first.figure)["panels"]:
        low, high, middle = (floats(line["y"]) for line in panel["lines"])
        assert (low <= middle).all()
        assert (middle <= high).all()
