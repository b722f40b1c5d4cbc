# SPDX-License-Identifier: Apache-2.0
"""Noise: standard normal numbers that depend only on seed, run, stream and sample or step.

Philox4x64-10 (Salmon, Moraes, Dror & Shaw, SC11) with the key (seed, run) counts through the samples. The method of Box
and Muller turns pairs of its words into pairs of normal numbers. Every sample has its own counter; the stream is the
upper half of the counter.
"""

from __future__ import annotations

import ctypes

import numpy as np

from ..compiling.library import load_native
from ..model.functions import FloatArray


def normals(seed: int, run: int, samples: int, size: int) -> FloatArray:
    """Return the noise of one run, bit-identical to that of a batch.

    Parameters
    ----------
    seed, run : int
        Key of the numbers.
    samples, size : int
        Number of evaluations of the law, and of normal numbers for each.

    Returns
    -------
    array, (samples, size)
    """
    if not (samples and size):
        return np.empty((samples, size))
    numbers = np.empty((samples, size))
    load_native().mv_normals(
        ctypes.c_uint64(seed),
        ctypes.c_uint64(run),
        ctypes.c_int64(samples),
        ctypes.c_int64(size),
        numbers.ctypes.data_as(ctypes.c_void_p),
    )
    return numbers
