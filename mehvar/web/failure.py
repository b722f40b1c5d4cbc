# SPDX-License-Identifier: Apache-2.0
"""Search for a run of a page that does not succeed: one parameter away from a run that does."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mehvar.base.manifest import Manifest
from mehvar.runtime.batch.blocks import IMPOSSIBLE
from mehvar.runtime.batch.evaluation.conditions import Criterion
from mehvar.runtime.batch.fill import run_batch
from mehvar.runtime.batch.plan import Campaign
from mehvar.runtime.batch.points import lists_as_distributions
from mehvar.runtime.model.model import Model
from mehvar.runtime.run.metrics import metrics
from mehvar.runtime.run.problem import Status
from mehvar.runtime.run.simulate import Run, simulate

from .cases import Case

_FACTORS = (1.25, 0.8, 1.5, 0.5, 2.0, 0.25)
"""Factors of a parameter, the nearest first; one batch has six runs for each parameter."""


@dataclass(frozen=True)
class Failure:
    """A run that does not succeed.

    Attributes
    ----------
    case : int
        Place of the run that succeeds.
    name, value
        The parameter that differs, and its value.
    checksum : str
        Of the run on this machine.
    """

    case: int
    name: str
    value: float
    checksum: str


def criterion_of(manifest: Manifest, success: str | None) -> Criterion | None:
    """Return a condition on metrics of a model, or None without a text; raise InputError for another text."""
    criterion = None if success is None else Criterion(success)
    if criterion is not None:
        criterion.check_names({name: metric.unit for name, metric in manifest.metrics.items()}, {})
    return criterion


def failure_of(model: Model, cases: Sequence[Case], criterion: Criterion | None) -> Failure | None:
    """Return the first run found that does not succeed, or None.

    Parameters
    ----------
    model : Model
        The model.
    cases : sequence of Case
        Runs of its page; the first that succeeds is varied.
    criterion : Criterion, optional
        As of `mehvar batch --success`; without it a run succeeds that reaches its end.
    """
    for place, case in enumerate(cases):
        if _succeeds(case.run, model, criterion):
            return next(_failures(model, place, case, criterion), None)
    return None


def _failures(model: Model, place: int, case: Case, criterion: Criterion | None) -> Iterator[Failure]:
    """Yield the changes of one value at which the run of a case fails, confirmed by a single run."""
    law, scenario = case.run.controller.name, case.run.scenario.name
    changes = _changes(model, case)
    for k in _failed(model, case, changes, criterion):
        name, value = changes[k]
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            run = simulate(model, law, scenario, {name: value})
        if not _succeeds(run, model, criterion):  # noise of a batch differs from the noise of a single run
            yield Failure(place, name, value, run.checksum)


def _changes(model: Model, case: Case) -> list[tuple[str, float]]:
    """Return parameters with another value, the nearest values first."""
    law, values = case.run.controller, case.run.parameters.values
    names = [q.name for q in (*law.parameters, *model.manifest.scenario_parameters, *model.manifest.parameters)]
    free = [name for name in names if values[name] and name not in (law.period, law.delay, *case.formulas)]
    return [(name, float(f"{values[name] * factor:.4g}")) for factor in _FACTORS for name in free]


def _failed(
    model: Model, case: Case, changes: Sequence[tuple[str, float]], criterion: Criterion | None
) -> NDArray[np.intp]:
    """Return the places of the changes whose runs, in one batch, do not succeed."""
    if not changes:
        return np.array([], int)
    values = case.run.parameters.values
    points = {name: [value if name == own else values[name] for own, value in changes] for name, _ in changes}
    campaign = Campaign(
        case.run.controller.name,
        len(changes),
        case.run.scenario.name,
        vary=lists_as_distributions(points, "the page's run"),
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of drawn values that bounds or constraints refuse
        runs = run_batch(model, campaign).dataset()
    status = runs["status"].values
    if criterion is None:
        succeeded = status == Status.DONE
    else:
        succeeded = criterion.succeeds(status, lambda name: runs[name].values)
    return np.flatnonzero(~succeeded & (status != IMPOSSIBLE))


def _succeeds(run: Run, model: Model, criterion: Criterion | None) -> bool:
    if criterion is None:
        return run.status is Status.DONE
    numbers = metrics(run, model.manifest)
    return bool(criterion.succeeds(np.array([run.status]), lambda name: np.array([numbers[name]]))[0])
