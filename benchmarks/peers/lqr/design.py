# SPDX-License-Identifier: Apache-2.0
"""Gains for every tool, and the reference; `python benchmarks/peers/lqr/design.py` writes gains.json."""

from __future__ import annotations

import json

import numpy as np
from in_mehvar import generated
from scipy.linalg import expm, solve_discrete_are
from task import HERE, PERIOD, VX

import mehvar

HULL = ["vy", "vz", "wx", "wy", "wz", "q1", "q2", "q3"]


def gains() -> np.ndarray:
    """Return K of the hull at speed with both bobs hanging, its inputs held for a period."""
    model = mehvar.load(generated())
    x = model.state(vx=VX, q0=1.0, s1x=-1.0, s2x=-1.0)
    linear = model.linearize(x, np.zeros(5), model.parameters(I1=0.0, I2=0.0))
    rows = [model.state_names.index(name) for name in HULL]
    turned = np.array([1.0] * 5 + [2.0] * 3)  # the law sees 2 q, which is the attitude angle of a small turn
    a, b = linear.A[np.ix_(rows, rows)] * turned[:, None] / turned, linear.B[rows] * turned[:, None]
    both = expm(PERIOD * np.block([[a, b], [np.zeros((5, 13))]]))
    f, g = both[:8, :8], both[:8, 8:]
    q = np.diag(1 / np.array([100, 100, 0.1, 0.1, 0.1, 0.002, 0.002, 0.002]) ** 2)
    r = np.diag(1 / np.array([500, 500, 500, 1, 1]) ** 2)
    cost = solve_discrete_are(f, g, q, r)
    return np.linalg.solve(r + g.T @ cost @ g, g.T @ cost @ f)


if __name__ == "__main__":
    (HERE / "gains.json").write_text(json.dumps(gains().round(4).tolist()) + "\n", encoding="utf-8")
