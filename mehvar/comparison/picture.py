# SPDX-License-Identifier: Apache-2.0
"""The picture of a comparison: the run that differs most, of both versions."""

from __future__ import annotations

import importlib.util
from typing import TYPE_CHECKING

from .result import ModelDiff

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def overlay_of(model: ModelDiff) -> Figure | None:
    """Return the picture; None where no run differs, or matplotlib is not installed."""
    overlay = model.overlay
    if overlay is None or importlib.util.find_spec("matplotlib") is None:
        return None
    from mehvar.pictures.overlay import overlay_picture
    from mehvar.pictures.style import style
    from mehvar.runtime.run.results import to_dataset

    with style():
        title = f"{model.model}: {overlay.scenario} under {overlay.law}"
        return overlay_picture(to_dataset(overlay.old), to_dataset(overlay.new), title)
