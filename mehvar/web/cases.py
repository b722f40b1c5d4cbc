# SPDX-License-Identifier: Apache-2.0
"""Initial runs of a page: every law in every possible scenario, with results of this machine."""

from __future__ import annotations

import warnings
from dataclasses import dataclass

from mehvar.base.errors import InputError, bad_value
from mehvar.base.manifest import Controller, Scenario
from mehvar.runtime.model.functions import FloatArray
from mehvar.runtime.model.model import Model
from mehvar.runtime.run.simulate import Run, simulate
from mehvar.runtime.run.ticks import ticks_of


@dataclass(frozen=True)
class Case:
    """A run on the host with its schedule, which a page repeats.

    Attributes
    ----------
    run : Run
        Run with default options.
    t : array
        Ticks, s.
    record_every, hold_every : int
        Number of ticks between samples, and number for which an input is held.
    """

    run: Run
    t: FloatArray
    record_every: int
    hold_every: int

    @property
    def rows(self) -> int:
        """Number of samples of the complete run."""
        return -(-(len(self.t) - 1) // self.record_every) + 1

    @property
    def evaluations(self) -> int:
        """Number of evaluations of a sampled law."""
        return (len(self.t) - 1) // self.hold_every + 1

    @property
    def formulas(self) -> list[str]:
        """Law parameters with a formula as default, which user or scenario may override."""
        law, case = self.run.controller, self.run.scenario
        values = {**case.values, **case.controllers.get(law.name, {})}
        return [q.name for q in law.parameters if q.formula is not None and q.name not in values]


def cases_of(model: Model) -> list[Case]:
    """Return the runs of a model, except scenarios that a law refuses.

    Raises
    ------
    InputError
        If no law can run any scenario.
    """
    manifest = model.manifest
    pairs = [(law, scenario) for law in manifest.controllers.values() for scenario in manifest.scenarios.values()]
    cases = [case for pair in pairs if (case := _case(model, *pair))]
    if not cases:
        raise bad_value("model", manifest.model, "a model with a law that runs one of its scenarios")
    return cases


def _case(model: Model, law: Controller, scenario: Scenario) -> Case | None:
    """Return the run of a law in a scenario with its ticks; None if the law refuses the scenario."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # advice about parameters is for the user who sets them
            run = simulate(model, law.name, scenario.name)
    except InputError:
        return None
    end, dt = float(run.options["t_end"]), float(run.options["dt_out"])
    ticks, record_every, hold_every = ticks_of(end, dt, run.hold, "the scenario")
    return Case(run, ticks, record_every, hold_every or 1)
