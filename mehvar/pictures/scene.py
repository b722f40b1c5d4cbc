# SPDX-License-Identifier: Apache-2.0
"""Data of an animation, which a script of the page draws."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class SceneLine:
    """A series beside an animation, drawn over time.

    Attributes
    ----------
    column, name : str
        Its column in the scene's runs; its name as HTML.
    color : str
        One of the colours of pictures.
    dash : bool
        Drawn with dashes.
    """

    column: str
    name: str
    color: str
    dash: bool = False


@dataclass(frozen=True)
class ScenePanel:
    """Series beside an animation with a common axis.

    Attributes
    ----------
    label : str
        Label of the axis.
    lines : tuple of SceneLine
        The series.
    scale : float
        Factor of the columns.
    """

    label: str
    lines: tuple[SceneLine, ...]
    scale: float = 1.0


@dataclass(frozen=True)
class Scene:
    """An animation: moving parts of each run, with series over time.

    Attributes
    ----------
    runs : mapping
        Titles of runs to named series; each has "t".
    constants : mapping
        Constant values, such as lengths and the target.
    panels : tuple of ScenePanel
        Series over time.
    speeds : tuple of float
        Available speeds in seconds of the run per second; the first is the default.
    """

    runs: Mapping[str, Mapping[str, FloatArray]]
    constants: Mapping[str, Any]
    panels: tuple[ScenePanel, ...]
    speeds: tuple[float, ...]
