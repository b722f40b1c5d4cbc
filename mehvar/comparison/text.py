# SPDX-License-Identifier: Apache-2.0
"""Comparison as indented text, coloured and wrapped on a terminal."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

from rich.text import Text

from mehvar.base.errors import first_names
from mehvar.codegen.diff.parameters import PARTS
from mehvar.codegen.diff.report import (
    PICTURE,
    Comparison,
    Edit,
    EquationChange,
    EquationGroup,
    EquationVerdict,
    ModelStatus,
    ParameterChange,
    handle,
    label,
)
from mehvar.terminal import Line

from ..estimation.margins import Margin
from .consequences import Consequences
from .runs import MarginChange, MetricChange, RunChange, Runs
from .spectra import Loop

_ZERO = 1e-9
"""Bound on rounding errors, of a rate at an equilibrium and of the smaller part of an eigenvalue."""
_DIGITS, _EVERY = 4, 17
"""Digits of an eigenvalue, and those of a double."""
_CONDITIONS = ("constraint", "limit", "warning")
"""Kinds of rows whose name is a message."""
_PLACE = re.compile(r"(?:\b(\w+) = )?\{(\w*)(?::[^{}]*)?\}")
"""Place of a number in a message, as in "m = {m:g} kg"."""
_ALIKE = ("family", "symmetric")
"""Kinds of groups that are reported once, by their first member."""
_CAUSAL = ("follows", "solved")
"""Kinds of groups that follow their cause in the report."""
_PART = 1e-3
"""Relative change of a metric that three digits show; smaller changes are only counted."""
_NAMED = 12
"""Number of equations that a shared report names: two lines of a terminal. A page lists all."""
_STYLES = {
    ModelStatus.SAME: "bold green",
    ModelStatus.NAMES: "bold green",
    ModelStatus.PICTURE: "bold green",
    ModelStatus.UNDECIDED: "bold yellow",
}
_TOLD = (EquationVerdict.CHANGED, EquationVerdict.UNDECIDED, EquationVerdict.ADDED, EquationVerdict.REMOVED)
"""Verdicts with separate reports, in this order."""
_WHOLE, _FEW = 8, 2
"""Numbers of causes with counterexample and evidence, and of further causes of a section with a line each; more share a
line, and a page has all."""
_RUNS, _METRICS = 4, 5
"""Numbers of listed runs, most changed first, and of metrics per run; a page has all."""
HEADLINES = {
    ModelStatus.SAME: "physics the SAME",
    ModelStatus.NAMES: "physics the SAME, names or order CHANGED",
    ModelStatus.PARAMETERS: "equations the SAME, numbers or names CHANGED",
    ModelStatus.PICTURE: "physics the SAME, picture CHANGED",
    ModelStatus.UNDECIDED: "physics UNDECIDED",
    ModelStatus.CHANGED: "physics CHANGED",
    ModelStatus.ADDED: "ADDED",
    ModelStatus.REMOVED: "REMOVED",
}
_COUNTED = {
    EquationVerdict.CHANGED: "changed",
    EquationVerdict.ADDED: "added",
    EquationVerdict.REMOVED: "removed",
    EquationVerdict.UNDECIDED: "undecided",
    EquationVerdict.INHERITED: "inherited",
    EquationVerdict.REARRANGED: "rearranged",
    EquationVerdict.RENAMED: "renamed",
    EquationVerdict.SCALED: "scaled",
    EquationVerdict.SAME: "unchanged",
}


def lines(
    model: str, status: ModelStatus, comparison: Comparison, follows: Consequences | None, notes: Sequence[str] = ()
) -> Iterator[Line]:
    """Yield the report on a model."""
    style = _STYLES.get(status, "bold red")
    yield 0, Text.assemble((f"{model}: ", "bold"), (HEADLINES[status], style), "   ", counted(comparison))
    for note in (*notes, *choices(comparison)):
        yield 2, Text(note)
    yield from _equations(comparison)
    yield from _equivalent(comparison)
    yield from _parameters(listed_parameters(comparison))
    if follows:
        yield from _consequences(follows, comparison)


def choices(comparison: Comparison) -> list[str]:
    """Return the structural choices that differ, as text."""
    return [f"structure {name}: {old} -> {new}" for name, old, new in comparison.structure]


def counted(comparison: Comparison) -> str:
    """Return the numbers of equations by verdict, as in "1 changed, 6 inherited, 40 unchanged"."""
    counts = [(len(comparison.of(verdict)), word) for verdict, word in _COUNTED.items()]
    return ", ".join(f"{count} {word}" for count, word in counts if count)


def title(equation: EquationChange, names: Sequence[str] = ()) -> str:
    """Return the name of an equation, or the names for equal parts, with number and title."""
    about = " ".join(part for part in (equation.number, equation.title) if part)
    if equation.kind == "equation" and about:  # its name is a left side, often just zero
        return about
    if equation.kind in _CONDITIONS:
        return f"{equation.kind}: {_PLACE.sub(lambda place: place[1] or place[2], equation.title)}"
    was = f" (was {equation.old_name})" if equation.old_name not in ("", equation.name) else ""
    return "  ".join(part for part in (", ".join(names or [equation.name + was]), about) if part)


def families(comparison: Comparison) -> dict[str, EquationGroup]:
    """Return the group of equal parts for each equation whose parts have the same edit."""
    return {name: group for group in comparison.groups if group.kind in _ALIKE for name in group.names}


def stories(comparison: Comparison) -> list[str]:
    """Return the reports about groups of equations, except equal parts and consequences."""
    return [group.says for group in comparison.groups if group.kind not in _ALIKE + _CAUSAL]


def one_by_one(comparison: Comparison) -> Iterator[tuple[EquationChange, EquationGroup | None]]:
    """Yield the equations with separate reports; the first stands for all equal parts."""
    family = families(comparison)
    told: set[tuple[str, str]] = set()
    for equation in (e for fate in _TOLD for e in comparison.of(fate)):
        group = family.get(equation.name)
        untold = not (is_quiet(equation) or equation.extended or equation.cause)
        if untold and (group is None or group.names[0] == equation.name):
            message = (equation.verdict.value, equation.title)
            if equation.kind not in _CONDITIONS or equation.edits or message not in told:
                yield equation, group
            told.add(message)


def following(comparison: Comparison, equation: EquationChange | None = None) -> str:
    """Return the consequences of a cause or of changed equations of motion on one line, or an empty text."""
    kind, source = ("solved", "") if equation is None else ("follows", handle(equation))
    for group in comparison.groups:
        names = group.names if equation is None else group.names[1:]
        if group.kind == kind and equation is None:
            return f"{group.says}: {_many(names)}"
        if group.kind == kind and group.names[0] == source:
            return f"and what follows from it, {group.says}: {_many(names)}"
    return ""


def _many(names: Sequence[str]) -> str:
    return f"{len(names)} equation{'s' * (len(names) > 1)}: {first_names(names, _NAMED, spare=1)}"


def is_quiet(equation: EquationChange) -> bool:
    """Return True for an added or removed definition that only names a value."""
    return not equation.matters and equation.verdict in (EquationVerdict.ADDED, EquationVerdict.REMOVED)


def evidence(equation: EquationChange) -> str:
    """Return the evidence for the verdict and, if available, the test of the edits."""
    replayed = "; the edits, applied to the old form, give the new one" if equation.replayed and equation.edits else ""
    return equation.how + replayed


def example(equation: EquationChange) -> str:
    """Return the counterexample in one line; empty without one."""
    point = equation.counterexample
    if not point:
        return ""
    at = ", ".join(f"{name} = {value}" for name, value in point.at)
    return f"at {at or 'zero'}{', the rest 0' if at else ''}: {point.left} became {point.right}"


def edit_title(edit: Edit) -> str:
    """Return position and effect of an edit, without a position that equals the edited part."""
    places = [place for place in edit.path if edit.old is None or place != edit.old.text]
    where = " > ".join(places)
    return f"in {where}: {edit.says}" if where else edit.says


def is_complete(edit: Edit) -> bool:
    """Return True if the words of an edit already contain its old and new expressions."""
    return all(part is None or part.text in edit.says for part in (edit.old, edit.new))


def listed_parameters(comparison: Comparison) -> list[ParameterChange]:
    """Return the reported names and numbers, with the first of equal parts for all; parts are told by themselves."""
    untold = {*comparison.extended(), PARTS}
    return [change for change in comparison.parameters if change.name.split(".")[-1] not in untold]


def labels(comparison: Comparison, names: Sequence[str]) -> str:
    """Return the shortest unambiguous names of equations, without duplicates."""
    shortest = {equation.name: label(equation) for equation in reversed(comparison.equations)}
    return first_names(list(dict.fromkeys(shortest.get(name, name) for name in names)), _NAMED, spare=1)


def _equations(comparison: Comparison) -> Iterator[Line]:
    """Yield the changed equations: the first ones with edits, others briefly or counted by section."""
    for says in stories(comparison):
        yield 2, Text(says, "bold")
    more: dict[tuple[EquationVerdict, str], list[tuple[EquationChange, EquationGroup | None]]] = {}
    for number, (equation, group) in enumerate(one_by_one(comparison)):
        if number < _WHOLE and equation.kind != PICTURE:
            yield 2, _head(comparison, equation, group)
            yield from _source(comparison, equation, group)
        else:
            more.setdefault((equation.verdict, equation.section or equation.kind), []).append((equation, group))
    for (verdict, section), rows in more.items():
        if len(rows) > _FEW:
            names = labels(comparison, [equation.name for equation, _ in rows])
            yield 2, Text.assemble((_COUNTED[verdict], _style(*rows[0])), f" {len(rows)} more of {section}: {names}")
        else:
            yield from (_short(comparison, *row) for row in rows)
    if follows := following(comparison):
        yield 2, Text(follows, "bold")
    for verdict in (EquationVerdict.ADDED, EquationVerdict.REMOVED):
        quiet = [label(e) for e in comparison.of(verdict) if is_quiet(e) and not e.extended]
        if quiet:
            yield 2, Text.assemble((f"{verdict.value} ", "cyan"), first_names(quiet, _NAMED, spare=1))


def _short(comparison: Comparison, equation: EquationChange, group: EquationGroup | None) -> Line:
    """Return a cause and its first edits on one line."""
    edits = "; ".join(map(edit_title, equation.edits[:2])) + "; ..." * (len(equation.edits) > 2)
    return 2, Text.assemble(_head(comparison, equation, group), f": {edits}" if edits else "")


def _style(equation: EquationChange, _: EquationGroup | None = None) -> str:
    return "yellow" if equation.verdict is EquationVerdict.UNDECIDED else "red" if equation.matters else "cyan"


def _head(comparison: Comparison, equation: EquationChange, group: EquationGroup | None) -> Text:
    style = _style(equation)
    names = group.names if group else ()
    why = harmless(comparison, equation)
    return Text.assemble(
        (_COUNTED[equation.verdict], style), " ", (title(equation, names), "bold"), f": {why}" if why else ""
    )


def harmless(comparison: Comparison, equation: EquationChange) -> str:
    """Return why a changed definition does not change the physics; empty if it does."""
    if equation.matters or equation.kind == PICTURE:
        return ""
    compensated = any(group.kind == "convention" and group.names[0] == equation.name for group in comparison.groups)
    return "what uses it compensates" if compensated else "only the picture uses it"


def _source(comparison: Comparison, equation: EquationChange, group: EquationGroup | None) -> Iterator[Line]:
    """Yield the lines below a changed equation: group, edits, example, evidence, users and what follows."""
    if group:
        yield 4, Text(group.says)
    for edit in equation.edits:
        yield from _edit(edit)
    if where := example(equation):
        yield 4, Text(where)
    if equation.verdict in (EquationVerdict.CHANGED, EquationVerdict.UNDECIDED):
        yield 4, Text(evidence(equation), "dim")
    if equation.users:
        yield 4, Text(f"inherited by {labels(comparison, equation.users)}", "dim")
    if follows := following(comparison, equation):
        yield 4, Text(follows, "bold")


def _edit(edit: Edit) -> Iterator[Line]:
    """Yield an edit: a lost or added part with its sign, else the title and, unless that has both, both parts."""
    if edit.old is None or edit.new is None:
        sign, part, style = ("-", edit.old, "red") if edit.old else ("+", edit.new, "green")
        yield 4, Text.assemble((f"{sign} {part.text if part else ''}", style), f"   {edit_title(edit)}")
        return
    yield 4, Text(edit_title(edit))
    if is_complete(edit):
        return
    yield 6, Text(f"- {edit.old.text}", "red")
    yield 6, Text(f"+ {edit.new.text}", "green")


def _equivalent(comparison: Comparison) -> Iterator[Line]:
    """Yield the equations that only look different, grouped by verdict and proof."""
    groups: dict[tuple[EquationVerdict, str], list[str]] = {}
    for equation in comparison.equivalent:
        name = label(equation)
        if equation.verdict is EquationVerdict.RENAMED:
            name = f"{equation.old_name} -> {name}"
        groups.setdefault((equation.verdict, equation.how), []).append(name)
    for (verdict, how), names in groups.items():
        yield 2, Text.assemble((f"{verdict.value} ", "green"), ", ".join(names))
        yield 4, Text(how, "dim")


def _parameters(changes: Sequence[ParameterChange]) -> Iterator[Line]:
    if changes:
        yield 2, Text("names and numbers", "bold")
    for change in changes:
        alone = change.what in ("added", "removed")
        between = change.old + change.new if alone else f"{change.old or 'none'} -> {change.new or 'none'}"
        unit = f" {change.unit}" if change.unit else ""
        yield 4, Text.assemble(f"{change.role} ", (change.name, "bold"), f"  {change.what}: {between}{unit}")


def _consequences(follows: Consequences, comparison: Comparison) -> Iterator[Line]:
    yield 2, Text("consequences", "bold")
    for text in consequence_lines(follows, comparison):
        yield 4, Text(text)


def consequence_lines(follows: Consequences, comparison: Comparison) -> Iterator[str]:
    """Yield the effects of a change, one line each, closed loops first."""
    yield from run_lines(follows.runs, comparison)
    yield from plant_lines(follows)


def plant_lines(follows: Consequences) -> Iterator[str]:
    """Yield the effects on the plant, its eigenvalues and the operation counts."""
    if follows.rates:
        yield f"the plant without a law: largest difference of rates at {follows.samples} random states (rms before):"
        yield from _first(f"  {r.name}'  {r.largest:.3g}{suffix(r.unit)}  ({r.typical:.3g})" for r in follows.rates)
    elif follows.samples:
        equal = f"rates equal at {follows.samples} random states with default parameters, to rounding"
        yield f"the plant without a law: {equal}"
    if follows.eigenvalues:
        yield f"eigenvalues at {point(follows)}:"
        yield from _first(f"  {moved(*pair)}  1/s" for pair in follows.eigenvalues)
    elif follows.samples:
        yield f"eigenvalues at {point(follows)}: the same"
    for loop in follows.loops[:_RUNS]:
        lost = "the loop became unstable; " if loop.lost else ""
        yield f"{lost}eigenvalues under {loop.law} at {_places(loop.point, loop.new_point)}:"
        yield from _first(f"  {moved(*pair)}  {unit(loop)}" for pair in loop.eigenvalues)
    if more := follows.loops[_RUNS:]:
        yield f"eigenvalues under {len(more)} more laws differ: {', '.join(loop.law for loop in more)}"
    operations = sorted(follows.operations, key=lambda row: -abs(row[2] - row[1]))
    for name, before, after in operations[:_NAMED]:
        yield f"operations of {name}: {before} -> {after} ({after - before:+d})"
    if len(operations) > _NAMED:
        yield f"operations of {len(operations) - _NAMED} more functions differ"
    if follows.note:
        yield follows.note


def run_lines(runs: Runs, comparison: Comparison) -> Iterator[str]:
    """Yield the effects on the scenarios under the laws."""
    changed = sorted(joined(runs.changed), key=lambda pair: -pair[0].size)
    for number, (run, scenarios) in enumerate(changed[:_NAMED]):
        yield f"{', '.join(scenarios)} under {run.law}: {outcome(run)}"
        if number < _RUNS:
            metrics = (
                f"  {m.name}  {m.old:.5g} -> {m.new:.5g}{suffix(m.unit)}{relative(m)}" for m in listed_metrics(run)
            )
            yield from _first(metrics, _METRICS)
    if len(changed) > _NAMED:
        yield f"runs of {len(changed) - _NAMED} more kinds differ"
    yield from same_runs(runs, comparison)
    yield from refused_runs(runs)
    for change in runs.margins:
        yield f"{change.title}:"
        for name, old, new in margin_rows(change):
            yield f"  {name}  {old} -> {new}"
    if runs.note:
        yield runs.note


def _first(texts: Iterable[str], count: int = _NAMED) -> Iterator[str]:
    """Yield the first lines of a table and the number of omitted ones."""
    rows = list(texts)
    kept = rows if len(rows) <= count + 1 else rows[:count]
    yield from kept
    if len(rows) > len(kept):
        yield f"  and {len(rows) - len(kept)} more"


def joined(runs: Sequence[RunChange]) -> list[tuple[RunChange, list[str]]]:
    """Return runs with their scenarios; scenarios with equal differences under one law share an entry."""
    groups: dict[RunChange, list[str]] = {}
    for run in runs:
        groups.setdefault(replace(run, scenario=""), []).append(run.scenario)
    return list(groups.items())


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
    little = len(run.metrics) - len(listed_metrics(run))
    less = f", {little} of them by less than {100 * _PART:g} %" if little else ""
    return "; ".join([*ends, f"{len(run.metrics)} of {run.count} metrics differ{less}"] if run.count else ends)


def listed_metrics(run: RunChange) -> list[MetricChange]:
    """Return the metrics whose change is large enough to be listed."""
    return [m for m in run.metrics if not abs(m.new - m.old) < _PART * max(abs(m.old), abs(m.new))]


def relative(metric: MetricChange) -> str:
    """Return the change of a metric relative to its old value; empty if one of both is zero, or not a number."""
    part = (metric.new - metric.old) / abs(metric.old) if metric.old and metric.new else math.inf
    return f"  ({100 * part:+.3g} %)" if math.isfinite(part) else ""


def suffix(unit: str) -> str:
    """Return a unit as it follows a number; empty for a number without one."""
    return "" if unit in ("", "1") else f" {unit}"


def margin_rows(change: MarginChange) -> Iterator[tuple[str, str, str]]:
    """Yield input, old and new margins."""
    old, new = ({margin.input: margin for margin in side} for side in (change.old, change.new))
    for name in dict.fromkeys((*old, *new)):
        before, after = (margin_text(side.get(name)) for side in (old, new))
        if before != after:
            yield name, before, after


def margin_text(margin: Margin | None) -> str:
    """Return a margin as text; "not defined" for an input that the law does not use, or without a linear loop."""
    return "not defined" if margin is None else margin.text


def unit(loop: Loop) -> str:
    """Return the unit of a loop's eigenvalues."""
    if loop.period is None:
        return "1/s"
    change = f"{loop.old_period:g} s -> " if loop.old_period not in (None, loop.period) else ""
    return f"a period of {change}{loop.period:g} s"


def point(follows: Consequences) -> str:
    """Return the linearisation point as text."""
    steady = "" if follows.residual < _ZERO else f", largest rate there {follows.residual:.2g}"
    return f"{_places(follows.point, follows.new_point)}{steady}"


def _places(old: Sequence[tuple[str, float]], new: Sequence[tuple[str, float]]) -> str:
    """Return the linearisation points of both versions as text: one if they agree in any order."""
    texts = [place(values) for values in (old, new)]
    agree = sorted(place([pair]) for pair in old) == sorted(place([pair]) for pair in new)
    return texts[0] if agree else " -> ".join(texts)


def place(values: Sequence[tuple[str, float]]) -> str:
    """Return the nonzero elements of a state as text."""
    where = ", ".join(f"{name} = {value:.4g}" for name, value in values)
    return f"{where}, the rest 0" if where else "zero"


def moved(old: complex, new: complex) -> str:
    """Return the change of an eigenvalue as text, with as many digits as it shows in."""
    pairs = [(number(old, digits), number(new, digits)) for digits in range(_DIGITS, _EVERY + 1)]
    return " -> ".join(next((pair for pair in pairs if pair[0] != pair[1]), pairs[-1]))


def number(value: complex, digits: int = _DIGITS) -> str:
    """Return an eigenvalue as text, together with its conjugate if it has one."""
    size = min(_ZERO, 10.0**-digits) * abs(value)
    real = f"{value.real:.{digits}g}" if abs(value.real) > size else ""
    imaginary = f"± {abs(value.imag):.{digits}g}i" if abs(value.imag) > size else ""
    return f"{real} {imaginary}".strip() or "0"
