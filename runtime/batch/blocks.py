# SPDX-License-Identifier: Apache-2.0
"""A block of runs: contents and computation."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mehvar.base.errors import InputError
from mehvar.base.manifest import Quantity

from ..run.metrics import undetermined
from ..run.options import AUTO, EXPLICIT, STIFF
from ..run.problem import Status
from ..run.results import attributes_of
from ..run.ticks import rows_of
from .kernel import compile_kernel
from .numerics import numerics_of, provenance
from .plan import Plan
from .sampling import FloatArray
from .store.layout import NOT_RUN, STATUS, Coordinate, Variable, number_units

Values = Mapping[str, NDArray[Any]]
"""Values of a block's runs in a store, by name."""

Missing = Sequence[tuple[int, range]]
"""Numbers of blocks, each with its runs."""

Provenance = Mapping[str, str | int]
"""The origin of a block: compiler, lanes, flags, versions."""

BlockSource = Callable[[Missing], Generator[tuple[int, Values, Provenance], None, None]]
"""Function that computes the missing blocks of a store, in any order."""

IMPOSSIBLE = 5
STATUS_TEXT = {int(status): status.text for status in Status} | {IMPOSSIBLE: "impossible", NOT_RUN: "not run"}
_IMPOSSIBLE = {"events": 0, "steps": 0, "violated": -1, STATUS: IMPOSSIBLE}
"""Results of impossible runs; others are NaN."""


class Blocks:
    """Computation of a plan's runs in blocks.

    Parameters
    ----------
    plan : Plan
        The runs.
    threads : int
        Threads that compute one block.

    Attributes
    ----------
    instants : array
        Instants of the stored series, s.
    numerics : str
        JSON of all that affects the rounding of runs on this machine.
    provenance : mapping
        The origin of the blocks.

    Raises
    ------
    InputError
        If a batch does not support an option, or there is no C compiler.
    """

    def __init__(self, plan: Plan, threads: int) -> None:
        self.plan, self.threads = plan, threads
        options = plan.options
        effective = plan.effective()
        self._auto = options.method == AUTO
        self._t_end: float = effective["t_end"]
        self._dt: float = effective["dt_out"]
        self._kernel = compile_kernel(
            plan.model, plan.law.name, plan.choices, options, own=plan.own, origin=plan.origin
        )
        self.metrics = self._kernel.loop.metrics
        self.notes = undetermined({metric.name: metric for metric in self.metrics}, self._t_end, self._dt)
        self._kernel.check(plan.nominal.p[None], self._t_end, self._dt)
        self.instants = self._instants()
        self.numerics = numerics_of(self._kernel, plan.campaign.sampling, effective)
        self.provenance: Provenance = provenance(self._kernel)

    @property
    def samples(self) -> int:
        """Number of sampling steps per run."""
        return math.ceil(self._t_end / self._dt)

    def variables(self) -> list[Variable]:
        """Return the variables that a store has for each run."""
        drawn = zip(self.plan.labels(), self.plan.quantities(), strict=True)
        series = self.quantities().items() if len(self.instants) else ()
        return [
            *(Variable(label, "float64", attributes=_about(f"{q.description}, drawn", q.unit)) for label, q in drawn),
            *self._summaries(),
            *(Variable(m.name, "float64", attributes=attributes_of(m, self.notes.get(m.name))) for m in self.metrics),
            *(Variable(name, "float64", "t", len(self.instants), _about(q.description, q.unit)) for name, q in series),
            *self._ends(),
        ]

    def _summaries(self) -> list[Variable]:
        """Return the summaries of a run's variables."""
        states, wide = len(self.plan.model.manifest.states), len(self._kernel.variables)
        return [
            Variable("final", "float64", "state", states, _about("state where the run ended")),
            Variable("minimum", "float64", "variable", wide, _about("smallest value over the run")),
            Variable("maximum", "float64", "variable", wide, _about("largest value over the run")),
        ]

    def _ends(self) -> list[Variable]:
        """Return the variables that tell how a run ended."""
        found = f"where {EXPLICIT} found the run stiff, which {STIFF} then made again from the start"
        events, words = len(self._kernel.loop.events), " ".join(text.replace(" ", "_") for text in STATUS_TEXT.values())
        flags = {"flag_values": list(STATUS_TEXT), "flag_meanings": words}
        return [
            Variable("t_stop", "float64", attributes=_about("where the run ended", "s")),
            Variable("error", "float64", attributes=_about("largest error of a step over its tolerance", "1")),
            *([Variable("t_stiff", "float64", attributes=_about(found, "s"))] if self._auto else []),
            *(
                [Variable("events", "int64", "event", events, _about("how often each event happened"))]
                if events
                else []
            ),
            Variable("steps", "int64", attributes=_about("accepted steps of the integrator", "1")),
            Variable("violated", "int8", attributes=_about("which limit ended the run, -1 for none")),
            Variable(STATUS, "uint8", attributes={**_about("how the run ended"), **flags}),
        ]

    def coordinates(self) -> dict[str, Coordinate]:
        """Return the coordinates of second dimensions: names or instants."""
        wide = self.quantities()
        coordinates = {
            "state": Coordinate(list(self.plan.model.state_names)),
            "variable": Coordinate(list(wide), {"units": [q.unit for q in wide.values()]}),
        }
        if events := self._kernel.loop.events:
            coordinates["event"] = Coordinate([event.name for event in events], {"ends": [e.ends for e in events]})
        if len(self.instants):
            coordinates["t"] = Coordinate(self.instants, {"units": "s", "long_name": "time"})
        return coordinates

    def scalars(self) -> dict[str, str]:
        """Return the unit of every name that conditions may use; each is one number per run."""
        return number_units(self.variables(), self.coordinates().__getitem__)

    def quantities(self) -> dict[str, Quantity]:
        """Return all variables of a run in the order of the kernel's columns."""
        manifest = self.plan.model.manifest
        quantities = {q.name: q for q in (*manifest.states, *manifest.outputs, *self.plan.law.memory)}
        quantities |= {f"u_{q.name}": q for q in manifest.inputs} | {f"u_cmd_{q.name}": q for q in manifest.inputs}
        return {name: quantities[name] for name in self._kernel.variables}

    def compute(
        self, first: int, count: int, stop: Callable[[], bool] | None = None, points: FloatArray | None = None
    ) -> Values | None:
        """Return the values of `count` runs from `first` on by name, or None if `stop` ended the computation.

        `points` are as of `Plan.draw`.
        """
        plan = self.plan
        draw = plan.draw(first, count, points)
        bad = ~draw.possible
        for vectors, nominal in ((draw.p, plan.nominal.p), (draw.c, plan.nominal.c), (draw.s, plan.nominal.s)):
            vectors[bad] = nominal
        draw.x0[bad] = plan.nominal_x0
        seed, save = plan.campaign.seed, plan.campaign.save_every
        block = self._kernel.run(
            first, draw.p, draw.c, draw.s, draw.x0, seed, self._t_end, self._dt, save, self.threads, stop
        )
        if block is None:
            return None
        values: dict[str, NDArray[Any]] = {v.name: getattr(block, v.name) for v in (*self._summaries(), *self._ends())}
        values |= {metric.name: block.metric_values[:, i] for i, metric in enumerate(self.metrics)}
        if len(self.instants):
            values |= {name: block.series[:, :, i] for i, name in enumerate(self._kernel.variables)}
        for name, array in values.items():
            array[bad] = _IMPOSSIBLE.get(name, math.nan)
        return {**dict(zip(plan.labels(), draw.values.T, strict=True)), **values}

    def _instants(self) -> NDArray[np.float64]:
        every = self.plan.campaign.save_every
        if every is None:
            return np.empty(0)
        return rows_of(every, self._t_end, self._dt, self.plan.origin)


def check_names(variables: list[Variable]) -> None:
    """Refuse a model for which two variables of a store would have the same name."""
    names = [variable.name for variable in variables]
    twice = [name for name in names if names.count(name) > 1]
    if twice:
        raise InputError(f"a store cannot hold two variables called {twice[0]}: rename one in the model")


def _about(text: str, unit: str | None = None) -> dict[str, Any]:
    """Return the attributes of a variable."""
    return {"long_name": text} if unit is None else {"units": unit, "long_name": text}
