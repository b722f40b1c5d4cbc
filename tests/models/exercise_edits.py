# SPDX-License-Identifier: Apache-2.0
"""Call every function of generated folders in C and in Python, and run every law, under sanitizers.

python tests/models/exercise_edits.py FOLDER...
"""

from __future__ import annotations

import contextlib
import sys
import warnings

import numpy as np

from mehvar.base.errors import MehvarError
from mehvar.runtime import Model, load, simulate
from tests.gates.exercise import functions


def values(model: Model) -> dict[str, tuple[np.ndarray, ...]]:
    """Return the results of each function at one ordinary point."""
    generator = np.random.default_rng(0)
    results = {}
    for name, function in model.functions.items():
        result = function(*(generator.uniform(0.1, 1.0, a.shape) for a in function.function.arguments))
        results[name] = result if isinstance(result, tuple) else (result,)
    return results


def run(model: Model) -> None:
    """Run every law for a short time; failures of runs are printed."""
    for law in model.manifest.controllers if model.manifest.scenarios else ():
        with warnings.catch_warnings(), contextlib.suppress(MehvarError):
            warnings.simplefilter("ignore")
            simulate(model, law, t_end=0.2)


def main(folders: list[str]) -> None:
    for folder in folders:
        fast, slow = load(folder, "c"), load(folder, "python")
        assert list(functions(fast)) == list(fast.functions)
        expected = values(slow)
        for name, results in values(fast).items():
            for a, b in zip(results, expected.get(name, ()), strict=name in expected):  # parts are in C alone
                np.testing.assert_allclose(a, b, rtol=1e-12, atol=1e-12, err_msg=f"{folder}: {name}")
        run(fast)
    print(f"{len(folders)} systems")


if __name__ == "__main__":
    main(sys.argv[1:])
