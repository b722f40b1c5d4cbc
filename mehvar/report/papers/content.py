# SPDX-License-Identifier: Apache-2.0
"""Content of the report on one paper, computed without writing files."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from mehvar.base.errors import MissingError
from mehvar.codegen.generate import installed_tree
from mehvar.codegen.structures import structure_folders
from mehvar.pictures.style import style, text_figure
from mehvar.report.board.section import Boards, run_boards
from mehvar.report.picture import Picture, picture
from mehvar.report.scene import scene
from mehvar.reproduction.beyond import Beyond, BeyondWords, Difference, differences, load_beyond
from mehvar.reproduction.claims import Claim
from mehvar.reproduction.deviations import by_run, deviations, table_claims
from mehvar.reproduction.ledger_text import evidence_verdict
from mehvar.reproduction.paper import PaperFigure, Reproduction, SceneCaption, load_reproduction
from mehvar.reproduction.runs import Runs
from mehvar.reproduction.statements import Coverage, Statement, coverage, statement_verdicts
from mehvar.runtime.model.model import load
from mehvar.runtime.run.metrics import Deviation
from mehvar.runtime.run.results import to_dataset

from .backends import Agreement, agreement
from .eigenvalues import LoopSpectrum, loop_spectra
from .study import Batch, run_study

if TYPE_CHECKING:
    from concurrent.futures import Future
    from pathlib import Path

    from mehvar.base.manifest import Manifest
    from mehvar.reproduction.ledgers import Ledger
    from mehvar.runtime.model.model import Model
    from mehvar.terminal import Advance


_BANDS = "Median of the runs, and the band that holds nine of ten"


@dataclass(frozen=True)
class BeyondReport:
    """Content of the page about an extension of a paper, with claims of our own."""

    words: BeyondWords
    manifest: Manifest
    claims: Sequence[Claim]
    pictures: Sequence[Picture]
    differences: Sequence[Difference]

    @property
    def unpictured(self) -> list[Claim]:
        """Return the claims without a figure."""
        return _unpictured(self.pictures, self.claims)


@dataclass(frozen=True)
class PaperReport:
    """Content of the page about one paper; `seconds` has the computing times by purpose."""

    model: Model
    paper: Reproduction
    claims: Sequence[Claim]
    pictures: Sequence[Picture]
    deviations: Sequence[Deviation]
    ledger: Ledger | None
    statements: Sequence[Statement]
    coverage: Sequence[Coverage]
    scene: Mapping[str, Any]
    batch: Batch | None
    bands: Picture | None
    boards: Boards
    agreement: Agreement | None
    spectra: Sequence[LoopSpectrum]
    beyond: BeyondReport | None
    loops: int
    seconds: Mapping[str, float]

    @property
    def manifest(self) -> Manifest:
        """Manifest of the model."""
        return self.model.manifest

    @property
    def cover(self) -> Picture | None:
        """Figure that represents the paper on the overview."""
        shown = zip(self.paper.figures, self.pictures, strict=True)
        return next((picture for figure, picture in shown if figure.number == self.paper.captions.cover), None)

    @property
    def unpictured(self) -> list[Claim]:
        """Return the claims without a figure."""
        return _unpictured(self.pictures, self.claims)

    @property
    def rows(self) -> list[tuple[tuple[str, str], list[Deviation]]]:
        """Return the compared numbers by scenario and law."""
        return by_run(self.deviations)


def _unpictured(pictures: Sequence[Picture], claims: Sequence[Claim]) -> list[Claim]:
    shown = {claim.number for picture in pictures for claim in picture.claims}
    return [claim for claim in claims if claim.number not in shown]


def beyond_folders(names: Sequence[str]) -> dict[str, Path]:
    """Return the generated folders of all extensions, derived unless the cache has them."""
    further = {name: beyond.words.structure for name in names if (beyond := load_beyond(name))}
    return structure_folders(installed_tree(), further)


def paper_report(
    name: str,
    ledgers: Future[dict[str, Ledger]],
    folders: Future[dict[str, Path]],
    casadi: Future[Model] | None,
    advance: Advance,
) -> PaperReport:
    """Compute everything for a paper's page, with derivations from other processes.

    Parameters
    ----------
    name : str
        The model.
    ledgers : concurrent.futures.Future
        Future of the judged equations of all papers by model.
    folders : concurrent.futures.Future
        Future of the generated folders of all extensions by model.
    casadi : concurrent.futures.Future, optional
        Future of the model in CasADi's own C; None without a compiler.
    advance : callable
        Called with the finished share, 1, and the current work.
    """
    paper, runs, clock = load_reproduction(name), Runs(load(name)), _Clock()
    advance(0.0, 1.0, f"{name}: claims")
    numbers = deviations(runs)
    claims = [*paper.claims(runs), *table_claims(runs.model.manifest, numbers)]
    clock.note("claims")
    pictures = []
    for done, figure in enumerate(paper.figures):
        advance(0.3 + 0.3 * done / len(paper.figures), 1.0, f"{name}: figure {figure.number}")
        pictures.append(_drawn(name, figure, claims, runs, paper.statements.printed.figures))
    clock.note("figures")
    animation = _animation(paper.captions.scene, runs)
    clock.note("animation")
    batch = texts = None
    if runs.model.backend == "c":
        batch = run_study(runs.model, paper.study, lambda done, what: advance(0.6 + 0.3 * done, 1.0, f"{name}: {what}"))
        clock.note("batches")
    advance(0.9, 1.0, f"{name}: board")
    boards = run_boards(runs)
    clock.note("board")
    advance(0.93, 1.0, f"{name}: beyond the paper")
    extension = load_beyond(name)
    further = _beyond(name, extension, Runs(load(folders.result()[name]), runs)) if extension else None
    clock.note("beyond the paper")
    advance(0.95, 1.0, f"{name}: the paper's equations")
    ledger = ledgers.result().get(name)
    verdicts = {entry["number"]: evidence_verdict(entry) for entry in ledger["entries"]} if ledger else {}
    statements = statement_verdicts(paper.statements, claims, verdicts) if ledger else []
    covered = coverage(paper.statements, statements, verdicts, (figure.number for figure in paper.figures))
    clock.note("equations")
    if casadi is not None:
        advance(0.97, 1.0, f"{name}: CasADi's own C")
        casadi.result()  # derived once: the cache has no lock, and two that miss an entry both make it
        texts = agreement(runs)
        clock.note("CasADi's own C")
    return PaperReport(
        runs.model, paper, claims, pictures, numbers, ledger, statements, covered, animation, batch,
        picture(f"{name}-bands", _BANDS, "", batch.figure) if batch else None,
        boards, texts,
        loop_spectra(runs, dict(by_run(numbers))), further, len(runs), clock.seconds,
    )  # fmt: skip


def _animation(texts: SceneCaption, runs: Runs) -> dict[str, Any]:
    datasets = {}
    for run in texts.run:
        settings: dict[str, Any] = dict(run.set)
        datasets[run.title] = to_dataset(runs(run.law, texts.scenario, **settings))
    return scene(datasets, runs.model, texts.signals)


def _beyond(name: str, beyond: Beyond, runs: Runs) -> BeyondReport:
    """Run a paper's extension and compare it with the paper's own runs."""
    old, new = runs.paper.model.manifest, runs.model.manifest
    claims = beyond.claims(runs)
    pictures = [
        replace(_figure(f"{name}-beyond-{f.number}", f, claims, runs), heading=f"Figure B{f.number}")
        for f in beyond.figures
    ]
    return BeyondReport(beyond.words, new, claims, pictures, differences(old, new))


def _drawn(name: str, figure: PaperFigure, claims: Sequence[Claim], runs: Runs, printed: int) -> Picture:
    beyond = figure.number > printed
    heading = f"Beyond the paper, {figure.number}" if beyond else figure.label or f"Figure {figure.number}"
    return replace(_figure(f"{name}-figure-{figure.number}", figure, claims, runs), heading=heading)


def _figure(name: str, figure: PaperFigure, claims: Sequence[Claim], runs: Runs) -> Picture:
    shown = [claim for number in figure.claims for claim in claims if claim.number == number]
    with style():
        try:
            canvas = figure.draw(runs)
        except MissingError as error:
            canvas = text_figure(f"Not drawn: {error}.")
    return picture(name, figure.title, figure.caption, canvas, shown)


class _Clock:
    """Stopwatch of the seconds per part of the work."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self._last = time.perf_counter()

    def note(self, what: str) -> None:
        now = time.perf_counter()
        self.seconds[what], self._last = now - self._last, now
