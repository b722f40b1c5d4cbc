# SPDX-License-Identifier: Apache-2.0
"""Data of an interactive chart, read from the panels of a figure over time."""

from __future__ import annotations

import html
import re
from typing import TYPE_CHECKING, Any

import numpy as np

from mehvar.base.errors import printable
from mehvar.pictures.style import BAND_HIGH, BAND_LOW, BLACK, BLUE, GREEN, GREY, LIGHT, ORANGE, PURPLE, SKY, VERMILLION

from .series import encode, thin

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

COLOR_NAMES = {
    BLUE: "blue", VERMILLION: "vermillion", GREEN: "green", PURPLE: "purple", ORANGE: "orange", SKY: "sky",
    BLACK: "black", GREY: "grey", LIGHT: "grey",
}  # fmt: skip
"""Names of the palette's colours in the style sheet, which has values for light and dark pages."""

_EDGE = 6.0
"""Pixels around a part of a picture, so that none of its lines is cut."""
_LETTERS = {
    "varphi": "φ", "phi": "φ", "vartheta": "ϑ", "theta": "θ", "psi": "ψ", "rho": "ρ", "mu": "μ", "delta": "δ",
    "Delta": "Δ", "perp": "⊥",
}  # fmt: skip


def chart(figure: Figure) -> dict[str, Any] | None:
    """Return the panels of a figure over time; None if a figure has no time axis.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        Figure in this package's style, whose lines have labels.

    Returns
    -------
    dict
        `columns` side by side; `rest`, parts of the picture that are not over time, as shares of it (left, top, width,
        height); and per panel: `title`, `label` and title of its `column` (HTML), `x` and the `y` of each line (see
        `encode`), initial limits, horizontal `levels`, vertical `marks`.
    """
    shown = [ax for ax in figure.axes if _over_time(ax)]
    if not shown:
        return None
    places = [spec.colspan.start if (spec := ax.get_subplotspec()) else 0 for ax in shown]
    titles = {place: _title(ax) for place, ax in zip(reversed(places), reversed(shown), strict=True)}
    return {
        "columns": len(titles),
        "rest": [_place(ax) for ax in figure.axes if ax not in shown],
        "panels": [
            {**_panel(ax), "column": titles[place] if len(titles) > 1 else ""}
            for place, ax in zip(places, shown, strict=True)
        ],
    }


def _over_time(ax: Axes) -> bool:
    """Return True for a panel over time; panels with a shared axis may have one label."""
    shared = ax.get_shared_x_axes().get_siblings(ax)
    return any(other.get_xlabel().startswith("time") for other in shared)


def _place(ax: Axes) -> list[float]:
    """Return left, top, width and height of a panel with its texts, as shares of a figure that has been drawn."""
    box = ax.get_tightbbox()
    assert box is not None
    assert ax.figure is not None
    box = box.padded(_EDGE).transformed(ax.figure.transFigure.inverted())
    (left, low), (right, high) = np.clip(box.get_points(), 0.0, 1.0).tolist()
    return [round(value, 4) for value in (left, 1.0 - high, right - left, high - low)]


def text(label: str) -> str:
    """Return a label with Matplotlib's mathematics as HTML."""
    parts = re.split(r"\$([^$]*)\$", html.escape(printable(label), quote=False))
    if not all(map(_is_mathematics, parts[1::2])):  # dollar signs of the user
        return html.escape(printable(label).replace(r"\$", "$"), quote=False)
    return "".join(_mathematics(part) if k % 2 else part for k, part in enumerate(parts))


def _is_mathematics(part: str) -> bool:
    return all(name in _LETTERS for name in re.findall(r"\\([a-zA-Z]+)", part.replace(r"\tilde", "")))


def plain(label: str) -> str:
    """Return a label in HTML without its markup."""
    return re.sub("<.*?>", "", label)


def _mathematics(formula: str) -> str:
    formula = re.sub(r"\\tilde\\([a-zA-Z]+)", lambda m: _LETTERS[m[1]] + "\u0303", formula)
    formula = re.sub(r"\\([a-zA-Z]+)", lambda m: _LETTERS[m[1]], formula)
    formula = re.sub(r"_(?:\{(.*?)\}|(.))", lambda m: f"<sub>{m[1] or m[2]}</sub>", formula)
    formula = re.sub(r"\^(?:\{(.*?)\}|(.))", lambda m: f"<sup>{m[1] or m[2]}</sup>", formula)
    return formula.replace("\\,", " ").replace("Δ ", "Δ").replace("-", "−").replace("'", "′")


def _panel(ax: Axes) -> dict[str, Any]:
    """Return a panel as JSON values; points are thinned unless a curve has steps."""
    lines = [line for line in ax.get_lines() if line.get_transform() == ax.transData and line.get_linestyle() != "None"]
    x, columns = _shared(lines)
    held = [line.get_drawstyle() == "steps-post" for line in lines]
    kept = np.arange(len(x)) if any(held) else thin(x, columns)
    low, high = sorted(ax.get_xlim())
    return {
        "title": _title(ax),
        "label": text(ax.get_ylabel()),
        "x": encode(x[kept]),
        "limits": [low, high],
        "log": [ax.get_xscale() == "log", ax.get_yscale() == "log"],
        "lines": [
            {**_look(line), "name": _name(line), "step": step, "y": encode(columns[kept, k]), "band": _band(line)}
            for k, (line, step) in enumerate(zip(lines, held, strict=True))
        ],
        **_references(ax),
    }


def _title(ax: Axes) -> str:
    """Return the title of a panel, or nothing if the axis label says the same."""
    title, axis = ax.get_title(loc="left"), ax.get_ylabel()
    return "" if re.sub(r" in (.*)", r" [\1]", title) == axis else text(title)


def _xy(line: Line2D) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
    return np.asarray(line.get_xdata(), dtype=float), np.asarray(line.get_ydata(), dtype=float)


def _shared(lines: list[Line2D]) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
    """Return all instants of several lines and their values, which are missing at other lines' instants."""
    x = np.unique(np.concatenate([_xy(line)[0] for line in lines]))
    columns = np.full((len(x), len(lines)), np.nan)
    for k, line in enumerate(lines):
        at, values = _xy(line)
        columns[np.searchsorted(x, at), k] = values
    return x, columns


def _references(ax: Axes) -> dict[str, Any]:
    """Return the reference lines of a panel: levels of y and marks of x."""
    across = [line for line in ax.get_lines() if line.get_transform() != ax.transData]
    levels = [line for line in across if line.get_transform() == ax.get_yaxis_transform(which="grid")]
    marks = [line for line in across if line not in levels]
    return {
        "levels": [{**_look(line), "name": _name(line), "at": float(_xy(line)[1][0])} for line in levels],
        "marks": [{**_look(line), "name": _name(line), "at": float(_xy(line)[0][0])} for line in marks],
    }


def _look(line: Line2D) -> dict[str, Any]:
    from matplotlib.colors import to_hex

    color = to_hex(line.get_color())
    names = {key.lower(): name for key, name in COLOR_NAMES.items()}
    dash = {"-": [], ":": [1.5, 3.0]}.get(str(line.get_linestyle()), [6.0, 4.0])
    return {"color": names.get(color, color), "dash": dash, "width": float(line.get_linewidth())}


def _name(line: Line2D) -> str:
    label = str(line.get_label())
    return "" if label.startswith("_") else text(label)


def _band(line: Line2D) -> str | None:
    return {BAND_LOW: "low", BAND_HIGH: "high"}.get(line.get_gid() or "")
