# SPDX-License-Identifier: Apache-2.0
"""Sobol indices of a store against SALib, from the same runs, for Ishigami's function."""

from __future__ import annotations

import json
from importlib.metadata import version

import numpy as np
from SALib.analyze import sobol

from mehvar.runtime.batch.evaluation.sensitivity import sensitivities
from mehvar.runtime.batch.sampling import Sampler
from mehvar.runtime.batch.store.layout import STATUS, Layout, Variable
from mehvar.runtime.batch.store.store import Store, create
from tests.validation.table import record

NAMES, GROUPS = ("a", "b", "c"), 1024


def ishigami(points: np.ndarray) -> np.ndarray:
    a, b, c = np.pi * (2 * points.T - 1)
    return np.sin(a) + 7 * np.sin(b) ** 2 + 0.1 * c**4 * np.sin(a)


def store(points: np.ndarray, metric: np.ndarray) -> Store:
    """Return a store in memory of these runs."""
    series = dict(zip((*NAMES, "m"), (*points.T, metric), strict=True)) | {STATUS: np.zeros(len(metric), np.uint8)}
    variables = [Variable(name, str(array.dtype)) for name, array in series.items()]
    campaign = json.dumps({"sampling": "saltelli", "vary": dict.fromkeys(NAMES, "uniform(0, 1)")})
    known = {"drawn": json.dumps(NAMES), "metrics": json.dumps(["m"]), "success": "", "campaign": campaign}
    made = create(None, Layout(len(metric), len(metric), variables, {}, attributes=known))
    made.write(0, series)
    return made


def test_indices_of_ishigami() -> None:
    n = (len(NAMES) + 2) * GROUPS
    points = Sampler("saltelli", [(name,) for name in NAMES], n, 1).points(0, n)
    metric = ishigami(points)
    (ours,) = sensitivities(store(points, metric))
    first_a, first_b, *crossed = metric.reshape(-1, len(NAMES) + 2).T
    problem = {"num_vars": 3, "names": list(NAMES), "bounds": [[-np.pi, np.pi]] * 3}
    ordered = np.stack([first_a, *crossed, first_b], axis=1).ravel()
    theirs = sobol.analyze(problem, ordered, calc_second_order=False, seed=1)
    for kind, shares, key in (("first-order", ours.first, "S1"), ("total", ours.total, "ST")):
        errors = [shares[name].value - theirs[key][k] for k, name in enumerate(NAMES)]
        record(
            f"statistics: {kind} indices of Ishigami's function, {n} runs",
            "SALib",
            version("SALib"),
            errors,
            theirs[f"{key}_conf"].min(),
            "1",
            "least of SALib's own 95 % intervals; its mean is taken over all runs, ours over two pages",
        )
