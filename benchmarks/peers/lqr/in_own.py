# SPDX-License-Identifier: Apache-2.0
"""mehvar without its model: the craft as a user's own system in own/models, by the same equations as for heyoka."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import task

import mehvar

FOLDER = task.HERE / "own"
MODEL = task.STARTS.parent / "own"


def law(t, x):
    """Command force and moment for a column of states each."""
    return np.concatenate(task.wrench(task.law(np.asarray(x).T)), axis=-1).T


def make(tolerance):
    """Generate, and return the batch of the first runs."""
    (FOLDER / "generated").mkdir(exist_ok=True)  # which makes it a project
    words = ["generate", "own", "--out", str(MODEL)]
    subprocess.run([sys.executable, "-m", "mehvar", *words], check=True, capture_output=True, cwd=FOLDER)
    model = mehvar.load(MODEL)

    def fly(starts):
        options = {"rtol": tolerance, "atol": tolerance, "threads": 1, "t_end": task.SAMPLES * task.PERIOD}
        many = mehvar.batch(model, law, len(starts), period=task.PERIOD, vary=task.VARY, seed=1, **options)
        return many["final"].values

    return fly


if __name__ == "__main__":
    task.measure(make, task.RUNS, sorted((FOLDER / "models").rglob("*.*")))
