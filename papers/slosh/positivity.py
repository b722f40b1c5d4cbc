# SPDX-License-Identifier: Apache-2.0
"""Regions where the Lyapunov functions (27) and (28) of the slosh paper are positive."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from mehvar.reproduction import Check, Runs

from .rows import LAWS

if TYPE_CHECKING:
    from numpy.typing import NDArray

    FloatArray = NDArray[np.float64]

_STATES = 1000
"""Number of random states with components within 1. For the printed weights V1 is negative at 228 of them, and f has
a negative eigenvalue at all. Half or twice as many change no verdict.
"""
_BODY_RATES = ("wx", "wy", "wz")
_BOB_RATES = ("phi1_dot", "theta1_dot", "phi2_dot", "theta2_dot")


def positive(runs: Runs, **weights: float) -> Sequence[Check]:
    """Return the checks of claim 14: both V at random states, and the f of (29), with some weights changed."""
    states = np.random.default_rng(14).uniform(-1, 1, (_STATES, len(runs("lyapunov-v1", "paper").x[0])))
    values = dict.fromkeys(weights.values())
    names = ", ".join(" = ".join([*(n for n, v in weights.items() if v == value), f"{value:g}"]) for value in values)
    of = f"with {names}: " if names else ""
    return (
        *(_positive(f"{of}least {law[-2:].upper()}", "", _values(runs, law, states, weights)) for law in LAWS),
        _positive(f"{of}least eigenvalue of f (29)", "s^2/rad^2", _least_of_f(runs, states, weights)),
    )


def _positive(what: str, unit: str, values: FloatArray) -> Check:
    least = float(values.min())
    return Check(f"{what} of {_STATES} random states", "> 0", f"{least:.3g} {unit}".strip(), least > 0)


def _values(runs: Runs, law: str, states: FloatArray, weights: Mapping[str, float]) -> FloatArray:
    run = runs(law, "paper")
    c = np.array([weights.get(q.name, run.parameters.values[q.name]) for q in run.controller.parameters])
    values: FloatArray = runs.model.functions[f"{law.replace('-', '_')}_value"](states, runs.model.parameters(), c)
    return values


def _least_of_f(runs: Runs, states: FloatArray, weights: Mapping[str, float]) -> FloatArray:
    """Return the least eigenvalue of f, the quadratic form in the body rates of V1 after completing the square.

    V1 is quadratic in the rates, so its second derivatives are differences of its values.
    """
    names = [q.name for q in runs.model.manifest.states]
    body, bobs = ([k for k, name in enumerate(names) if name in some] for some in (_BODY_RATES, _BOB_RATES))
    unit, rates = np.eye(len(names)), [*body, *bobs]
    still = states.copy()
    still[:, [k for k, name in enumerate(names) if not name.startswith(("phi", "theta")) or k in rates]] = 0.0

    def value(*ones: int) -> FloatArray:
        return _values(runs, "lyapunov-v1", still + sum(unit[k] for k in ones), weights)

    alone = {k: value(k) for k in rates}
    second = np.array([[value(i, j) - alone[i] - alone[j] for j in rates] for i in rates]).transpose(2, 0, 1)
    of_body, mixed, of_bobs = second[:, :3, :3], second[:, :3, 3:], second[:, 3:, 3:]
    left = of_body - mixed @ np.linalg.solve(of_bobs, mixed.transpose(0, 2, 1))
    least: FloatArray = np.linalg.eigvalsh(left)[:, 0]
    return least
