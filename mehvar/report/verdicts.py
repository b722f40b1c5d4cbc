# SPDX-License-Identifier: Apache-2.0
"""Verdicts on requirements: text, facts, and a page for reviews."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from mehvar.api import check_file_determines, posed_batch, stored_batch
from mehvar.base.errors import bad_value, unknown_name
from mehvar.campaign import read_campaign
from mehvar.html import page
from mehvar.runtime.arguments import check_arguments
from mehvar.runtime.batch.blocks import STATUS_TEXT
from mehvar.runtime.batch.evaluation.conditions import Number
from mehvar.runtime.batch.evaluation.rare import Progress, decide_rare
from mehvar.runtime.batch.evaluation.requirements import (
    DECIDED,
    Verdict,
    checked_confidence,
    decide,
    stored_requirements,
)
from mehvar.runtime.batch.evaluation.statistics import column, scalars
from mehvar.runtime.batch.fill import used_threads
from mehvar.runtime.batch.repeat import repetition
from mehvar.runtime.batch.store.layout import STATUS
from mehvar.runtime.batch.store.store import Store, open_store
from mehvar.runtime.model.model import Model, load
from mehvar.runtime.run.problem import COMPLETE

_SHOWN = 3
"""Number of failures whose values are shown."""
_KINDS = {"holds": "holds", "does not hold": "fails", "undecided": "note"}
"""Colours of verdicts on a page."""


def require(
    runs: Model | str | os.PathLike[str],
    requirements: Mapping[str, str] | None = None,
    *,
    confidence: float | None = None,
    rare: bool = False,
    **batch: Any,
) -> Verdicts:
    """Decide requirements from the runs of a store, or from new runs until all are decided.

    Parameters
    ----------
    runs : path, str or Model
        The store of a batch; a campaign file that ends in `.toml`; or a model, whose batch the other arguments
        describe.
    requirements : mapping of str to str, optional
        Requirements by name, such as "quantile(0.997, PEAK) < 0.02 deg" or "probability(T_x < 20) > 0.99", on the
        numbers that success conditions may use. Default: those of the store or campaign.
    confidence : float, optional
        Each bound is wrong with a probability of at most 1 - confidence; default: the store's, or 0.95.
    rare : bool
        Search for rare failures by splitting, for failure rates of 1/1000 or less. n is then the largest number of
        runs per requirement. The runs are not stored.
    **batch
        Arguments of `mehvar.batch`. Its n is the largest number of runs.

    Returns
    -------
    Verdicts
        One verdict per requirement: holds, does not hold or undecided, with the evidence and the worst runs.

    Raises
    ------
    InputError
        If there is no requirement, a requirement cannot be read, or `mehvar.batch` refuses an argument.
    """
    check_arguments("mapping", "the call", requirements=requirements)
    check_arguments("truth", "the call", rare=rare)
    if not isinstance(runs, Model):
        check_arguments("path", "the call", runs=runs)
    if rare:
        return _rare(runs, requirements, confidence, **batch)
    if not isinstance(runs, Model) and not batch and not _is_file(runs):
        return Verdicts(open_store(runs), requirements, confidence)
    if "until" not in batch:
        batch["until"] = (read_campaign(Path(str(runs))).until if _is_file(runs) else None) or DECIDED
    return Verdicts(stored_batch(runs, require=requirements, confidence=confidence, **batch), None, None)


def _is_file(runs: object) -> bool:
    """Return True for a campaign file."""
    return not isinstance(runs, Model) and str(runs).endswith(".toml")


def _rare(
    runs: Model | str | os.PathLike[str],
    requirements: Mapping[str, str] | None,
    confidence: float | None,
    *,
    threads: int | None = None,
    report: Progress | None = None,
    **batch: Any,
) -> Verdicts:
    """Decide requirements with a search for rare failures."""
    _check_not_stored(batch, "the call")
    own, origin = None, "the call"
    if isinstance(runs, Model) or not _is_file(runs):
        campaign, own = posed_batch(runs, **batch)
    else:
        check_file_determines(runs, batch)
        file, origin = read_campaign(Path(runs)), str(runs)
        _check_not_stored({name: str(value) for name, value in vars(file).items() if value is not None}, origin)
        requirements = file.require if requirements is None else requirements
        confidence = file.confidence if confidence is None else confidence
        runs, campaign = file.model, file.campaign(origin)
    confidence = checked_confidence(confidence, origin)
    model = runs if isinstance(runs, Model) else load(runs, "c")
    threads = used_threads(threads, origin)
    verdicts = decide_rare(model, campaign, requirements or {}, confidence, threads, own, report, origin)
    title = f"{model.name} {campaign.controller} {campaign.scenario}: failures sought, seed {campaign.seed}"
    return RareVerdicts(verdicts, title, confidence)


def _check_not_stored(given: Mapping[str, object], origin: str) -> None:
    """Refuse arguments of a stored batch in a search for rare failures."""
    for name in ("out", "resume", "success", "until", "strict", "scheduler"):
        if name in given:
            raise bad_value(name, given[name], "left out with rare, which does not store runs", origin)


class Verdicts:
    """Verdicts on requirements from a store's runs, one `Verdict` per requirement.

    Parameters
    ----------
    store : Store
        The runs.
    requirements : mapping of str to str, optional
        Requirements by name; default: those of the batch.
    confidence : float, optional
        Confidence of each bound; default: that of the batch.

    Raises
    ------
    InputError
        If nothing is required, or a requirement cannot be read.
    """

    def __init__(self, store: Store, requirements: Mapping[str, str] | None, confidence: float | None) -> None:
        self._store = store
        self._verdicts = decide(store, requirements, confidence)
        self.confidence = stored_requirements(store)[1] if confidence is None else confidence

    def __iter__(self) -> Iterator[Verdict]:
        return iter(self._verdicts)

    def __len__(self) -> int:
        return len(self._verdicts)

    def __getitem__(self, name: str) -> Verdict:
        by_name = {verdict.requirement.name: verdict for verdict in self._verdicts}
        if name not in by_name:
            raise unknown_name("requirement", name, by_name)
        return by_name[name]

    @property
    def hold(self) -> bool:
        """True if every requirement holds."""
        return all(verdict.answer == "holds" for verdict in self._verdicts)

    def __repr__(self) -> str:
        return "\n".join(self.lines())

    def lines(self) -> list[str]:
        """Return the verdicts as text."""
        lines = [f"{self._title()}, confidence {self.confidence:g}"]
        for verdict in self._verdicts:
            lines += [
                f"{verdict.requirement.name}: {verdict.answer.upper()}",
                f"    {', '.join(filter(None, (verdict.requirement.text, verdict.requirement.units)))}",
                f"    {self._evidence(verdict)}",
                *(f"    {': '.join(filter(None, pair))}" for pair in self._worst(verdict)),
            ]
        return lines

    def facts(self) -> list[dict[str, Any]]:
        """Return the verdicts as mappings of plain values."""
        return [
            {
                "name": verdict.requirement.name,
                "requirement": verdict.requirement.text,
                "verdict": verdict.answer,
                "share": verdict.requirement.share,
                "confidence": self.confidence,
                **{name: getattr(verdict.evidence, name, None) for name in ("runs", "fulfilled", "low", "high")},
                "reason": verdict.reason,
                "worst": [run for run, _ in verdict.worst],
            }
            for verdict in self._verdicts
        ]

    def page(self) -> str:
        """Return the verdicts as an HTML page."""
        rows = [(v.requirement, v.answer, _KINDS[v.answer], self._evidence(v), self._worst(v)) for v in self._verdicts]
        return page("requirements.html.j2", title=self._title(), wrong=f"{1 - self.confidence:.6g}", rows=rows)

    def _repr_html_(self) -> str:
        return self.page()

    def _title(self) -> str:
        about = self._store.attributes
        return f"{about['model']} {about['controller']} {about['scenario']}: {self._store.n} runs, seed {about['seed']}"

    def _evidence(self, verdict: Verdict) -> str:
        facts = verdict.evidence
        if facts is None:
            return verdict.reason
        return f"{facts.text(verdict.requirement.share)} ({verdict.reason})"

    def _worst(self, verdict: Verdict) -> list[tuple[str, str]]:
        """Return the worst runs and, for a store on disk, the commands that repeat them."""
        path = self._store.path
        return [
            (
                f"run {run}{self._value(run, value, verdict.requirement.number)}",
                "" if path is None else repetition(self._store, run, str(path)),
            )
            for run, value in verdict.worst
        ]

    def _value(self, run: int, value: float, number: Number | None) -> str:
        """Return the required number of a run, or the reason why it has none."""
        if number is None:
            return ""
        if math.isfinite(value):
            unit = number.unit(scalars(self._store)) or "1"
            return f", {number.text} = {value:.6g}{'' if unit == '1' else f' {unit}'}"
        block = next(block for block in self._store.stored() if run in self._store.runs(block))
        row = run - self._store.runs(block).start
        status = int(self._store.read(STATUS, [block])[row])
        if status not in COMPLETE:
            return f", which ended as {STATUS_TEXT[status]!r}"
        value = float(number(lambda name: column(self._store, name, [block]))[row])
        return f", which has no {number.text}" if math.isnan(value) else f", {number.text} = {value:g}"


class RareVerdicts(Verdicts):
    """Verdicts from a search for rare failures, under a title."""

    def __init__(self, verdicts: list[Verdict], title: str, confidence: float) -> None:
        self._verdicts, self._about, self.confidence = verdicts, title, confidence

    def _title(self) -> str:
        return self._about

    def _worst(self, verdict: Verdict) -> list[tuple[str, str]]:
        """Return the varied values of the worst failures."""
        count = min(_SHOWN, *map(len, verdict.failures.values())) if verdict.failures else 0
        return [
            (", ".join(f"{name} = {values[k]:.6g}" for name, values in verdict.failures.items()) + " fails", "")
            for k in range(count)
        ]
