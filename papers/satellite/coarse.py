# SPDX-License-Identifier: Apache-2.0
"""Coarse simulator of the satellite, as the paper's may have been: one Euler step per sample.

The satellite, its torque held over the sample, has B = Ts^2/(2 I) (1 + q^-1), with a zero at -1. Stepped
semi-implicitly, rates first and then angles with the new rates, an axis has B = Ts^2/I and no zero; stepped explicitly,
with the old rates, B = Ts^2/I q^-1, one more delay. This serves readings of the paper only: the product integrates.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from .rows import AXES, LATE

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from mehvar import Model
    from mehvar.runtime import Run

    FloatArray = NDArray[np.float64]
    BoolArray = NDArray[np.bool_]


Step = Literal["semi-implicit", "explicit"]


@dataclass(frozen=True)
class CoarseRuns:
    """Runs of a law on the coarse simulator, one row each.

    Attributes
    ----------
    done : array of bool, (n,)
        True for runs without a violated limit.
    rms : array, (n, 3)
        RMS error of roll, pitch and yaw against the reference model, from 200 s on, deg.
    torque : array, (n, samples, 3)
        Torque that acts over each sample, from 200 s on, N m.
    """

    done: BoolArray
    rms: FloatArray
    torque: FloatArray


def coarse_runs(model: Model, run: Run, step: Step, delay: int, covariances: FloatArray) -> CoarseRuns:
    """Run a sampled law on the coarse simulator once for each first covariance, all runs side by side.

    Parameters
    ----------
    model : Model
        The satellite.
    run : Run
        A run of the law, which has its scenario, parameters and initial state.
    step : {"semi-implicit", "explicit"}
        Angles by the rates after the sample, or before.
    delay : int
        Samples between command and action.
    covariances : array, (n,)
        F(0) of each run.
    """
    c = np.tile(run.parameters.c, (len(covariances), 1))
    c[:, [q.name for q in run.controller.parameters].index("F0")] = covariances
    loop = Loop(model, run, step, delay, c)
    instants = [k * loop.period for k in range(round(run.scenario.duration / loop.period))]
    samples = [sample for t, sample in ((t, loop.step(t)) for t in instants) if t >= LATE]
    errors, torques = (np.array(series) for series in zip(*samples, strict=True))
    rms = np.degrees(np.sqrt(np.square(errors).mean(axis=0)))
    return CoarseRuns(loop.done, rms, torques.swapaxes(0, 1))


class Loop:
    """State, memory and torques of all runs, whose parameters of the law are the rows of c, and one sample of them.

    Attributes
    ----------
    period : float
        Of the law, s.
    done : array of bool, (n,)
        True for runs without a violated limit.
    x : array, (n, nx)
        States.
    applied : array, (n, 3)
        Torques that act.
    """

    def __init__(self, model: Model, run: Run, step: Step, delay: int, c: FloatArray) -> None:
        law, functions, n = run.controller, model.functions, len(c)
        self._explicit = step == "explicit"
        self.period = float(run.parameters.values["Ts"])
        self.done = np.ones(n, bool)
        self._functions, self._law = functions, functions[law.name]
        numbers = run.parameters
        self._p, self._s, self.x = (np.tile(v, (n, 1)) for v in (numbers.p, numbers.s, run.x[0]))
        self._c = c
        memory = [q.name for q in law.memory]
        self._model = [memory.index(f"ym_{axis}") for axis in AXES]
        self._z = functions[f"{law.name}_start"](self.x, self._reference(0.0), self._p, self._c)
        self.applied = np.zeros((n, 3))
        self._waiting = [self.applied] * delay

    def step(self, t: float) -> tuple[FloatArray, FloatArray]:
        """Advance all runs without a violated limit by a sample; return the errors before, rad, and the torques."""
        error: FloatArray = self.x[:, :3] - self._z[:, self._model]
        command, self._z = self._law(self.x, self._reference(t), self.applied, self._z, self._p, self._c)
        self.done &= (self._functions["limits"](self.x, command, self._p) > 0).all(axis=1)
        self._waiting.append(command)
        self.applied = np.where(self.done[:, None], self._waiting.pop(0), 0.0)
        self.x = np.where(self.done[:, None], self._moved(), self.x)
        return error, self.applied

    def _moved(self) -> FloatArray:
        """Return the state a sample later."""
        after = self.x + self.period * self._slope(self.x)
        if self._explicit:
            return after
        after[:, :3] = self.x[:, :3]
        after[:, :3] += self.period * self._slope(after)[:, :3]
        return after

    def _slope(self, x: FloatArray) -> FloatArray:
        slope: FloatArray = self._functions["rhs"](x, self.applied, self._p)
        return slope

    def _reference(self, t: float) -> FloatArray:
        reference: FloatArray = self._functions["reference"](t, self._p, self._s)
        return reference
