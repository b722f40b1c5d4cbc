# SPDX-License-Identifier: Apache-2.0
"""Verdicts on requirements that rarely fail, from a search for failures; see `splitting`."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mehvar.base.errors import bad_value

from ...model.model import Model
from ...run.problem import COMPLETE
from ...run.user.law import PythonLaw
from ..blocks import IMPOSSIBLE, Blocks, Values
from ..plan import Campaign, Plan
from ..sampling import FloatArray, stream
from ..store.layout import STATUS, array_of
from .requirements import RareEvidence, Requirement, Verdict, read_requirements
from .splitting import FEWEST, REPETITIONS, Estimate, Levels, bounds, estimate, most_levels, pilot

Progress = Callable[[int, int], None]
"""Function that receives the number of runs so far and the largest possible number."""

_RAREST = 1e-12
"""Smallest share of failures. For smaller shares, points of the unit cube are too coarse: they are multiples of
1e-16."""
_PILOT = 100
"""Divisor of the number of runs that gives the pilot's runs per level, which are at least those of a repetition."""
_AT_ONCE = 2**14
"""Number of runs that are computed at once, with all their summaries."""
_EDGE = 2.0**-53


def decide_rare(
    model: Model,
    campaign: Campaign,
    requirements: Mapping[str, str],
    confidence: float,
    threads: int,
    own: PythonLaw | None = None,
    report: Progress | None = None,
    origin: str = "the call",
) -> list[Verdict]:
    """Decide requirements with a search for failures.

    Parameters
    ----------
    model, own, origin
        As of `run_batch`.
    campaign : Campaign
        The runs; n is the largest number of runs per requirement.
    requirements : mapping of str to str
        Quantiles by name, as of `read_requirements`.
    confidence : float
        Confidence of each bound.
    threads : int
        Threads of this process.
    report : callable, optional
        Called after each step.

    Raises
    ------
    InputError
        Without a requirement or distribution, for a requirement on a probability, or if a batch refuses an argument.
    """
    plan = Plan(model, campaign, origin, own)
    _check(plan, origin)
    blocks = Blocks(plan, threads)
    read = read_requirements(requirements, blocks.scalars(), blocks.notes, origin)
    if not read:
        raise bad_value("require", requirements, "at least one requirement", origin)
    for requirement in read:
        _check_rare(requirement, origin)
    seekers = [_Seeker(blocks, requirement, k, len(read), report) for k, requirement in enumerate(read)]
    return [seeker.verdict(confidence) for seeker in seekers]


def _check(plan: Plan, origin: str) -> None:
    if not plan.names or any(d.listed for d in plan.dispersions):
        allowed = "distributions: rare failures are sought among the drawn values"
        raise bad_value("vary", dict(plan.campaign.vary), allowed, origin)
    if plan.campaign.sampling != Campaign.sampling:
        raise bad_value("sampling", plan.campaign.sampling, "left out with rare: the points depend on the runs", origin)
    if plan.campaign.save_every is not None:
        raise bad_value("save", plan.campaign.save_every, "left out with rare, which does not store runs", origin)


def _check_rare(requirement: Requirement, origin: str) -> None:
    name, text = requirement.name, requirement.text
    if not requirement.number:
        raise bad_value(name, text, "a quantile with rare, as in 'quantile(0.999999, PEAK) < 1 deg'", origin)
    if 1 - requirement.share < _RAREST:
        raise bad_value(name, text, f"about a share of failures of at least {_RAREST:g}", origin)


class _Seeker:
    """Search for failures of one requirement."""

    def __init__(
        self, blocks: Blocks, requirement: Requirement, place: int, places: int, report: Progress | None
    ) -> None:
        self._blocks, self._requirement = blocks, requirement
        self._n = blocks.plan.campaign.n
        self._runs, self._before, self._all = 0, place * self._n, places * self._n
        self._impossible, self._report = False, report

    def verdict(self, confidence: float) -> Verdict:
        """Return the verdict on the requirement."""
        requirement, plan = self._requirement, self._blocks.plan
        if self._n < _enough(0):
            return Verdict(requirement, "undecided", None, f"undecided: {self._too_few()}", ())
        rng = np.random.Generator(stream(plan.campaign.seed, f"failures of {requirement.text}"))
        dimensions, score = len(plan.names), self._score
        stages = pilot(score, dimensions, max(FEWEST, self._n // _PILOT), 1 - requirement.share, rng)
        size = (self._n - self._runs) // (REPETITIONS * (1 + len(stages.levels)))
        problem = stages.problem or (self._too_few() if size < FEWEST else "")
        if problem:
            return Verdict(requirement, "undecided", None, f"undecided after {self._runs} runs: {problem}", ())
        return self._decided(stages, estimate(score, dimensions, size, stages, rng), confidence)

    def _decided(self, stages: Levels, result: Estimate, confidence: float) -> Verdict:
        """Return the verdict by the bounds on the share of failures; undecided if the estimate has a problem."""
        requirement = self._requirement
        if result.problem:
            return Verdict(requirement, "undecided", None, f"undecided after {self._runs} runs: {result.problem}", ())
        least, most = bounds(result.shares, confidence)
        least = least if stages.end == 0 else 0.0
        facts = RareEvidence(self._runs, None, 1 - most, 1 - least, least, most)
        reason = f"{len(stages.levels)} levels, {REPETITIONS} repetitions; failures far from all others may be missed"
        reason += "; runs with values that are not allowed count as failures" if self._impossible else ""
        failures = self._values(result.failed)
        return Verdict(requirement, facts.answer(requirement.share), facts, reason, (), failures)

    def _too_few(self) -> str:
        return f"n = {self._n} is too small: {_enough(most_levels(1 - self._requirement.share))} runs are enough"

    def _score(self, points: FloatArray) -> FloatArray:
        """Return the distance of each run's number from the limit, which is zero or positive for failures."""
        parts = np.array_split(points, -(-len(points) // _AT_ONCE) or 1)
        scores: FloatArray = np.concatenate([self._piece(part) for part in parts])
        return scores

    def _piece(self, points: FloatArray) -> FloatArray:
        """Return the scores of runs at standard normal points; a run without a number counts as a failure."""
        count, requirement = len(points), self._requirement
        values = self._blocks.compute(self._runs, count, points=_cube(points))
        assert values is not None
        self._runs += count
        if self._report is not None:
            self._report(self._before + self._runs, self._all)
        status = values[STATUS]
        self._impossible |= bool((status == IMPOSSIBLE).any())
        assert requirement.number is not None
        number = requirement.number(lambda name: self._column(values, name))
        failed = ~requirement.condition.succeeds(status, lambda name: self._column(values, name))
        excess = number - requirement.limit if requirement.largest else requirement.limit - number
        excess[~np.isin(status, COMPLETE) | np.isnan(excess)] = math.inf
        scores: FloatArray = np.where(failed, np.maximum(excess, 0.0), np.minimum(excess, -math.ulp(0.0)))
        return scores

    def _column(self, values: Values, name: str) -> NDArray[Any]:
        """Return one number per run, by its name in conditions."""
        coordinates = self._blocks.coordinates()
        array, place = array_of(name, coordinates.__getitem__)
        return values[array] if place is None else values[array][:, place]

    def _values(self, points: FloatArray) -> dict[str, FloatArray]:
        """Return the drawn values of points by name."""
        drawn = self._blocks.plan.draw(0, len(points), _cube(points)).values
        return dict(zip(self._blocks.plan.names, drawn.T, strict=True))


def _enough(levels: int) -> int:
    """Return a sufficient number of runs for a pilot and all repetitions."""
    pilot_alone, search = FEWEST * (1 + levels), FEWEST * REPETITIONS * (1 + levels)
    return math.ceil(max(pilot_alone + search, search / (1 - (1 + levels) / _PILOT)))


def _cube(points: FloatArray) -> FloatArray:
    """Return points of the unit cube from standard normal numbers."""
    from scipy.special import ndtr

    cube: FloatArray = np.clip(ndtr(points), _EDGE, 1 - _EDGE)
    return cube
