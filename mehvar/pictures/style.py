# SPDX-License-Identifier: Apache-2.0
"""Common style of all pictures: palette, lines, fonts, empty figures, axis labels."""

from __future__ import annotations

import functools
import importlib.util
import json
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TYPE_CHECKING, Any

from mehvar.base.errors import InputError, printable
from mehvar.base.units import pretty_unit
from mehvar.runtime.run.options import OPTIONS
from mehvar.runtime.run.problem import COMPLETE

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

BLUE, VERMILLION, GREEN, PURPLE = "#0072B2", "#D55E00", "#009E73", "#CC79A7"
ORANGE, SKY, BLACK, GREY, LIGHT = "#E69F00", "#56B4E9", "#222222", "#777777", "#DDDDDD"
COLORS = (BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY, BLACK)
"""Palette of Okabe and Ito without its yellow, which is too faint on white."""
BAND_LOW, BAND_HIGH = "band-low", "band-high"
"""`gid` of the lower and upper edges of a band, which an interactive chart fills."""
_MOST_CHANGES = 4
"""Largest number of changed values in a title, so that it stays on one line."""
DPI = 150
"""Resolution, sharp in print at column width; twice the resolution makes the report four times as large."""

_by_pyplot: ContextVar[bool] = ContextVar("_by_pyplot", default=False)
"""True if pyplot creates new figures, which a notebook or window then shows."""

_STYLE: dict[str, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 9.0,
    "axes.titlesize": 9.0,
    "axes.titlelocation": "left",
    "axes.labelsize": 9.0,
    "axes.edgecolor": GREY,
    "axes.axisbelow": True,
    "axes.grid": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "grid.color": "#E6E6E6",
    "grid.linewidth": 0.7,
    "xtick.color": "#444444",
    "ytick.color": "#444444",
    "legend.frameon": False,
    "legend.fontsize": 8.0,
    "lines.linewidth": 1.5,
    "savefig.dpi": DPI,
    "svg.hashsalt": "mehvar",
}


def require_matplotlib() -> None:
    """Raise an error with the install command if matplotlib is missing.

    Raises
    ------
    InputError
        If matplotlib is not installed.
    """
    if importlib.util.find_spec("matplotlib") is None:
        raise InputError('pictures need matplotlib: pip install "mehvar[plot]"')


@contextmanager
def style() -> Iterator[None]:
    """Apply the style, regardless of the user's settings."""
    require_matplotlib()
    import matplotlib.style
    from cycler import cycler

    colors = {"axes.prop_cycle": cycler(color=COLORS)}
    with matplotlib.style.context(["default", {**_STYLE, **colors}], after_reset=True):
        yield


@contextmanager
def interactive_style() -> Iterator[None]:
    """Apply the style to pyplot's figures, after loading its backend.

    Pyplot loads a notebook's backend at the first drawing and then becomes interactive. Inside the style block this
    change would be reverted, and a notebook would show only the first picture.
    """
    require_matplotlib()
    from matplotlib import pyplot

    pyplot.draw_if_interactive()  # type: ignore[no-untyped-call]
    token = _by_pyplot.set(True)
    try:
        with style():
            yield
    finally:
        _by_pyplot.reset(token)


def new_figure(width: float, height: float) -> Figure:
    """Return an empty figure with automatic layout.

    Parameters
    ----------
    width, height : float
        Inches.
    """
    if not _by_pyplot.get():
        return _figure_class()(figsize=(width, height), dpi=DPI, layout="constrained")
    from matplotlib import pyplot

    return pyplot.figure(figsize=(width, height), dpi=DPI, layout="constrained", FigureClass=_figure_class())


@functools.cache
def _figure_class() -> type[Figure]:
    """Return the figure class that shows texts literally."""
    from matplotlib.figure import Figure

    class TextProof(Figure):
        """A figure that shows texts literally unless they are formulas, and in this style wherever it is drawn.

        Matplotlib makes ticks when it draws, from the settings of that moment.
        """

        def draw(self, renderer: Any) -> None:
            with style():
                _make_drawable(self)
                super().draw(renderer)

        def savefig(self, *args: Any, **options: Any) -> None:
            with style():
                super().savefig(*args, **options)

        def _ipython_display_(self) -> None:
            """Detach the figure from pyplot, which would show it again at the end of the cell."""
            from matplotlib import get_backend, pyplot

            if "inline" in get_backend():
                pyplot.close(self)
            raise NotImplementedError  # IPython then shows it as any other figure

    return TextProof


_DOLLAR = re.compile(r"(?<!\\)\$")


def _make_drawable(figure: Figure) -> None:
    """Replace characters without a glyph, and escape the dollar signs of texts that are no formulas."""
    from matplotlib.mathtext import MathTextParser
    from matplotlib.text import Text

    parser: Any = MathTextParser("path")
    for text in figure.findobj(Text):
        assert isinstance(text, Text)
        content = text.get_text()
        if printable(content) != content:
            text.set_text(printable(content))
        if "$" not in content:
            continue
        try:
            for line in printable(content).splitlines():  # the parser has no glyph for the end of a line
                parser.parse(line)
        except ValueError:
            text.set_text(_DOLLAR.sub(r"\\$", printable(content)))


def text_figure(text: str) -> Figure:
    """Return a figure with a text in place of a picture."""
    figure = new_figure(7.0, 1.0)
    figure.text(0.5, 0.5, text, ha="center", va="center", wrap=True)
    return figure


def label(symbol: str, meaning: str, unit: str) -> str:
    """Return an axis label: symbol, meaning and unit.

    Parameters
    ----------
    symbol, meaning, unit : str
        As in `$t$`, `time`, `s`.
    """
    return f"{meaning} {symbol} [{pretty_unit(unit)}]"


def time_axis(ax: Axes, text: str, last: bool = True, zero: bool = True) -> None:
    """Set limits, zero line and labels of an axis over time.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        The panel.
    text : str
        Label of the vertical axis.
    last : bool
        True for the lowest panel, which labels the time.
    zero : bool
        Draw a line at zero.
    """
    if zero:
        ax.axhline(0.0, color=GREY, lw=0.6, zorder=0.9)
    ax.margins(x=0)
    ax.set_xlabel(label("$t$", "time", "s"))
    if not last:
        ax.xaxis.label.set_visible(False)
        ax.tick_params(labelbottom=False)
    ax.set_ylabel(text)


def case_text(about: Mapping[str, Any]) -> str:
    """Return the scenario and changed values of a run or batch as text, as in "paper, theta_0 = 0.3"."""
    if "campaign" in about:
        campaign = json.loads(about["campaign"])
        plain = {name: row.default for name, row in OPTIONS.items()}
        options = {name: value for name, value in campaign["options"].items() if value != plain.get(name)}
        changed = {**campaign["parameters"], **options, **campaign["initial"]}
    else:
        changed = json.loads(about["changed"])
    parts = [f"{name} = {v:.6g}" if isinstance(v, float) else f"{name} = {v}" for name, v in changed.items()]
    more = [f"{len(parts) - _MOST_CHANGES} more"] if len(parts) > _MOST_CHANGES else []
    return ", ".join([about["scenario"], *parts[:_MOST_CHANGES], *more])


def headline(dataset: xr.Dataset) -> str:
    """Return title and case of a run, and the reason of an early end.

    Parameters
    ----------
    dataset : xarray.Dataset
        Result of `mehvar.simulate`.
    """
    text = f"{dataset.attrs['title']} (scenario {case_text(dataset.attrs)})"
    if dataset.attrs["status"] in [status.text for status in COMPLETE]:
        return text
    return f"{text}\nended early: {dataset.attrs['reason']}"
