# SPDX-License-Identifier: Apache-2.0
"""A point of each model at which no term vanishes."""

from __future__ import annotations

import subprocess

import numpy as np
import pytest

import mehvar
from mehvar.base.manifest import Function
from mehvar.runtime.model.functions import FloatArray
from tests import commands

MODELS = ("triangle", "slosh", "satellite")
LONGEST = 6000
"""Largest number of operations of compared functions; larger ones only take longer."""


def point(function: Function) -> list[FloatArray]:
    """Return arguments of a function, the same each time."""
    generator = np.random.default_rng(1)
    return [generator.uniform(0.1, 0.9, spec.shape) for spec in function.arguments]


@pytest.fixture(scope="session")
def own(tmp_path_factory: pytest.TempPathFactory) -> mehvar.Model:
    """The model of `mehvar new`, generated."""
    folder = tmp_path_factory.mktemp("own")
    for words, place in ((["new", "own"], folder), (["generate", "own"], folder / "own")):
        subprocess.run([*commands.mehvar(), *words], cwd=place, check=True, capture_output=True)
    return mehvar.load(folder / "own" / "generated" / "own")


@pytest.fixture(params=[*MODELS, "own"])
def model(request: pytest.FixtureRequest) -> mehvar.Model:
    """The three systems, and a user's system."""
    if request.param == "own":
        mine: mehvar.Model = request.getfixturevalue("own")
        return mine
    return mehvar.load(request.param)


def close(actual: object, expected: object) -> None:
    """Compare to 1e-12 of the largest element: where sums cancel, compilers differ by rounding of the terms."""
    expected = np.asarray(expected)
    scale = float(np.max(np.abs(expected), initial=0.0, where=np.isfinite(expected)))
    np.testing.assert_allclose(np.asarray(actual), expected, rtol=1e-12, atol=1e-12 * scale)
