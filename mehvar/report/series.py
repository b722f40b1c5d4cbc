# SPDX-License-Identifier: Apache-2.0
"""Series for a page, reduced to visible samples and encoded as compact text."""

from __future__ import annotations

import base64
from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]
_FAR = 1e9
"""Substitute for values that are not finite, large enough to keep the sample and its neighbours."""

TOLERANCE = 3e-4
"""Largest distance of an omitted sample from the line through kept samples, relative to the series' range.

This is a third of a pixel in a chart 1000 pixels high, so no visible sample is omitted.
"""


def thin(t: ArrayLike, columns: ArrayLike, tolerance: float = TOLERANCE) -> NDArray[np.intp]:
    """Return the samples whose connecting lines represent every column (Ramer 1972, Douglas 1973).

    Parameters
    ----------
    t : array_like, (n,)
        Increasing sample times.
    columns : array_like, (n, m)
        Series over `t`. A sample that is not finite is kept.
    tolerance : float
        Relative to the range of each column.

    Returns
    -------
    array of int
        Indices in order; the first and the last sample are among them.
    """
    x, y = np.asarray(t, dtype=float), np.asarray(columns, dtype=float).reshape(len(np.asarray(t)), -1)
    scaled = np.column_stack([_scaled(column) for column in y.T])
    keep = np.zeros(len(x), dtype=bool)
    keep[[0, -1]] = True
    parts = [(0, len(x) - 1)]
    while parts:
        first, last = parts.pop()
        if last - first < 2:
            continue
        inside = slice(first + 1, last)
        share = (x[inside] - x[first]) / (x[last] - x[first])
        line = scaled[first] + share[:, None] * (scaled[last] - scaled[first])
        off = np.abs(scaled[inside] - line).max(axis=1)
        worst = int(np.argmax(off))
        if off[worst] > tolerance:
            middle = first + 1 + worst
            keep[middle] = True
            parts += [(first, middle), (middle, last)]
    return np.flatnonzero(keep)


def _scaled(column: FloatArray) -> FloatArray:
    """Return a column relative to its range, with very large numbers for values that are not finite."""
    finite = column[np.isfinite(column)]
    span = float(np.ptp(finite)) if finite.size else 0.0
    return np.where(np.isfinite(column), column / (span or 1.0), _FAR)


def encode(values: ArrayLike) -> str:
    """Return numbers as base64 of 32-bit little-endian floats."""
    return base64.b64encode(np.asarray(values, dtype="<f4").tobytes()).decode("ascii")


def track(t: ArrayLike, columns: Mapping[str, ArrayLike]) -> dict[str, object]:
    """Return reduced series with a common time, encoded: {"t": text, "columns": {name: text}}."""
    values = np.column_stack([np.asarray(column, dtype=float) for column in columns.values()])
    kept = thin(t, values)
    encoded = {name: encode(values[kept, k]) for k, name in enumerate(columns)}
    return {"t": encode(np.asarray(t)[kept]), "columns": encoded}
