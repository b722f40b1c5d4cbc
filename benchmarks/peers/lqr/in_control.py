# SPDX-License-Identifier: Apache-2.0
"""python-control: equations by hand in NumPy, an nlsys, one response per sample."""

from __future__ import annotations

import control
import numpy as np
import task

MASS, CENTRE, INERTIA = task.hull()
ABOUT = INERTIA + MASS * (CENTRE @ CENTRE * np.eye(3) - np.outer(CENTRE, CENTRE))
HAT = MASS * np.cross(np.eye(3), CENTRE)
HULL = np.block([[MASS * np.eye(3), -HAT], [HAT, ABOUT]])


def cross(a, b):
    """Return a x b; np.cross takes ten times as long for three numbers."""
    (x, y, z), (u, v, w) = a, b
    return np.array([y * w - z * v, z * u - x * w, x * v - y * u])


def rates(t, x, u, params):
    """Return the rates of the states at force and moment u."""
    v, w, q = x[:3], x[3:6], x[6:10]
    a = HULL.copy()
    b = u - np.concatenate([MASS * cross(w, cross(w, CENTRE)), cross(w, ABOUT @ w)])
    bobs = []
    for (m, length, pivot, eps), (arm, turning) in zip(task.BOBS, x[10:].reshape(2, 2, 3), strict=True):
        slip = turning - cross(w, arm)
        r = np.array([pivot, 0, 0]) + length * arm
        rest = cross(w, cross(w, r)) + 2 * length * cross(w, slip)
        drag = eps / length * slip
        row = np.concatenate([arm, cross(r, arm)])
        onto = drag - m * (arm @ rest - length * slip @ slip) * arm
        a += m * np.outer(row, row)
        b += np.concatenate([onto, cross(r, onto)])
        bobs.append((m, length, arm, slip, r, rest + drag / m))
    linear, angular = np.split(np.linalg.solve(a, b), 2)
    dx = [linear - cross(w, v), angular, [-q[1:] @ w / 2], (q[0] * w + cross(q[1:], w)) / 2]
    for _, length, arm, slip, r, rest in bobs:
        push = linear + cross(angular, r) + rest
        bend = -(push - arm * (arm @ push)) / length - slip @ slip * arm
        dx += [slip, bend + cross(angular, arm) + cross(w, slip)]
    return np.concatenate(dx)


def make(tolerance):
    craft = control.nlsys(rates, inputs=6, states=22)
    options = {"solve_ivp_method": "DOP853", "solve_ivp_kwargs": {"rtol": tolerance, "atol": tolerance}}

    def one(x):
        for k in range(task.SAMPLES):
            u = np.concatenate(task.wrench(task.law(x)))
            times = np.array([k, k + 1]) * task.PERIOD
            response = control.input_output_response(craft, times, np.tile(u[:, None], 2), x, **options)
            x = response.states[:, -1]
        return x

    return lambda starts: np.array([one(x) for x in task.initial(starts)])


if __name__ == "__main__":
    task.measure(make, 10)
