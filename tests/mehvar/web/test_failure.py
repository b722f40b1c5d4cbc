# SPDX-License-Identifier: Apache-2.0
"""A run of a page that does not succeed is found near one that does."""

import pytest

from mehvar.base.errors import InputError
from mehvar.runtime.model.model import load
from mehvar.runtime.run.metrics import metrics
from mehvar.runtime.run.simulate import simulate
from mehvar.web.cases import Case
from mehvar.web.failure import criterion_of, failure_of


@pytest.fixture(scope="module")
def cases():
    run = simulate("triangle", "path", "paper")
    return [Case(run, run.t, 1, 1)]


def test_the_run_found_is_one_value_away_and_does_not_succeed(cases):
    model = load("triangle")
    failure = failure_of(model, cases, criterion_of(model.manifest, "T_theta < 20 and T_rho < 25"))
    run = simulate(model, "path", "paper", {failure.name: failure.value})
    numbers = metrics(run, model.manifest)
    assert not (numbers["T_theta"] < 20 and numbers["T_rho"] < 25)
    assert failure.checksum == run.checksum


def test_what_no_run_misses_has_no_failure(cases):
    model = load("triangle")
    assert failure_of(model, cases, criterion_of(model.manifest, "travel > 0")) is None


def test_a_condition_on_something_else_is_refused():
    with pytest.raises(InputError, match="T_thet"):
        criterion_of(load("triangle").manifest, "T_thet < 20")
