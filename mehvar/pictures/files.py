# SPDX-License-Identifier: Apache-2.0
"""Writer of pictures. A file is complete or absent, and the same figure gives the same bytes."""

from __future__ import annotations

import io
import struct
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from mehvar.runtime.files import checked_ending, write_atomic

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_METADATA: dict[str, dict[str, None]] = {
    ".png": {"Software": None},
    ".svg": {"Date": None},
    ".pdf": {"CreationDate": None},
}
"""Metadata omitted from each format because they differ between two writes."""


def save(figure: Figure, path: Path) -> None:
    """Write a figure. The file is complete or absent, and the same figure gives the same bytes.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        Figure to write.
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
    """Return the bytes of a picture file in the format of a suffix."""
    content = io.BytesIO()
    figure.savefig(content, format=suffix[1:], metadata=_METADATA[suffix])
    return content.getvalue()


def small_png(figure: Figure, colors: int = 256) -> bytes:
    """Return a figure as PNG with 256 colours, which takes a third of the size and looks the same.

    For a few lines 32 colours are enough and save another third.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from PIL import Image

    canvas: Any = FigureCanvasAgg(figure)  # matplotlib's canvas has no annotations
    content = io.BytesIO()
    canvas.draw()  # once, where a figure that is saved is drawn a second time for its layout
    Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB").quantize(colors).save(
        content, "png", optimize=True
    )
    return content.getvalue()


def pixels(png: bytes) -> tuple[int, int]:
    """Return width and height of a PNG."""
    width, height = struct.unpack(">II", png[16:24])
    return width, height


def checked_suffix(path: Path) -> str:
    """Return the suffix of a picture's file in lower case; raise InputError for an unknown format."""
    return checked_ending("picture", path, _METADATA)
