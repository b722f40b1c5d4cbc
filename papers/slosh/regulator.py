# SPDX-License-Identifier: Apache-2.0
"""The matrices of the regulator of craft = beyond, from the Jacobian of the generated model.

`python -m papers.slosh.regulator FOLDER NAME=VALUE ...` prints them as settings of a run, for the parameters of
FOLDER with the values that are given, in place of those that stand in models/slosh/beyond/parameters.toml.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm, solve_discrete_are

from mehvar import Model, load

Array = NDArray[np.float64]
PLANE = ("vy", "q3", "wz", "s1y", "s2y", "sigma1y", "sigma2y", "gimbal2")
INPUTS = ("Mz", "delta2")
MEASURED = 3
_HALF_ANGLE = np.array([1.0, 2.0, *[1.0] * 6])
"""An attitude angle is twice the quaternion's component."""
_LARGE = np.array([10.0, 0.03, 0.02, 0.3, 0.5, 0.3, 0.5, 0.3])
"""States of equal weight: Bryson's rule. With 15 m/s in place of 10 the paper's v_y settles in 752 s, not in 532; with
0.05 rad in place of 0.03 the hull tilts farther, by 0.127 rad in place of 0.088."""
_EFFORT = np.array([1000.0, 0.3])
"""Moment, N m, and gimbal angle, rad, of equal weight: about two thirds and half of the values of the paper's laws."""
BURNT = 300.0
"""Fuel burnt at the linearisation, kg. Poles of the loop, 1/s, full and with 400 and 475 kg burnt: for 300 kg -0.011,
-0.031, -0.046; for full tanks -0.017, +0.44, +0.79, as the pendulums of low tanks are longer than assumed."""
_DISTURBANCE = np.array([0.01, 1e-4, 1e-3, 0.01, 0.01, 0.02, 0.02, 1e-3])
"""Standard deviations of unmodelled disturbances to the states per sample of 0.1 s."""
_NOISE = np.array([0.05, 5e-4, 5e-4])
"""Standard deviations of velocity, m/s, attitude, rad, and body rate, rad/s, of an inertial unit. A run has no noise:
they only tune the filter."""


def plane(model: Model, p: Array, burnt: float = BURNT) -> tuple[Array, Array]:
    """Return A and B of the plane of y about straight flight.

    Parameters
    ----------
    model : Model
        Of craft = beyond with two pendulums.
    p : ndarray
        Parameters of the plant.
    burnt : float
        Fuel, kg.

    Notes
    -----
    At v_x = 0 a velocity in body axes is one in fixed axes but for the thrust, which turns with the hull: the rate of
    w_y is that of v_y plus a_x a_3.
    """
    x = model.state(q0=1.0, s1x=-1.0, s2x=-1.0, burnt=burnt)
    u = np.zeros(len(model.input_names))
    linear = model.linearize(x, u, p)
    rows = [model.state_names.index(name) for name in PLANE]
    columns = [model.input_names.index(name) for name in INPUTS]
    A = linear.A[np.ix_(rows, rows)] * _HALF_ANGLE[:, None] / _HALF_ANGLE
    A[0, 1] += model.rhs(x, u, p)[model.state_names.index("vx")]
    return A, linear.B[np.ix_(rows, columns)] * _HALF_ANGLE[:, None]


def sampled(A: Array, B: Array, period: float) -> tuple[Array, Array]:
    """Return the plane over one period, its inputs held."""
    n, m = B.shape
    both = expm(period * np.block([[A, B], [np.zeros((m, n + m))]]))
    return both[:n, :n], both[:n, n:]


def matrices(model: Model, **values: float) -> dict[str, Array]:
    """Return Phi, Gamma, L_gain and K_gain, and the period that they are made for.

    Parameters
    ----------
    model : Model
        Of craft = beyond with two pendulums.
    **values : float
        Parameters of the plant other than the defaults.
    """
    p = model.parameters(**values)
    period = p[model.parameter_names.index("sample")]
    F, G = sampled(*plane(model, p), period)
    C = np.eye(MEASURED, len(PLANE))
    P = solve_discrete_are(F, G, np.diag(_LARGE**-2.0), np.diag(_EFFORT**-2.0))
    K = np.linalg.solve(np.diag(_EFFORT**-2.0) + G.T @ P @ G, G.T @ P @ F)
    S = solve_discrete_are(F.T, C.T, np.diag(_DISTURBANCE**2), np.diag(_NOISE**2))
    L = S @ C.T @ np.linalg.inv(C @ S @ C.T + np.diag(_NOISE**2))
    return {"Phi": F, "Gamma": G, "L_gain": L, "K_gain": K, "sample_of_gains": np.array(period)}


def settings(found: Mapping[str, Array]) -> dict[str, float]:
    """Return the matrices element by element, by the names of the law's parameters."""
    return {
        "_".join((name, *(str(k + 1) for k in place))): float(matrix[place])
        for name, matrix in found.items()
        for place in np.ndindex(*matrix.shape)
    }


def main(arguments: list[str]) -> None:
    """Print the settings."""
    folder, *pairs = arguments
    values = {name: float(value) for name, value in (pair.split("=") for pair in pairs)}
    for name, value in settings(matrices(load(folder), **values)).items():
        print(f"{name}={value:.10g}")


if __name__ == "__main__":
    main(sys.argv[1:])
