# SPDX-License-Identifier: Apache-2.0
"""Dispersions: distributions of parameters and states, as in `m1 = "normal(50, 2)"`.

Each distribution maps numbers in (0, 1) to values by its quantile function, so that any sampling design works.
Results are bit-identical on all machines.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from mehvar.base.errors import InputError, bad_value, unknown_name

from ..arguments import parsed
from ..units import distribution
from .sampling import FloatArray, exponential, normal_quantile

Quantile = Callable[[FloatArray], FloatArray]
"""Function from points of the unit cube to values, both of shape (n, d)."""


@dataclass(frozen=True)
class Dispersion:
    """Names and their joint distribution.

    Attributes
    ----------
    names : tuple of str
        Parameters or initial states.
    quantile : callable
        The quantile of the distribution.
    text : str
        The distribution as it was written.
    listed : int
        Number of listed values, one for each run; 0 for a distribution.
    """

    names: tuple[str, ...]
    quantile: Quantile
    text: str
    listed: int = 0

    @property
    def of_vector(self) -> bool:
        """True for a vector with a length: its components share one unit."""
        return self.text.startswith("sphere")

    def centre(self) -> dict[str, float]:
        """Return the values at the centre of the unit cube; a vector points along its last axis."""
        u = np.full((1, len(self.names)), 0.5)
        if self.of_vector:
            u[0, -1] = 0.6  # at 0.5 all components are zero, and a zero vector has no direction
        return dict(zip(self.names, map(float, self.quantile(u)[0]), strict=True))


def read_dispersions(
    vary: Mapping[str, str], origin: str = "vary", written: Mapping[str, str] | None = None
) -> tuple[Dispersion, ...]:
    """Read distributions by name.

    Parameters
    ----------
    vary : mapping of str to str
        A name, or several names with commas between them, to a text: normal(mean, sd), uniform(low, high),
        lognormal(mu, sigma), triangular(low, mode, high), choice(value, ...), or values(value, ...) with one value for
        each run; for several names normal([means], [rows of the covariance matrix]) or sphere(radius).
    origin : str
        Origin of the texts in error messages.
    written : mapping of str to str, optional
        The texts as the user wrote them, for error messages.

    Raises
    ------
    InputError
        If a text cannot be read, arguments define no distribution, or a name occurs twice.
    """
    for names, text in vary.items():
        if not isinstance(text, str):
            raise bad_value(names, text, 'a text such as "normal(50, 2)"', origin)
    dispersions = [_read(names, text, origin, (written or vary)[names]) for names, text in vary.items()]
    flat = [name for dispersion in dispersions for name in dispersion.names]
    twice = [name for name in flat if flat.count(name) > 1]
    if twice:
        raise InputError(f"{twice[0]} is given twice (from {origin})")
    return tuple(dispersions)


def in_units(vary: Mapping[str, str], units: Mapping[str, str], origin: str) -> dict[str, str]:
    """Return distributions in the units of their variables.

    Raises
    ------
    InputError
        As of `read_dispersions` and of units; with the text as it was written.
    """
    result = {names: distribution(names, text, units, origin) for names, text in vary.items()}
    read_dispersions({names: text for names, text in result.items() if text != vary[names]}, origin, vary)
    return result


class _RefusedError(ValueError):
    """Error for arguments that do not define a distribution."""


def _normal(names: int, mean: float, sd: float) -> Quantile:
    _require(names == 1 and sd > 0)
    return lambda u: mean + sd * normal_quantile(u)


def _uniform(names: int, low: float, high: float) -> Quantile:
    _require(names == 1 and low < high and math.isfinite(high - low))
    return lambda u: low + (high - low) * u


def _lognormal(names: int, mu: float, sigma: float) -> Quantile:
    _require(names == 1 and sigma > 0)
    return lambda u: exponential(mu + sigma * normal_quantile(u))


def _triangular(names: int, low: float, mode: float, high: float) -> Quantile:
    """Return the quantile function of a triangular distribution; refuse one whose width is infinite or zero."""
    _require(names == 1 and low <= mode <= high and low < high)
    width, rise, fall = high - low, mode - low, high - mode
    _require(math.isfinite(width * width))

    def quantile(u: FloatArray) -> FloatArray:
        below, above = low + np.sqrt(u * width * rise), high - np.sqrt((1 - u) * width * fall)
        return np.where(u * width < rise, below, above)

    return quantile


def _choice(names: int, *values: float) -> Quantile:
    _require(names == 1 and len(values) > 0)
    each = np.array(values)
    return lambda u: each[np.floor(u * each.size).astype(np.intp)]


def _sphere(names: int, radius: float = 1.0) -> Quantile:
    """Return uniform directions from normal numbers: Muller, Communications of the ACM 2 (1959)."""
    _require(names >= 2 and radius > 0)

    def quantile(u: FloatArray) -> FloatArray:
        z = normal_quantile(u)
        square = np.zeros(len(u))
        for k in range(names):
            square = square + z[:, k] * z[:, k]
        return z * (radius / np.sqrt(square))[:, None]

    return quantile


def _correlated(names: int, means: tuple[float, ...], covariance: tuple[tuple[float, ...], ...]) -> Quantile:
    """Return the quantile function of correlated normal numbers, by the Cholesky factor of their covariance."""
    _require(names == len(means) == len(covariance) and all(len(row) == names for row in covariance))
    _require(all(covariance[i][j] == covariance[j][i] for i in range(names) for j in range(i)))
    factor = _cholesky(covariance)

    def quantile(u: FloatArray) -> FloatArray:
        z = normal_quantile(u)
        values = np.empty_like(z)
        for i, (mean, row) in enumerate(zip(means, factor, strict=True)):
            values[:, i] = mean
            for k, weight in enumerate(row):
                values[:, i] += weight * z[:, k]
        return values

    return quantile


def _cholesky(matrix: tuple[tuple[float, ...], ...]) -> list[list[float]]:
    """Return the rows of the lower Cholesky factor, without LAPACK, whose last digits depend on the machine."""
    rows: list[list[float]] = []
    for i, entries in enumerate(matrix):
        row: list[float] = []
        for j in range(i):
            row.append((entries[j] - sum(row[k] * rows[j][k] for k in range(j))) / rows[j][j])
        square = entries[i] - sum(a * a for a in row)
        _require(square > 0)
        rows.append([*row, math.sqrt(square)])
    return rows


def _require(condition: bool) -> None:
    if not condition:
        raise _RefusedError


_KINDS: Mapping[str, tuple[Callable[..., Quantile], str]] = {
    "normal": (_normal, "normal(mean, sd) with sd > 0, for one name"),
    "uniform": (_uniform, "uniform(low, high) with low < high, for one name"),
    "lognormal": (_lognormal, "lognormal(mu, sigma) of the logarithm with sigma > 0, for one name"),
    "triangular": (_triangular, "triangular(low, mode, high) with low <= mode <= high, low < high, for one name"),
    "choice": (_choice, "choice(value, ...), for one name"),
    "values": (_choice, "values(value, ...), for one name, one value for each run"),
    "sphere": (_sphere, "sphere(radius) with radius > 0, for the two or more components of a vector"),
}
_MULTIVARIATE = "normal([means], [rows of a positive definite covariance matrix]), as many as there are names"


def _read(names: str, text: str, origin: str, written: str) -> Dispersion:
    """Return the dispersion that a text describes; `names` are one name or several with commas."""
    targets = tuple(name.strip() for name in names.split(","))
    kind, arguments, keywords = _call(names, text, origin, written)
    if kind not in _KINDS:
        raise unknown_name(f"distribution of {names}", kind, _KINDS, origin)
    make, usage = _KINDS[kind]
    if kind == "normal" and len(targets) > 1:
        make, usage = _correlated, _MULTIVARIATE
    try:
        _require(make is _correlated or all(isinstance(a, float) for a in (*arguments, *keywords.values())))
        quantile = make(len(targets), *arguments, **keywords)
    except (TypeError, _RefusedError):
        raise bad_value(names, written, f"{usage}", origin) from None
    return Dispersion(targets, quantile, text.strip(), len(arguments) if kind == "values" else 0)


def _call(names: str, text: str, origin: str, written: str) -> tuple[str, list[object], dict[str, object]]:
    """Return name and arguments of a call in Python syntax; lists become tuples of floats."""
    try:
        call = parsed(text.strip())
        if not isinstance(call, ast.Call) or not isinstance(call.func, ast.Name):
            raise ValueError
        arguments = [_numbers(ast.literal_eval(argument)) for argument in call.args]
        keywords = {str(k.arg): _numbers(ast.literal_eval(k.value)) for k in call.keywords}
    except (AttributeError, ValueError, TypeError, OverflowError, MemoryError, RecursionError):
        raise bad_value(names, written, "a distribution with numbers, as in normal(50, 2)", origin) from None
    return call.func.id, arguments, keywords


def _numbers(value: object) -> object:
    if isinstance(value, Sequence) and not isinstance(value, str):
        return tuple(_numbers(item) for item in value)
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise ValueError
    return float(value)
