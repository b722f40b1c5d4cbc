# SPDX-License-Identifier: Apache-2.0
"""Effects of a change as blocks of the document, runs under laws first."""

from __future__ import annotations

import importlib.util
import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from mehvar.codegen.diff.report import Comparison

from .consequences import Consequences
from .document import Block, Drawing, Table, Words, limited
from .runs import MarginChange, MetricChange, Overlay, RunChange, Runs
from .spectra import Loop, Pairs

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_ZERO = 1e-9
"""Bound on rounding errors, of a rate at an equilibrium and of the smaller part of an eigenvalue."""
_ROUNDING = 1e-13
"""Difference of equal parts of two eigenvalues, relative to the eigenvalue."""
_DIGITS, _EVERY = 4, 17
"""Digits of an eigenvalue, and those of a double."""
_PART = 1e-3
"""Relative change of a metric that three digits show; smaller changes are only counted."""
_WHOLE = 4
"""Number of runs, most changed first, and of loops that are not folded."""


def effects(model: str, follows: Consequences, overlay: Overlay | None, comparison: Comparison) -> Iterator[Block]:
    """Yield the effects of a change: pictures, runs, margins, and the plant without a law."""
    if overlay:
        yield Drawing("The run that differs most, old dashed, new solid", partial(overlay.picture, model))
    if follows.rates or follows.eigenvalues or follows.loops:
        yield Drawing("What differs of rates and eigenvalues", partial(_picture, follows))
    yield from _runs(follows.runs, comparison)
    yield from _plant(follows)


def _picture(follows: Consequences) -> Figure | None:
    """Return the picture of rates, of the plant's eigenvalues, and of those of the first loop that differs."""
    if importlib.util.find_spec("matplotlib") is None:
        return None
    from mehvar.pictures.overlay import effects_picture
    from mehvar.pictures.style import style

    rates = {f"{rate.name}'": 100 * rate.largest / (rate.typical or rate.largest) for rate in follows.rates}
    spectra = [("eigenvalues without a law", "1/s", follows.eigenvalues)] if follows.eigenvalues else []
    for loop in follows.loops[:1]:
        title = f"eigenvalues under {loop.law}{', which became unstable' * loop.lost}"
        spectra.append((title, "1" if loop.period else "1/s", loop.eigenvalues))
    with style():
        return effects_picture(rates, spectra)


def _runs(runs: Runs, comparison: Comparison) -> Iterator[Block]:
    """Yield the effects on the scenarios under the laws."""
    scenarios: dict[RunChange, list[str]] = {}  # those with equal differences under one law share a table
    for run in runs.changed:
        scenarios.setdefault(replace(run, scenario=""), []).append(run.scenario)
    tables = {}
    for run in sorted(scenarios, key=lambda run: -run.size):
        rows = [(m.name, f"{m.old:.5g}", f"{m.new:.5g}", _shown(m.unit), relative(m)) for m in _listed(run)]
        name = f"{', '.join(scenarios[run])} under {run.law}"
        tables[name] = Table(f"{name}: {outcome(run)}", ("metric", "old", "new", "unit", "change"), rows)
    yield from limited(tables, _WHOLE, "under other laws or scenarios, which differ less")
    for line in (*same_runs(runs, comparison), *refused_runs(runs)):
        yield Words(line)
    for change in runs.margins:
        yield Table(change.title, ("input", "old", "new"), list(_margin_rows(change)))
    if runs.note:
        yield Words(runs.note)


def _plant(follows: Consequences) -> Iterator[Block]:
    """Yield the effects on the plant, its eigenvalues and the operation counts."""
    steady = "" if follows.residual < _ZERO else f", largest rate there {follows.residual:.2g}"
    where = f"eigenvalues at {_places(follows.point, follows.new_point)}{steady}"
    states = f"at {follows.samples} random states"
    if follows.rates:
        rows = [(f"{r.name}'", f"{r.largest:.3g}", f"{r.typical:.3g}", _shown(r.unit)) for r in follows.rates]
        heads = ("rate of", "largest difference", "rms of the old rate", "unit")
        yield Table(f"the plant without a law: largest difference of rates {states}, and rms before", heads, rows)
    elif follows.samples:
        yield Words(f"the plant without a law: rates equal {states} with default parameters, to rounding")
    if follows.eigenvalues:
        yield _spectrum(where, follows.eigenvalues, "1/s")
    elif follows.samples:
        yield Words(f"{where}: the same")
    loops = {}
    for loop in follows.loops:
        lost = "the loop became unstable; " * loop.lost
        title = f"{lost}eigenvalues under {loop.law} at {_places(loop.point, loop.new_point)}"
        loops[loop.law] = _spectrum(title, loop.eigenvalues, unit(loop))
    yield from limited(loops, _WHOLE, "laws under which eigenvalues differ")
    if follows.operations:
        counts = sorted(follows.operations, key=lambda row: -abs(row[2] - row[1]))
        rows = [(name, str(old), str(new), f"{new - old:+d}") for name, old, new in counts]
        yield Table("operations of generated functions", ("function", "old", "new", "change"), rows)
    if follows.note:
        yield Words(follows.note)


def _spectrum(title: str, pairs: Pairs, unit: str) -> Table:
    return Table(title, ("old", "new", "unit"), [(*moved(*pair), unit) for pair in pairs])


def same_runs(runs: Runs, comparison: Comparison) -> list[str]:
    """Return the runs whose metrics are all equal, law by law, and why a changed equation has no effect in any run."""
    still = [f"no state moves, so that the run shows nothing: {_cases(runs.resting)}"] if runs.resting else []
    moving = [run for run in runs.same if run not in runs.resting]
    if not moving:
        return still
    if runs.changed:
        return [f"equal in all metrics: {_cases(moving)}", *still]
    count = f"{len(moving)} run{'s' * (len(moving) > 1)}"
    equal = f"all metrics equal in {count}, largest relative difference {runs.largest:.2g}: {_cases(moving)}"
    lines = [equal, *still]
    parts = [part.text for e in comparison.changed for edit in e.edits for part in (edit.old, edit.new) if part]
    edited = set(re.findall(r"\w+", " ".join(parts)))
    if names := [name for name in runs.zero if name in edited]:
        lines.append(f"the changed terms have {', '.join(f'{name} = 0' for name in names)} in all of these runs")
    return lines


def _cases(runs: Sequence[tuple[str, str]]) -> str:
    """Return pairs of law and scenario as text, law by law."""
    laws = dict.fromkeys(law for law, _ in runs)
    scenarios = {law: ", ".join(scenario for other, scenario in runs if other == law) for law in laws}
    return "; ".join(f"{names} under {law}" for law, names in scenarios.items())


def refused_runs(runs: Runs) -> list[str]:
    """Return the runs that both versions refuse, with the reason."""
    return [f"not run, as both refuse it: {scenario} under {law}: {reason}" for law, scenario, reason in runs.refused]


def outcome(run: RunChange) -> str:
    """Return the difference of a run in words."""
    ends = [f"{side} {end}" for side, end in (("the old one", run.old), ("the new one", run.new)) if end]
    if run.old == run.new:
        ends = [f"both {run.old}"] if run.old else []
    little = len(run.metrics) - len(_listed(run))
    less = f", {little} of them by less than {100 * _PART:g} %" if little else ""
    return "; ".join([*ends, f"{len(run.metrics)} of {run.count} metrics differ{less}"] if run.count else ends)


def _listed(run: RunChange) -> list[MetricChange]:
    """Return the metrics whose change is large enough to be listed."""
    return [m for m in run.metrics if not abs(m.new - m.old) < _PART * max(abs(m.old), abs(m.new))]


def relative(metric: MetricChange) -> str:
    """Return the change of a metric relative to its old value; empty if one of both is zero, or not a number."""
    part = (metric.new - metric.old) / abs(metric.old) if metric.old and metric.new else math.inf
    return f"{100 * part:+.3g} %" if math.isfinite(part) else ""


def _shown(unit: str) -> str:
    return "" if unit == "1" else unit


def _margin_rows(change: MarginChange) -> Iterator[tuple[str, str, str]]:
    """Yield input, old and new margins; an input that the law does not use, or without a linear loop, has none."""
    old, new = ({margin.input: margin.text for margin in side} for side in (change.old, change.new))
    for name in dict.fromkeys((*old, *new)):
        before, after = (side.get(name, "not defined") for side in (old, new))
        if before != after:
            yield name, before, after


def unit(loop: Loop) -> str:
    """Return the unit of a loop's eigenvalues."""
    if loop.period is None:
        return "1/s"
    change = f"{loop.old_period:g} s -> " if loop.old_period not in (None, loop.period) else ""
    return f"per period of {change}{loop.period:g} s"


def _places(old: Sequence[tuple[str, float]], new: Sequence[tuple[str, float]]) -> str:
    """Return the linearisation points of both versions as text: one if they agree in any order."""
    places = [{f"{name} = {value:.4g}": None for name, value in values} for values in (old, new)]
    texts = [f"{', '.join(place)}, the rest 0" if place else "zero" for place in places]
    return texts[0] if places[0] == places[1] else " -> ".join(texts)


def moved(old: complex, new: complex) -> tuple[str, str]:
    """Return an eigenvalue of both versions as text, with as many digits as its change shows in."""
    equal = _ROUNDING * abs(old)  # equal parts may lie on both sides of the edge of a digit
    real = old.real if abs(new.real - old.real) <= equal else new.real
    imaginary = old.imag if abs(new.imag - old.imag) <= equal else new.imag
    new = complex(real, imaginary)
    pairs = [(number(old, digits), number(new, digits)) for digits in range(_DIGITS, _EVERY + 1)]
    return next((pair for pair in pairs if pair[0] != pair[1]), pairs[-1])


def number(value: complex, digits: int = _DIGITS) -> str:
    """Return an eigenvalue as text, together with its conjugate if it has one."""
    size = min(_ZERO, 10.0**-digits) * abs(value)
    real = f"{value.real:.{digits}g}" if abs(value.real) > size else ""
    imaginary = f"± {abs(value.imag):.{digits}g}i" if abs(value.imag) > size else ""
    return f"{real} {imaginary}".strip() or "0"
