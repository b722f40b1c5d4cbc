# SPDX-License-Identifier: Apache-2.0
"""Repetition of one run of a batch, with all variables recorded."""

from __future__ import annotations

import json
import math
import os
import shlex
import sys
from collections import Counter
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from types import FunctionType
from typing import TYPE_CHECKING, Any

import numpy as np

from mehvar.base.errors import InputError, bad_value
from mehvar.base.manifest import OPEN_LOOP

from ..model.catalogue import find_model, project_models, shipped_models
from ..model.functions import FloatArray
from ..model.model import Model, load
from ..run.metrics import metrics
from ..run.options import AUTO, FIXED, OPTIONS
from ..run.problem import Progress
from ..run.simulate import Run, simulate
from ..run.ticks import rows_of
from ..run.user.choice import law_of
from ..run.user.law import LawFunction, PythonLaw, recorded_memory
from .numerics import generated_digest, other_options
from .plan import Campaign, Plan
from .store.layout import STATUS

if TYPE_CHECKING:
    import xarray

    from .store.dataset import Batch, DatasetBatch


SESSION_LAWS: dict[str, LawFunction] = {}
"""Python laws of this session's batches by their source, for repeated runs."""


SESSION_MODELS: dict[str, Model] = {}
"""Models of this session's batches from `mehvar.build`, by the digest of their code."""


class TrustError(InputError):
    """Error for a repeat that would compile and execute a model that only the store names."""


def plan_of(
    store: Batch,
    model: Model | str | os.PathLike[str] | None = None,
    trust: bool = False,
    controller: LawFunction | None = None,
    inputs: Mapping[str, object] | xarray.Dataset | None = None,
    interpolation: str | None = None,
) -> Plan:
    """Return the plan of a store.

    Models and Python laws are code, and a store is data, so that code never comes from a store.

    Parameters
    ----------
    store : Batch
        The store.
    model : Model, str or path, optional
        The model, as for `load`. Default: the model of this name that is installed or in the current project, if its
        code has the recorded hash.
    trust : bool
        Use the model that the store names, if its code has the recorded hash.
    controller : callable, optional
        The batch's Python law. Default: the law with the recorded source that ran a batch in this session, or the
        function of that name in the running program or notebook.
    inputs, interpolation : optional
        Inputs of a batch without a law, as for `simulate`.

    Raises
    ------
    InputError
        If a law in Python or inputs are missing or differ from those of the batch, or this build's options differ.
    TrustError
        If only the store names the model, or the model has changed.
    """
    if controller is None and inputs is None:
        controller = _session_law(store)
    _check_law(store, controller, inputs)  # before the model, because a trusted model does not restore the law
    if model is None:
        model = _trusted_model(store, trust)
    loaded = model if isinstance(model, Model) else load(model, "c")
    campaign = Campaign(**json.loads(store.attributes["campaign"]))
    own = _own(store, loaded, campaign, controller, inputs, interpolation)
    if own is not None:  # the plan takes the time for which it is held from the law
        campaign = replace(campaign, options={k: v for k, v in campaign.options.items() if k != "hold"})
    plan = Plan(loaded, campaign, store.name, own)
    if differences := other_options(json.loads(store.attributes["numerics"])["options"], plan.effective()):
        raise InputError(f"{store.name} was made with other options, by another build: {', '.join(differences)}")
    return plan


def _session_law(store: Batch) -> LawFunction | None:
    """Return the law of a batch if this session ran or defined it; `_own` compares it with the recorded source."""
    ran = SESSION_LAWS.get(str(store.attributes.get("law", "")))
    # as in python:pd; the `main` of a command is another module
    name = str(store.attributes["controller"]).partition(":")[2]
    defined = getattr(sys.modules.get("__main__"), name, None) if name else None
    if isinstance(defined, FunctionType) and not defined.__module__.startswith("mehvar."):
        return ran or defined
    return ran


def _needed(store: Batch) -> str | None:
    """Return the argument, law or inputs, that `again` needs for a batch without a law of the model; else None."""
    if "law" not in store.attributes:
        return None
    return "inputs" if store.attributes["controller"] == OPEN_LOOP else "controller"


def repetition(store: Batch, run: int, path: str) -> str:
    """Return the command or Python call that repeats a run."""
    needed = _needed(store)
    if needed or not path:
        given = {"inputs": ", inputs=INPUTS", "controller": ", controller=LAW"}.get(needed or "", "")
        return f"runs.mehvar.again({run}{given})"
    return f"mehvar simulate --from {shlex.quote(path)} --run {run}"


def _check_law(store: Batch, controller: object, inputs: object) -> None:
    """Refuse a batch whose law or inputs are missing, and unused arguments."""
    law = str(store.attributes["controller"])
    needed = _needed(store)
    given = {"controller": controller, "inputs": inputs}
    if needed is not None and given[needed] is None:
        if needed == "inputs":
            how = "pass its inputs, as in runs.mehvar.again(17, inputs=INPUTS)"
            raise InputError(f"{store.name} ran without a law: {how}")
        raise InputError(
            f"{store.name} ran under {law}, a law in Python that is not defined here. Repeat the run in Python, with "
            "the law: runs.mehvar.again(RUN, controller=LAW). The batch has the law's source in its attribute 'law'"
        )
    for name, value in given.items():
        if value is not None and name != needed:
            raise bad_value(name, value, f"left out: {store.name} was run under {law}", "the call")


def _own(
    store: Batch,
    model: Model,
    campaign: Campaign,
    controller: LawFunction | None,
    inputs: Mapping[str, object] | xarray.Dataset | None,
    interpolation: str | None,
) -> PythonLaw | None:
    """Return the Python law of a batch if it equals the recorded one."""
    if controller is None and inputs is None:
        return None
    if not store.attributes["law"]:
        raise InputError(
            f"{store.name} did not record the law {campaign.controller}, because it reads something that cannot be "
            "identified: pass such values as parameters, or keep them in numbers of the law's module"
        )
    text, hold = str(store.attributes["law"]), float(campaign.options["hold"])
    end = float(campaign.options.get("t_end") or model.manifest.scenario(campaign.scenario).duration)
    memory = None if controller is None else recorded_memory(text)
    _, own = law_of(model.manifest, controller, inputs, interpolation, hold, memory, end, "the call")
    if own is None or own.text != text:
        raise InputError(f"{store.name} was run under another version of {campaign.controller}:\n{text}")
    return own


def is_model_of(store: Batch, model: Model) -> bool:
    """Return True if a store was made from this model's code."""
    return generated_digest(model.manifest) == _recorded_digest(store)


def keep_for_session(store: Batch, model: Model) -> None:
    """Allow runs of a batch to be repeated in this session, which already ran the model."""
    SESSION_MODELS[_recorded_digest(store)] = model


def _trusted_model(store: Batch, trust: bool) -> Model | str:
    """Return the model of a store: of the session, installed, of the project or, if trusted, its source."""
    name, source = str(store.attributes["model"]), str(store.attributes["model_source"])
    if known := SESSION_MODELS.get(_recorded_digest(store)):
        return known
    for folder in filter(None, (models.get(name) for models in (shipped_models(), project_models()))):
        with suppress(InputError):  # a damaged or older folder is not the model of this store
            if generated_digest(find_model(folder)) == _recorded_digest(store):
                return str(folder)
    there = os.path.isdir(source)  # noqa: PTH112 - pathlib raises for a name that is too long
    if not (trust and there):
        raise TrustError(
            f"{store.name} needs the model {name} in a version that is neither installed nor in this project; "
            f"{_way(source, there)}"
        )
    if generated_digest(find_model(source)) != _recorded_digest(store):
        raise TrustError(
            f"{store.name} was made from another version of {source!r}: restore that version to repeat a run"
        )
    return source


def _way(source: str, there: bool) -> str:
    """Return advice on which model to name if a store's model is not found."""
    if not there:
        gone = f"its folder {source!r} does not exist here. " if os.sep in source else ""
        return f"{gone}Name a generated folder with the code of the batch: mehvar simulate FOLDER --from STORE --run ID"
    return (
        f"the store names {source!r}, whose code would be compiled and run. If you trust it, add --trust-model, "
        "in Python model=PATH; or name a model of your own: mehvar simulate MODEL --from STORE --run ID"
    )


def _recorded_digest(store: Batch) -> str:
    return str(json.loads(store.attributes["numerics"])["generated"])


def repeat_run(plan: Plan, store: Batch, number: int, progress: Progress | None = None) -> Run:
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
    campaign, own = plan.campaign, plan.own
    changes = plan.options.changes()
    options: dict[str, Any] = {name: changes[name] for name in changes if "run" not in OPTIONS[name].refused}
    if own is not None:  # it brings its own period
        options.pop("hold", None)
        place = number % store.width
        own = own.among(min(store.width, store.n - number + place), [place])
    if plan.noisy:
        options |= {"seed": campaign.seed, "run": number}
    return simulate(
        plan.model,
        own or campaign.controller,
        campaign.scenario,
        parameters,
        initial,
        progress=progress,
        origin=f"run {number}",
        **options,
        **plan.choices,
    )


def check_row(plan: Plan, dataset: DatasetBatch, number: int) -> None:
    """Refuse a row of a dataset whose drawn values are not those of the run with its number.

    Raises
    ------
    InputError
        With the run that has the row's values, if there is one.
    """
    block = number // dataset.chunk
    if not (plan.names and 0 <= number < dataset.n and dataset.has(block)):
        return
    row = np.array([dataset.read(label, [block])[number % dataset.chunk] for label in plan.labels()])
    if np.array_equal(row, list(plan.drawn(number).values())):
        return
    others = np.flatnonzero((plan.draw(0, plan.campaign.n).values == row).all(axis=1))
    which = f"run {others[0]}" if others.size else f"another run than {number}"
    raise InputError(f"row {number} holds {which} of the batch, as after isel or sortby: repeat from the whole dataset")


def difference(run: Run, plan: Plan, store: Batch, number: int) -> str | None:
    """Return the difference between a repeated and the stored run: empty if identical, None if the run is not stored.

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
    if run.t[-1] != run.t_stop:  # the numbers at its end are not finite
        numbers["final"] = store.read("final", [block])[row]
    differences = [f"{name} is not in both" for name in sorted(numbers.keys() ^ variables.keys())]
    batch_only = {"error"} if run.options["method"] in FIXED else set()
    for name in (variables.keys() & numbers.keys()) - batch_only:
        here, there = np.asarray(numbers[name]), store.read(name, [block])[row]
        if not np.array_equal(here, there, equal_nan=here.dtype.kind == "f"):
            differences.append(f"{name} by up to {_largest(here, there):.3g}")
    attributes = store.attributes
    differences += [name for name, value in plan.facts().items() if attributes[name] != value]
    return f"differs from the store in {', '.join(sorted(differences))}" if differences else ""


def _numbers(run: Run, plan: Plan, number: int) -> dict[str, Any]:
    """Return a run's values by the names of the store's variables."""
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
    """Return the series at the stored instants, with NaN after the end of the run."""
    if plan.campaign.save_every is None:
        return {}
    dt, end = float(run.options["dt_out"]), float(run.options["t_end"])
    rows = np.rint(rows_of(plan.campaign.save_every, end, dt, plan.origin) / dt).astype(int)
    instants, last = rows_of(dt, end, dt, plan.origin), len(run.t) - 1
    inside = rows < last + (run.t[-1] == instants[min(last, len(instants) - 1)])  # an event may end a run between two
    return {name: np.where(inside, values[np.where(inside, rows, 0)], math.nan) for name, values in series.items()}


def _largest(one: FloatArray, other: FloatArray) -> float:
    """Return the largest difference; infinite if only one of two numbers is finite."""
    with np.errstate(invalid="ignore"):
        gap = np.abs(np.subtract(one, other, dtype=np.float64))
    alike = (one == other) | (np.isnan(one) & np.isnan(other))
    return float(np.max(np.where(alike, 0.0, np.where(np.isfinite(gap), gap, np.inf))))
