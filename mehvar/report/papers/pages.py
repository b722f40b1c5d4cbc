# SPDX-License-Identifier: Apache-2.0
"""Pages of the papers' report: one per paper, and an overview of all claims."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any

from markupsafe import Markup

from mehvar import html
from mehvar.report.page import Page, Part, Section, Stage, Text, page_text, typeset
from mehvar.report.picture import Picture
from mehvar.reproduction.claims import Check, Claim, ClaimKind, ClaimVerdict, tally
from mehvar.reproduction.ledger_page import FILTERS

from .appendix import batch_blocks, casadi_blocks, eigenvalue_table, metric_tables
from .content import PaperReport

OVERVIEW = "index.html"
_INVITATION = Markup(
    '<p><a href="{}">Run it yourself</a>: the generated C as WebAssembly, with sliders, in a page of its own; its '
    "checksum is that of this machine.</p>"
)
_LEAD = (
    "Derived again, turned into code and run. Every figure was drawn, and every claim decided, by running the "
    "generated models; a claim that is not reproduced is listed with the others."
)


def paper_pages(
    reports: Sequence[PaperReport], facts: Mapping[str, str], live: Mapping[str, str] = MappingProxyType({})
) -> dict[str, str]:
    """Return the pages of the report by file name.

    Parameters
    ----------
    reports : sequence of PaperReport
        One for each paper.
    facts : mapping
        Versions and computing times.
    live : mapping
        Links to the pages on which models run.
    """
    files = {report.manifest.model: f"{report.manifest.model}.html" for report in reports}
    others = {"overview": OVERVIEW, **files}
    papers = {report.manifest.model: _paper(report, others, live) for report in reports}
    pages = {OVERVIEW: _overview(reports, papers, facts, others)}
    pages |= {files[name]: page for name, page in papers.items()}
    return {file: page_text(page) for file, page in pages.items()}


def _part(name: str, content: Mapping[str, object], pictures: Sequence[Picture] = ()) -> Part:
    """Return a macro of the template."""
    filters: dict[str, Callable[..., Any]] = {
        "typeset": typeset, "brief": _brief, "outcome": _outcome, **FILTERS,
    }  # fmt: skip
    return Part(Markup(html.page("report/papers.html.j2", filters, part=name, content=content)), pictures)


def _overview(
    reports: Sequence[PaperReport], pages: Mapping[str, Page], facts: Mapping[str, str], others: Mapping[str, str]
) -> Page:
    """Return the page about all papers: their claims by outcome, and the versions."""
    present = {claim.verdict for report in reports for claim in report.claims}
    verdicts = [verdict for verdict in ClaimVerdict if verdict in present]
    content = {
        "reports": reports, "pages": pages, "others": others, "facts": facts,
        "verdicts": verdicts, "outcomes": list(dict.fromkeys(map(_outcome, verdicts))),
        "counts": tally(claim for report in reports for claim in report.claims),
        "failing": {
            kind: [(report.manifest.model, claim) for report in reports for claim in _failing(report.claims, kind)]
            for kind in ClaimKind
        },
        "own": {report.manifest.model: tally(report.claims)[ClaimKind.PAPER] for report in reports},
    }  # fmt: skip
    return Page(
        "What the papers say, computed anew",
        [
            Section("papers", "Papers", [_part("papers", content)]),
            Section("claims", "All claims", [_part("claims", content)]),
            Section("facts", "Versions, hashes and times", [_part("facts", content)]),
        ],
        _LEAD,
        others,
    )


def _failing(claims: Sequence[Claim], kind: str) -> list[Claim]:
    """Return the claims of a kind that do not hold."""
    return [claim for claim in claims if claim.kind is kind and _outcome(claim.verdict) == "does not hold"]


def _outcome(verdict: ClaimVerdict) -> str:
    """Return what a verdict says without its reasons."""
    return next((outcome for outcome in ("does not hold", "undecided") if verdict.startswith(outcome)), "holds")


def _paper(report: PaperReport, others: Mapping[str, str], live: Mapping[str, str]) -> Page:
    """Return the page about a paper; it omits sections for which the paper has no contents."""
    name = report.manifest.model
    words = report.paper.captions.scene
    stage = Stage(name, words.title, words.caption, report.scene)
    runs_here = [Part(_INVITATION.format(live[name]))] if name in live else []
    content = {
        "report": report,
        "name": name,
        "counts": tally(report.claims),
        "weak": [c for c in report.claims if c.kind is ClaimKind.PAPER and c.verdict is not ClaimVerdict.HOLDS],
        "titles": {claim.number: claim.title for claim in report.claims},
    }
    ledger, beyond = report.ledger, report.beyond

    def section(part: str, title: str, shown: Sequence[Picture] = ()) -> Section:
        return Section(f"{name}-{part}", title, [_part(part, content, shown)])

    return Page(
        f"{name}: {report.manifest.title}",
        [
            section("summary", "Summary"),
            Section(f"{name}-animation", "Animation", [stage, *runs_here]),
            section("figures", "Figures and claims", report.pictures),
            Section(f"{name}-reading", "How the paper was read", list(map(Text, report.paper.captions.readings))),
            Section(f"{name}-batch", "What if: runs drawn at random", list(batch_blocks(report))),
            Section(f"{name}-board", "The laws on a microcontroller", report.boards.blocks),
            Section(f"{name}-casadi", "Our text against CasADi's own C", list(casadi_blocks(report)), fold=True),
            *([section("statements", "What the paper says, sentence by sentence")] if report.statements else []),
            Section(f"{name}-numbers", "Numbers of the runs", list(metric_tables(report)), fold=True),
            Section(f"{name}-eigenvalues", "Eigenvalues of the loops", [eigenvalue_table(report)], fold=True),
            *([section("errata", "Errata: printed against derived")] if ledger else []),
            *([section("beyond", "Beyond the paper", beyond.pictures)] if beyond else []),
        ],
        report.paper.captions.citation,
        others,
    )


def _brief(claim: Claim) -> tuple[Sequence[Check], int]:
    """Return the checks that a table shows, failed ones first, and the number of omitted checks."""
    checks = sorted(claim.checks, key=lambda check: check.holds)
    return checks[:3], max(0, len(checks) - 3)
