# SPDX-License-Identifier: Apache-2.0
"""Campaign, with the parameter vectors and initial states of its runs."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import MISSING, asdict, dataclass, field, replace
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mehvar.base.errors import InputError, bad_value, unknown_name
from mehvar.base.manifest import Parameter, Quantity
from mehvar.base.names import identifier

from ..arguments import check_arguments
from ..model.functions import START_OFF, displacement
from ..model.model import Model
from ..model.parameters import Resolved, check_values, named_values, number, resolve
from ..run.options import OPTIONS, check_effects, count_option, number_option, read_options, rows, word_option
from ..run.problem import (
    actuator_period,
    check_sampled_parts,
    initial_corrections,
    is_consistent,
    of_scenario,
    sampled_parameters,
    variant_suffix,
)
from ..run.readers import check_read
from ..run.user.law import PythonLaw
from .dispersions import read_dispersions
from .sampling import DESIGNS, Design, FloatArray, Sampler

INITIAL = "initial_"

_T = TypeVar("_T")


@dataclass(frozen=True)
class Campaign:
    """All settings that determine the numbers of a batch.

    Parameters
    ----------
    controller, scenario : str
        The law and the scenario; the model's first scenario for None.
    n, seed : int
        Number of runs; seed of all random numbers.
    vary : mapping of str to str
        Distributions by name of a parameter or state, as `read_dispersions` takes them. A state varies at t = 0.
    parameters, initial : mapping
        Parameters and initial states that all runs share.
    sampling : str
        Sampling design, see `Sampler`.
    options : mapping
        Options and choices as in `simulate`, `t_end`, `dt_out`, `method`, `plant` and so on, and `profile`.
    save_every : float, optional
        Step of the stored series, s; default: none are stored.
    """

    controller: str
    n: int = count_option(MISSING, "Number of runs", least=1)
    scenario: str | None = None
    seed: int = count_option(0, "Seed of all random numbers")
    vary: Mapping[str, str] = field(default_factory=dict)
    parameters: Mapping[str, float] = field(default_factory=dict)
    initial: Mapping[str, float] = field(default_factory=dict)
    sampling: Design = word_option("random", "Design of the drawn points", DESIGNS)
    options: Mapping[str, float | str] = field(default_factory=dict)
    save_every: float | None = number_option(
        None, "Step of the stored series", "s", otherwise="none are stored", above=0.0, name="save"
    )

    def json_text(self) -> str:
        """Return the campaign as JSON for stores and workers."""
        return json.dumps(asdict(self), sort_keys=True)


CAMPAIGN_OPTIONS = rows(Campaign)


@dataclass(frozen=True)
class Draw:
    """Consecutive runs from `first`: drawn values and resulting vectors, one row per run.

    `possible` is True for the runs that bounds, constraints and limits allow.
    """

    first: int
    values: FloatArray
    p: FloatArray
    c: FloatArray
    s: FloatArray
    x0: FloatArray
    possible: NDArray[np.bool_]


class Plan:
    """A campaign for a loaded model; `draw` returns its runs.

    Attributes
    ----------
    names : tuple of str
        The dispersed names, in column order of `Draw.values`.
    nominal : Resolved
        Parameters at the centre of every dispersion, which must be possible.
    options : RunOptions
        Options of every run.
    choices : mapping
        Choices of the model by name.
    own : OwnLaw or None
        A law written in Python instead of a law of the model.

    Raises
    ------
    InputError
        For unknown names, invalid distributions, or a nominal run that is impossible.
    """

    def __init__(
        self, model: Model, campaign: Campaign, origin: str = "the call", own: PythonLaw | None = None
    ) -> None:
        manifest = model.manifest
        check_arguments("text", origin, controller=campaign.controller, scenario=campaign.scenario)
        check_arguments("mapping", origin, vary=campaign.vary, parameters=campaign.parameters, initial=campaign.initial)
        self.model, self.origin, self.own = model, origin, own
        self.law = manifest.controller(campaign.controller) if own is None else own.controller
        self.scenario = manifest.scenario(campaign.scenario)
        if own is not None:
            campaign = self._held(campaign, own)
        self.options, choices = read_options(campaign.options, "batch", origin)
        self.origin = of_scenario(self.options, self.scenario, origin)
        self.choices: Mapping[str, Any] = choices
        check_values(manifest, self.law, campaign.parameters, origin, OPTIONS)
        self.dispersions = read_dispersions(dict(sorted(campaign.vary.items())), origin)
        self.campaign = campaign = self._checked(campaign)
        self.names = tuple(name for d in self.dispersions for name in d.names)
        self._groups = (manifest.parameters, self.law.parameters, manifest.scenario_parameters)
        self._columns = [{q.name: i for i, q in enumerate(group)} for group in self._groups]
        self._states = {q.name: i for i, q in enumerate(manifest.states)}
        self._check_names()
        kind, others = f"state of {model.name} in initial", [q.name for q in manifest.scenario_parameters]
        self._initial = named_values(model.state_names, kind, campaign.initial, origin, others)
        self._check_listed()
        self._sampler = Sampler(campaign.sampling, [d.names for d in self.dispersions], campaign.n, campaign.seed)
        centres = {name: value for d in self.dispersions for name, value in d.centre().items()}
        self.nominal = self._resolved(centres, f"{origin} or the middle of vary" if centres else origin)
        check_sampled_parts(manifest, self.nominal.values, self.options.hold, origin)
        if self.options.hold is not None and (both := set(self.names) & sampled_parameters(manifest).keys()):
            raise InputError(f"{min(both)} cannot vary (from {origin}): all runs of a batch share one period")
        self._check_read()
        self.nominal_x0 = self._started(self.nominal.p, self.nominal.s, centres)

    def effective(self) -> dict[str, Any]:
        """Return the options of all runs by name: given values, or defaults of the scenario or of mehvar."""
        scenario = {"t_end": self.scenario.duration, "dt_out": self.scenario.step}
        options = {name: getattr(self.options, name) for name, row in OPTIONS.items() if "batch" not in row.refused}
        return options | {
            name: OPTIONS[name].check(options[name] or value, self.origin) for name, value in scenario.items()
        }

    @property
    def sampled(self) -> bool:
        """True if the law is sampled."""
        return self.options.hold is not None or self.law.period is not None

    @property
    def noisy(self) -> bool:
        """True if runs have noise."""
        return self.model.manifest.random(self.sampled)

    def labels(self) -> tuple[str, ...]:
        """Return the dispersed names as in a store: states are `initial_NAME`."""
        return tuple(name if self._is_parameter(name) else f"{INITIAL}{name}" for name in self.names)

    def quantities(self) -> tuple[Quantity, ...]:
        """Return name, unit and description of each dispersed name."""
        rows: list[Quantity | Parameter]
        rows = [*self.model.manifest.states, *(parameter for group in self._groups for parameter in group)]
        quantities = {q.name: Quantity(q.name, q.unit, q.description) for q in rows}
        return tuple(quantities[name] for name in self.names)

    def facts(self) -> dict[str, Any]:
        """Return the attributes of a store that follow from the campaign and the model."""
        manifest = self.model.manifest
        return {
            "model": manifest.model,
            "model_hash": manifest.hash,
            "controller": self.law.name,
            "scenario": self.scenario.name,
            "seed": self.campaign.seed,
            "drawn": json.dumps(self.labels()),
            "nominal": json.dumps(self.nominal.values),
            "structure": json.dumps(manifest.structure),
        }

    def draw(self, first: int, count: int, points: FloatArray | None = None) -> Draw:
        """Return the runs first ... first + count - 1; a run does not depend on the runs drawn with it.

        `points` of the unit cube, shape (count, names), replace those of the campaign's design.
        """
        values = self._values(first, count, points)
        vectors = [np.tile(v, (count, 1)) for v in (self.nominal.p, self.nominal.c, self.nominal.s)]
        drawn = dict(zip(self.names, values.T, strict=True))
        for vector, columns in zip(vectors, self._columns, strict=True):
            for name in drawn.keys() & columns.keys():
                vector[:, columns[name]] = drawn[name]
        p, c, s = vectors
        self._fill_formulas(c)
        x0 = self._started(p, s, drawn)
        return Draw(first, values, p, c, s, x0, self._possible(p, c, s, x0))

    def drawn(self, run: int) -> dict[str, float]:
        """Return the drawn values of a run by name."""
        return dict(zip(self.names, map(float, self._values(run, 1)[0]), strict=True))

    def settings(self, run: int) -> tuple[dict[str, float], dict[str, float]]:
        """Return the parameters and initial states that repeat this run as a single one."""
        parameters, states = self._split(self.drawn(run))
        return {**self.campaign.parameters, **parameters}, {**self._initial, **states}

    def refusal(self, run: int) -> str:
        """Return the reason why a run is impossible; empty if it is possible."""
        try:
            self._resolved(self.drawn(run), f"run {run}")
        except InputError as error:
            return str(error)
        draw = self.draw(run, 1)
        if draw.possible[0]:
            return ""
        state = ", ".join(f"{name} = {value:.6g}" for name, value in zip(self._states, draw.x0[0], strict=True))
        return f"the initial state of run {run} is impossible (limits, length of a quaternion): {state}"

    def _held(self, campaign: Campaign, own: PythonLaw) -> Campaign:
        """Return the campaign with the hold time of its Python law, as for a sampled law."""
        if "hold" in campaign.options:
            allowed = "left out: hold applies to laws of the model; use period for other laws"
            raise bad_value("hold", campaign.options["hold"], allowed, self.origin)
        dt = OPTIONS["dt_out"].check(campaign.options.get("dt_out") or self.scenario.step, self.origin)
        manifest = self.model.manifest
        values = {q.name: float(campaign.parameters.get(q.name, q.default or 0)) for q in manifest.parameters}
        hold, _ = own.hold(dt, self.origin, actuator_period(manifest, values, self.scenario))
        if hold is None:
            raise bad_value(
                "period",
                None,
                "given: in a batch, laws and inputs in Python are evaluated at samples only",
                self.origin,
            )
        return replace(campaign, options={**campaign.options, "hold": hold})

    def _checked(self, campaign: Campaign) -> Campaign:
        """Return the campaign as stored, with converted and checked values and without default options."""
        numbers: dict[str, Any] = {
            name: row.check(getattr(campaign, name), self.origin) for name, row in CAMPAIGN_OPTIONS.items()
        }
        given = {name: value for name, value in campaign.options.items() if name in OPTIONS}
        check_effects(given, self.options.method, self.sampled, self.noisy, self.origin)
        drawn = any(not dispersion.listed for dispersion in self.dispersions)
        if numbers["seed"] != Campaign.seed and not drawn and not self.noisy:
            raise bad_value(
                "seed", campaign.seed, "left out unless values are drawn or the runs have noise", self.origin
            )
        if numbers["sampling"] != Campaign.sampling and not drawn:
            raise bad_value("sampling", campaign.sampling, "left out unless values are drawn", self.origin)
        return replace(
            campaign,
            options={**self.options.changes(), **self.choices},
            parameters={name: number(name, value, self.origin) for name, value in campaign.parameters.items()},
            initial={name: number(name, value, self.origin) for name, value in campaign.initial.items()},
            **numbers,
        )

    def _check_listed(self) -> None:
        """Refuse lists whose length differs from the number of runs, and lists that a sampling design would mix."""
        for dispersion in self.dispersions:
            if dispersion.listed and dispersion.listed != self.campaign.n:
                allowed = f"{dispersion.listed}, as {', '.join(dispersion.names)} lists as many values"
                raise bad_value("n", self.campaign.n, allowed, self.origin)
            if dispersion.listed and self.campaign.sampling == "saltelli":
                raise bad_value(
                    "sampling", "saltelli", "another design: saltelli combines values of different runs", self.origin
                )

    def _values(self, first: int, count: int, points: FloatArray | None = None) -> FloatArray:
        """Return the drawn values of runs, (count, names), by default from the sampler's points."""
        points = self._sampler.points(first, count) if points is None else points
        values, place = np.empty_like(points), 0
        for dispersion in self.dispersions:
            columns = slice(place, place + len(dispersion.names))
            if dispersion.listed:  # the quantile of these points is the value of the run
                points[:, columns] = ((np.arange(first, first + count) + 0.5) / dispersion.listed)[:, None]
            values[:, columns] = dispersion.quantile(points[:, columns])
            place = columns.stop
        return values

    def _resolved(self, drawn: Mapping[str, float], origin: str) -> Resolved:
        manifest, functions = self.model.manifest, self.model.functions
        values = {**self.campaign.parameters, **self._split(drawn)[0]}
        if self.law.delay:
            values.setdefault(self.law.delay, float(self.options.delay))
        names = (*OPTIONS, *manifest.choices)
        return resolve(manifest, functions, self.law, self.scenario, values, origin, names)

    def _split(self, values: Mapping[str, _T]) -> tuple[dict[str, _T], dict[str, _T]]:
        """Return the values of parameters and of initial states separately."""
        parameters = {name: value for name, value in values.items() if self._is_parameter(name)}
        return parameters, {name: value for name, value in values.items() if name not in parameters}

    def _started(self, p: FloatArray, s: FloatArray, drawn: Mapping[str, ArrayLike]) -> FloatArray:
        """Return the initial states of runs, shape (..., nx)."""
        x0 = np.array(self.model.functions["initial"](p, s))
        for name, value in {**self._initial, **self._split(drawn)[1]}.items():
            x0[..., self._states[name]] = value
        return x0

    def _is_parameter(self, name: str) -> bool:
        return any(name in columns for columns in self._columns)

    def _check_names(self) -> None:
        """Refuse varied names that are unknown, also set, or fixed by the sample times, and vectors of mixed units."""
        names = [name for columns in self._columns for name in columns] + list(self._states)
        fixed = {*self.campaign.parameters, *self.campaign.initial}
        for name in self.names:
            if name not in names:
                kind = f"parameter or state of {self.model.name} with {self.law.name}"
                raise unknown_name(kind, name, names, f"vary, {self.origin}")
            if name in fixed:
                raise InputError(f"{name} is both set and varied (from {self.origin})")
            if name in (self.law.delay, self.law.period):
                raise InputError(
                    f"{name} cannot vary (from {self.origin}): it determines the sample times of {self.law.name}"
                )
        units = {q.name: q.unit for q in self.quantities()}
        for d in self.dispersions:
            if d.of_vector and len({units[name] for name in d.names}) > 1:
                listed = ", ".join(f"{name} in {units[name]}" for name in d.names)
                raise bad_value(",".join(d.names), d.text, f"of components in one unit, not {listed}", self.origin)

    def _check_read(self) -> None:
        """Refuse parameters that no run reads."""
        given = dict(self.campaign.parameters) | {name: d.text for d in self.dispersions for name in d.names}
        suffix = variant_suffix(self.model.manifest, self.choices, self.origin)
        parameters, states = self._split(given)
        check_read(
            self.model.manifest, self.law, suffix, self.sampled, parameters, {*self._initial, *states}, self.origin
        )

    def _fill_formulas(self, c: FloatArray) -> None:
        """Compute law parameters that depend on others, as `resolve` does for one run."""
        places = [i for i, q in enumerate(self.law.parameters) if q.formula is not None]
        derived = [i for i, q in enumerate(self.law.parameters) if self.nominal.origins[q.name].startswith("formula ")]
        if not derived:
            return
        formulas = self.model.functions[f"{identifier(self.law.name)}_defaults"]
        c[:, derived] = math.nan
        for _ in derived:
            defaults = formulas(c)
            for i in derived:
                column = defaults[:, places.index(i)]
                c[:, i] = np.where(np.isnan(c[:, i]), column, c[:, i])

    def _possible(self, p: FloatArray, c: FloatArray, s: FloatArray, x0: FloatArray) -> NDArray[np.bool_]:
        """Return for each run True if its values and initial state are allowed."""
        manifest, functions = self.model.manifest, self.model.functions
        good = np.array(np.isfinite(x0).all(axis=1))
        for group, vectors in zip(self._groups, (p, c, s), strict=True):
            good &= _within(group, vectors)
        if manifest.constraints:
            good &= (functions["constraints"](p, s) > 0).all(axis=1)
        if self.law.constraints:
            good &= (functions[f"{identifier(self.law.name)}_constraints"](p, c, s) > 0).all(axis=1)
        good &= (np.abs(displacement(manifest, functions, x0, p)) <= START_OFF).all(axis=1)
        if manifest.limits:
            inputs = np.zeros(len(manifest.inputs))
            good &= (functions["limits"](x0, inputs, p) > 0).all(axis=1)
        if manifest.algebraic and not self.sampled and self.law.name in manifest.controllers:
            corrections = initial_corrections(self.model, self.law, p, c, s, x0)
            good &= is_consistent(corrections, x0, self.options).all(axis=1)
        return good


def _within(parameters: Sequence[Parameter], values: FloatArray) -> NDArray[np.bool_]:
    """Return True for the rows in which every parameter is within its bounds."""
    good = np.array(np.isfinite(values).all(axis=1))
    for parameter, column in zip(parameters, values.T, strict=True):
        good &= parameter.allows(column)
    return good
