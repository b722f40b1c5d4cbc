# SPDX-License-Identifier: Apache-2.0
"""A closed loop with all its numbers, and its trajectory: the same for every backend."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import IntEnum
from typing import Literal

from ..model.functions import FloatArray, Real
from ..model.manifest import Controller
from ..model.model import Model

Method = Literal["dop853", "dopri5", "rock4", "rk4"]
Progress = Callable[[float, float], None]
Law = Callable[[FloatArray, FloatArray, FloatArray, FloatArray], tuple[FloatArray, FloatArray]]
"""A sampled law evaluated elsewhere: state as measured, reference, applied input, memory -> input, memory."""

METHODS: tuple[Method, ...] = ("rk4", "dopri5", "dop853", "rock4")  # numbered as in native/methods/tableaux.h
STAGES = 16  # the most that a method has, and the length of a row of its coefficients: MV_STAGES


class Status(IntEnum):
    """How a run ended, numbered as in native/step/schedule.h."""

    DONE = 0
    NOT_FINITE = 1
    STEP_UNDERFLOW = 2
    TOO_MANY_STEPS = 3
    LIMIT = 4

    @property
    def text(self) -> str:
        """The status in a few words."""
        return self.name.lower().replace("_", " ")


@dataclass(frozen=True)
class Problem:
    """One closed loop.

    Parameters
    ----------
    p, c, s : array
        Parameters of plant, law and scenario.
    x0, z0 : array
        Initial state, and the memory of a sampled law before its first sample.
    noise : array, (n, ne)
        Independent standard normal numbers for each evaluation of a sampled law.
    suffix : str
        Of the functions that the chosen variant of the plant has of its own.
    real : str
        What a sampled law computes with, "double" or "float".
    t : array
        Ticks in seconds, the first at 0 and the last at the end; integration stops at each of them exactly.
    dt, hold : float
        Sampling step of the result and hold time of the law, s; no hold time for a continuous closed loop.
    record_every : int
        Ticks from one recorded sample to the next; the last tick is recorded too.
    hold_every : int or None
        Ticks for which a sampled law's input is held; None for a continuous closed loop.
    delay : int
        Samples of the law between computing an input and applying it; zero input before.
    method : str
        "dop853", "dopri5", "rock4" or "rk4".
    rtol, atol : float
        Tolerances of the adaptive methods.
    step : float
        Largest step of rk4, s.
    max_steps : int
        Trial steps from one tick to the next after which the run ends.
    progress : callable, optional
        Called now and then with the time reached and the end time.
    law : callable, optional
        Evaluates the sampled law in place of the generated function.
    """

    model: Model
    controller: Controller
    p: FloatArray
    c: FloatArray
    s: FloatArray
    x0: FloatArray
    z0: FloatArray
    noise: FloatArray
    suffix: str
    real: Real
    t: FloatArray
    dt: float
    hold: float | None
    record_every: int
    hold_every: int | None
    delay: int
    method: Method
    rtol: float
    atol: float
    step: float
    max_steps: int
    progress: Progress | None
    law: Law | None = None


@dataclass(frozen=True)
class Trajectory:
    """Recorded samples, one row each, and how the run ended.

    `z` is the law's memory as the law finds it at the sample; `violated` is the index of the limit that
    Status.LIMIT is about, and `x_stop` the state there.
    """

    t: FloatArray
    x: FloatArray
    u: FloatArray
    u_cmd: FloatArray
    y: FloatArray
    z: FloatArray
    status: Status
    violated: int
    t_stop: float
    x_stop: FloatArray
    statistics: Mapping[str, int]
