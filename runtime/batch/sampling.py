# SPDX-License-Identifier: Apache-2.0
"""Points of the unit cube for runs. The point of run i does not depend on the division of a batch.

Random numbers are counter-based (Philox), with one stream per seed and name, of which run i uses number i.
"""

from __future__ import annotations

import ctypes
import functools
import hashlib
import threading
import warnings
from collections.abc import Sequence
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from mehvar.base.errors import InputError, bad_value, either

from ..compiling.library import load_library, native_headers, native_sources

FloatArray = NDArray[np.float64]
WordArray = NDArray[np.uint64]
Design = Literal["random", "latin", "sobol", "saltelli"]

DESIGNS: tuple[Design, ...] = get_args(Design)
OPEN_DESIGNS: tuple[Design, ...] = ("random", "sobol")  # the first runs do not depend on n
_BLOCK = 4  # words that Philox makes per counter value
_ROUNDS = 8
"""Number of rounds of the permutation. Four make it pseudorandom for large halves (Luby and Rackoff 1988), eight also
for halves of a few bits. Fewer would relate the strata of neighbouring runs.
"""
_SOBOL_BITS = 32
"""Number of binary digits of a point, and of the number of points: 4e9 runs. Half a cell is added, so no point is 0."""
_SOBOL_LOCK = threading.Lock()


class Sampler:
    """Points of the unit cube, one row per run, one column per dimension.

    Parameters
    ----------
    design : str
        One of `DESIGNS`: independent numbers; a Latin hypercube of n runs; a scrambled Sobol sequence; or groups of
        runs for variance based sensitivities (Saltelli 2010): a point A, a point B, and A with one factor at a time
        from B.
    factors : sequence of tuple of str
        Names of the dimensions; names that vary together share a tuple.
    n : int
        Runs of the whole batch.
    seed : int
        The same seed gives the same points.

    Raises
    ------
    InputError
        If the design is unknown or n is invalid for it.
    """

    def __init__(self, design: Design, factors: Sequence[tuple[str, ...]], n: int, seed: int) -> None:
        if design not in DESIGNS:
            raise bad_value("sampling", design, either(DESIGNS))
        self._design = design
        self._factors = factors
        self._names = [name for factor in factors for name in factor]
        self._n, self._seed = n, seed
        if design == "saltelli":
            _check_groups(n, len(factors))

    def points(self, first: int, count: int) -> FloatArray:
        """Return the points of `count` runs from `first` on, shape (count, dimensions), strictly between 0 and 1."""
        if not self._names:
            return np.empty((count, 0))
        if self._design == "sobol":
            return self._sobol(first, count, len(self._names))
        if self._design == "saltelli":
            return self._saltelli(first, count)
        columns = [self._column(name, first, count) for name in self._names]
        return np.stack(columns, axis=1)

    def _column(self, name: str, first: int, count: int) -> FloatArray:
        inside = uniforms(self._seed, name, first, count)
        if self._design == "random":
            return inside
        runs = np.arange(first, first + count, dtype=np.uint64)
        stratum = permuted(runs, self._n, stream(self._seed, f"{name} order"))
        result: FloatArray = (stratum + inside) / self._n
        return np.minimum(result, 1 - 2.0**-53)  # the last stratum may be rounded up to 1

    def _saltelli(self, first: int, count: int) -> FloatArray:
        """Return for each group the rows A, B, then A with each factor from B."""
        size = len(self._factors) + 2
        groups, member = np.divmod(np.arange(first, first + count), size)
        d = len(self._names)
        pairs = self._sobol(int(groups[0]), int(groups[-1] - groups[0]) + 1, 2 * d)[groups - groups[0]]
        a, b = pairs[:, :d], pairs[:, d:]
        factor_of = np.repeat(np.arange(len(self._factors)), [len(factor) for factor in self._factors])
        from_b = (member[:, None] == 1) | (member[:, None] == factor_of + 2)
        result: FloatArray = np.where(from_b, b, a)
        return result

    def _sobol(self, first: int, count: int, dimensions: int) -> FloatArray:
        """Return points of the scrambled Sobol sequence, (count, dimensions), moved off zero by half a step."""
        engine = _sobol_engine(self._seed, dimensions)
        with _SOBOL_LOCK, warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # it concerns a piece of the sequence, not the whole
            if engine.num_generated > first:
                engine.reset()
            if engine.num_generated < first:
                engine.fast_forward(first - engine.num_generated)
            points: FloatArray = engine.random(count)
        return points + 2.0 ** -(_SOBOL_BITS + 1)


def stream(seed: int, name: str) -> np.random.Philox:
    """Return the generator of a seed and a name; its key differs from those of measurement noise in the highest bit."""
    word = int.from_bytes(hashlib.blake2b(name.encode(), digest_size=8).digest(), "little") | 1 << 63
    return np.random.Philox(key=np.array([seed, word], dtype=np.uint64))


def uniforms(seed: int, name: str, first: int, count: int) -> FloatArray:
    """Return uniform numbers of runs from `first` on, odd multiples of 2^-53 and never 0 or 1."""
    skip = first % _BLOCK
    words = stream(seed, name).advance(first // _BLOCK).random_raw(skip + count)[skip:]
    return ((words >> np.uint64(12)).astype(np.float64) + 0.5) * 2.0**-52


def permuted(values: WordArray, n: int, keys: np.random.Philox) -> WordArray:
    """Return a pseudorandom permutation of 0..n-1 at the given values.

    A balanced Feistel network over the next even power of two; results outside 0..n-1 pass through it again.
    """
    half = np.uint64(max(1, ((n - 1).bit_length() + 1) // 2))
    mask = (np.uint64(1) << half) - np.uint64(1)
    rounds = keys.random_raw(_ROUNDS)
    result = _feistel(values, half, mask, rounds)
    while (outside := result >= n).any():
        result[outside] = _feistel(result[outside], half, mask, rounds)
    return result


def _feistel(values: WordArray, half: np.uint64, mask: np.uint64, rounds: WordArray) -> WordArray:
    left, right = values >> half, values & mask
    for key in rounds:
        left, right = right, left ^ (_mixed(right ^ key) & mask)
    return (left << half) | right


def _mixed(word: WordArray) -> WordArray:
    """Return the final mixing function of SplitMix64 (Steele, Lea, Flood 2014)."""
    word = (word ^ (word >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    word = (word ^ (word >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return word ^ (word >> np.uint64(31))


def normal_quantile(u: FloatArray) -> FloatArray:
    """Return the standard normal quantile of numbers in (0, 1), bit-identical on all machines."""
    return _elementwise("mv_normal_quantile", u)


def exponential(x: FloatArray) -> FloatArray:
    """Return e to the power x, bit-identical on all machines."""
    return _elementwise("mv_exponential", x)


def _elementwise(function: str, values: FloatArray) -> FloatArray:
    array = np.ascontiguousarray(values)
    result = np.empty_like(array)
    pointer = ctypes.c_void_p
    call = getattr(_library(), function)
    call(ctypes.c_int64(array.size), pointer(array.ctypes.data), pointer(result.ctypes.data))
    return result


@functools.cache
def _library() -> ctypes.CDLL:
    sources = native_headers() | native_sources("random/quantile.c")
    return load_library("quantile", sources, ["quantile.c"])


@functools.lru_cache(maxsize=4)
def _sobol_engine(seed: int, dimensions: int) -> Any:
    from scipy.stats import qmc

    generator = np.random.Generator(np.random.Philox(np.random.SeedSequence(seed)))
    try:
        return qmc.Sobol(dimensions, scramble=True, bits=_SOBOL_BITS, rng=generator)
    except ValueError as error:
        raise InputError(f"sampling with {dimensions} dimensions: {error}") from error


def _check_groups(n: int, factors: int) -> None:
    """Refuse a number of runs that is not a power of two times the group size."""
    groups, rest = divmod(n, factors + 2)
    if rest or groups < 2 or groups & (groups - 1):
        near = max(2, 1 << max(0, (n // (factors + 2)).bit_length() - 1))
        allowed = f"{factors + 2} times a power of two for saltelli with {factors} dispersions"
        raise bad_value("n", n, f"{allowed}, such as {near * (factors + 2)} or {2 * near * (factors + 2)}")
