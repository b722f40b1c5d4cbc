# SPDX-License-Identifier: Apache-2.0
"""Print the largest difference of the functions of two generated folders, relative to the largest result of each.

python tests/gates/numbers_of.py OLD NEW
"""

from __future__ import annotations

import sys

import numpy as np

from mehvar.runtime import Model, load

POINTS = 20


def difference(old: Model, new: Model) -> float:
    random = np.random.default_rng(5)
    largest = 0.0
    assert list(old.functions) == list(new.functions)
    for name, function in old.manifest.functions.items():
        if "_prepare" in name or "_hold" in name:
            continue  # what is prepared is laid out as the generator likes
        arguments = [random.uniform(0.1, 1.0, (POINTS, *argument.shape)) for argument in function.arguments]
        pair = [model.functions[name](*arguments) for model in (old, new)]
        results = zip(*(found if isinstance(found, tuple) else (found,) for found in pair), strict=True)
        for a, b in results:
            assert np.array_equal(np.isfinite(a), np.isfinite(b)), name
            finite = np.isfinite(a)
            if finite.any():
                scale = max(1.0, float(np.abs(a[finite]).max()))
                largest = max(largest, float(np.abs(a[finite] - b[finite]).max()) / scale)
    return largest


if __name__ == "__main__":
    print(difference(*(load(folder) for folder in sys.argv[1:3])))
