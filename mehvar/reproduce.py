# SPDX-License-Identifier: Apache-2.0
"""Every figure and claim of the papers, computed anew, as one HTML report."""

from __future__ import annotations

import base64
import json
import math
import platform
import re
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import jinja2

from codegen.generate import installed_tree
from mehvar.diff_html import typeset
from mehvar.diff_paper import Ledger, counted, example, judged
from mehvar.papers import (
    Claim,
    Comparison,
    PaperFigure,
    Runs,
    Verdict,
    by_run,
    compare,
    load_paper,
    paper_models,
    table_claims,
)
from mehvar.plots import pretty_unit, require_matplotlib, save, style
from runtime.compiler import find_compiler
from runtime.errors import bad_value
from runtime.files import write_atomic
from runtime.manifest import Manifest
from runtime.model import load

Progress = Callable[[float, float], None]

_TEMPLATES = Path(__file__).parent / "templates"
_PACKAGES = ("mehvar", "numpy", "scipy", "matplotlib")
_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


@dataclass(frozen=True)
class _DrawnFigure:
    """A figure of the report: its number and texts, and the file's bytes as a data URI."""

    number: int
    title: str
    caption: str
    uri: str


@dataclass(frozen=True)
class _Report:
    """What the page says about one paper."""

    manifest: Manifest
    citation: str
    readings: tuple[str, ...]
    figures: Sequence[_DrawnFigure]
    claims: Sequence[Claim]
    comparisons: Sequence[Comparison]
    facts: Sequence[tuple[str, str]]
    ledger: Ledger | None


def reproduce(out: Path, progress: Progress | None = None) -> bool:
    """Compute every figure and claim of every paper and write the report.

    Parameters
    ----------
    out : Path
        Folder of the report, made if it does not exist: index.html, which needs nothing else; claims.json; figures/.
    progress : callable, optional
        Called with what is done and the total, in figures.

    Returns
    -------
    bool
        Whether every claim holds, with or without a note.

    Raises
    ------
    InputError
        If matplotlib is not installed or `out` is not a folder.
    OSError
        If a file cannot be written.
    """
    require_matplotlib()
    if out.exists() and not out.is_dir():
        raise bad_value("output folder", str(out), "a folder, or nothing yet")
    (out / "figures").mkdir(parents=True, exist_ok=True)
    models = paper_models()
    ledgers = {ledger["model"]: ledger for ledger in judged(installed_tree())}
    reports = [_report(name, out, ledgers.get(name), _part(progress, i, len(models))) for i, name in enumerate(models)]
    claims = [claim for report in reports for claim in report.claims]
    write_atomic(out / "claims.json", _claims_text(reports))
    write_atomic(out / "index.html", _page(reports, claims))
    return all(claim.verdict is not Verdict.FAILS for claim in claims)


def _part(progress: Progress | None, index: int, count: int) -> Progress:
    """Return a progress call for one of several papers."""

    def advance(done: float, total: float) -> None:
        if progress is not None:
            progress(index + done / total, count)

    return advance


def _report(name: str, out: Path, ledger: Ledger | None, advance: Progress) -> _Report:
    started = time.perf_counter()
    paper, runs = load_paper(name), Runs(load(name))
    manifest, asked = runs.model.manifest, paper.figures()
    total = len(asked) + 2
    comparisons = compare(runs)
    advance(1, total)
    claims = [*paper.claims(runs), *table_claims(manifest, comparisons)]
    advance(2, total)
    figures = []
    for done, figure in enumerate(asked, 3):
        figures.append(_drawn(figure, runs, out / "figures" / f"{name}-{figure.number:02d}.png"))
        advance(done, total)
    facts = _facts(runs, time.perf_counter() - started)
    return _Report(manifest, paper.CITATION, paper.READINGS, figures, claims, comparisons, facts, ledger)


def _drawn(figure: PaperFigure, runs: Runs, path: Path) -> _DrawnFigure:
    with style():
        save(figure.draw(runs), path)
    uri = "data:image/png;base64," + base64.b64encode(path.read_bytes()).decode("ascii")
    return _DrawnFigure(figure.number, figure.title, figure.caption, uri)


def _facts(runs: Runs, seconds: float) -> list[tuple[str, str]]:
    """Return what was run, by what, and how long it took."""
    manifest, compiler = runs.model.manifest, find_compiler()
    versions = {"python": platform.python_version(), **_versions(), **manifest.versions}
    backend = {"c": "generated C", "python": "generated NumPy module"}[runs.model.backend]
    return [
        ("model", f"{manifest.model}: {manifest.title}"),
        ("model hash", manifest.hash),
        ("code", backend + (f", {compiler.version}" if runs.model.backend == "c" and compiler else "")),
        ("versions", ", ".join(f"{name} {number}" for name, number in versions.items())),
        ("closed loops", f"{len(runs)}, integrated in {runs.run_seconds:.2f} s"),
        ("compiling or loading", f"{runs.compile_seconds:.2f} s"),
        ("figures and claims", f"{seconds:.1f} s in all"),
    ]


def _versions() -> dict[str, str]:
    found = {}
    for package in _PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            continue
    return found


def _claims_text(reports: Sequence[_Report]) -> str:
    fields = ("number", "text", "expected", "measured", "verdict", "note")
    entries = [
        {"model": report.manifest.model, **{field: getattr(claim, field) for field in fields}}
        for report in reports
        for claim in report.claims
    ]
    return json.dumps(entries, indent=1, ensure_ascii=False) + "\n"


def _page(reports: Sequence[_Report], claims: Sequence[Claim]) -> str:
    loader = jinja2.FileSystemLoader(_TEMPLATES)
    environment = jinja2.Environment(
        loader=loader, autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters |= {"typeset": _typeset, "unit": pretty_unit, "number": _number, "deviation": _deviation}
    environment.filters |= {"mathml": typeset, "counted": counted, "example": example}
    environment.filters["groupby_run"] = by_run
    counts = [(verdict, sum(claim.verdict is verdict for claim in claims)) for verdict in Verdict]
    page = environment.get_template("report.html.j2")
    return page.render(reports=reports, counts=counts, total=len(claims)) + "\n"


def _typeset(text: str) -> str:
    """Return text with proper minus signs and powers of ten."""

    def power(match: re.Match[str]) -> str:
        return f"{match[1]}×10{str(int(match[2])).translate(_SUPERSCRIPTS)}"

    text = re.sub(r"(\d)e([+-]?\d+)", power, text)
    return re.sub(r"(?<![\w.\-])-(?=\d)", "−", text)


def _number(value: float) -> str:
    return _typeset(f"{value:.4g}") if math.isfinite(value) else "does not settle"


def _deviation(comparison: Comparison) -> str:
    value = comparison.deviation
    if not math.isfinite(value) or not math.isfinite(comparison.expected):
        return "–"
    if comparison.metric.kind == "sign_changes":
        return _typeset(f"{value:+.0f}") if value else "0"
    return _typeset(f"{100 * value:+.2f} %") if abs(value) >= 5e-5 else "0.00 %"
