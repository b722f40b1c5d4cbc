# SPDX-License-Identifier: Apache-2.0
"""A page of sections: texts, tables, formulas, pictures and animations, in one file that needs nothing else."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from markupsafe import Markup

from mehvar import html
from mehvar.errors import bad_value
from mehvar.papers.reproduction import Reproduction
from mehvar.papers.scene import Scene
from mehvar.runtime.files import write_atomic

from .content import Picture
from .page import SCRIPTS, STYLES, asset, page_data, typeset, uri


@dataclass(frozen=True)
class Text:
    """A paragraph."""

    text: str
    kind: str = field(default="text", init=False)


@dataclass(frozen=True)
class Table:
    """A table under a heading; a table without rows is not shown."""

    title: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    kind: str = field(default="table", init=False)


@dataclass(frozen=True)
class Formulas:
    """Formulas under a heading that opens: pairs of what each is and the formula as MathML."""

    title: str
    formulas: Sequence[tuple[str, Markup]]
    kind: str = field(default="formulas", init=False)


@dataclass(frozen=True)
class Drawing:
    """A picture, with its chart where it is over time."""

    picture: Picture
    kind: str = field(default="drawing", init=False)


@dataclass(frozen=True)
class Stage:
    """An animation of runs, drawn by the script of the paper that it belongs to."""

    name: str
    paper: Reproduction
    scene: Scene
    kind: str = field(default="stage", init=False)


Block = Text | Table | Formulas | Drawing | Stage


@dataclass(frozen=True)
class Section:
    """Blocks under a heading of the page, which its contents link by `anchor`."""

    anchor: str
    title: str
    blocks: Sequence[Block]


def sections_page(title: str, sections: Sequence[Section]) -> str:
    """Return the page.

    Parameters
    ----------
    title : str
        What it is about.
    sections : sequence of Section
        In order; the contents link them.
    """
    blocks = [block for section in sections for block in section.blocks]
    stages = [block for block in blocks if isinstance(block, Stage)]
    scenes: Mapping[str, Scene] = {stage.name: stage.scene for stage in stages}
    text = html.page(
        "report/sections.html.j2",
        {"typeset": typeset, "uri": uri},
        title=title,
        sections=sections,
        styles=[asset(name) for name in STYLES],
        scripts=[*map(asset, SCRIPTS), *(Markup(stage.paper.script) for stage in stages), asset("report.js")],
        licence=asset("uplot/LICENSE"),
        data=page_data([block.picture for block in blocks if isinstance(block, Drawing)], scenes),
    )
    return text + "\n"


def write_page(path: Path, title: str, sections: Sequence[Section]) -> Path:
    """Write the page, whole or not at all; return its path.

    Raises
    ------
    InputError
        If the folder is not there.
    OSError
        If the file cannot be written.
    """
    if not path.parent.is_dir():
        raise bad_value("page", str(path), "in a folder that exists")
    write_atomic(path, sections_page(title, sections).encode())
    return path
