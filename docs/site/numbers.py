# SPDX-License-Identifier: Apache-2.0
"""List the pages of benchmarks/results in docs/numbers.md, with the main tables."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

RESULTS = Path(__file__).parents[2] / "benchmarks" / "results"
PAGE = Path(__file__).parents[1] / "numbers.md"

_SHOWN = {
    "closed_loop.md": ("path, samples every 1 s",),
    "batch_open_loop.md": ("slosh, two pendulums, 10 s", "slosh on ball joints, 10 s", "satellite, 100 s"),
    "batch_closed_loop.md": ("",),
    "own_law.md": ("",),
}
"""Sections whose first table is shown, in this order; an empty heading is the first table of the page."""
_COMMANDS = {
    "batch.md": "put together by hand from the four pages of batches below; "
    + ", ".join(f"`python -m benchmarks.batch.{name}`" for name in ("rhs", "closed_loop", "open_loop", "scaling")),
    "soak.md": "made by `make soak`",
}
"""Origins of pages that do not name the command that wrote them."""
_SETTINGS = {
    "batch.md": "tolerance 1e-6; a user's default is 1e-11",
    "generate.md": "with a user's defaults",
    "fmi.md": "co-simulation with a user's defaults, model exchange with CVODE at 1e-10",
    "diff.md": "with a user's defaults",
    "mutation.md": "six points a gate; a user's default is 12",
    "kill_test.md": "0.2 s of the triangle, a sample every 0.1 s; a user's defaults are 35 s and none",
    "matrix.md": "with a user's defaults",
    "bare.md": "tolerances as the table says, a held input and one sample; a user's default is 1e-11",
    "fixed_costs.md": "tolerance 1e-6, one sample; a user's default is 1e-11",
    "precision.md": "whole scenarios at tolerances as the table says; a user's default is 1e-11",
    "own_law.md": "100 s of the satellite, own laws sampled every 0.5 s; a user's defaults are 800 s and continuous",
    "small_edits.md": "the models in their default structure, which is a user's default",
    "soak.md": "settings stand on the page of each figure, beside a user's defaults where they differ",
    "store.md": "0.2 s of the triangle, a sample every 0.1 s; a user's defaults are 35 s and none",
    "tools.md": "one call at one point with a user's default parameters",
    "validation.md": "tolerances of the cases; a user's default is 1e-11",
    "mutants.md": "the tests with a user's defaults",
    "closed_loop.md": "samples every 1 s where a heading says so; a user's default is 0.01 s",
    "batch_open_loop.md": "tolerances and steps as the tables say; a user's default is dop853 at 1e-11",
    "batch_closed_loop.md": "tolerance 1e-6, the method that a campaign names; a user's default is dop853 at 1e-11",
    "batch_rhs.md": "one call of a right-hand side; 'fast' is a profile to ask for, 'portable' a user's default",
    "batch_scaling_counts.md": "tolerance 1e-6 and 0.05 s of the triangle; a user's default is 1e-11 and 35 s",
    "batch_scaling_pendulums.md": "rk4, 100 steps of 0.1 s, held input; a user's default is dop853 at 1e-11",
    "batch_scaling_threads.md": "tolerance 1e-6; a user's default is 1e-11",
    "compare.md": "tolerance 1e-9, on ball joints, own laws every 0.1 s; a user's default is 1e-11 and continuous",
    "board.md": "one sample of delay and 5000 samples; a user's defaults are none and 1600",
}
"""Settings of each page's measurements, where they differ from a user's defaults."""
_HEAD = """# Numbers

Every measurement has a page with machine, versions, date, command and caveats. Machines were shared: compare ratios.
[Benchmarks](../benchmarks/README.md) explains how to repeat them; `python docs/site/numbers.py` writes this page.

## Main results
"""
_INDEX = """## All measurements

| page | how it was made |
|---|---|"""


def page(results: Path = RESULTS) -> str:
    """Return the page of numbers as Markdown: the main tables, then a row for each page of results."""
    sections = {path.name: list(_sections(_text(path))) for path in sorted(results.glob("*.md"))}
    parts = [_HEAD]
    for name, headings in _SHOWN.items():
        parts.append(f"### {_link(name, sections[name])}\n")
        for heading in headings:
            parts += [f"**{heading}**\n"] if heading else []
            parts.append(_table(name, sections[name], heading))
    rows = [f"| {_link(name, own)} | {_origin(name, _text(results / name))} |" for name, own in sections.items()]
    return "\n".join([*parts, _INDEX, *rows, ""])


def _text(path: Path) -> str:
    """Return a page of results without its folded parts."""
    return re.sub(r"<details>.*?</details>", "", path.read_text(encoding="utf-8"), flags=re.DOTALL)


def _link(name: str, sections: list[tuple[str, str]]) -> str:
    return f"[{sections[0][0]}](../benchmarks/results/{name})"


def _origin(name: str, text: str) -> str:
    """Say which command made the numbers of a page, and at which settings if they are not the defaults."""
    made = _COMMANDS.get(name, "")
    command = re.search(r"`((?:python|make) [^`\n]+)`", text)
    if not made and command is None:
        raise SystemExit(f"benchmarks/results/{name} names no command that wrote it")
    made = made or f"made by `{command[1]}`"
    return f"{made[0].upper()}{made[1:]}; {_SETTINGS[name]}"


def _sections(text: str) -> Iterator[tuple[str, str]]:
    """Return headings of all levels with what follows them."""
    parts = re.split(r"^#+ (.+)$", text, flags=re.MULTILINE)[1:]
    return zip(parts[::2], parts[1::2], strict=True)


def _table(name: str, sections: list[tuple[str, str]], heading: str) -> str:
    """Return the first table of a section, of the whole page for an empty heading; links lead on as they did."""
    for title, text in sections:
        table = re.search(r"(?:^\|.*\n)+", text, flags=re.MULTILINE)
        if table and heading in ("", title):
            return re.sub(r"\]\((?!\w+:)", "](../benchmarks/results/", table[0])
    raise SystemExit(
        f"benchmarks/results/{name} has no table under {heading or 'any heading'!r}: mend docs/site/numbers.py"
    )


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
    print(f"wrote {PAGE}")
