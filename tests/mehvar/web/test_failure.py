# SPDX-License-Identifier: Apache-2.0
"""A run of a page that does not succeed is found near one that does."""

import pytest

from mehvar.base.errors import InputError
from mehvar.runtime.model.model import load
from mehvar.runtime.run.metrics import metrics
from mehvar.runtime.run.simulate import simulate
from mehvar.web.cases import Case
from mehvar.web.failure import failure_of


@pytest.fixture(scope="module")
def cases():
    run = simulate("triangle", "path", "paper")
    return [Case(run, run.t, 1, 1)]


def test_the_run_found_is_one_value_away_and_does_not_succeed(cases):
    model = load("triangle")
    failure = failure_of(model, cases, "T_theta < 20 and T_rho < 25")
    run = simulate(model, "path", "paper", {failure.name: failure.value})
    numbers = metrics(run, model.manifest)
    assert not (numbers["T_theta"] < 20 and numbers["T_rho"] < 25)
    assert failure.checksum == run.checksum
    assert f"T_theta = {numbers['T_theta']:.4g} s" in failure.text


def test_what_no_run_misses_has_no_failure(cases):
    assert failure_of(load("triangle"), cases, "travel > 0") is None


def test_a_condition_on_something_else_is_refused(cases):
    with pytest.raises(InputError, match="T_thet"):
        failure_of(load("triangle"), cases, "T_thet < 20")
