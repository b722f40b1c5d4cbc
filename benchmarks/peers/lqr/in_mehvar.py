# SPDX-License-Identifier: Apache-2.0
"""mehvar: the model of slosh on ball joints, the law in Python, a batch."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import task

import mehvar

MODEL = task.STARTS.parent / "slosh"


def generated() -> Path:
    """Derive the variant and generate its C."""
    words = ["generate", "slosh", "--structure", "inertia=ball", "--structure", "attitude=quaternion", "--out", MODEL]
    subprocess.run([sys.executable, "-m", "mehvar", *map(str, words)], check=True, capture_output=True)
    return MODEL


def law(t, x):
    """Command the inputs for a column of states each."""
    return task.law(np.asarray(x).T).T


def make(tolerance):
    """Return the batch of the first runs, with initial states that mehvar draws."""
    model = mehvar.load(generated())

    def fly(starts):
        span = task.SAMPLES * task.PERIOD
        options = {"rtol": tolerance, "atol": tolerance, "threads": 1, "I1": 0.0, "I2": 0.0, "t_end": span}
        many = mehvar.batch(model, law, len(starts), period=task.PERIOD, vary=task.VARY, seed=1, **options)
        task.STARTS.parent.mkdir(parents=True, exist_ok=True)
        if len(starts) == task.RUNS:
            np.save(task.STARTS, np.stack([many[name].values for name in task.VARY], axis=-1))
        return many["final"].values

    return fly


if __name__ == "__main__":
    task.measure(make, task.RUNS)
