# SPDX-License-Identifier: Apache-2.0
"""heyoka: equations by hand, one rank-one update of a 6 x 6 system per bob, Taylor series in a batch of lanes."""

from __future__ import annotations

import heyoka as hy
import numpy as np
import task


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def dot(a, b):
    return hy.sum([x * y for x, y in zip(a, b, strict=True)])


def plus(*vectors):
    return [hy.sum(list(terms)) for terms in zip(*vectors, strict=True)]


def times(k, a):
    return [k * x for x in a]


def solved(a, b):
    """Solve a symmetric positive definite system by elimination."""
    n = len(b)
    for i in range(n):
        for j in range(i + 1, n):
            k = a[j][i] / a[i][i]
            a[j] = [a[j][c] - k * a[i][c] if c > i else hy.expression(0.0) for c in range(n)]
            b[j] = b[j] - k * b[i]
    x = [None] * n
    for i in reversed(range(n)):
        x[i] = (b[i] - dot(a[i][i + 1 :], x[i + 1 :])) / a[i][i] if i < n - 1 else b[i] / a[i][i]
    return x


def equations():
    """Return (state, rate) pairs; force and moment are parameters 0 to 5."""
    names = [
        hy.make_vars(*(f"{n}{i}" for i in range(k))) for n, k in (("v", 3), ("w", 3), ("q", 4), ("s", 6), ("e", 6))
    ]
    v, w, q, s, e = names
    force, moment = [hy.par[i] for i in range(3)], [hy.par[i] for i in range(3, 6)]
    mass, centre, inertia = task.hull()
    about = inertia + mass * (centre @ centre * np.eye(3) - np.outer(centre, centre))
    hat = mass * np.cross(np.eye(3), centre)
    a = [[hy.expression(float(x)) for x in row] for row in np.block([[mass * np.eye(3), -hat], [hat, about]])]
    momentum = [dot([hy.expression(float(x)) for x in row], w) for row in about]
    sweep = cross(w, cross(w, [hy.expression(float(x)) for x in centre]))
    b = [*plus(force, times(-mass, sweep)), *plus(moment, times(-1.0, cross(w, momentum)))]
    bobs = []
    for i, (m, length, pivot, eps) in enumerate(task.BOBS):
        arm, turning = s[3 * i : 3 * i + 3], e[3 * i : 3 * i + 3]
        slip = plus(turning, times(-1.0, cross(w, arm)))
        r = [pivot + length * arm[0], length * arm[1], length * arm[2]]
        rest = plus(cross(w, cross(w, r)), times(2 * length, cross(w, slip)))
        drag = times(eps / length, slip)
        row = [*arm, *cross(r, arm)]
        pull = m * (dot(arm, rest) - length * dot(slip, slip))
        onto = plus(drag, times(-pull, arm))
        for j in range(6):
            a[j] = [a[j][k] + m * row[j] * row[k] for k in range(6)]
        b = plus(b, [*onto, *cross(r, onto)])
        bobs.append((m, length, arm, slip, r, rest, drag))
    x = solved(a, b)
    linear, angular = x[:3], x[3:]
    half = times(0.5, w)
    turns = [-dot(q[1:], half), *plus(times(q[0], half), cross(q[1:], half))]
    slips, swings = [], []
    for m, length, arm, slip, r, rest, drag in bobs:
        push = plus(linear, cross(angular, r), rest, times(1 / m, drag))
        across = plus(push, times(-dot(arm, push), arm))
        bend = plus(times(-1 / length, across), times(-dot(slip, slip), arm))
        slips += slip
        swings += plus(bend, cross(angular, arm), cross(w, slip))
    rates = [*plus(linear, times(-1.0, cross(w, v))), *angular, *turns, *slips, *swings]
    return list(zip([*v, *w, *q, *s, *e], rates, strict=True))


ORDER = [*range(10), 10, 11, 12, 16, 17, 18, 13, 14, 15, 19, 20, 21]
"""Places of (V, Omega, q, s1, s2, sigma1, sigma2) in the states of the task."""


def make(tolerance):
    width = hy.recommended_simd_size()
    zeros = np.zeros((22, width))
    craft = hy.taylor_adaptive_batch(equations(), zeros, pars=np.zeros((6, width)), tol=tolerance, fast_math=True)

    def fly(starts):
        final = np.empty((len(starts), 22))
        for first in range(0, len(starts), width):
            x = task.initial(starts[first : first + width])
            n = len(x)
            craft.set_time(0.0)
            craft.state[:] = np.resize(x, (width, 22))[:, ORDER].T
            for k in range(task.SAMPLES):
                force, moment = task.wrench(task.law(craft.state.T))
                craft.pars[:] = np.concatenate([force, moment], axis=-1).T
                craft.propagate_until((k + 1) * task.PERIOD)
            final[first : first + n, ORDER] = craft.state.T[:n]
        return final

    return fly


if __name__ == "__main__":
    task.measure(make, task.RUNS)
