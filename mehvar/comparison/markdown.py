# SPDX-License-Identifier: Apache-2.0
"""Comparison as Markdown for a pull request, with tables of effects, edits as diffs, and folded details."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from mehvar.codegen.diff.report import Edit, EquationChange, EquationGroup, EquationVerdict
from mehvar.terminal import plain_text

from .result import Diff, ModelDiff
from .runs import MarginChange, RunChange
from .text import (
    HEADLINES,
    choices,
    counted,
    edit_title,
    example,
    following,
    is_complete,
    joined,
    labels,
    listed_metrics,
    margin_rows,
    one_by_one,
    outcome,
    plant_lines,
    refused_runs,
    relative,
    same_runs,
    stories,
    title,
)

_LONGEST = 60_000
"""Largest number of characters; GitHub refuses comments above 65 536, and a sender may add some lines."""
_WHOLE = 20
"""Number of causes that are shown with their edits."""


def markdown(diff: Diff) -> str:
    """Return the comment as text."""
    models = [part for model in diff.models for each in model for part in (*_model(each), "")]
    text = "\n".join([f"## Equations: {_code(diff.old)} → {_code(diff.new)}", "", *models])
    if len(text) <= _LONGEST:
        return text
    kept = text[: text.rindex("\n\n", 0, _LONGEST)]
    closed = "\n```\n" if kept.count("\n```") % 2 else ""
    closed += "\n</details>\n" * (kept.count("<details>") - kept.count("</details>"))
    return f"{kept}\n{closed}\nCut here: `mehvar diff --out page.html` has all of it.\n"


def _model(model: ModelDiff) -> Iterator[str]:
    """Yield the section of a model: counts, parts, equations, parameters, runs, and the complete text, folded."""
    yield f"### {model.name}: {HEADLINES[model.status]}"
    yield ""
    yield counted(model.comparison)
    yield ""
    for line in model.parts:
        yield f"- **{_plain(line)}**"
    for line in (*model.notes, *choices(model.comparison)):
        yield f"- {_plain(line)}"
    for line in filter(None, [*stories(model.comparison), following(model.comparison)]):
        yield f"- **{_plain(line)}**"
    yield from _sources(model)
    yield from _parameters(model)
    if model.consequences:
        yield from _runs(model.consequences.runs.changed)
        yield from _margins(model.consequences.runs.margins)
        runs = model.consequences.runs
        for line in (*same_runs(runs, model.comparison), *refused_runs(runs)):
            yield from ("", f"{_plain(line[0].upper() + line[1:])}.")
        yield from ("", *_folded("plant without a law, eigenvalues, operations", list(plant_lines(model.consequences))))
    if any(equation.verdict is not EquationVerdict.SAME for equation in model.comparison) or model.differs:
        yield from _folded("all of it as text", [plain_text(replace(model, structures=()).lines())])


def _sources(model: ModelDiff) -> Iterator[str]:
    sources = list(one_by_one(model.comparison))
    for equation, group in sources[:_WHOLE]:
        yield from ("", *_source(model, equation, group))
    if len(sources) > _WHOLE:
        yield from ("", f"... and {len(sources) - _WHOLE} more.")


def _source(model: ModelDiff, equation: EquationChange, group: EquationGroup | None) -> Iterator[str]:
    """Yield the lines of a changed equation: verdict, edits as a diff, and one line of remarks."""
    about = title(equation, group.names if group else ())
    yield f"**{EquationVerdict(equation.verdict).value}** {_code(about)}"
    if group:
        yield from ("", _plain(group.says))
    if equation.edits:
        yield from ("```diff", *(line for edit in equation.edits for line in _edit(edit)), "```")
    notes = [example(equation), following(model.comparison, equation)]
    if equation.users:
        notes.append(f"inherited by {labels(model.comparison, equation.users)}")
    yield "; ".join(_plain(note) for note in notes if note)


def _edit(edit: Edit) -> Iterator[str]:
    yield f"# {edit_title(edit)}"
    if edit.old is not None and edit.new is not None and is_complete(edit):
        return
    for sign, part in (("-", edit.old), ("+", edit.new)):
        if part is not None:
            yield f"{sign} {part.text}"


def _parameters(model: ModelDiff) -> Iterator[str]:
    rows = [
        (_code(change.name), change.role, change.what, change.old, change.new, change.unit)
        for change in model.comparison.parameters
    ]
    yield from _table(("name", "role", "what", "old", "new", "unit"), rows)


def _runs(changed: Sequence[RunChange]) -> Iterator[str]:
    for run, scenarios in joined(changed):
        yield from ("", f"**{', '.join(scenarios)} under {run.law}**: {_plain(outcome(run))}")
        rows = [
            (_code(m.name), f"{m.old:.5g}", f"{m.new:.5g}", relative(m).strip(" ()"), m.unit)
            for m in listed_metrics(run)
        ]
        yield from _table(("metric", "old", "new", "change", "unit"), rows)


def _margins(changed: Sequence[MarginChange]) -> Iterator[str]:
    for change in changed:
        yield from ("", f"{change.title[0].upper()}{change.title[1:]}:")
        yield from _table(("input", "old", "new"), list(margin_rows(change)))


def _table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> Iterator[str]:
    if rows:
        yield ""
        for row in (heads, ["---"] * len(heads), *rows):
            yield f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in row)} |"


def _folded(summary: str, lines: Sequence[str]) -> Iterator[str]:
    if lines:
        yield from ("", f"<details><summary>{summary}</summary>", "", "```text", *lines, "```", "", "</details>")


def _code(text: str) -> str:
    return f"`{text.replace('`', chr(39))}`"


def _plain(text: str) -> str:
    """Escape a text for Markdown and HTML."""
    return "".join(f"\\{letter}" if letter in "\\`*_<>#|[]" else letter for letter in text)
