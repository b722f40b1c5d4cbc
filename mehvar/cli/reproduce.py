# SPDX-License-Identifier: Apache-2.0
"""`mehvar reproduce`: all figures and claims of the papers, computed anew, as an HTML report."""

from __future__ import annotations

import json
import os
import platform
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from mehvar.base.versions import installed
from mehvar.pictures.style import require_matplotlib
from mehvar.reproduction.claims import ClaimVerdict, tally, tally_text
from mehvar.reproduction.ledgers import paper_ledgers
from mehvar.reproduction.paper import paper_models, papers_tree
from mehvar.runtime.compiling.compiler import find_compiler
from mehvar.runtime.files import check_folder, filling
from mehvar.runtime.model.model import load
from mehvar.terminal import Advance, progress
from mehvar.web.export import export_web
from mehvar.web.module import zig_available

if TYPE_CHECKING:
    from mehvar.base.manifest import Manifest
    from mehvar.report.papers.content import PaperReport
    from mehvar.reproduction.claims import Claim

_LIVE = "live"
_MAKER = "mehvar reproduce"
_NAMES = ("index.html", "claims.json", "beyond.json", "figures", _LIVE)
_PACKAGES = ("python", "mehvar", "numpy", "scipy", "matplotlib", "unicorn")


def command(
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder of the report.")] = Path("report"),
) -> int:
    """Write the report of the reproduced papers; return the exit status."""
    with progress("reproduce") as advance:
        counts, failures = reproduce(out, advance)
    for line in [*counts, f"report: {out / 'index.html'}", *failures]:
        typer.echo(line)
    return int(bool(failures))


def reproduce(out: Path, advance: Advance | None = None) -> tuple[list[str], list[str]]:
    """Compute all figures and claims of all papers, a batch and a board run per system, then write the report.

    Writing starts after all computations.

    Parameters
    ----------
    out : Path
        Folder of the report. It gets index.html and a self-contained page per paper; claims.json and beyond.json with
        verdicts on the papers' claims and on claims about extensions; figures/; and with zig live/, the pages on
        which each system runs.
    advance : callable, optional
        Called with the finished amount, the total, both in papers, and the current work.

    Returns
    -------
    list of str
        Numbers of claims of each kind by verdict, one line per kind.
    list of str
        Failures, one line per kind: claims that fail without a documented refutation, laws that are not bit-identical
        on board and host, and functions that CasADi's own C computes differently.

    Raises
    ------
    InputError
        If matplotlib is not installed, `out` is invalid, or there is no paper.
    OSError
        If a file cannot be written.
    """
    require_matplotlib()
    tree = papers_tree()
    models = paper_models(tree)
    check_folder(out, _MAKER, [*_NAMES, *(f"{name}.html" for name in models)])
    from mehvar.report.papers.content import beyond_folders, paper_report
    from mehvar.report.papers.pages import paper_pages

    started = time.perf_counter()
    with _in_background() as background:  # other processes derive while this one draws: both cores have work
        ledgers = background.submit(lambda: {ledger["model"]: ledger for ledger in paper_ledgers(tree)})
        folders = background.submit(beyond_folders, models)
        compiled = models if find_compiler() is not None else ()
        casadi = {name: background.submit(load, name, "casadi") for name in compiled}
        reports = [
            paper_report(name, ledgers, folders, casadi.get(name), _part(advance, i, len(models)))
            for i, name in enumerate(models)
        ]
    live = {name: f"{_LIVE}/{name}.html" for name in models} if zig_available() else {}
    _write(out, reports, paper_pages(reports, _facts(reports, time.perf_counter() - started), live), live)
    if advance is not None:
        advance(len(models), len(models))
    counts = tally(claim for report in reports for claim in report.claims)
    return [tally_text(kind, of) for kind, of in counts.items()], _failures(reports)


@contextmanager
def _in_background() -> Iterator[ThreadPoolExecutor]:
    """Yield an executor that runs tasks one by one and drops waiting tasks at the end."""
    executor = ThreadPoolExecutor(1)
    try:
        yield executor
    finally:
        executor.shutdown(cancel_futures=True)


def _failures(reports: Sequence[PaperReport]) -> list[str]:
    """Return a line for each kind of failure, with the claims, laws or functions that fail."""
    kinds: dict[str, Callable[[PaperReport], Iterable[str]]] = {
        "claims that do not hold": lambda report: (c.number for c in report.claims if c.verdict is ClaimVerdict.FAILS),
        "claims beyond the papers that do not hold": lambda report: (
            c.number for c in (report.beyond.claims if report.beyond else ()) if c.verdict is ClaimVerdict.FAILS
        ),
        "laws that differ between board and host": lambda report: (b.law for b in report.boards.laws if not b.same),
        "functions that differ from CasADi's own C": lambda report: (
            report.agreement.different if report.agreement else ()
        ),
    }
    names = {kind: [f"{r.manifest.model} {name}" for r in reports for name in of(r)] for kind, of in kinds.items()}
    return [f"{kind}: {', '.join(several)}; see the report" for kind, several in names.items() if several]


def _part(advance: Advance | None, index: int, count: int) -> Advance:
    """Return the progress function for one of several papers."""

    def part(done: float, total: float, what: str = "") -> None:
        if advance is not None:
            advance(index + done / total, count, what)

    return part


def _write(out: Path, reports: Sequence[PaperReport], pages: Mapping[str, str], live: Iterable[str]) -> None:
    """Write pages, figures, claims as JSON, and pages that run the models in `live`, to the folder `out`."""
    with filling(out, _MAKER) as folder:
        for report in (report for report in reports if report.manifest.model in live):
            study = report.paper.study
            export_web(report.manifest.model, folder / _LIVE, success=study.success, own_law=study.own_law.strip())
        (folder / "figures").mkdir()
        for report in reports:
            for figure, picture in zip(report.paper.figures, report.pictures, strict=True):
                (folder / "figures" / f"{report.manifest.model}-{figure.number:02d}.png").write_bytes(picture.png)
            for picture in report.beyond.pictures if report.beyond else ():
                (folder / "figures" / f"{picture.name}.png").write_bytes(picture.png)
        (folder / "claims.json").write_text(_claims_text((r.manifest, r.claims) for r in reports), encoding="utf-8")
        beyond = ((report.beyond.manifest, report.beyond.claims) for report in reports if report.beyond)
        (folder / "beyond.json").write_text(_claims_text(beyond), encoding="utf-8")
        for name, text in pages.items():
            (folder / name).write_text(text, encoding="utf-8")


def _claims_text(decided: Iterable[tuple[Manifest, Sequence[Claim]]]) -> str:
    fields = ("number", "kind", "text", "expected", "measured", "verdict", "note", "outcome")
    entries = [
        {"model": manifest.model, **{field: getattr(claim, field) for field in fields}}
        for manifest, claims in decided
        for claim in claims
    ]
    return json.dumps(entries, indent=1, ensure_ascii=False) + "\n"


def _facts(reports: Sequence[PaperReport], seconds: float) -> dict[str, str]:
    """Return the versions of the software and the time of the computation."""
    compiler, code = find_compiler(), reports[0].model.backend
    backend = {"c": "generated C", "python": "generated NumPy modules"}[code]
    versions = {**installed(*_PACKAGES), **reports[0].manifest.versions}
    return {
        "code that ran": backend + (f", {compiler.version}" if code == "c" and compiler else ""),
        "versions": ", ".join(f"{name} {number}" for name, number in versions.items()),
        "system": f"{platform.system()} on {platform.machine()}, {os.cpu_count()} processors",
        "made": f"{time.strftime('%Y-%m-%d %H:%M')}, in {seconds:.0f} s",
    }
