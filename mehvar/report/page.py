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
from mehvar.ledger.page import FILTERS
from mehvar.papers.claims import Check, Claim, ClaimVerdict
from mehvar.papers.deviations import Deviation
from mehvar.papers.scene import Scene
from mehvar.pictures.style import pretty_unit

from .backends import POINTS, TOLERANCE
from .batches import SEED
from .content import PaperReport, Picture, scene_data

_TEMPLATES = Path(__file__).parents[1] / "templates" / "report"
SCRIPTS = ("uplot/uPlot.iife.min.js", "data.js", "charts.js", "view.js", "player.js")
STYLES = ("uplot/uPlot.min.css", "report.css")
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
        "typeset": typeset, "unit": pretty_unit, "number": number, "deviation": deviation, "uri": uri, "brief": _brief,
        "complex": eigenvalue, **FILTERS,
    }  # fmt: skip
    text = html.page(
        "report/report.html.j2",
        filters,
        reports=reports,
        facts=facts,
        counts=counts,
        total=len(claims),
        styles=[asset(name) for name in STYLES],
        scripts=[*map(asset, SCRIPTS), *scenes, asset("report.js")],
        seed=SEED,
        points=POINTS,
        tolerance=TOLERANCE,
        licence=asset("uplot/LICENSE"),
        data=page_data(
            [p for r in reports for p in (*r.pictures, r.bands) if p is not None],
            {r.manifest.model: r.scene for r in reports},
        ),
    )
    return text + "\n"


def asset(name: str) -> Markup:
    """Return a style or a script as it stands in a page."""
    return Markup((_TEMPLATES / name).read_text(encoding="utf-8"))


def page_data(pictures: Sequence[Picture], scenes: Mapping[str, Scene]) -> Markup:
    """Return the numbers of charts and animations as JSON that may stand in a script element."""
    data: dict[str, Any] = {
        "charts": {p.name: p.chart for p in pictures if p.chart},
        "scenes": {name: scene_data(name, scene) for name, scene in scenes.items()},
    }
    return Markup(json.dumps(data, ensure_ascii=False, separators=(",", ":")).replace("<", "\\u003c"))


def uri(picture: Picture) -> str:
    """Return the static picture as an address that holds it."""
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
