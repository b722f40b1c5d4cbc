# SPDX-License-Identifier: Apache-2.0
"""Figure as content of a page: its texts, a static picture, and a chart if it shows time series."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from mehvar.pictures.files import pixels, small_png
from mehvar.pictures.style import style

from .charts import chart

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from mehvar.reproduction.claims import Claim


@dataclass(frozen=True)
class Picture:
    """A figure of the page: unique name, texts, picture, and a chart if it shows time series.

    `heading` names the figure of the paper, or marks an extension. `colors` is True if colours show numbers, as in a
    heat map: a dark page keeps them.
    """

    name: str
    title: str
    caption: str
    png: bytes
    chart: Mapping[str, Any] | None
    claims: Sequence[Claim] = ()
    heading: str = ""
    colors: bool = False

    @property
    def size(self) -> tuple[int, int]:
        """Return width and height of the static picture in pixels."""
        return pixels(self.png)

    @property
    def uri(self) -> str:
        """Return the static picture as a data URL."""
        return "data:image/png;base64," + base64.b64encode(self.png).decode("ascii")


def picture(
    name: str, title: str, caption: str, figure: Figure, claims: Sequence[Claim] = (), charted: bool = True
) -> Picture:
    """Return a figure as content of the page; a chart doubles its size."""
    with style():
        return Picture(name, title, caption, small_png(figure), chart(figure) if charted else None, claims,
                       colors=_has_colors(figure))  # fmt: skip


def _has_colors(figure: Figure) -> bool:
    """Return True if colours of a figure show numbers."""
    drawn = (artist for ax in figure.axes for artist in (*ax.collections, *ax.images))
    return any(artist.get_array() is not None for artist in drawn)
