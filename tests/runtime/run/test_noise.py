# SPDX-License-Identifier: Apache-2.0
"""Noise: the generator's published vectors, NumPy's stream, and what normal numbers should be like."""

from __future__ import annotations

import ctypes

import numpy as np
import pytest
from scipy import stats

from mehvar.runtime.compiling.library import load_library, native_sources
from mehvar.runtime.run.noise import normals
from tests.reference.scipy_loop.noise import Stream, drawn

WRAPPER = """#include "philox.h"
void words(uint64_t a, uint64_t b, uint64_t counter, uint64_t *out) { mv_philox(a, b, counter, out); }
"""


@pytest.fixture(scope="module")
def philox():
    sources = {"words.c": WRAPPER, **native_sources("random/philox.h")}
    library = load_library("words", sources, ["words.c"])

    def words(key: tuple[int, int], counter: int) -> list[int]:
        out = (ctypes.c_uint64 * 4)()
        library.words(ctypes.c_uint64(key[0]), ctypes.c_uint64(key[1]), ctypes.c_uint64(counter), out)
        return list(out)

    return words


def test_the_published_vector(philox):
    """philox4x64 10 of the Random123 known-answer file, counter and key zero."""
    expected = [0x16554D9ECA36314C, 0xDB20FE9D672D0FDC, 0xD7E772CEE186176B, 0x7E68B68AEC7BA23B]
    assert philox((0, 0), 0) == expected


@pytest.mark.parametrize("key", [(0, 0), (1, 2), (2**64 - 1, 2**63 + 5)])
def test_numpys_stream(philox, key):
    stream = np.random.Philox(key=np.array(key, dtype=np.uint64)).random_raw(12).tolist()
    assert [word for counter in (1, 2, 3) for word in philox(key, counter)] == stream


def test_c_and_numpy_agree():
    for size in (1, 3, 4, 6):
        native, plain = normals(7, 11, 50, size), drawn(7, 11, Stream.MEASUREMENTS, 0, 50, size)
        assert native.shape == (50, size)
        np.testing.assert_allclose(native, plain, rtol=1e-13, atol=1e-15)


def test_the_numbers_are_normal_and_independent():
    x = normals(3, 4, 20_000, 6)
    assert stats.kstest(x.ravel(), "norm").pvalue > 1e-3
    assert np.abs(np.corrcoef(x.T) - np.eye(6)).max() < 4 / np.sqrt(len(x))
    assert abs(np.corrcoef(x[1:, 0], x[:-1, 0])[0, 1]) < 4 / np.sqrt(len(x))
    assert not np.isin(normals(3, 5, 100, 6), x).any()


def test_a_run_is_the_same_however_many_samples_are_drawn():
    np.testing.assert_array_equal(normals(1, 2, 10, 6), normals(1, 2, 100, 6)[:10])
