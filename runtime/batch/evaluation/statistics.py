# SPDX-License-Identifier: Apache-2.0
"""Statistics of a store: success rate, confidence intervals, worst runs, bands, sensitivities.

Data are read by blocks or columns, so that memory does not grow with the stored data per run.
"""

from __future__ import annotations

import json
import math
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mehvar.base.errors import InputError, bad_value, either

from ..blocks import STATUS_TEXT
from ..dispersions import read_dispersions
from ..sampling import OPEN_DESIGNS, FloatArray
from ..store.dataset import Batch
from ..store.layout import NOT_RUN, STATUS, array_of, number_units
from ..store.records import CURE, DamageError
from .binomial import lower_bound, ranks
from .conditions import Criterion

if TYPE_CHECKING:
    from ..store.store import Store

CONFIDENCE = 0.95
QUANTILES = (0.01, 0.05, 0.25, 0.5, 0.75, 0.95, 0.99)
_TURN, _ROUNDING = 2 * math.pi, 1e-9
"""A turn, and the relative excess of one that rounding may leave."""
_SLAB_BYTES = 2**26
"""Number of bytes of series that are read at once, 64 MiB, of which quantiles need several copies. Half as many
double the passes over large chunks.
"""
NO_INTERVAL = {
    "listed": "no interval: the values are listed, not drawn, so the share describes only these runs",
    "saltelli": "no interval: the runs are groups for Sobol indices, and depend on each other",
}
"""Designs for which the share of successful runs is not a probability or has an unknown error."""
_RULE = re.compile(r"^\s*ci\(\s*success\s*\)\s*<\s*([0-9.eE+-]+)\s*$")


def success_condition(text: str | None) -> Criterion:
    """Return the condition of success from a text; without one, success is reaching the end."""
    return Criterion("status == done or status == event" if text is None else text, "success")


def fulfilment(store: Batch, condition: Criterion, blocks: Sequence[int]) -> NDArray[np.bool_]:
    """Return True for each run of some stored blocks that fulfils a condition; see `Criterion.succeeds`.

    Raises
    ------
    InputError
        If the condition has unknown names, names without a number, or mixed units.
    """
    condition.check(scalars(store), notes(store))
    return condition.succeeds(store.read(STATUS, blocks), lambda name: column(store, name, blocks))


class Rule(ABC):
    """Condition on consecutive runs from 0 that ends a batch.

    Attributes
    ----------
    runs : int
        Number of these runs so far.
    counts : tuple of int
        Sums of the counts of their blocks.
    """

    def __init__(self) -> None:
        self.runs, self.counts = 0, tuple[int, ...]()
        self._next, self._by_block = 0, dict[int, tuple[int, ...]]()

    @abstractmethod
    def count(self, store: Batch, block: int) -> tuple[int, ...]:
        """Return the counts of a stored block."""

    @abstractmethod
    def holds(self, counts: Sequence[int], runs: int) -> bool:
        """Return True if the sums over the first runs suffice; each call adds runs."""

    def holds_with(self, store: Batch, block: int) -> bool:
        """Count a stored block, in any order of blocks; return True if the rule holds for the runs up to `runs`."""
        self._by_block[block] = self.count(store, block)
        while (counts := self._by_block.pop(self._next, None)) is not None:
            self.runs += len(store.runs(self._next))
            self.counts = tuple(map(sum, zip(self.counts or (0,) * len(counts), counts, strict=True)))
            self._next += 1
            if self.holds(self.counts, self.runs):
                return True
        return False


class StopRule(Rule):
    """Rule on the interval of the success probability.

    Parameters
    ----------
    text : str
        Rule such as "ci(success) < 0.01", on the full width of the exact 95 % interval of the success probability.
    design : str
        Design of the runs, as of `design_of`. Only independent points and the Sobol sequence can end early.
    success : Criterion, optional
        Condition of success; default: reaching the end.

    Raises
    ------
    InputError
        If the text is not such a rule, the width is not in (0, 1), or the design needs all its runs.
    """

    def __init__(self, text: str, design: str, success: Criterion | None = None) -> None:
        super().__init__()
        match = _RULE.match(text)
        try:
            self._width = float(match.group(1)) if match else 0.0
        except ValueError:
            self._width = 0.0
        if not 0 < self._width < 1:
            raise bad_value("until", text, "'ci(success) < WIDTH' with a WIDTH between 0 and 1, or 'decided'")
        if design == "listed":
            raise InputError(f"until = {text!r} needs random draws: values(...) lists are not random")
        if design not in OPEN_DESIGNS:
            raise InputError(f"until = {text!r} needs sampling {either(OPEN_DESIGNS)}: {design} needs all n runs")
        self._success = success or success_condition(None)

    def count(self, store: Batch, block: int) -> tuple[int, ...]:
        """Return the number of successful runs in a block."""
        return (int(np.count_nonzero(fulfilment(store, self._success, [block]))),)

    def holds(self, counts: Sequence[int], runs: int) -> bool:
        """Return True if the interval is narrow enough."""
        low, high = interval(counts[0], runs)
        return high - low < self._width


def interval(successes: int, runs: int) -> tuple[float, float]:
    """Return the exact 95 % interval of a probability (Clopper and Pearson 1934)."""
    one_sided = (1 + CONFIDENCE) / 2
    return lower_bound(successes, runs, one_sided), 1 - lower_bound(runs - successes, runs, one_sided)


def design_of(attributes: Mapping[str, Any]) -> str:
    """Return the design of a batch, by its store's attributes: a sampling design, or "listed"."""
    campaign = json.loads(attributes.get("campaign", "{}"))
    dispersions = read_dispersions(campaign.get("vary", {}))
    return "listed" if any(d.listed for d in dispersions) else str(campaign.get("sampling", "random"))


def notes(store: Batch) -> dict[str, str]:
    """Return the reasons in a store why a metric has no value in any run."""
    return {name: v.attributes["note"] for name, v in store.variables().items() if "note" in v.attributes}


def scalars(store: Batch) -> dict[str, str]:
    """Return the unit of every name in conditions; each is one number per run."""
    return number_units(store.variables().values(), store.coordinate)


def column(store: Batch, name: str, blocks: Sequence[int] | None = None) -> FloatArray:
    """Return a number of each stored run, by a name of `scalars`."""
    array, place = array_of(name, store.coordinate)
    if place is None:
        return store.read(name, blocks)
    selection = store.stored() if blocks is None else blocks
    return np.concatenate([store.read(array, [block])[:, place] for block in selection])


@dataclass(frozen=True)
class MetricStatistics:
    """Statistics of one number of the runs: mean of finite values, quantiles, extreme runs.

    `note` is the reason if no run has the number. `intervals` has the 95 % interval of each quantile. An end is NaN
    if too few runs determine it; both are NaN if the design has no interval.
    """

    name: str
    unit: str
    description: str
    note: str
    finite: int
    mean: float
    sd: float
    quantiles: Mapping[float, float]
    intervals: Mapping[float, tuple[float, float]]
    smallest: tuple[int, float]
    largest: tuple[int, float]


@dataclass(frozen=True)
class Statistics:
    """Result of `summarise`.

    Attributes
    ----------
    planned, stored : int
        All runs, and those stored and intact.
    writer : str or None
        The process that is writing the store now.
    statuses : mapping of str to int
        Number of runs by how they ended.
    endings : mapping of str to (int, int)
        For each event, the number of runs that it ended, and the number that it ended at their start.
    successes : int
        Number of successful runs; `probability` is their share, `low` and `high` its exact 95 % interval.
    design : str
        Design of the runs; those of `NO_INTERVAL` have NaN as every end of an interval.
    rows : list of MetricStatistics
        One per metric of the model; of a model without metrics, one per state at the end.
    """

    planned: int
    stored: int
    writer: str | None
    statuses: Mapping[str, int]
    endings: Mapping[str, tuple[int, int]]
    successes: int
    probability: float
    low: float
    high: float
    design: str
    rows: list[MetricStatistics]


def summarise(store: Store, success: str | None = None) -> Statistics:
    """Return the statistics of a store, finished or not.

    Parameters
    ----------
    store : Store
        The store.
    success : str, optional
        Condition that a run fulfils besides reaching its end; default: the batch's own condition.

    Raises
    ------
    InputError
        If nothing is stored yet, or the condition has names that the store lacks.
    DamageError
        If a file of the store is missing or changed.
    """
    blocks, writer = whole_blocks(store)
    condition = success_condition((store.attributes["success"] or None) if success is None else success)
    endings, successes = np.zeros(NOT_RUN + 1, np.int64), 0
    for block in blocks:
        endings += np.bincount(store.read(STATUS, [block]), minlength=len(endings))
        successes += int(np.count_nonzero(fulfilment(store, condition, [block])))
    runs = int(endings.sum())
    design = design_of(store.attributes)
    low, high = (math.nan, math.nan) if design in NO_INTERVAL else interval(successes, runs)
    return Statistics(
        planned=store.n,
        stored=runs,
        writer=writer,
        statuses={STATUS_TEXT[code]: int(endings[code]) for code in np.flatnonzero(endings).tolist()},
        endings=_endings(store, blocks),
        successes=successes,
        probability=successes / runs,
        low=low,
        high=high,
        design=design,
        rows=[metric_statistics(store, name, blocks, design) for name in summary_names(store)],
    )


def whole_blocks(store: Store) -> tuple[Sequence[int], str | None]:
    """Return the intact stored blocks, and the process that currently writes the store.

    Raises
    ------
    InputError
        If nothing is stored yet.
    DamageError
        If a file of the store is missing or changed.
    """
    verification = store.verify()
    writer = verification.writer
    if not verification.sound and writer is None:
        raise DamageError(f"{store.name} is damaged: {verification.summary()}; {CURE}")
    if not verification.whole:
        raise InputError(f"{store.name} has no stored run yet{f': it is being written by {writer}' if writer else ''}")
    return verification.whole, writer


def _endings(store: Batch, blocks: Sequence[int]) -> dict[str, tuple[int, int]]:
    """Return the numbers of runs that each event ended, in total and at their start, failures first."""
    events = store.coordinate("event")
    ends = events.attributes.get("ends", ())
    if not any(ends):
        return {}
    happened, begins = store.read("events", blocks) > 0, store.read("t_stop", blocks) == 0
    left, counts = np.ones(len(begins), bool), dict[int, tuple[int, int]]()
    for k in sorted((k for k, how in enumerate(ends) if how), key=lambda k: (ends[k] != "failure", k)):
        ended = happened[:, k] & left
        left &= ~ended
        counts[k] = int(np.count_nonzero(ended)), int(np.count_nonzero(ended & begins))
    return {str(events.values[k]): counts[k] for k in sorted(counts) if counts[k][0]}


NO_METRICS = "the model declares no metrics (in scenarios.toml, or System(metrics=...))"


def metric_names(store: Batch) -> list[str]:
    """Return the model's metrics in a store, in the model's order."""
    names: list[str] = json.loads(store.attributes["metrics"])
    return names


def summary_names(store: Batch) -> list[str]:
    """Return the names of the metrics; for a model without metrics, of the final states."""
    return metric_names(store) or [f"final({state})" for state in store.coordinate("state").values]


def drawn_names(store: Batch) -> list[str]:
    """Return the drawn values in a store, in the order of the dispersions."""
    names: list[str] = json.loads(store.attributes["drawn"])
    return names


def worst(
    store: Batch, values: Callable[[int], FloatArray], most: int, before: int | None = None
) -> list[tuple[int, float]]:
    """Return the runs with the largest values and these, largest first; runs without a value are omitted.

    Parameters
    ----------
    values : callable
        Returns one number for each run of a block.
    before : int, optional
        Read only blocks before this run; default: all.
    """
    blocks = [block for block in store.stored() if before is None or store.runs(block).stop <= before]
    runs = np.concatenate([np.empty(0, int), *map(store.runs, blocks)])
    numbers = np.concatenate([np.empty(0), *map(values, blocks)])
    order = np.argsort(-numbers, kind="stable")[: min(most, np.count_nonzero(~np.isnan(numbers)))]  # NaN are last
    return list(zip(runs[order].tolist(), numbers[order].tolist(), strict=True))


def bands(store: Batch, name: str, quantiles: Sequence[float]) -> FloatArray:
    """Return quantiles over the runs of a stored series, shape (quantiles, samples), without ended runs.

    An angle that `wraps` is unwrapped in each run, from starts within half a turn of their mean direction: its
    quantiles would span the whole turn.

    Raises
    ------
    InputError
        If the store has no such series.
    """
    variable = store.variables().get(name)
    if variable is None or variable.dimension != "t":
        raise InputError(
            f"{store.name} holds no series {name!r}; a batch stores series with --save DT, or save=DT in Python"
        )
    parts, before = [], None
    wrapped = wraps(store, name)
    for values in _slabs(store, name):
        if wrapped:
            before = values = _unwrapped(values, before)
        alive = np.isfinite(values).any(axis=0)
        part = np.full((len(quantiles), values.shape[1]), np.nan)
        part[:, alive] = np.nanquantile(values[:, alive], quantiles, axis=0)
        parts.append(part)
    return np.concatenate(parts, axis=1)


def wraps(store: Batch, name: str) -> bool:
    """Return True for a stored angle within one turn that jumps by more than half a turn in some run."""
    if store.variables()[name].attributes.get("units") != "rad":
        return False
    low, high, jumps, before = math.inf, -math.inf, False, np.empty((0, 0))
    for values in _slabs(store, name):
        low, high = np.fmin(low, np.nanmin(values, initial=low)), np.fmax(high, np.nanmax(values, initial=high))
        if high - low > _TURN * (1 + _ROUNDING):
            return False
        steps = np.diff(np.hstack([before, values]) if before.size else values, axis=1)
        jumps, before = jumps or bool((np.abs(steps) > _TURN / 2).any()), values[:, -1:]
    return jumps


def _slabs(store: Batch, name: str) -> Iterator[FloatArray]:
    """Yield the samples of a stored series in parts that fit in memory, shape (runs, samples)."""
    blocks, size = store.stored(), store.variables()[name].size
    width = max(1, _SLAB_BYTES // (8 * sum(len(store.runs(block)) for block in blocks)))
    for first in range(0, size, width):
        yield store.series(name, first, min(first + width, size), blocks)


def _unwrapped(values: FloatArray, before: FloatArray | None) -> FloatArray:
    """Return angles without jumps, continued from the samples before them or near their mean direction."""
    if before is None:
        start = values[:, :1]
        mean = np.angle(np.nansum(np.exp(1j * start)))
        before = start - _TURN * np.round((start - mean) / _TURN)
    return np.unwrap(np.hstack([before[:, -1:], values]), axis=1)[:, 1:]


def metric_statistics(store: Batch, name: str, blocks: Sequence[int], design: str) -> MetricStatistics:
    """Return the statistics of one number per run over some blocks, by a name of `scalars`."""
    attributes, values = number_attributes(store, name), column(store, name, blocks)
    runs = np.concatenate([store.runs(block) for block in blocks])
    ends = np.cumsum([len(store.runs(block)) for block in blocks])
    parts = [part[np.isfinite(part)] for part in np.split(values, ends[:-1])]
    finite, centre = sum(part.size for part in parts), next((float(part[0]) for part in parts if part.size), 0.0)
    # block by block, so that the sums do not depend on how blocks are read
    total = sum(float(np.sum(part - centre)) for part in parts)
    squares = sum(float(np.sum((part - centre) ** 2)) for part in parts)
    variance = (squares - total**2 / finite) / (finite - 1) if finite > 1 else math.nan
    smallest, largest = (_end(runs, values, find) for find in (np.argmin, np.argmax))
    quantiles, intervals = _quantiles(values)
    if design in NO_INTERVAL:
        intervals = dict.fromkeys(QUANTILES, (math.nan, math.nan))
    return MetricStatistics(
        name=name,
        unit=attributes["units"],
        description=attributes["long_name"],
        note=attributes.get("note", ""),
        finite=finite,
        mean=centre + total / finite if finite else math.nan,
        sd=math.sqrt(max(variance, 0.0)) if finite > 1 else math.nan,
        quantiles=quantiles,
        intervals=intervals,
        smallest=smallest,
        largest=largest,
    )


def number_attributes(store: Batch, name: str) -> Mapping[str, Any]:
    """Return unit, description and note of one number per run."""
    if name in (variables := store.variables()):
        return variables[name].attributes
    return {"units": scalars(store)[name], "long_name": "where the run ended" if name.startswith("final(") else name}


def _end(runs: NDArray[np.int_], values: FloatArray, find: Callable[[FloatArray], np.intp]) -> tuple[int, float]:
    """Return run and value of the smallest or the largest number; run -1 without numbers."""
    places = np.flatnonzero(~np.isnan(values))
    if not places.size:
        return -1, math.nan
    place = places[find(values[places])]
    return int(runs[place]), float(values[place])


def _quantiles(values: FloatArray) -> tuple[dict[float, float], dict[float, tuple[float, float]]]:
    """Return quantiles and their intervals without interpolation, because values may be infinite.

    Sorts in place.
    """
    values.sort()  # NaN last
    known = values[: len(values) - int(np.count_nonzero(np.isnan(values)))]
    if not known.size:
        return dict.fromkeys(QUANTILES, math.nan), dict.fromkeys(QUANTILES, (math.nan, math.nan))
    padded = np.concatenate([[math.nan], known, [math.nan]])
    places = {q: ranks(q, known.size, CONFIDENCE) for q in QUANTILES}
    intervals = {q: (float(padded[low]), float(padded[high])) for q, (low, high) in places.items()}
    return {q: float(known[math.ceil(q * known.size) - 1]) for q in QUANTILES}, intervals
