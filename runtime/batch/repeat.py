# SPDX-License-Identifier: Apache-2.0
"""Repetition of one run of a batch, with all variables recorded."""

from __future__ import annotations

import json
import math
import os
from collections import Counter
from collections.abc import Mapping
from typing import Any

import numpy as np

from mehvar.errors import InputError, bad_value
from mehvar.manifest import OPEN_LOOP

from ..model.catalogue import find_model, project_models, shipped_models
from ..model.functions import FloatArray
from ..model.model import Model, load
from ..run.metrics import metrics
from ..run.options import AUTO, FIXED, OPTIONS
from ..run.problem import Progress, Status
from ..run.simulate import Run, simulate
from ..run.ticks import rows_of
from .numerics import generated_digest, other_options
from .plan import Campaign, Plan
from .store.layout import STATUS
from .store.store import Store


class TrustError(InputError):
    """Repeating a run would compile and run a model that only the store names."""


def plan_of(store: Store, model: Model | str | os.PathLike[str] | None = None, trust: bool = False) -> Plan:
    """Return the plan of a store.

    A model is code and a store is data, so a store never decides which code runs.

    Parameters
    ----------
    store : Store
        The store.
    model : Model, str or path, optional
        The model, as `load` takes it. Unless given, the installed model of the same name, if the hash of its code is
        the one recorded in the store.
    trust : bool
        Take the model that the store names, if the hash of its code is the one recorded in the store.

    Raises
    ------
    InputError
        If the law was one in Python, or this build's options for the campaign differ.
    TrustError
        If only the store says where the model is, or the model has changed since.
    """
    law = store.attributes["controller"]
    if "law" in store.attributes or law == OPEN_LOOP:  # before the model: trust in it would not bring the law back
        what = "an open loop" if law == OPEN_LOOP else law
        raise InputError(
            f"{store.name} was run under {what}, which no store keeps: repeat a run with mehvar.simulate, "
            f"{'its inputs' if law == OPEN_LOOP else 'the law'}, and the values that the run drew"
        )
    if model is None:
        model = _trusted_model(store, trust)
    loaded = model if isinstance(model, Model) else load(model, "c")
    plan = Plan(loaded, Campaign(**json.loads(store.attributes["campaign"])), store.name)
    if differences := other_options(json.loads(store.attributes["numerics"])["options"], plan.effective()):
        raise InputError(f"{store.name} was made with other options, by another build: {', '.join(differences)}")
    return plan


def is_model_of(store: Store, model: Model) -> bool:
    """Return True if a store was made from this model's code."""
    return generated_digest(model.manifest) == _recorded_digest(store)


def _trusted_model(store: Store, trust: bool) -> str:
    name, source = str(store.attributes["model"]), str(store.attributes["model_source"])
    installed = shipped_models().get(name)  # not one of the working folder, which may have come with the store
    if installed is not None and generated_digest(find_model(installed)) == _recorded_digest(store):
        return str(installed)
    there = os.path.isdir(source)  # noqa: PTH112 - pathlib raises for a name that is too long
    if not (trust and there):
        raise TrustError(
            f"{store.name} was made from a model {name} that is not installed here with the same text; "
            f"{_way(store, name, source, there)}"
        )
    if generated_digest(find_model(source)) != _recorded_digest(store):
        raise TrustError(f"{store.name} was made from another text than that of {source!r} now: it cannot be repeated")
    return source


def _way(store: Store, name: str, source: str, there: bool) -> str:
    """Return advice on the model to name for a store whose model is not installed."""
    own = project_models().get(name)
    if own is not None and generated_digest(find_model(own)) == _recorded_digest(store):
        return f"that in {own} has this text: to take it, mehvar simulate {name} --from STORE --run ID"
    if not there:
        return (
            f"it names {source!r}, which is no folder here: name the model, mehvar simulate MODEL --from STORE --run ID"
        )
    return (
        f"it names {source!r}, and a model is code that would be compiled and run. If you trust it, add --trust-model "
        "(trust=True); or name a model of your own: mehvar simulate MODEL --from STORE --run ID"
    )


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


def difference(run: Run, plan: Plan, store: Store, number: int) -> str | None:
    """Describe how a repeated run differs from the stored one: empty if no bit differs, None if it is not stored.

    Every variable of the store is compared, with two exceptions. The final state of a run that ended early lies
    between samples. The error of a method with a fixed step is estimated only in batches. Attributes are compared
    where they identify the run.
    """
    block = number // store.chunk
    if not store.has(block):
        return None
    row = number - store.runs(block).start
    numbers = _numbers(run, plan, number)
    variables = store.variables()
    if run.status is not Status.DONE and not run.status.by_event:
        numbers["final"] = store.read("final", [block])[row]
    differences = [f"{name} is not in both" for name in sorted(numbers.keys() ^ variables.keys())]
    batch_only = {"error"} if run.options["method"] in FIXED else set()
    for name in (variables.keys() & numbers.keys()) - batch_only:
        here, there = np.asarray(numbers[name]), store.read(name, [block])[row]
        if not np.array_equal(here, there, equal_nan=here.dtype.kind == "f"):
            differences.append(f"{name} by up to {_largest(here, there):.3g}")
    attributes = store.attributes
    differences += [name for name, value in _facts(plan).items() if attributes[name] != value]
    return f"differs from the store in {', '.join(sorted(differences))}" if differences else ""


def _numbers(run: Run, plan: Plan, number: int) -> dict[str, Any]:
    """Return a run by the names of the store's variables."""
    reports = {output.name for output in run.controller.outputs}  # of the law; a store does not keep them
    series = {name: values for name, values in run.variables().items() if name not in reports}
    wide = np.stack(list(series.values()), axis=1)
    own = {
        **{"final": run.x[-1], "minimum": wide.min(axis=0), "maximum": wide.max(axis=0), "t_stop": run.t_stop},
        **{"error": run.error, "steps": run.statistics["steps"], "violated": run.violated, STATUS: int(run.status)},
    }
    if run.options["method"] == AUTO:
        own["t_stiff"] = run.t_stiff
    if run.possible_events:
        counts = Counter(name for _, name in run.events)
        own["events"] = [counts[event.name] for event in run.possible_events]
    drawn = dict(zip(plan.labels(), plan.drawn(number).values(), strict=True))
    return {**drawn, **metrics(run, run.manifest), **_saved(run, plan, series), **own}


def _saved(run: Run, plan: Plan, series: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
    """Return the series at the stored instants; NaN after the end of a run."""
    if plan.campaign.save_every is None:
        return {}
    dt, end = float(run.options["dt_out"]), float(run.options["t_end"])
    rows = np.rint(rows_of(plan.campaign.save_every, end, dt, plan.origin) / dt).astype(int)
    instants, last = rows_of(dt, end, dt, plan.origin), len(run.t) - 1
    inside = rows < last + (run.t[-1] == instants[min(last, len(instants) - 1)])  # an event may end a run between two
    return {name: np.where(inside, values[np.where(inside, rows, 0)], math.nan) for name, values in series.items()}


def _facts(plan: Plan) -> dict[str, Any]:
    """Return the attributes of a store that depend only on its campaign and the model."""
    manifest = plan.model.manifest
    return {
        **{"model": manifest.model, "model_hash": manifest.hash, "structure": json.dumps(manifest.structure)},
        **{"controller": plan.law.name, "scenario": plan.scenario.name, "seed": plan.campaign.seed},
        **{"nominal": json.dumps(plan.nominal.values), "drawn": json.dumps(plan.labels())},
    }


def _largest(one: FloatArray, other: FloatArray) -> float:
    """Return the largest difference; infinite where only one of two numbers is finite."""
    with np.errstate(invalid="ignore"):
        gap = np.abs(np.subtract(one, other, dtype=np.float64))
    alike = (one == other) | (np.isnan(one) & np.isnan(other))
    return float(np.max(np.where(alike, 0.0, np.where(np.isfinite(gap), gap, np.inf))))
