# SPDX-License-Identifier: Apache-2.0
"""The satellite with any tensor and any wheels, compiled, and its motion by SciPy."""

from __future__ import annotations

import functools
import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import mehvar
from mehvar.codegen.generate import write
from tests.derived import variant

Array = NDArray[np.float64]
MU = 3.986004418e14
NOTHING = np.zeros(4)
"""Torques of the four motors."""


@functools.cache
def craft() -> mehvar.Model:
    """Return the model."""
    folder = Path(_scratch().name)
    write(folder, variant("satellite", chart="quaternion", inertia="full", wheels="any"))
    return mehvar.load(folder)


@functools.cache
def _scratch() -> tempfile.TemporaryDirectory[str]:
    return tempfile.TemporaryDirectory(prefix="craft-")


def names(key: str) -> list[str]:
    """Return the names of the states, inputs, ..."""
    return [q.name for q in getattr(craft().manifest, key)]


def state(**values: float) -> Array:
    """Return x with the given values, otherwise zero, in the attitude of the orbit axes."""
    values = {"q0": 1.0, **values}
    return np.array([values.get(name, 0.0) for name in names("states")])


def motion(x: Array, u: Array, p: Array, times: Array) -> Array:
    """Return the states at times by SciPy's dop853 over the compiled equations."""
    done = solve_ivp(
        lambda _t, y: craft().rhs(y, u, p), (times[0], times[-1]), x, "DOP853", times, rtol=1e-12, atol=1e-14
    )
    assert done.success
    return np.asarray(done.y.T)


def column(x: Array, *which: str) -> Array:
    """Return columns of states by their names."""
    return x[..., [names("states").index(name) for name in which]]
