# SPDX-License-Identifier: Apache-2.0
"""One run of a batch again, alone and with everything recorded."""

from __future__ import annotations

from typing import Any

import numpy as np

from mehvar.errors import InputError, bad_value

from ..model.functions import FloatArray
from ..run.metrics import metrics
from ..run.options import OPTIONS
from ..run.problem import Progress, Status
from ..run.simulate import Run, simulate
from .plan import Plan
from .store import STATUS, Store


def repeat_run(plan: Plan, store: Store, number: int, progress: Progress | None = None) -> Run:
    """Integrate run `number` of a batch.

    Raises
    ------
    InputError
        If the store has no such run, or its drawn values are not allowed.
    """
    if not 0 <= number < store.n:
        raise bad_value("run", number, f"a whole number from 0 to {store.n - 1}, the runs of {store.name}")
    refusal = plan.refusal(number)
    if refusal:
        raise InputError(refusal)
    parameters, initial = plan.settings(number)
    campaign = plan.campaign
    changes = plan.options.changes()
    options: dict[str, Any] = {name: changes[name] for name in changes if "run" not in OPTIONS[name].refused}
    if plan.noisy:
        options |= {"seed": campaign.seed, "run": number}
    return simulate(
        plan.model,
        campaign.controller,
        campaign.scenario,
        parameters,
        initial,
        progress=progress,
        origin=f"run {number}",
        **options,
        **plan.choices,
    )


def difference(run: Run, store: Store, number: int) -> str | None:
    """Say how a repeated run differs from the stored one: nothing when no bit does, None when it is not stored."""
    block = number // store.chunk
    if block not in store.stored():
        return None
    row = number - store.runs(block).start
    reports = {output.name for output in run.controller.outputs}  # of the law, which a store does not keep
    wide = np.stack([series for name, series in run.variables().items() if name not in reports], axis=1)
    names = metrics(run, run.manifest)
    pairs = {
        "minimum": (wide.min(axis=0), store.read("minimum", [block])[row]),
        "maximum": (wide.max(axis=0), store.read("maximum", [block])[row]),
        "metrics": (np.array(list(names.values())), np.array([store.read(name, [block])[row] for name in names])),
        "t_stop": (np.array([run.t_stop]), store.read("t_stop", [block])[row : row + 1]),
        STATUS: (np.array([int(run.status)]), store.read(STATUS, [block])[row : row + 1]),
    }
    if run.status is Status.DONE:
        pairs["final"] = (run.x[-1], store.read("final", [block])[row])
    differences = [
        f"{name} by up to {_largest(here, there):.3g}"
        for name, (here, there) in pairs.items()
        if not np.array_equal(here, there, equal_nan=here.dtype.kind == "f")
    ]
    return f"differs from the store in {', '.join(differences)}" if differences else ""


def _largest(one: FloatArray, other: FloatArray) -> float:
    """Return the largest difference; infinite where only one of two numbers is finite."""
    with np.errstate(invalid="ignore"):
        gap = np.abs(np.subtract(one, other, dtype=np.float64))
    alike = (one == other) | (np.isnan(one) & np.isnan(other))
    return float(np.max(np.where(alike, 0.0, np.where(np.isfinite(gap), gap, np.inf))))
