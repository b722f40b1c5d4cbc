# SPDX-License-Identifier: Apache-2.0
"""The plant as SciPy integrates it."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import mehvar
from mehvar.base.errors import InputError


def test_an_input_of_time_drives_the_plant():
    """The triangle's first three states are integrals of its inputs, its fourth one of them."""
    model = mehvar.load("triangle")
    fun, jac, y0, t_span = model.as_solve_ivp(u=lambda t: [0.0, 0.2 * np.cos(t), 0.0])
    run = solve_ivp(fun, (0.0, 3.0), y0, "Radau", jac=jac, rtol=1e-10, atol=1e-12)
    assert t_span[1] == model.manifest.scenario(None).duration
    assert run.y[1, -1] - y0[1] == pytest.approx(0.2 * np.sin(3.0), abs=1e-9)
    swept = y0[0] ** 2 * 0.2 * np.sin(3.0)
    assert run.y[3, -1] - y0[3] == pytest.approx(swept, abs=1e-9)


def test_the_jacobian_is_that_of_the_function(model):
    fun, jac, y0, _ = model.as_solve_ivp(u=np.full(len(model.input_names), 0.1))
    step = 1e-6 * np.maximum(1.0, np.abs(y0))
    columns = [(fun(0.0, y0 + h) - fun(0.0, y0 - h)) / (2 * h.max()) for h in np.diag(step)]
    np.testing.assert_allclose(jac(0.0, y0), np.transpose(columns), rtol=1e-5, atol=1e-5)


def test_an_unknown_scenario_is_refused():
    with pytest.raises(InputError, match="unknown scenario"):
        mehvar.load("triangle").as_solve_ivp(scenario="none")
