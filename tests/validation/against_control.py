# SPDX-License-Identifier: Apache-2.0
"""Linear models against python-control, which differentiates numerically."""

from __future__ import annotations

import control
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import mehvar
from tests.validation.table import record

POINTS = {
    "triangle": {"rho": 0.3, "phi": 0.4, "mu": 0.17, "theta": 1.0},
    "slosh": {"vx": 10.0, "wy": 0.02, "phi1": 0.2, "theta2": -0.1},
    "satellite": {"roll": 0.2, "pitch": -0.1, "wy": -1e-3, "hx": 0.02},
}


@pytest.mark.parametrize("name", POINTS)
def test_linear_models(name: str) -> None:
    model = mehvar.load(name)
    x, p, u = model.state(**POINTS[name]), model.parameters(), np.full(len(model.input_names), 0.01)
    A, B, _, _ = model.linearize(x, u, p)
    system = control.nlsys(lambda _t, y, v, _p: model.rhs(y, v, p), inputs=len(u), states=len(x))
    coarse, fine = (control.linearize(system, x, u, eps=eps) for eps in (2e-6, 1e-6))
    scale = max(1.0, np.abs(A).max())
    record(
        f"{name}: A and B at a point",
        "python-control",
        control.__version__,
        np.concatenate([np.ravel(A - fine.A), np.ravel(B - fine.B)]) / scale,
        1.1 * max(np.abs(coarse.A - fine.A).max(), np.abs(coarse.B - fine.B).max(), 1e-9 * scale) / scale,
        "of the largest element or 1",
        "change when its step of 1e-6 is doubled and a tenth, as it is of order one; at least its rounding, 1e-9",
    )


def test_response_of_the_linear_satellite() -> None:
    """A torque of 1e-6 N m for 100 s: the linear response of python-control against the model itself."""
    model = mehvar.load("satellite")
    p = model.parameters()
    rest = model.state(wy=-p[model.parameter_names.index("omega0")])
    system = control.ss(*model.linearize(rest, np.zeros(3), p))
    errors, sizes = [], []
    times = np.linspace(0, 100, 101)
    for size in (1e-6, 5e-7):
        torque = size * np.array([1.0, -2.0, 1.5])
        linear = control.forced_response(system, times, np.outer(torque, np.ones_like(times))).states.T[:, :9]
        run = solve_ivp(
            lambda _t, y, u=torque: model.rhs(y, u, p), (0, 100), rest, "DOP853", times, rtol=1e-12, atol=1e-16
        )
        errors.append(np.abs(linear + rest[:9] - run.y.T[:, :9]).max())
        sizes.append(np.abs(linear).max())
    record(
        "satellite: response to small torques, 100 s",
        "python-control",
        control.__version__,
        errors[1] / sizes[1],
        errors[0] / sizes[0],
        "of the response",
        "the same for torques twice as large: a linear model's error falls with them",
    )
