# SPDX-License-Identifier: Apache-2.0
"""The methods `rock4` and `rodas5p` as SciPy solvers."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.integrate import RK45, DenseOutput, OdeSolver
from scipy.integrate._ivp.common import norm, num_jac, select_initial_step
from scipy.linalg import lu_factor, lu_solve

from mehvar.runtime.compiling.library import NATIVE
from mehvar.runtime.model.functions import FloatArray

from .headers import numbers

_ROCK_STAGES = 16
_RODAS_STAGES = 8
_SAFETY, _SHRINK, _GROW = 0.9, 0.2, 10.0
"""Step-size constants of SciPy's own explicit solvers."""
_TIME_STEP = numbers("step/implicit.h")["TIME_STEP"]


class Rock4(RK45):  # type: ignore[misc]  # SciPy has no annotations
    """Sixteen stages of order four with a long stable piece of the negative real axis.

    The coefficients of the native integrator, from `native/methods/rock4.inc`, dense output of order four among
    them. Source: Abdulle, SIAM J. Sci. Comput. 23 (2002) 2041.
    """

    order, error_estimator_order, n_stages = 4, 3, _ROCK_STAGES
    _text = (NATIVE / "methods" / "rock4.inc").read_text(encoding="utf-8")
    _rows = np.array(_text.rstrip(",\n").split(","), dtype=np.float64).reshape(_ROCK_STAGES + 4, _ROCK_STAGES)
    A, B, C = _rows[:_ROCK_STAGES], _rows[_ROCK_STAGES], _rows[_ROCK_STAGES + 1]
    E = np.append(_rows[_ROCK_STAGES + 2], 0.0)
    _start, _end, _all = np.eye(_ROCK_STAGES + 1)[0], np.eye(_ROCK_STAGES + 1)[-1], np.append(B, 0.0)
    _more = np.append(_rows[_ROCK_STAGES + 3], 0.0)  # of s^2 (1 - s)^2
    P = np.stack([_start, 3 * _all - 2 * _start - _end + _more, _start + _end - 2 * _all - 2 * _more, _more], axis=1)


def _rodas_rows() -> FloatArray:
    text = (NATIVE / "methods" / "rodas5p.inc").read_text(encoding="utf-8")
    rows = [[float(number) for number in row.split(",")] for row in re.findall(r"\{([^}]*)\}", text)]
    return np.array([row + [0.0] * (_RODAS_STAGES - len(row)) for row in rows])


class StiffTest:
    """Test of SciPy's DOP853 for steps limited by stability instead of error, as in native/step/stiffness.h."""

    _STABLE_PIECE, _STIFF_STEPS, _SMOOTH_STEPS = 6.1, 15, 6

    def __init__(self) -> None:
        self._stiff = self._smooth = 0

    def is_stiff_after(self, solver: Any) -> bool:
        """Check the last step; return True if enough steps so far were limited by stability."""
        h, slopes, last = solver.h_previous, solver.K, solver.n_stages - 1
        place = solver.y_old + h * (solver.A[last, :last] @ slopes[:last])
        if h * norm(slopes[-1] - slopes[last]) > self._STABLE_PIECE * norm(solver.y - place):
            self._stiff, self._smooth = self._stiff + 1, 0
        else:
            self._smooth += 1
        self._stiff = 0 if self._smooth >= self._SMOOTH_STEPS else self._stiff
        return self._stiff >= self._STIFF_STEPS


class Rodas5P(OdeSolver):  # type: ignore[misc]  # SciPy has no annotations
    """Eight stages of order five, each a linear system, for stiff loops; dense output of order four.

    The coefficients of the native integrator, from `native/methods/rodas5p.inc`. Source: Steinebach, BIT Numer. Math.
    63 (2023) 27.

    Parameters
    ----------
    jac : callable, optional
        Jacobian of the slope, as a function of time and coordinates; by differences unless given.
    mass : array, optional
        Diagonal of the mass matrix: one, and zero for algebraic states.
    """

    A, G, (C, D), DENSE = np.split(_rodas_rows(), (8, 16, 18))
    order = 4  # of the estimate
    t: float
    y: FloatArray
    f: FloatArray

    def __init__(
        self,
        fun: Callable[[float, FloatArray], FloatArray],
        t0: float,
        y0: FloatArray,
        t_bound: float,
        rtol: float,
        atol: float,
        first_step: float | None = None,
        jac: Callable[[float, FloatArray], FloatArray] | None = None,
        mass: FloatArray | None = None,
    ) -> None:
        super().__init__(fun, t0, y0, t_bound, vectorized=False)
        self.rtol, self.atol = rtol, atol
        self.f = self.fun(self.t, self.y)
        self._jac, self._factor = jac, None
        self._mass = np.ones(len(self.y)) if mass is None else np.asarray(mass, dtype=np.float64)
        span, direction = t_bound - t0, 1.0
        self.h_abs = first_step or select_initial_step(
            self.fun, self.t, self.y, t_bound, span, self.f, direction, self.order, rtol, atol
        )

    def _jacobian(self) -> FloatArray:
        if self._jac is None:
            jacobian, self._factor = num_jac(self._columns, self.t, self.y, self.f, self.atol, self._factor)
        else:
            jacobian = self._jac(self.t, self.y)
        return np.where(np.isfinite(jacobian), jacobian, 0.0)

    def _columns(self, t: float, y: FloatArray) -> FloatArray:
        return np.stack([self.fun(t, column) for column in y.T], axis=1) if y.ndim == 2 else self.fun(t, y)

    def _step_impl(self) -> tuple[bool, str | None]:
        step = _TIME_STEP * max(1.0, abs(self.t))
        in_time = (self.fun(self.t + step, self.y) - self.f) / step
        jacobian, refused = self._jacobian(), False
        while True:
            least = 10 * abs(np.nextafter(self.t, np.inf) - self.t)
            if not self.h_abs >= least:
                return False, self.TOO_SMALL_STEP
            h = min(self.h_abs, self.t_bound - self.t)
            y, stages = self._stages(h, jacobian, in_time)
            scale = self.atol + self.rtol * np.maximum(np.abs(self.y), np.abs(y))
            error = norm(stages[-1] / scale) if np.all(np.isfinite(y)) else np.inf
            factor = _SHRINK if not np.isfinite(error) else _SAFETY * max(error, 1e-10) ** (-1 / (self.order + 1))
            if error <= 1:
                self.h_abs = h * min(1.0 if refused else _GROW, factor)
                break
            self.h_abs, refused = h * max(_SHRINK, factor), True
        t = self.t + h if h < self.t_bound - self.t else self.t_bound
        self._last = (self.t, self.y, h, stages)
        self.t, self.y, self.f = t, y, self.fun(t, y)
        return True, None

    def _stages(self, h: float, jacobian: FloatArray, in_time: FloatArray) -> tuple[FloatArray, FloatArray]:
        n = len(self.y)
        matrix, stages, at = np.diag(self._mass) / (h * self.D[0]) - jacobian, np.zeros((_RODAS_STAGES, n)), self.y
        factors = lu_factor(matrix, check_finite=False)
        for s in range(_RODAS_STAGES):
            at = self.y + self.A[s, :s] @ stages[:s]
            slope = self.fun(self.t + self.C[s] * h, at) if s else self.f
            right = slope + self._mass * (self.G[s, :s] @ stages[:s]) / h + self.D[s] * h * in_time
            stages[s] = lu_solve(factors, right, check_finite=False)
        return at + stages[-1], stages

    def _dense_output_impl(self) -> DenseOutput:
        return _Dense(*self._last, self.t, self.y, self.DENSE)


class _Dense(DenseOutput):  # type: ignore[misc]
    def __init__(self, t0: float, y0: FloatArray, h: float, stages: FloatArray, *end: Any) -> None:
        t, y, weights = end
        super().__init__(t0, t)
        self._y0, self._h, self._change, self._terms = y0, h, y - y0, weights @ stages

    def _call_impl(self, t: float) -> FloatArray:
        part = (t - self.t_old) / self._h
        one, two, three = self._terms
        sums: FloatArray = self._change + (1 - part) * (one + part * (two + part * three))
        value: FloatArray = self._y0 + part * sums
        return value
