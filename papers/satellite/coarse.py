# SPDX-License-Identifier: Apache-2.0
"""A coarse simulator of the satellite, as one of the paper's time may have been: one step of Euler's method a sample.

The satellite, its torque held over the sample, has B = Ts^2/(2 I) (1 + q^-1), with a zero at -1. Stepped
semi-implicitly, rates first and then angles with the new rates, an axis has B = Ts^2/I and no zero; stepped explicitly,
with the old rates, B = Ts^2/I q^-1, one more delay. This serves readings of the paper only: the product integrates.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from mehvar.runtime.batch.plan import Plan

from .rows import AXES, LATE

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from mehvar.runtime.batch.plan import Campaign
    from mehvar.runtime.model.model import Model

    FloatArray = NDArray[np.float64]
    BoolArray = NDArray[np.bool_]


Step = Literal["semi-implicit", "explicit"]


@dataclass(frozen=True)
class CoarseRuns:
    """Runs of a law on the coarse simulator, one row each.

    Attributes
    ----------
    values : array, (n, k)
        What was drawn, in the order of the names.
    done : array of bool, (n,)
        Whether no limit was passed before the end.
    rms : array, (n, 3)
        RMS error of roll, pitch and yaw against the reference model, from 200 s on, deg.
    torque : array, (n, samples, 3)
        Torque that acts over each sample, from 200 s on, N m.
    """

    values: FloatArray
    done: BoolArray
    rms: FloatArray
    torque: FloatArray


def coarse_runs(model: Model, campaign: Campaign, step: Step) -> CoarseRuns:
    """Run a batch of a sampled law on the coarse simulator, all runs side by side.

    Parameters
    ----------
    model : Model
        The satellite.
    campaign : Campaign
        As for the batch engine; of its options only the delay counts.
    step : {"semi-implicit", "explicit"}
        Angles by the rates after the sample, or before.
    """
    plan = Plan(model, campaign)
    loop = _Loop(model, plan, step)
    instants = [k * loop.period for k in range(round(plan.scenario.duration / loop.period))]
    samples = [sample for t, sample in ((t, loop.step(t)) for t in instants) if t >= LATE]
    errors, torques = (np.array(series) for series in zip(*samples, strict=True))
    rms = np.degrees(np.sqrt(np.square(errors).mean(axis=0)))
    return CoarseRuns(loop.values, loop.done, rms, torques.swapaxes(0, 1))


class _Loop:
    """State, memory and torques of all runs, and one sample of them."""

    def __init__(self, model: Model, plan: Plan, step: Step) -> None:
        law, functions = plan.law, model.functions
        self._explicit = step == "explicit"
        draw = plan.draw(0, plan.campaign.n)
        self.period = float(draw.p[0, model.parameter_names.index("Ts")])
        self.values, self.done = draw.values, draw.possible.copy()
        self._functions, self._law = functions, functions[law.name]
        self._p, self._c, self._s, self._x = draw.p, draw.c, draw.s, draw.x0
        memory = [q.name for q in law.memory]
        self._model = [memory.index(f"ym_{axis}") for axis in AXES]
        self._z = functions[f"{law.name}_start"](self._x, self._reference(0.0), self._p, self._c)
        self._applied = np.zeros((plan.campaign.n, 3))
        self._waiting = [self._applied] * plan.options.delay

    def step(self, t: float) -> tuple[FloatArray, FloatArray]:
        """Go on by a sample, a run that passed a limit not any more; return the errors before, rad, and the torques."""
        error: FloatArray = self._x[:, :3] - self._z[:, self._model]
        command, self._z = self._law(self._x, self._reference(t), self._applied, self._z, self._p, self._c)
        self.done &= (self._functions["limits"](self._x, command, self._p) > 0).all(axis=1)
        self._waiting.append(command)
        self._applied = np.where(self.done[:, None], self._waiting.pop(0), 0.0)
        self._x = np.where(self.done[:, None], self._moved(), self._x)
        return error, self._applied

    def _moved(self) -> FloatArray:
        """Return the state a sample later."""
        after = self._x + self.period * self._slope(self._x)
        if self._explicit:
            return after
        after[:, :3] = self._x[:, :3]
        after[:, :3] += self.period * self._slope(after)[:, :3]
        return after

    def _slope(self, x: FloatArray) -> FloatArray:
        slope: FloatArray = self._functions["rhs"](x, self._applied, self._p)
        return slope

    def _reference(self, t: float) -> FloatArray:
        reference: FloatArray = self._functions["reference"](t, self._p, self._s)
        return reference
