# SPDX-License-Identifier: Apache-2.0
"""The report as one HTML page that needs nothing else: styles, scripts, pictures and data are in it."""

from __future__ import annotations

import base64
import json
import math
import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from markupsafe import Markup, escape

from mehvar import html
from mehvar.comparison.text import number as eigenvalue
from mehvar.ledger.text import counted, example
from mehvar.papers.claims import Check, Claim, ClaimVerdict
from mehvar.papers.deviations import Deviation
from mehvar.pictures.style import pretty_unit

from .backends import POINTS, TOLERANCE
from .batches import SEED
from .content import PaperReport, Picture, scene_data

_TEMPLATES = Path(__file__).parents[1] / "templates" / "report"
_SCRIPTS = ("uplot/uPlot.iife.min.js", "data.js", "charts.js", "view.js", "player.js")
_STYLES = ("uplot/uPlot.min.css", "report.css")
_GREEK = {"phi": "φ", "theta": "θ", "delta": "δ"}
_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def page(reports: Sequence[PaperReport], facts: Mapping[str, str]) -> str:
    """Return the page.

    Parameters
    ----------
    reports : sequence of PaperReport
        One for each paper.
    facts : mapping
        Versions and times of the whole.
    """
    claims = [claim for report in reports for claim in report.claims]
    counts = [(verdict, sum(claim.verdict is verdict for claim in claims)) for verdict in ClaimVerdict]
    scenes = [Markup(report.paper.script) for report in reports]
    filters: dict[str, Callable[..., Any]] = {
        "typeset": typeset, "unit": pretty_unit, "number": number, "deviation": deviation, "counted": counted,
        "example": example, "uri": _uri, "brief": _brief,
        "complex": eigenvalue,
    }  # fmt: skip
    text = html.page(
        "report/report.html.j2",
        filters,
        reports=reports,
        facts=facts,
        counts=counts,
        total=len(claims),
        styles=[_text(name) for name in _STYLES],
        scripts=[*map(_text, _SCRIPTS), *scenes, _text("report.js")],
        seed=SEED,
        points=POINTS,
        tolerance=TOLERANCE,
        licence=_text("uplot/LICENSE"),
        data=_data(reports),
    )
    return text + "\n"


def _text(name: str) -> Markup:
    return Markup((_TEMPLATES / name).read_text(encoding="utf-8"))


def _data(reports: Sequence[PaperReport]) -> Markup:
    """Return the numbers of charts and animations as JSON that may stand in a script element."""
    pictures = [p for r in reports for p in (*r.pictures, r.bands) if p is not None and p.chart]
    data: dict[str, Any] = {
        "charts": {p.name: p.chart for p in pictures},
        "scenes": {r.manifest.model: scene_data(r.manifest.model, r.scene) for r in reports},
    }
    return Markup(json.dumps(data, ensure_ascii=False, separators=(",", ":")).replace("<", "\\u003c"))


def _uri(picture: Picture) -> str:
    return "data:image/png;base64," + base64.b64encode(picture.png).decode("ascii")


def _brief(claim: Claim) -> tuple[Sequence[Check], int]:
    """Return the checks that a table shows, those that fail first, and how many it leaves out."""
    checks = sorted(claim.checks, key=lambda check: check.holds)
    return checks[:3], max(0, len(checks) - 3)


def typeset(text: str) -> Markup:
    """Return text with proper minus signs, powers of ten, Greek letters and subscripts."""

    def power(match: re.Match[str]) -> str:
        return f"{match[1]}×10{str(int(match[2])).translate(_SUPERSCRIPTS)}"

    text = str(escape(text))
    text = re.sub(r"(\d)e([+-]?\d+)", power, text)
    text = re.sub(r"(?<![\w.\-])-(?=\d)", "−", text)
    text = re.sub(rf"\b({'|'.join(_GREEK)})(?=\b|_|\d)", lambda match: _GREEK[match[1]], text)
    return Markup(re.sub(r"(?<!\w)([^\W\d_])_(\w)(?!\w)", r"\1<sub>\2</sub>", text))


def number(value: float) -> str:
    """Return a number with four digits."""
    return typeset(f"{value:.4g}") if math.isfinite(value) else "does not settle"


def deviation(number: Deviation) -> str:
    """Return how far a number is from what was expected."""
    value = number.size
    if not math.isfinite(value) or not math.isfinite(number.expected):
        return "–"
    if number.metric.kind == "sign_changes":
        return typeset(f"{value:+.0f}") if value else "0"
    return typeset(f"{100 * value:+.2f} %") if abs(value) >= 5e-5 else "0.00 %"
