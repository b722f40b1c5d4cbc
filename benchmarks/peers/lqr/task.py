# SPDX-License-Identifier: Apache-2.0
"""The task of every tool: a craft with two fuel pendulums under one LQR, from a thousand starts.

The bobs are points on ball joints and their damping is eps/2 |s'|^2: every tool here can say that, Basilisk's own
pendulum included.
"""

from __future__ import annotations

import argparse
import inspect
import io
import json
import os
import resource
import time
import tokenize
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Fly = Callable[[Array], Array]
"""From initial states (runs, 9) to final states (runs, 22): V, Omega, q (scalar first, body to inertial), then s and
sigma = s' + Omega x s of each bob, all vectors in body axes."""

M, M0, I0, J, H0, B, D, F = 975.0, 480.0, 50.0, 400.0, 0.05, -0.6, 1.2, 2450.0
BOBS = ((50.0, 0.2, 0.6, 3.57), (5.0, 0.1, 0.9, 0.15))
"""Mass, length, pivot ahead of O and damping of each pendulum, from the paper."""
VX, PERIOD, SAMPLES = 3000.0, 0.1, 200
TOLERANCE = 1e-9
"""Relative and absolute tolerance, which all tools support; defaults: SciPy 1e-3, mehvar 1e-11, heyoka 2e-16."""
DELTA_MAX = 0.6  # rad, that of the tutorial on the LQR: its gains ask for more in the first samples
HERE = Path(__file__).parent
GAINS: Array = np.array(json.loads((HERE / "gains.json").read_text(encoding="utf-8")))
"""K (5, 8): Mx, My, Mz, delta1, delta2 from vy, vz, Omega, 2 (q1, q2, q3)."""
VARY = {
    **{"vy_0": "uniform(60, 90)", "vz_0": "uniform(20, 30)"},
    **{"att1_0": "uniform(-0.1, 0.1)", "att2_0": "uniform(-0.1, 0.1)", "att3_0": "uniform(-0.1, 0.1)"},
    **{"phi1_0": "uniform(0.3, 0.7)", "theta1_0": "uniform(-3, 3)"},
    **{"phi2_0": "uniform(0.3, 0.7)", "theta2_0": "uniform(-3, 3)"},
}
STARTS = HERE.parents[2] / "build" / "compare" / "starts.npy"
RUNS = 1000


def hull() -> tuple[float, Array, Array]:
    """Return mass, centre of mass from O and inertia about that centre of hull and fixed fuel as one body."""
    mass, centres = M + M0, (np.array([-B, 0.0, 0.0]), np.array([-H0, 0.0, 0.0]))
    centre = (M * centres[0] + M0 * centres[1]) / mass
    inertia = (J + I0) * np.eye(3)
    for part, at in zip((M, M0), centres, strict=True):
        r = at - centre
        inertia += part * (r @ r * np.eye(3) - np.outer(r, r))
    return mass, centre, inertia


def law(state: Array) -> Array:
    """Return the inputs that the LQR commands at states (..., 22)."""
    seen = np.concatenate([state[..., 1:6], 2 * state[..., 7:10]], axis=-1)
    u = -seen @ GAINS.T
    u[..., 3:] = np.clip(u[..., 3:], -DELTA_MAX, DELTA_MAX)
    return u


def wrench(u: Array) -> tuple[Array, Array]:
    """Return force, and moment about O, of inputs (..., 5)."""
    d1, d2 = u[..., 3], u[..., 4]
    force = F * np.stack([np.cos(d1) * np.cos(d2), np.sin(d2), -np.sin(d1) * np.cos(d2)], axis=-1)
    return force, u[..., :3] + np.cross([-(B + D), 0.0, 0.0], force)


def initial(starts: Array) -> Array:
    """Return the states (runs, 22) of starts (runs, 9)."""
    vy, vz, a1, a2, a3, *angles = starts.T
    half = [(np.cos(a / 2), np.sin(a / 2)) for a in (a1, a2, a3)]
    (c1, s1), (c2, s2), (c3, s3) = half
    q = [
        c1 * c2 * c3 + s1 * s2 * s3,
        s1 * c2 * c3 - c1 * s2 * s3,
        c1 * s2 * c3 + s1 * c2 * s3,
        c1 * c2 * s3 - s1 * s2 * c3,
    ]
    zero = np.zeros_like(vy)
    bobs = [
        [-np.cos(phi), np.sin(phi) * np.sin(theta), np.sin(phi) * np.cos(theta), zero, zero, zero]
        for phi, theta in (angles[:2], angles[2:])
    ]
    return np.stack([np.full_like(vy, VX), vy, vz, zero, zero, zero, *q, *bobs[0], *bobs[1]], axis=-1)


def matrix(q: Array) -> Array:
    """Return the matrix from body to inertial axes of a unit quaternion, scalar first."""
    w, v = q[0], np.asarray(q[1:])
    return (w * w - v @ v) * np.eye(3) + 2 * np.outer(v, v) + 2 * w * np.cross(np.eye(3), v)


def measure(make: Callable[[float], Fly], runs: int, more: Iterable[Path] = ()) -> None:
    """Build, simulate one and then `runs` initial states; print processor times, lines of code and final states.

    Processor time is that of all threads and of compilers that were started; of a thousand runs it is scaled up when
    `runs` are fewer.
    """
    parser = argparse.ArgumentParser()
    parser.add_argument("--runs", type=int, default=runs, help="how many of the thousand are flown")
    parser.add_argument("--tolerance", type=float, default=TOLERANCE)
    parser.add_argument("--out", type=Path, help="final states and times, .npz")
    given = parser.parse_args()
    source = inspect.getsourcefile(make)
    assert source is not None
    starts = np.load(STARTS) if STARTS.exists() else np.zeros((RUNS, len(VARY)))
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})  # one core
    begun = _spent()
    fly = make(given.tolerance)
    fly(starts[:1])
    ready = _spent()
    fly(starts[1:2])
    alone = _spent()
    final = fly(starts[: given.runs])
    done = _spent()
    facts: dict[str, Any] = {
        "lines": sum(lines(path) for path in (Path(source), *more) if path.suffix in (".py", ".toml")),
        "set_up": ready - begun,
        "one": alone - ready,
        "thousand": (done - alone) * RUNS / given.runs,
        "runs": given.runs,
    }
    print(json.dumps(facts))
    if given.out:
        np.savez(given.out, final=canonical(final), facts=json.dumps(facts))


def canonical(final: Array) -> Array:
    """Return states with q0 >= 0."""
    result = np.array(final)
    result[:, 6:10] *= np.where(result[:, 6:7] < 0, -1.0, 1.0)
    return result


def lines(path: Path) -> int:
    """Count the lines of code of a program, without comments, docstrings and the call that measures it."""
    if path.suffix == ".toml":
        return sum(bool(line.strip()) and line[0] != "#" for line in path.read_text(encoding="utf-8").splitlines())
    text = path.read_text(encoding="utf-8").partition('if __name__ == "__main__"')[0]
    held: set[int] = set()
    start = True
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type in (tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT):
            start = start or token.type == tokenize.NEWLINE
            continue
        if token.type == tokenize.STRING and start:
            continue
        start = False
        held.update(range(token.start[0], token.end[0] + 1))
    return len(held)


def _spent() -> float:
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + children.ru_utime + children.ru_stime
