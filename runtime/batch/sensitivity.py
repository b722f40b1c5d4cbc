# SPDX-License-Identifier: Apache-2.0
"""How much of a metric's scatter each drawn value explains."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from .sampling import FloatArray
from .statistics import column, drawn_names, metric_names
from .store import Store


@dataclass(frozen=True)
class Sensitivity:
    """Shares of one metric's scatter.

    Attributes
    ----------
    metric : str
        Which.
    kind : {"sobol", "regression"}
        Sobol indices of each dispersion, or standardised regression coefficients of each drawn value.
    first : mapping of str to float
        First-order index, or coefficient: the change of the metric in its standard deviations for one of the drawn
        value's.
    total : mapping of str to float
        Total index; empty for a regression.
    explained : float
        Share of the variance that the regression explains, R^2; the sum of the first-order indices.
    runs : int
        Runs that count.
    """

    metric: str
    kind: str
    first: Mapping[str, float]
    total: Mapping[str, float]
    explained: float
    runs: int


def sensitivities(store: Store) -> list[Sensitivity]:
    """Return the sensitivities of every metric that scatters.

    A complete store with the design saltelli gives first-order and total Sobol indices (Saltelli et al. 2010) of each
    metric that is finite in all runs; everything else standardised regression coefficients over the runs in which
    the metric is finite.
    """
    if not drawn_names(store):
        return []
    campaign = json.loads(store.attributes["campaign"])
    whole = len(store.stored()) == store.blocks()
    factors = [tuple(name.strip() for name in names.split(",")) for names in sorted(campaign["vary"])]
    result = []
    for name in metric_names(store):
        values = column(store, name) if campaign["sampling"] == "saltelli" and whole else np.array([np.nan])
        indices = _sobol(name, values, factors) if np.isfinite(values).all() else _regression(store, name)
        if indices is not None:
            result.append(indices)
    return result


def _sobol(metric: str, values: FloatArray, factors: list[tuple[str, ...]]) -> Sensitivity | None:
    from scipy.stats import sobol_indices

    if not np.ptp(values) > 0:
        return None
    pages = values.reshape(-1, len(factors) + 2).T
    shaped = {"f_A": pages[:1], "f_B": pages[1:2], "f_AB": pages[2:, None, :]}
    indices = sobol_indices(func=shaped, n=pages.shape[1])
    names = [", ".join(factor) for factor in factors]
    return Sensitivity(
        metric=metric,
        kind="sobol",
        first=dict(zip(names, map(float, indices.first_order.ravel()), strict=True)),
        total=dict(zip(names, map(float, indices.total_order.ravel()), strict=True)),
        explained=float(indices.first_order.sum()),
        runs=values.size,
    )


def _regression(store: Store, metric: str) -> Sensitivity | None:
    """Return standardised coefficients by least squares, from sums over blocks."""
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
    correlation = covariance[np.ix_([*moving, -1], [*moving, -1])] / np.outer(sd[[*moving, -1]], sd[[*moving, -1]])
    coefficients = np.linalg.lstsq(correlation[:-1, :-1], correlation[:-1, -1])[0]
    return Sensitivity(
        metric=metric,
        kind="regression",
        first={names[i]: float(b) for i, b in zip(moving, coefficients, strict=True)},
        total={},
        explained=float(coefficients @ correlation[:-1, -1]),
        runs=runs,
    )
