# SPDX-License-Identifier: Apache-2.0
"""One style for every picture, a picture of any run, and files that are complete or absent."""

from __future__ import annotations

import importlib
import importlib.util
import io
import textwrap
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import cycle, islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mehvar.errors import InputError, bad_value
from mehvar.runtime.files import write_atomic
from mehvar.runtime.model.manifest import Manifest, Quantity, identifier

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

BLUE, VERMILLION, GREEN, PURPLE = "#0072B2", "#D55E00", "#009E73", "#CC79A7"
ORANGE, SKY, BLACK, GREY, LIGHT = "#E69F00", "#56B4E9", "#222222", "#777777", "#DDDDDD"
COLORS = (BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY, BLACK)
"""Okabe and Ito's palette without its yellow, which is too faint on white."""
DPI = 150

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
_LINES = ("-", "--", ":", "-.")
_METADATA: dict[str, dict[str, None]] = {
    ".png": {"Software": None},
    ".svg": {"Date": None},
    ".pdf": {"CreationDate": None},
}
_MOST_NAMED = 12


@dataclass(frozen=True)
class _Panel:
    """Variables of one kind and unit: pairs of the dataset's variable and what it is."""

    kind: str
    unit: str
    variables: tuple[tuple[str, Quantity], ...]


def require_matplotlib() -> None:
    """Refuse with the command that helps.

    Raises
    ------
    InputError
        If matplotlib is not installed.
    """
    if importlib.util.find_spec("matplotlib") is None:
        raise InputError('pictures need matplotlib: pip install "mehvar[plot]"')


@contextmanager
def style() -> Iterator[None]:
    """Apply the style, whatever the user's own settings are."""
    require_matplotlib()
    import matplotlib.style
    from cycler import cycler

    colors = {"axes.prop_cycle": cycler(color=COLORS)}
    with matplotlib.style.context(["default", {**_STYLE, **colors}], after_reset=True):
        yield


def new_figure(width: float, height: float) -> Figure:
    """Return an empty figure whose parts make room for each other; sizes in inches."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), dpi=DPI, layout="constrained")


def picture(dataset: xr.Dataset, manifest: Manifest) -> Figure:
    """Draw one run.

    A module mehvar.papers.MODEL, where there is one, says how; otherwise every state, input and output is drawn over
    time, one panel for each kind and unit.

    Parameters
    ----------
    dataset : xarray.Dataset
        What `mehvar.runtime.run.results.to_dataset` or `open_result` return.
    manifest : Manifest
        The model's.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    InputError
        If matplotlib is not installed.
    """
    require_matplotlib()
    name = f"mehvar.papers.{identifier(manifest.model)}"
    own = importlib.import_module(f"{name}.study") if importlib.util.find_spec(name) else None
    with style():
        if own is not None and hasattr(own, "picture"):
            drawn: Figure = own.picture(dataset, manifest)
            return drawn
        return _panels_picture(dataset, manifest)


def save(figure: Figure, path: Path) -> None:
    """Write a figure; the file is complete or absent, and the same figure gives the same bytes.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        What to write.
    path : Path
        Its suffix decides the format: .png, .svg or .pdf.

    Raises
    ------
    InputError
        For another suffix, a missing folder, or a path that is a folder.
    OSError
        If the file cannot be written; the message names it.
    """
    write_atomic(path, encoded(figure, checked_suffix(path)))


def encoded(figure: Figure, suffix: str) -> bytes:
    """Return a figure as the bytes of a file with a suffix that `save` knows."""
    content = io.BytesIO()
    with style():
        figure.savefig(content, format=suffix[1:], metadata=_METADATA[suffix])
    return content.getvalue()


def checked_suffix(path: Path) -> str:
    """Return the suffix of a picture's file in small letters, or raise InputError for one that is no format."""
    suffix = Path(path).suffix.lower()
    if suffix not in _METADATA:
        raise bad_value("picture", str(path), "a file name that ends in .png, .svg or .pdf")
    return suffix


def label(symbol: str, meaning: str, unit: str) -> str:
    """Return an axis label: symbol, meaning and unit."""
    return f"{meaning} {symbol} [{pretty_unit(unit)}]"


def pretty_unit(unit: str) -> str:
    """Return a unit with raised exponents."""
    return unit.replace("^2", "²").replace("^3", "³")


def time_axis(ax: Axes, text: str, last: bool = True, zero: bool = True) -> None:
    """Finish an axis over time: limits, zero line, labels."""
    if zero:
        ax.axhline(0.0, color=GREY, lw=0.6, zorder=0.9)
    ax.margins(x=0)
    ax.set_xlabel(label("$t$", "time", "s"))
    if not last:
        ax.xaxis.label.set_visible(False)
        ax.tick_params(labelbottom=False)
    ax.set_ylabel(text)


def headline(dataset: xr.Dataset) -> str:
    """Return what was run and, when it ended early, why."""
    text = f"{dataset.attrs['title']} (scenario {dataset.attrs['scenario']})"
    if dataset.attrs["status"] == "done":
        return text
    return f"{text}\nended early: {dataset.attrs['reason']}"


def _panels_picture(dataset: xr.Dataset, manifest: Manifest) -> Figure:
    panels = _panels(manifest)
    columns = 1 if len(panels) <= 4 else 2
    rows = -(-len(panels) // columns)
    figure = new_figure(7.0 * columns, 0.6 + 1.9 * rows)
    figure.suptitle(headline(dataset), fontsize=10, wrap=True)
    grid = figure.subplots(rows, columns, sharex=True, squeeze=False)
    axes: list[Axes] = list(grid.T.flat)
    for panel, ax in zip(panels, axes, strict=False):
        _draw(ax, dataset, panel)
        ax.set_xlabel(label("t", "time", "s"))
        ax.tick_params(labelbottom=True)
    for ax in axes[len(panels) :]:
        ax.remove()
    return figure


def _panels(manifest: Manifest) -> list[_Panel]:
    kinds: tuple[tuple[str, str, Sequence[Quantity]], ...] = (
        ("state", "", manifest.states),
        ("input", "u_", manifest.inputs),
        ("output", "", manifest.outputs),
    )
    return [
        _Panel(kind, unit, tuple((prefix + q.name, q) for q in quantities if q.unit == unit))
        for kind, prefix, quantities in kinds
        for unit in dict.fromkeys(q.unit for q in quantities)
    ]


def _draw(ax: Axes, dataset: xr.Dataset, panel: _Panel) -> None:
    t = dataset["t"].values
    for number, (variable, quantity) in enumerate(panel.variables):
        line = next(islice(cycle(_LINES), number // len(COLORS), None))
        text = textwrap.fill(f"{variable}: {quantity.description}", 34)
        named = number < _MOST_NAMED
        ax.plot(t, dataset[variable].values, line, label=text if named else None)
    ax.margins(x=0)
    if len(panel.variables) == 1:
        variable, quantity = panel.variables[0]
        ax.set_title(f"{panel.kind}: {quantity.description}")
        ax.set_ylabel(f"{variable} [{pretty_unit(panel.unit)}]")
        return
    ax.set_title(f"{panel.kind}s in {pretty_unit(panel.unit)}")
    ax.set_ylabel(f"{panel.kind}s [{pretty_unit(panel.unit)}]")
    hidden = len(panel.variables) - _MOST_NAMED
    title = f"the first {_MOST_NAMED} of {len(panel.variables)}" if hidden > 0 else None
    ax.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), borderaxespad=0.0, title=title)
