# SPDX-License-Identifier: Apache-2.0
"""Sensitivities: share of a metric's variance that each drawn value explains."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ...run.options import RunOptions
from ..sampling import FloatArray
from ..store.dataset import Batch
from .statistics import CONFIDENCE, column, drawn_names, metric_names

_RESAMPLES = 999
"""Bootstrap resamples, as in SciPy: an interval ends at the 25th and the 975th value. For normal scatter its ends
have a standard deviation of 2 % of its width; with half as many 3 %, with twice as many 1.5 %."""
_LEAST_GROUPS = 16
"""Smallest number of groups with reliable bootstrap intervals. In 150 tests, intervals contained the index in all
cases with 32 groups, at least 97 % with 16, 79 % with 8, 61 % with 4.
"""

_ERROR = 100
"""Error of a metric relative to the tolerance of a step: final errors were 4 to 600 times the tolerance (numerics.md,
known-limits.md). Half or twice this value changes the verdict on scatter between 5e-10 and 2e-9 of a metric, at
default tolerances."""


KINDS = {
    "sobol": "Sobol indices, first order / total, with 95 % intervals: shares of the variance",
    "regression": "sensitivities: standardised regression coefficients with 95 % intervals",
}
"""Kinds of sensitivities in words."""


@dataclass(frozen=True)
class Share:
    """A sensitivity with its 95 % interval; NaN if undetermined.

    Attributes
    ----------
    value, low, high : float
        Estimate and ends of its interval.
    """

    value: float
    low: float
    high: float

    @property
    def determined(self) -> bool:
        """True if the interval excludes a part of the possible range."""
        return self.high - self.low < 1

    def __str__(self) -> str:
        """Return the value with its interval."""
        if not self.determined:
            return "undetermined"
        value, low, high = (f"{round(number, 3) + 0.0:.3f}" for number in (self.value, self.low, self.high))
        return f"{value} [{low}, {high}]"


UNDETERMINED = Share(math.nan, math.nan, math.nan)


@dataclass(frozen=True)
class Sensitivity:
    """Sensitivities of one metric to the drawn values.

    Attributes
    ----------
    metric : str
        The metric.
    kind : {"sobol", "regression"}
        Sobol indices of each dispersion, or standardised regression coefficients of each drawn value.
    first : mapping of str to Share
        First-order index, or regression coefficient in standard deviations of metric and drawn value. Undetermined if
        the metric scatters only by its integration error.
    total : mapping of str to Share
        Total index; empty for a regression.
    explained : float
        Share of the variance that the regression explains, R^2; the sum of the first-order indices.
    runs : int
        Number of runs used.
    """

    metric: str
    kind: str
    first: Mapping[str, Share]
    total: Mapping[str, Share]
    explained: float
    runs: int

    def text(self, name: str) -> str:
        """Return the share of a drawn value as text; for Sobol indices, first-order and total."""
        shares = [str(group[name]) for group in (self.first, self.total) if name in group]
        return " / ".join(shares) or "-"

    @property
    def explained_text(self) -> str:
        """Return the explained share of the variance; "-" if a share is undetermined."""
        return f"{self.explained:.3f}" if all(share.determined for share in self.first.values()) else "-"


def tables(items: Sequence[Sensitivity]) -> Iterator[tuple[str, list[str], list[tuple[str, ...]]]]:
    """Yield the kind, heads and rows of a table for each kind of sensitivity that occurs."""
    for kind in KINDS:
        group = [item for item in items if item.kind == kind]
        names = list(dict.fromkeys(name for item in group for name in item.first))
        rows = [(item.metric, *map(item.text, names), item.explained_text, str(item.runs)) for item in group]
        if rows:
            yield kind, ["metric", *names, "R^2" if kind == "regression" else "sum", "runs"], rows


def sensitivities(store: Batch) -> list[Sensitivity]:
    """Return the sensitivities of all metrics that scatter.

    A complete store with the design saltelli gives first-order and total Sobol indices (Saltelli et al. 2010) of each
    metric that is finite in all runs, with bootstrap intervals over the groups of the design. Any other store or
    metric gives standardised regression coefficients over the runs in which the metric is finite, with least-squares
    intervals.
    """
    if not drawn_names(store):
        return []
    campaign = json.loads(store.attributes["campaign"])
    whole = len(store.stored()) == store.blocks()
    factors = [tuple(name.strip() for name in names.split(",")) for names in sorted(campaign["vary"])]
    result = []
    for name in metric_names(store):
        values = column(store, name)
        rounding = _rounding(values, campaign.get("options", {}))
        complete = campaign["sampling"] == "saltelli" and whole and bool(np.isfinite(values).all())
        indices = _sobol(name, values, factors, rounding) if complete else _regression(store, name, rounding)
        if indices is not None:
            result.append(indices)
    return result


def _rounding(values: FloatArray, options: Mapping[str, float]) -> float:
    """Return the standard deviation that integration errors can cause."""
    defaults = RunOptions()
    finite = np.abs(values[np.isfinite(values)])
    largest = float(finite.max()) if finite.size else 0.0
    return _ERROR * (float(options.get("atol", defaults.atol)) + float(options.get("rtol", defaults.rtol)) * largest)


def _sobol(metric: str, values: FloatArray, factors: list[tuple[str, ...]], rounding: float) -> Sensitivity | None:
    """Return the Sobol indices of a metric over a complete design; None if the metric is constant."""
    if not np.ptp(values) > 0:
        return None
    pages = values.reshape(-1, len(factors) + 2)
    names = [", ".join(factor) for factor in factors]
    products = _products(pages)
    first, total = _indices(products.sum(axis=0, keepdims=True), len(pages))
    if values.std() <= rounding or len(pages) < _LEAST_GROUPS:
        nothing = dict.fromkeys(names, UNDETERMINED)
        return Sensitivity(metric, "sobol", nothing, nothing, math.nan, values.size)
    firsts, totals = _indices(_resampled(products), len(pages))
    return Sensitivity(
        metric=metric,
        kind="sobol",
        first=dict(zip(names, _shares(first[0], firsts), strict=True)),
        total=dict(zip(names, _shares(total[0], totals), strict=True)),
        explained=float(first.sum()),
        runs=values.size,
    )


def _products(pages: FloatArray) -> FloatArray:
    """Return the terms of variance and indices for each group A, B, then A with one factor of B each."""
    centred = pages - pages[:, :2].mean()
    a, b, mixed = centred[:, :1], centred[:, 1:2], centred[:, 2:]
    return np.hstack([a + b, a * a + b * b, b * (mixed - a), (a - mixed) ** 2 / 2])


def _indices(sums: FloatArray, groups: int) -> tuple[FloatArray, FloatArray]:
    """Return first-order and total indices of each row of `_products`: Saltelli et al. 2010 (b) and (f)."""
    variance = sums[:, 1:2] / (2 * groups) - (sums[:, :1] / (2 * groups)) ** 2
    with np.errstate(divide="ignore", invalid="ignore"):
        indices = sums[:, 2:] / groups / variance
    first, total = np.hsplit(indices, 2)
    return first, total


def _resampled(products: FloatArray) -> FloatArray:
    """Return reproducible sums over groups drawn with replacement, one row per draw."""
    draws, n = np.random.Generator(np.random.Philox(0)), len(products)
    counts = (np.bincount(draws.integers(n, size=n), minlength=n) for _ in range(_RESAMPLES))
    return np.stack([times @ products for times in counts])


def _shares(values: FloatArray, resampled: FloatArray) -> list[Share]:
    tail = (1 - CONFIDENCE) / 2
    low, high = np.quantile(resampled, (tail, 1 - tail), axis=0)
    return [Share(float(v), float(a), float(b)) for v, a, b in zip(values, low, high, strict=True)]


def _regression(store: Batch, metric: str, rounding: float) -> Sensitivity | None:
    """Return standardised coefficients by least squares, from sums over blocks."""
    from scipy.special import stdtrit

    names = drawn_names(store)
    sums, centre = np.zeros((len(names) + 2, len(names) + 2)), np.zeros(len(names) + 1)
    for block in store.stored():
        columns = [store.read(name, [block]) for name in (*names, metric)]
        rows = np.stack(columns, axis=1)
        rows = rows[np.isfinite(rows).all(axis=1)]
        if rows.size and not sums[0, 0]:
            centre = rows.mean(axis=0)
        rows = np.column_stack([np.ones(len(rows)), rows - centre])
        sums += rows.T @ rows
    runs = int(sums[0, 0])
    if runs < len(names) + 2:
        return None
    mean = sums[0, 1:] / runs
    covariance = sums[1:, 1:] / runs - np.outer(mean, mean)
    sd = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    moving = np.flatnonzero(sd[:-1] > 0)
    if not sd[-1] > 0 or not moving.size:
        return None
    if sd[-1] <= rounding:
        nothing = dict.fromkeys((names[i] for i in moving), UNDETERMINED)
        return Sensitivity(metric, "regression", nothing, {}, math.nan, runs)
    correlation = covariance[np.ix_([*moving, -1], [*moving, -1])] / np.outer(sd[[*moving, -1]], sd[[*moving, -1]])
    own, common = correlation[:-1, :-1], correlation[:-1, -1]
    coefficients = np.linalg.lstsq(own, common, rcond=None)[0]
    explained = float(coefficients @ common)
    spread = np.diag(np.linalg.pinv(own)) * max(1 - explained, 0.0) / (runs - moving.size - 1)
    reach = stdtrit(runs - moving.size - 1, (1 + CONFIDENCE) / 2) * np.sqrt(spread)
    shares = (Share(float(b), float(b - d), float(b + d)) for b, d in zip(coefficients, reach, strict=True))
    return Sensitivity(
        metric=metric,
        kind="regression",
        first=dict(zip((names[i] for i in moving), shares, strict=True)),
        total={},
        explained=explained,
        runs=runs,
    )
