# SPDX-License-Identifier: Apache-2.0
"""The noise of a run by NumPy's Philox, up to the last few bits."""

from __future__ import annotations

from enum import IntEnum

import numpy as np

from mehvar.runtime.model.functions import FloatArray

_WORDS = 4  # per counter value of Philox
_BLOCK = 512  # steps whose numbers are drawn at once; half or twice as many take the same time


class Stream(IntEnum):
    """Purpose of numbers, as in native/random/noise.h."""

    MEASUREMENTS = 0
    WIENER_PROCESSES = 1
    RANDOM_STEPS = 2


class Draws:
    """The numbers of a stream, sample by sample, computed in NumPy."""

    def __init__(self, seed: int, run: int, stream: Stream, size: int) -> None:
        self._key, self._size = (seed, run, stream), size
        self._block, self._numbers = -1, np.empty((0, size))

    def __call__(self, index: int) -> FloatArray:
        """Return the numbers of a sample or step."""
        block, place = divmod(index, _BLOCK)
        if block != self._block:
            self._block, self._numbers = block, drawn(*self._key, block * _BLOCK, _BLOCK, self._size)
        numbers: FloatArray = self._numbers[place]
        return numbers


def drawn(seed: int, run: int, stream: Stream, first: int, samples: int, size: int) -> FloatArray:
    """Return the numbers of some samples."""
    blocks = -(-size // _WORDS)
    key, counter = np.array([seed, run], dtype=np.uint64), np.array([first * blocks, stream, 0, 0], dtype=np.uint64)
    words = np.random.Philox(key=key, counter=counter).random_raw(_WORDS * blocks * samples)
    fractions = ((words >> np.uint64(12)) * 2.0**-52).reshape(samples, 2 * blocks, 2)
    radius, angle = np.sqrt(-2.0 * np.log(1.0 - fractions[..., 0])), 2.0 * np.pi * fractions[..., 1]
    pairs = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1)
    return pairs.reshape(samples, 4 * blocks)[:, :size]
