# SPDX-License-Identifier: Apache-2.0
"""Noise: standard normal numbers that depend only on seed, run, stream, and sample or step.

Philox4x64-10 (Salmon, Moraes, Dror & Shaw, SC11) with the key (seed, run) counts through the samples. The method of Box
and Muller turns pairs of its words into pairs of normal numbers. Every sample has its own counter; the stream is the
upper half of the counter.
"""

from __future__ import annotations

import ctypes
from enum import IntEnum

import numpy as np

from ..compiling.library import load_native
from ..model.functions import FloatArray

_WORDS = 4  # per counter value of Philox
_BLOCK = 512  # steps whose numbers are drawn at once; half or twice as many take the same time


class Stream(IntEnum):
    """Purpose of numbers, as in native/random/noise.h."""

    MEASUREMENTS = 0
    WIENER_PROCESSES = 1
    RANDOM_STEPS = 2


def normals(seed: int, run: int, samples: int, size: int, native: bool = True) -> FloatArray:
    """Return the noise of one run.

    Parameters
    ----------
    seed, run : int
        Key of the numbers.
    samples, size : int
        Evaluations of the law, and numbers for each.
    native : bool
        Compute in C, bit-identical to a batch; NumPy agrees up to the last few bits.

    Returns
    -------
    array, (samples, size)
    """
    if not (samples and size):
        return np.empty((samples, size))
    if native:
        numbers = np.empty((samples, size))
        load_native().mv_normals(
            ctypes.c_uint64(seed),
            ctypes.c_uint64(run),
            ctypes.c_int64(samples),
            ctypes.c_int64(size),
            numbers.ctypes.data_as(ctypes.c_void_p),
        )
        return numbers
    return _drawn(seed, run, Stream.MEASUREMENTS, 0, samples, size)


class Draws:
    """The numbers of a stream, sample by sample, computed in NumPy."""

    def __init__(self, seed: int, run: int, stream: Stream, size: int) -> None:
        self._key, self._size = (seed, run, stream), size
        self._block, self._numbers = -1, np.empty((0, size))

    def __call__(self, index: int) -> FloatArray:
        """Return the numbers of a sample or step."""
        block, place = divmod(index, _BLOCK)
        if block != self._block:
            self._block, self._numbers = block, _drawn(*self._key, block * _BLOCK, _BLOCK, self._size)
        numbers: FloatArray = self._numbers[place]
        return numbers


def _drawn(seed: int, run: int, stream: Stream, first: int, samples: int, size: int) -> FloatArray:
    blocks = -(-size // _WORDS)
    key, counter = np.array([seed, run], dtype=np.uint64), np.array([first * blocks, stream, 0, 0], dtype=np.uint64)
    words = np.random.Philox(key=key, counter=counter).random_raw(_WORDS * blocks * samples)
    fractions = ((words >> np.uint64(12)) * 2.0**-52).reshape(samples, 2 * blocks, 2)
    radius, angle = np.sqrt(-2.0 * np.log(1.0 - fractions[..., 0])), 2.0 * np.pi * fractions[..., 1]
    pairs = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1)
    return pairs.reshape(samples, 4 * blocks)[:, :size]
