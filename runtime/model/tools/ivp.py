# SPDX-License-Identifier: Apache-2.0
"""A model as an initial value problem for SciPy."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..functions import FloatArray, Functions


class InitialValueProblem(NamedTuple):
    """Arguments of `scipy.integrate.solve_ivp`; unpacks as (fun, jac, y0, t_span).

    Attributes
    ----------
    fun, jac : callable
        Functions of (t, x): dx/dt and its exact derivative with respect to x.
    y0 : array
        State at the start.
    t_span : tuple of float
        Start and end, s.
    """

    fun: Callable[[float, FloatArray], FloatArray]
    jac: Callable[[float, FloatArray], FloatArray]
    y0: FloatArray
    t_span: tuple[float, float]


def initial_value_problem(
    functions: Functions, input_at: Callable[[float], FloatArray], p: FloatArray, x0: FloatArray, end: float
) -> InitialValueProblem:
    """Return a plant's initial value problem for an input that depends on time only.

    Parameters
    ----------
    functions : Functions
        Of the model.
    input_at : callable
        The input at a time.
    p, x0 : array
        Parameters and the state at the start.
    end : float
        s.
    """
    rhs, jac_x = functions["rhs"], functions["jac_x"]

    def fun(t: float, x: FloatArray) -> FloatArray:
        return np.asarray(rhs(x, input_at(t), p))

    def jac(t: float, x: FloatArray) -> FloatArray:
        return np.asarray(jac_x(x, input_at(t), p))

    return InitialValueProblem(fun, jac, x0, (0.0, end))
