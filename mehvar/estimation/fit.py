# SPDX-License-Identifier: Apache-2.0
"""Estimation of parameters and initial states from a recorded run by nonlinear least squares."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mehvar.api import simulate
from mehvar.base.errors import InputError, bad_value, unknown_name
from mehvar.base.manifest import Controller
from mehvar.runtime.arguments import check_arguments, check_units
from mehvar.runtime.model.model import Model, load
from mehvar.runtime.model.parameters import number_above
from mehvar.runtime.run.ticks import fraction, multiples
from mehvar.runtime.run.user.law import LawFunction

if TYPE_CHECKING:
    import xarray as xr

FloatArray = NDArray[np.float64]
_STEP = 3e-4
"""Relative step of a central difference: the cube root of a run's relative error, about 1e-11, balances both errors.
A derivative then has an error of about 1e-7."""
_UNSEEN = 1e-6
"""Bound on singular values of unit columns, relative to the largest one. Smaller effects on the data are lost in
derivative errors of 1e-7.
"""
_RUN_ERROR = 1e-11
"""Relative error of a run with default tolerances. Divided by the step, it bounds the error of a derivative."""
_FLAT = 0.1
"""Relative change that separates parameters without effect from those that act in steps, such as times."""
_FAR = 1e3
"""Residual, in standard deviations, of samples after the end of a trial run."""
_NEAR = 0.1
"""Distance from the least residuals, in standard deviations, at which a search has converged: an interval of 95 % then
covers 94.9 %.
"""
_NEAR_OF_MISFIT = 1e-5
"""Part of the residuals that the distance may have too: SciPy stops at relative changes of 1e-12 of their squares."""


@dataclass(frozen=True)
class Fit:
    """Result of `fit`.

    Attributes
    ----------
    names : tuple of str
        Names of the free values, in the order of `values` and `covariance`.
    values : ndarray
        Their estimates, shape (k,).
    covariance : ndarray
        Their covariance, shape (k, k); infinite for undetermined values.
    sigma : mapping of str to float
        Standard deviation of each variable's noise, as given or as estimated.
    unseen : tuple of mapping of str to float
        Combinations of relative changes without effect on the data.
    misfit : float
        Probability of residuals at least as large for the given noise (chi-square test); NaN for estimated noise.
    correlation : mapping of str to float
        For each variable, the probability of such correlation between successive residuals if they are independent.
    converged : bool
        False if the search ended before a minimum.
    bounded : tuple of str
        Values at a bound of their parameter, for which the covariance is invalid.
    run : xarray.Dataset
        The run with the estimates.
    """

    names: tuple[str, ...]
    values: FloatArray
    covariance: FloatArray
    sigma: Mapping[str, float]
    unseen: tuple[Mapping[str, float], ...]
    misfit: float
    correlation: Mapping[str, float]
    converged: bool
    bounded: tuple[str, ...]
    run: xr.Dataset

    def __getitem__(self, name: str) -> float:
        return float(self.values[self._index(name)])

    def _index(self, name: str) -> int:
        if name not in self.names:
            raise unknown_name("free value of the fit", name, self.names)
        return self.names.index(name)

    def deviation(self, name: str) -> float:
        """Return the standard deviation of an estimate."""
        k = self._index(name)
        return math.sqrt(self.covariance[k, k])

    def interval(self, name: str, confidence: float = 0.95) -> tuple[float, float]:
        """Return the interval of an estimate, whose coverage holds for many samples."""
        from scipy.special import ndtri

        if not 0 < confidence < 1:
            raise bad_value("confidence", confidence, "a number > 0 and < 1")
        half = float(ndtri((1 + confidence) / 2)) * self.deviation(name)
        return self[name] - half, self[name] + half

    def __repr__(self) -> str:
        lines = [f"{name} = {self[name]:.6g} +- {self.deviation(name):.2g}" for name in self.names]
        lines += [] if self.converged else ["the search ended before the residuals were at their least"]
        lines += [f"{name} is at a bound: its deviation does not hold" for name in self.bounded]
        lines += [
            f"not seen: {', '.join(f'{weight:+.2f} {name}' for name, weight in row.items())}" for row in self.unseen
        ]
        if not math.isnan(self.misfit):
            lines.append(f"residuals as large: probability {self.misfit:.2g}")
        lines += [f"residuals of {name} as correlated: probability {p:.2g}" for name, p in self.correlation.items()]
        return "\n".join(lines)


def fit(
    model: Model | str | os.PathLike[str],
    data: xr.Dataset,
    free: Sequence[str],
    controller: str | LawFunction | None = None,
    scenario: str | None = None,
    parameters: Mapping[str, ArrayLike] | None = None,
    initial: Mapping[str, float] | None = None,
    *,
    sigma: Mapping[str, float] | None = None,
    **options: Any,
) -> Fit:
    """Estimate parameters and initial states from a recorded run.

    The estimates minimise the sum of squared residuals, each divided by the standard deviation of its variable's
    noise. SciPy's trust-region method starts at the values of the scenario and of `parameters`.

    Parameters
    ----------
    model, controller, scenario, parameters, initial
        As of `mehvar.simulate`. Without a controller the loop is open, with the inputs `u_NAME` of the data.
    data : xarray.Dataset
        Samples over `t` in s, at 0, DT, 2 DT, ...; states and outputs by name. NaN stands for a missing sample. An
        attribute `units` must be the model's unit.
    free : sequence of str
        Parameters, and states for their initial values.
    sigma : mapping of str to float, optional
        Standard deviation of the noise of each compared variable, in its unit. Default: all states and outputs of the
        data, with deviations estimated from the residuals.
    **options
        As of `mehvar.simulate`, except `t_end` and `dt_out`, which follow from the data.

    Raises
    ------
    InputError
        If a name is unknown, the samples are invalid, or the run with the start values ends before the data.
    """
    check_arguments("mapping", "the call", parameters=parameters, initial=initial, sigma=sigma)
    loaded = model if isinstance(model, Model) else load(model)
    problem = _Problem(loaded, data, free, controller, scenario, parameters or {}, initial or {}, sigma, options)
    solution = problem.solve()
    if sigma is None:  # again with the deviations that the residuals show
        problem.estimate_sigma(solution)
        solution = problem.solve(solution)
    return problem.result(solution, sigma is not None)


class _Problem:
    """The residuals of a run as a function of the free values."""

    def __init__(
        self,
        model: Model,
        data: xr.Dataset,
        free: Sequence[str],
        controller: str | LawFunction | None,
        scenario: str | None,
        parameters: Mapping[str, ArrayLike],
        initial: Mapping[str, float],
        sigma: Mapping[str, float] | None,
        options: Mapping[str, Any],
    ) -> None:
        self._model, self._controller, self._scenario = model, controller, scenario
        self._refusal = "the run ends before the first sample"
        self._free = free_names(free, "parameters or states")
        starts = {name: options[name] for name in self._free if name in options and name not in parameters}
        self._parameters, self._initial = {**parameters, **starts}, initial
        t = _grid(data, options)
        self._data = data = data.assign_coords(t=("t", t, data.t.attrs))
        self._options = {name: value for name, value in options.items() if name not in starts}
        self._options |= {"t_end": float(t[-1]), "dt_out": float(t[1])}
        if controller is None:
            self._options["inputs"] = data
        manifest = model.manifest
        known = {q.name: q.unit for q in (*manifest.states, *manifest.outputs)}
        shown = {str(name) for name, array in data.data_vars.items() if array.dims == ("t",)} & known.keys()
        for name, value in (sigma or {}).items():
            if name not in shown:
                raise unknown_name("state or output of the data", name, shown, "sigma")
            number_above(0, name, value, "a number > 0", "sigma")
        self._variables = list(sigma or sorted(shown))
        if not self._variables:
            raise InputError(f"data: must have a state or output of {model.name} over t: {', '.join(sorted(known))}")
        check_units(data, {name: known[name] for name in self._variables}, "data")
        run = self._run({})
        self._known(run)
        if sigma is None:
            _check_variables(data, run)
        start = {**json.loads(run.attrs["parameters"]), **json.loads(run.attrs["initial"])}
        self._start = np.array([float(start[name]) for name in self._free])
        self._scale = np.where(self._start != 0, np.abs(self._start), 1.0)
        self._run(dict(zip(self._free, map(float, self._start), strict=True)))  # refuses free values without effect
        if run.attrs["t_stop"] < float(data.t[-1]) * (1 - 1e-12):
            raise InputError(
                f"the run with the first guess ended early at {run.attrs['t_stop']:.6g} s: {run.attrs['reason']}. "
                f"Set other values of {', '.join(self._free)} to start from, or shorten the data"
            )
        self._measured = {name: np.asarray(data[name].values, float) for name in self._variables}
        if infinite := [name for name, m in self._measured.items() if np.isinf(m).any()]:
            at = float(data.t[int(np.argmax(np.isinf(self._measured[infinite[0]])))])
            raise bad_value("data", f"{infinite[0]} infinite at t = {at:g} s", "finite, or NaN for a missing sample")
        self._kept = np.concatenate([np.isfinite(m) for m in self._measured.values()])
        if empty := [name for name, m in self._measured.items() if not np.isfinite(m).any()]:
            raise bad_value(
                "data",
                f"{empty[0]} without a sample",
                "a dataset with samples of each variable: drop this variable, or name the others in sigma",
            )
        self._sigma = sigma or {name: float(np.nanstd(m)) or 1.0 for name, m in self._measured.items()}
        if np.count_nonzero(self._kept) <= len(self._free):
            raise InputError(
                f"data: {np.count_nonzero(self._kept)} samples cannot determine {len(self._free)} values: give more"
            )

    def _known(self, run: xr.Dataset) -> None:
        """Refuse free names that are unknown, and those that determine the law's sample times."""
        names = {*json.loads(run.attrs["parameters"]), *self._model.state_names}
        law = self._law()
        for name in self._free:
            if name not in names:
                raise unknown_name("parameter or state", name, names, "free")
            if law is not None and name in (law.period, law.delay):
                raise InputError(
                    f"{name}, listed in 'free', cannot be fitted: it determines the sample times of {law.name}"
                )

    def _law(self) -> Controller | None:
        return self._model.manifest.controllers.get(self._controller) if isinstance(self._controller, str) else None

    def _run(self, values: Mapping[str, float]) -> xr.Dataset:
        states = set(self._model.state_names)
        parameters = {**self._parameters, **{k: v for k, v in values.items() if k not in states}}
        initial = {**self._initial, **{k: v for k, v in values.items() if k in states}}
        return simulate(self._model, self._controller, self._scenario, parameters, initial, **self._options)

    def _residuals(self, relative: FloatArray) -> FloatArray:
        """Return the residuals in standard deviations of the noise, with large values for failed or invalid runs."""
        values = self._start + relative * self._scale
        try:
            run = self._run(dict(zip(self._free, map(float, values), strict=True)))
        except InputError as error:  # a trial outside what the model allows, as inertias of no body
            self._refusal = str(error)
            return np.full(np.count_nonzero(self._kept), _FAR)
        parts = []
        for name, measured in self._measured.items():
            computed = np.full(len(measured), np.nan)
            values = np.asarray(run[name].values, float)[: len(measured)]
            computed[: len(values)] = values
            parts.append((computed - measured) / self._sigma[name])
        residuals: FloatArray = np.concatenate(parts)[self._kept]
        return np.where(np.isfinite(residuals), residuals, _FAR)

    def _jacobian(self, relative: FloatArray) -> FloatArray:
        """Return the derivatives of the residuals, (residuals, free), by central differences, one-sided at a bound."""
        columns: list[FloatArray] = []
        low, high = self._bounds()
        for k in range(len(relative)):
            ends: list[tuple[float, FloatArray]] = []
            for sign in (1, -1):
                point = relative.copy()
                point[k] = np.clip(point[k] + sign * _STEP, low[k], high[k])
                ends.append((float(point[k]), self._residuals(point)))
            (above, plus), (below, minus) = ends
            if np.all(plus == _FAR) and np.all(minus == _FAR):
                raise InputError(
                    f"{self._free[k]}, listed in 'free', cannot be fitted: no other value near its first guess is "
                    f"valid: {self._refusal}"
                )
            columns.append((plus - minus) / (above - below))
        return np.stack(columns, axis=1)

    def _directions(self, jacobian: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return orthonormal relative changes, as columns: those that the data see, and all others."""
        rows = {name: math.sqrt(np.nanmean(m**2)) or 1.0 for name, m in self._measured.items()}
        sizes = [np.full(m.shape, rows[name] / self._sigma[name]) for name, m in self._measured.items()]
        errors = _RUN_ERROR / _STEP * np.concatenate(sizes)[self._kept]
        columns = jacobian / errors[:, None]
        norms = np.linalg.norm(columns, axis=0)
        known = norms > math.sqrt(len(errors))
        norms[~known] = 1.0
        _, strengths, combinations = np.linalg.svd(columns * known / norms, full_matrices=False)
        lost = combinations[strengths <= _UNSEEN * strengths[0]] / norms
        basis = np.linalg.qr(lost.T, mode="complete")[0]
        basis *= np.where(basis.sum(axis=0) < 0, -1, 1)
        return basis[:, len(lost) :], basis[:, : len(lost)]

    def _seen_slopes(self, relative: FloatArray) -> FloatArray:
        """Return the Jacobian without slopes along unseen changes, whose errors would move the values."""
        jacobian = self._jacobian(relative)
        seen, _ = self._directions(jacobian)
        projection = seen @ seen.T
        projection[np.abs(projection) < _UNSEEN**2] = 0  # a rounded zero column would be scaled to a unit column
        return jacobian @ projection

    def _is_minimum(self, residuals: FloatArray, jacobian: FloatArray) -> bool:
        """Return True if no seen change of values off their bounds reduces the residuals."""
        inner = jacobian * ~self._at_bound
        seen, _ = self._directions(inner)
        distance = np.linalg.norm(np.linalg.qr(inner @ seen)[0].T @ residuals)
        return bool(distance < _NEAR + _NEAR_OF_MISFIT * np.linalg.norm(residuals) + self._run_error())

    def _run_error(self) -> float:
        """Return the norm of the run's own errors, in standard deviations of the noise."""
        sizes = (float(np.nansum((m / self._sigma[name]) ** 2)) for name, m in self._measured.items())
        return _RUN_ERROR * math.sqrt(sum(sizes))

    def _bounds(self) -> tuple[FloatArray, FloatArray]:
        """Return the bounds of the relative changes, with open bounds moved inwards by a step."""
        manifest, law = self._model.manifest, self._law()
        rows = {q.name: q for q in (*manifest.parameters, *manifest.scenario_parameters)}
        rows |= {} if law is None else {q.name: q for q in law.parameters}
        low, high = np.full(len(self._free), -np.inf), np.full(len(self._free), np.inf)
        for k, name in enumerate(self._free):
            if (row := rows.get(name)) is not None and name not in self._model.state_names:
                low[k] = (row.lower - self._start[k]) / self._scale[k] + _STEP * row.lower_open
                high[k] = (row.upper - self._start[k]) / self._scale[k] - _STEP * row.upper_open
        return np.minimum(low, 0), np.maximum(high, 0)

    def solve(self, start: FloatArray | None = None) -> FloatArray:
        """Return the relative changes of the free values that minimise the residuals."""
        from scipy.optimize import least_squares

        low, high = self._bounds()
        x0 = np.zeros(len(self._free)) if start is None else start
        tight = low >= high
        if tight.any():
            raise bad_value("free", self._free[int(np.argmax(tight))], "a parameter with wider bounds")
        inside = np.clip(x0, low + 1e-9 * (x0 <= low), high - 1e-9 * (x0 >= high))
        result = least_squares(
            self._residuals,
            inside,
            self._seen_slopes,
            bounds=(low, high),
            x_scale="jac",
            xtol=1e-12,
            ftol=1e-12,
            gtol=1e-12,
        )
        self._converged = bool(result.success)
        self._at_bound = np.asarray(result.active_mask, bool)
        return np.asarray(result.x, float)

    def estimate_sigma(self, relative: FloatArray) -> None:
        """Estimate the standard deviations of the noise from the residuals."""
        rows = self._by_variable(self._residuals(relative))
        samples = int(np.count_nonzero(self._kept))
        share = samples / (samples - len(self._free))
        self._sigma = {
            name: (float(np.sqrt(np.mean(rows[name] ** 2) * share)) or 1.0) * self._sigma[name] for name in rows
        }

    def _by_variable(self, residuals: FloatArray) -> dict[str, FloatArray]:
        rows: dict[str, FloatArray] = {}
        first = 0
        for name, measured in self._measured.items():
            count = int(np.count_nonzero(np.isfinite(measured)))
            rows[name] = residuals[first : first + count]
            first += count
        return rows

    def _check_flat(self, relative: FloatArray, residuals: FloatArray, directions: FloatArray) -> None:
        """Refuse combinations of parameters that affect the data but have zero slope."""
        for direction in directions.T:
            for step in (_FLAT * direction, -_FLAT * direction):
                moved = self._residuals(np.clip(relative + step, *self._bounds()))
                if np.linalg.norm((moved - residuals)[moved < _FAR]) > 1 + self._run_error():
                    name = self._free[int(np.argmax(np.abs(direction)))]
                    raise InputError(
                        f"{name}, listed in 'free', cannot be fitted: only large changes of it affect the data, "
                        "as of a time between two samples. Leave it out, or start from another value"
                    )

    def result(self, relative: FloatArray, known_noise: bool) -> Fit:
        """Return estimates, covariance and tests of the residuals."""
        from scipy.stats import chi2, norm

        residuals, jacobian = self._residuals(relative), self._jacobian(relative)
        seen, unseen = self._directions(jacobian)
        self._check_flat(relative, residuals, unseen)
        root = seen @ np.linalg.pinv(jacobian @ seen, rcond=0)
        covariance = root @ root.T * np.outer(self._scale, self._scale)
        lost = (np.abs(unseen) > 1e-3).any(axis=1)
        covariance[lost, lost] = math.inf
        freedom = len(residuals) - len(self._free)
        correlation = {}
        for name, row in self._by_variable(residuals).items():
            power = float(row @ row)
            lag = float(row[1:] @ row[:-1]) / power if power > 0 and len(row) > 2 else 0.0
            correlation[name] = float(2 * norm.sf(abs(lag) * math.sqrt(len(row))))
        values = self._start + relative * self._scale
        run = self._run(dict(zip(self._free, map(float, values), strict=True)))
        if run.sizes["t"] < self._data.sizes["t"]:
            raise InputError(
                f"the run with the estimates ended early at {run.attrs['t_stop']:.6g} s: {run.attrs['reason']}"
            )
        return Fit(
            names=self._free,
            values=values,
            covariance=covariance,
            sigma=dict(self._sigma),
            unseen=tuple(
                {name: float(w) for name, w in zip(self._free, row, strict=True) if abs(w) > 1e-3} for row in unseen.T
            ),
            misfit=float(chi2.sf(residuals @ residuals, freedom)) if known_noise else math.nan,
            correlation=correlation,
            converged=self._converged and self._is_minimum(residuals, jacobian),
            bounded=tuple(name for name, at in zip(self._free, self._at_bound, strict=True) if at),
            run=run,
        )


def free_names(free: Sequence[str], what: str) -> tuple[str, ...]:
    """Return the names of free values; refuse anything but different texts."""
    if not isinstance(free, list | tuple) or not free or not all(isinstance(name, str) for name in free):
        raise bad_value("free", free, f"a list of names of {what}, at least one")
    if twice := {name for name in free if list(free).count(name) > 1}:
        raise InputError(f"free: {min(twice)} is given twice")
    return tuple(free)


def _check_variables(data: xr.Dataset, run: xr.Dataset) -> None:
    """Refuse a variable of the data over t that no run has."""
    names = [str(name) for name, array in run.data_vars.items() if array.dims == ("t",)]
    for name, array in data.data_vars.items():
        if array.dims == ("t",) and name not in names:
            note = "leave it out, or name the variables to compare in sigma"
            raise unknown_name("variable of the data", name, names, note=note)


def _grid(data: xr.Dataset, options: Mapping[str, Any]) -> FloatArray:
    """Return the instants of the data without rounding."""
    for name in ("t_end", "dt_out", "inputs"):
        if name in options:
            raise bad_value(name, options[name], "left out: the data determine it")
    if not hasattr(data, "data_vars") or "t" not in data.coords or data.sizes["t"] < 2:
        raise bad_value("data", type(data).__name__, "an xarray.Dataset with two or more samples over t")
    check_units(data, {"t": "s"}, "data")
    single = data.t.dtype == np.float32
    t = np.asarray(data.t.values, float)
    step = float(t[-1]) / (len(t) - 1)
    errors = np.abs(t - step * np.arange(len(t)))
    rounding = np.finfo(np.float32).eps * t[-1] if single else 0.0
    if not (step > 0 and (errors <= max(1e-6 * step, rounding)).all()):
        k = int(np.argmax(errors))
        raise bad_value("t", f"{t[k]:.12g} at sample {k}", f"at 0, DT, 2 DT, ..., {t[-1]:.6g}: resample", "data")
    return multiples(fraction(float(f"{step:.6g}" if single else f"{step:.12g}")), len(t))
