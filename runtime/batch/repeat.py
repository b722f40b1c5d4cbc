# SPDX-License-Identifier: Apache-2.0
"""One run of a batch again, alone and with everything recorded."""

from __future__ import annotations

import json
import os
from typing import Any

import numpy as np

from mehvar.errors import InputError, bad_value

from ..model.catalogue import find_model, shipped_models
from ..model.functions import FloatArray
from ..model.model import Model, load
from ..run.metrics import metrics
from ..run.options import OPTIONS
from ..run.problem import Progress, Status
from ..run.simulate import Run, simulate
from .numerics import generated_digest
from .plan import Campaign, Plan
from .store.layout import STATUS
from .store.store import Store


class TrustError(InputError):
    """Repeating a run would compile and run a model that nobody but the store names."""


def plan_of(store: Store, model: Model | str | os.PathLike[str] | None = None, trust: bool = False) -> Plan:
    """Return the plan that a store was made from.

    A model is code, and a store is data: which code runs is never for the store to say.

    Parameters
    ----------
    store : Store
        Which.
    model : Model, str or path, optional
        The model to take, as `load` takes it. Unless given, the installed one of the store's model's name, if its text
        hashes to what the store has recorded.
    trust : bool
        Take the model that the store names, if its text hashes to what the store has recorded.

    Raises
    ------
    InputError
        If the law was one in Python.
    TrustError
        If only the store says where the model is, or it has changed since.
    """
    if model is None:
        model = _trusted_model(store, trust)
    loaded = model if isinstance(model, Model) else load(model, "c")
    if store.attributes["controller"] not in loaded.manifest.controllers and "law" in store.attributes:
        raise InputError(
            f"{store.name} was run under {store.attributes['controller']}, which no store keeps: repeat a run with "
            "mehvar.simulate, the law, and the values that the run drew"
        )
    return Plan(loaded, Campaign(**json.loads(store.attributes["campaign"])), store.name)


def is_model_of(store: Store, model: Model) -> bool:
    """Whether a store was made from this text."""
    return generated_digest(model.manifest) == _recorded_digest(store)


def _trusted_model(store: Store, trust: bool) -> str:
    name, source = str(store.attributes["model"]), str(store.attributes["model_source"])
    installed = shipped_models().get(name)  # not that of the folder one stands in, which may have come with the store
    if installed is not None and generated_digest(find_model(installed)) == _recorded_digest(store):
        return str(installed)
    if not trust:
        raise TrustError(
            f"{store.name} was made from a model {name} that is not installed here with the same text; it names "
            f"{source!r}, and a model is code that would be compiled and run. If you trust it, add --trust-model "
            "(trust=True); or name a model of your own: mehvar simulate MODEL --from STORE --run ID"
        )
    if generated_digest(find_model(source)) != _recorded_digest(store):
        raise TrustError(f"{store.name} was made from another text than that of {source!r} now: it cannot be repeated")
    return source


def _recorded_digest(store: Store) -> str:
    return str(json.loads(store.attributes["numerics"])["generated"])


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
