# SPDX-License-Identifier: Apache-2.0
"""Batch of a paper: its dispersions and success condition, from `study.toml`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Band:
    """A stored series to draw over time: its axis label, and True for an angle in degrees."""

    label: str
    degrees: bool = False

    @property
    def scale(self) -> float:
        """Factor applied to the series."""
        return 180 / math.pi if self.degrees else 1.0


@dataclass(frozen=True)
class Study:
    """A batch for each of several laws: dispersions, success condition, and series to show.

    Attributes
    ----------
    text : str
        The question, in words.
    laws : mapping of str to str
        Laws and their titles.
    runs : int
        Number of runs per law.
    vary : mapping of str to str
        Distributions of parameters, as in `mehvar batch --vary`.
    success : str
        Success condition, as in `--success`.
    bands : mapping of str to Band
        Stored series to draw.
    every : float
        Seconds between stored samples.
    own_law : str
        Text with which the reader's own law begins, on the page that runs the system.
    scenario : str, optional
        Default: the model's first scenario.
    options : mapping
        Options of each run, as in `--set`.
    """

    text: str
    laws: Mapping[str, str]
    runs: int
    vary: Mapping[str, str]
    success: str
    bands: Mapping[str, Band]
    every: float
    own_law: str
    scenario: str | None = None
    options: Mapping[str, float | str] = field(default_factory=dict)
