# SPDX-License-Identifier: Apache-2.0
"""Measurement noise: standard normal numbers that depend on seed, run and sample alone.

Philox4x64-10 (Salmon, Moraes, Dror & Shaw, SC11) with the key (seed, run) counts through the samples; pairs of its
words become pairs of normal numbers by the method of Box and Muller. Every sample starts at a counter of its own.
"""

from __future__ import annotations

import ctypes

import numpy as np

from ..compiling.library import load_native
from ..model.functions import FloatArray

_WORDS = 4  # that Philox makes per counter value


def normals(seed: int, run: int, samples: int, size: int, native: bool = True) -> FloatArray:
    """Return the noise of one run.

    Parameters
    ----------
    seed, run : int
        Key of the numbers.
    samples, size : int
        Evaluations of the law, and numbers for each.
    native : bool
        Compute in C, to the bits that a batch has; NumPy agrees to the last few.

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
    blocks = -(-size // _WORDS)
    words = np.random.Philox(key=np.array([seed, run], dtype=np.uint64)).random_raw(_WORDS * blocks * samples)
    fractions = ((words >> np.uint64(12)) * 2.0**-52).reshape(samples, 2 * blocks, 2)
    radius, angle = np.sqrt(-2.0 * np.log(1.0 - fractions[..., 0])), 2.0 * np.pi * fractions[..., 1]
    pairs = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1)
    return pairs.reshape(samples, 4 * blocks)[:, :size]
