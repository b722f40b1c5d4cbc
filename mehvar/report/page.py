# SPDX-License-Identifier: Apache-2.0
"""Writer of a page: sections in one file with styles, scripts and data."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from markupsafe import Markup

from mehvar import html
from mehvar.base.errors import bad_value
from mehvar.base.units import pretty_unit
from mehvar.runtime.files import write_atomic

from .picture import Picture

_SCRIPTS = (
    "uplot/uPlot.iife.min.js", "data.js", "save.js", "charts.js", "view.js", "geometry.js", "player.js", "report.js",
)  # fmt: skip
_STYLES = ("uplot/uPlot.min.css", "charts.css", "report.css")
"""Files of `mehvar/templates/report`."""
_GREEK = {"phi": "φ", "theta": "θ", "delta": "δ"}


@dataclass(frozen=True)
class Text:
    """A paragraph."""

    text: str
    kind: str = field(default="text", init=False)


@dataclass(frozen=True)
class Table:
    """A table with a heading and a note that explains its numbers, omitted if it has no rows."""

    title: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    note: str = ""
    kind: str = field(default="table", init=False)


@dataclass(frozen=True)
class Formulas:
    """A foldable list of formulas: pairs of title and MathML."""

    title: str
    formulas: Sequence[tuple[str, Markup]]
    kind: str = field(default="formulas", init=False)


@dataclass(frozen=True)
class Drawing:
    """A picture, with an interactive chart if its axis is time."""

    picture: Picture
    kind: str = field(default="drawing", init=False)


@dataclass(frozen=True)
class Stage:
    """An animation of runs, with the data of its `scene`."""

    name: str
    title: str
    caption: str
    scene: Mapping[str, Any]
    kind: str = field(default="stage", init=False)


@dataclass(frozen=True)
class Part:
    """Block of the page: its HTML and its pictures."""

    html: Markup
    pictures: Sequence[Picture] = ()
    kind: str = field(default="part", init=False)


Block = Text | Table | Formulas | Drawing | Stage | Part


@dataclass(frozen=True)
class Section:
    """A section of the page with a heading; the contents link to `anchor`, and blocks of `fold` are shown on demand."""

    anchor: str
    title: str
    blocks: Sequence[Block]
    fold: bool = False


@dataclass(frozen=True)
class Page:
    """Title, introduction and sections of a page; `others` are titles and files of related pages."""

    title: str
    sections: Sequence[Section]
    lead: str = ""
    others: Mapping[str, str] = field(default_factory=dict)


def page_text(page: Page) -> str:
    """Return a page as HTML."""
    blocks = [block for section in page.sections for block in section.blocks]
    stages = [block for block in blocks if isinstance(block, Stage)]
    pictures = [block.picture for block in blocks if isinstance(block, Drawing)]
    pictures += [picture for block in blocks if isinstance(block, Part) for picture in block.pictures]
    text = html.page(
        "report/page.html.j2",
        {"typeset": typeset, "numerals": numerals},
        page=page,
        styles=[_asset(name) for name in _STYLES],
        scripts=[_asset(name) for name in _SCRIPTS],
        licence=_asset("uplot/LICENSE"),
        data=_data(pictures, stages),
    )
    return text + "\n"


def write_page(path: Path, page: Page) -> Path:
    """Write a page, complete or not at all; return its path.

    Raises
    ------
    InputError
        If the folder does not exist.
    OSError
        If the file cannot be written.
    """
    if not path.parent.is_dir():
        raise bad_value("page", str(path), "in a folder that exists")
    write_atomic(path, page_text(page).encode())
    return path


def _asset(name: str) -> Markup:
    return html.asset(f"report/{name}")


def _data(pictures: Sequence[Picture], stages: Sequence[Stage]) -> Markup:
    """Return the data of charts and animations."""
    data = {
        "charts": {p.name: p.chart for p in pictures if p.chart},
        "scenes": {stage.name: stage.scene for stage in stages},
    }
    return html.script_data(data)


def numerals(text: str) -> str:
    """Return a cell of numbers with minus signs and powers of ten, another with the exponents of its units raised."""
    if not re.fullmatch(r"[-+\d.,e %[\]±]*\d[-+\d.,e %[\]±]*", text):
        return pretty_unit(text)
    return re.sub(r"(?<!\d)-(?=[\d.])", "−", html.powers(text))


def typeset(text: str) -> Markup:
    """Return text with its quantities set, and with Greek letters and subscripts."""
    text = re.sub(rf"\b({'|'.join(_GREEK)})(?=\b|_|\d)", lambda match: _GREEK[match[1]], html.quantities(text))
    return Markup(re.sub(r"(?<!\w)([^\W\d_])_(\w|\d+)(?!\w)", r"\1<sub>\2</sub>", text))
