# SPDX-License-Identifier: Apache-2.0
"""Peers integrate the equations of our C."""

from __future__ import annotations

import functools
import math

import numpy as np
import pytest

from benchmarks.peers.equations import ARITHMETIC, Equations, packed, scalar_source, walk
from mehvar.runtime import load

pytestmark = pytest.mark.soak  # what peers are given

FUNCTIONS = [
    *(pytest.param(*f, marks=pytest.mark.soak) for f in (("triangle", "path_loop"), ("slosh", "lyapunov_v2_loop"))),
    ("satellite", "mrac"),
    ("satellite", "rhs"),
]


@functools.cache
def equations(model: str) -> Equations:
    """Derive a model once for all its functions."""
    return Equations(model, {})


@pytest.mark.parametrize(("model", "name"), FUNCTIONS)
def test_the_scalar_text_computes_what_the_model_does(model: str, name: str) -> None:
    function = equations(model).best(name)
    loaded = load(model).functions[function.name]
    namespace = {"math": math, "np": np, "_sign": np.sign}
    exec(scalar_source(function, "scalar"), namespace)
    generator = np.random.Generator(np.random.Philox(7))
    for _ in range(5):
        arguments = [0.0 if size is None else generator.uniform(0.2, 0.6, size) for _, size in function.arguments]
        wanted = loaded(*arguments)
        wanted = wanted if isinstance(wanted, tuple) else (wanted,)
        results = [np.full(np.shape(w), np.nan) for w in wanted]
        namespace["scalar"](*arguments, *results)
        for result, want in zip(results, wanted, strict=True):
            # the same operations; sums of more than two terms may be taken in another order
            np.testing.assert_allclose(result, want, rtol=1e-12, atol=1e-12 * np.max(np.abs(want)))


def test_a_result_of_several_lines_is_one_expression() -> None:
    slope, _ = packed(Equations("slosh", {"inertia": "ball", "attitude": "quaternion"}).best("rhs"), "x")
    namespace = {"math": math, "np": np}
    exec(scalar_source(slope, "scalar"), namespace)
    generator = np.random.Generator(np.random.Philox(7))
    x, k = (generator.uniform(0.2, 0.6, size) for _, size in slope.arguments)
    (wanted,) = walk(slope.tape, [x, k], {**ARITHMETIC, "sqrt": math.sqrt, "sin": math.sin, "cos": math.cos})
    result = np.full(len(wanted), np.nan)
    namespace["scalar"](x, k, result)
    np.testing.assert_allclose(result, wanted, rtol=1e-12, atol=1e-12 * np.max(np.abs(wanted)))
