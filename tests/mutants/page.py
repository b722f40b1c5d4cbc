# SPDX-License-Identifier: Apache-2.0
"""Tables of benchmarks/results/mutants.md: counts by module, and every survivor with its reason."""

from __future__ import annotations

import tomllib
from collections import Counter
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path

from tests.mutants.records import ROOT, Result, subjects

PAGE = ROOT / "benchmarks" / "results" / "mutants.md"
BEGIN, END = "<!-- mutants: written by make mutants -->\n", "<!-- end of the mutants -->\n"
SAMPLE, SAMPLE_END = "<!-- sample: written by python -m tests.mutants --sample -->\n", "<!-- end of the sample -->\n"
_REASONS = Path(__file__).parent / "survivors.toml"


def write(results: Sequence[Result]) -> None:
    """Write the tables into the page; survivors without a reason are marked open."""
    _put(BEGIN, END, whole(results, _today()))


def write_sample(results: Sequence[Result], size: int, seed: int) -> None:
    """Put the counts and survivors of a sample into the page."""
    _put(SAMPLE, SAMPLE_END, drawn(results, size, seed, _today()))


def _today() -> str:
    return f"{datetime.now(UTC):%Y-%m-%d}"


def drawn(results: Sequence[Result], size: int, seed: int, day: str) -> list[str]:
    """Return the lines of a sample: counts by folder, and survivors."""
    tried = [result for result in results if result.outcome != "refused"]
    alive = [result for result in tried if result.outcome == "survived"]
    lines = [
        f"{len(results)} of {size} mutants of seed {seed} tried by {day}: "
        f"{len(tried) - len(alive)} killed by the closest tests, {_alive(alive)}, "
        f"{len(results) - len(tried)} do not compile.",
        "",
        "| folder | tried | killed | alive |",
        "|---|---|---|---|",
    ]
    for folder in sorted({_folder(result) for result in tried}):
        own = [result for result in tried if _folder(result) == folder]
        lived = sum(result.outcome == "survived" for result in own)
        lines.append(f"| `{folder}` | {len(own)} | {len(own) - lived} | {lived} |")
    return [*lines, "", *_survivors(alive, reasons())]


def _folder(result: Result) -> str:
    parts = result.module.split("/")
    return "/".join(parts[: min(2, len(parts) - 1)])


def _put(begin: str, end: str, lines: Sequence[str]) -> None:
    text = PAGE.read_text(encoding="utf-8")
    head, rest = text.split(begin)
    PAGE.write_text(head + begin + "\n".join(lines) + "\n" + end + rest.split(end)[1], encoding="utf-8")


def reasons() -> dict[str, str]:
    """Return the reasons of survivors, by module and change."""
    rows = tomllib.loads(_REASONS.read_text(encoding="utf-8"))["survivor"]
    return {f"{row['module']}: {row['before']} -> {row['after']}": row["reason"] for row in rows}


def _alive(alive: Sequence[Result]) -> str:
    why = reasons()
    return f"{len(alive)} alive ({sum(result.key not in why for result in alive)} open)"


def whole(results: Sequence[Result], day: str) -> list[str]:
    """Return the lines of the campaign of subjects.toml: counts by module, and survivors."""
    wanted = sum(subject.draw for subject in subjects())
    tried = [result for result in results if result.outcome != "refused"]  # a compiler needs no test
    alive = [result for result in tried if result.outcome == "survived"]
    dead = f"{len(results) - len(tried)} more do not compile"
    cost = f"{sum(result.seconds for result in results) / max(1, len(results)):.1f} s of a processor each"
    lines = [
        f"{len(tried)} of {wanted} mutants tried by {day}, {_alive(alive)}; {dead}; {cost}.",
        "",
        "| area | module | tried | killed by a test | by its time | alive |",
        "|---|---|---|---|---|---|",
    ]
    for area, module in sorted({(result.area, result.module) for result in tried}):
        count = Counter(result.outcome for result in tried if result.module == module)
        numbers = (count.total(), *(count[outcome] for outcome in ("killed", "timeout", "survived")))
        lines.append(f"| {area} | `{module}` | {' | '.join(map(str, numbers))} |")
    return [*lines, "", *_survivors(alive, reasons())]


def _survivors(alive: Sequence[Result], why: Mapping[str, str]) -> list[str]:
    if not alive:
        return ["No survivors."]
    rows = ["| survivor | instead | why it lives |", "|---|---|---|"]
    for result in alive:
        reason = why.get(result.key, "**open**")
        rows.append(f"| `{result.module}` {_code(result.before)} | {_code(result.after)} | {reason} |")
    return rows


def _code(text: str) -> str:
    return "`" + text.replace("|", "\\|").replace("`", "'") + "`"
