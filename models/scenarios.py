# SPDX-License-Identifier: Apache-2.0
"""Described runs and the numbers that sum them up."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

KINDS = ("settling", "settling_about_end", "max", "min", "max_abs", "rms", "travel", "sign_changes", "final")
"""Of metrics."""


@dataclass(frozen=True)
class Metric:
    """A number that sums up a run.

    Parameters
    ----------
    name, kind, unit, description : str
        `kind` is one of `KINDS`.
    of : tuple of str
        Variables of the result, or differences of two as in "roll - ym_roll".
    band : float
        Settling band or dead band, in the unit of the variables.
    since, until : float
        Part of the run that counts, s.
    """

    name: str
    kind: str
    of: tuple[str, ...]
    unit: str
    description: str
    band: float = 0.0
    since: float = 0.0
    until: float = float("inf")


@dataclass(frozen=True)
class Scenario:
    """A run that the paper or we describe: values, duration and the numbers it is expected to show.

    Parameters
    ----------
    name, title : str
        Identifier and one line for people.
    duration, step : float
        Length of the run and sampling step of its result, s.
    values : mapping of str to float
        Plant and scenario parameters that differ from their defaults.
    controllers : mapping of str to mapping
        Law parameters that differ from their defaults, per law.
    expect : mapping of str to mapping
        Expected metrics per law.
    """

    name: str
    title: str
    duration: float
    step: float
    values: Mapping[str, float]
    controllers: Mapping[str, Mapping[str, float]]
    expect: Mapping[str, Mapping[str, float]]
