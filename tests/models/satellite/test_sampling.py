# SPDX-License-Identifier: Apache-2.0
"""A loop at another period than the one that the instruments compute with."""

from __future__ import annotations

import json

import pytest

import mehvar


def law(_t, x):
    return -0.002 * x[:3] - 0.03 * x[3:6]


def test_a_law_in_python_is_refused_at_a_period_that_is_not_the_instruments() -> None:
    """Ts decides the size of the noise of a sample: at another period the densities would be others."""
    with pytest.raises(
        mehvar.InputError, match=r"Ts = 0.5 .*must be 0.1 s, the period of the loop: actuate and measure"
    ):
        mehvar.simulate("satellite", law, period=0.1, t_end=1.0)
    with pytest.raises(mehvar.InputError, match=r"Ts = 0.5 .*must be 0.1 s"):
        mehvar.batch("satellite", law, 2, period=0.1, t_end=1.0)
    run = mehvar.simulate("satellite", law, period=0.1, t_end=1.0, Ts=0.1)
    assert run.attrs["status"] == "done"
    batch = mehvar.batch("satellite", law, 2, period=0.1, t_end=1.0, Ts=0.1)
    assert (batch.status == 0).all()
    with pytest.raises(mehvar.InputError, match="Ts cannot vary"):
        mehvar.batch("satellite", law, 2, period=0.5, t_end=1.0, vary={"Ts": "uniform(0.4, 0.6)"})


def test_a_vector_of_a_length_has_components_in_one_unit():
    with pytest.raises(mehvar.InputError, match=r"I_x,roll = 'sphere\(0.1\)' .*not I_x in kg m\^2, roll in rad"):
        mehvar.batch("satellite", "pd", n=2, vary={"I_x,roll": "sphere(0.1)"})
    assert mehvar.batch("satellite", "pd", n=2, t_end=1.0, vary={"roll,pitch": "sphere(0.1)"}).sizes["run"] == 2


@pytest.mark.parametrize(("given", "origin"), [({}, "default"), ({"delay": 1}, "the call")])
def test_the_delay_of_a_law_comes_from_the_run_that_sets_it(given, origin):
    run = mehvar.simulate("satellite", "pd", t_end=1.0, **given)
    assert json.loads(run.attrs["parameter_origins"])["delay"] == origin
