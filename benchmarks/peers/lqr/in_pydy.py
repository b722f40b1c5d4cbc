# SPDX-License-Identifier: Apache-2.0
"""PyDy: bodies and points in sympy.physics.mechanics, Kane's equations, a right-hand side through Cython, SciPy."""

from __future__ import annotations

import numpy as np
import sympy as sp
import task
from pydy.codegen.ode_function_generators import generate_ode_function
from scipy.integrate import solve_ivp
from sympy.physics import mechanics as me


def equations():
    """Return Kane's method, its coordinates and speeds, and the symbols of force and moment.

    A bob's arm is turned by alpha about z and beta about y, which are singular 90 degrees from hanging.
    """
    inertial, body, o = me.ReferenceFrame("N"), me.ReferenceFrame("B"), me.Point("O")
    q, v, w = me.dynamicsymbols("q0:4"), me.dynamicsymbols("v0:3"), me.dynamicsymbols("w0:3")
    body.orient(inertial, "Quaternion", q)
    omega = sum((a * b for a, b in zip(w, body, strict=True)), me.Vector(0))
    body.set_ang_vel(inertial, omega)
    o.set_vel(inertial, sum((a * b for a, b in zip(v, body, strict=True)), me.Vector(0)))
    turns = [-sum(a * b for a, b in zip(q[1:], w, strict=True)) / 2]
    turns += list((q[0] * sp.Matrix(w) + sp.Matrix(q[1:]).cross(sp.Matrix(w))) / 2)
    mass, centre, inertia = task.hull()
    middle = o.locatenew("C", float(centre[0]) * body.x)
    middle.v2pt_theory(o, inertial, body)
    tensor = me.inertia(body, *(float(x) for x in np.diag(inertia)))
    bodies = [me.RigidBody("hull", middle, body, mass, (tensor, middle))]
    push, couple = sp.symbols("f0:3"), sp.symbols("c0:3")
    loads = [(o, sum((a * b for a, b in zip(push, body, strict=True)), me.Vector(0)))]
    loads += [(body, sum((a * b for a, b in zip(couple, body, strict=True)), me.Vector(0)))]
    kinematic = [a.diff() - b for a, b in zip(q, turns, strict=True)]
    coordinates, speeds = list(q), [*v, *w]
    bobs = [sp.symbols(f"m{k} l{k} h{k} eps{k}") for k in (1, 2)]
    for k, (m, length, pivot, eps) in enumerate(bobs):
        alpha, beta, a, b = me.dynamicsymbols(f"alpha{k} beta{k} a{k} b{k}")
        arm = sp.Matrix([-sp.cos(alpha) * sp.cos(beta), -sp.sin(alpha) * sp.cos(beta), sp.sin(beta)])
        rate = arm.diff(alpha) * a + arm.diff(beta) * b
        bob = o.locatenew(f"bob{k}", me.Vector([(sp.Matrix([pivot, 0, 0]) + length * arm, body)]))
        slip = me.Vector([(length * rate, body)])
        bob.set_vel(inertial, o.vel(inertial) + omega.cross(bob.pos_from(o)) + slip)
        drag = -eps / length**2 * slip
        loads += [(bob, drag), (middle, -drag), (body, -bob.pos_from(middle).cross(drag))]
        bodies.append(me.Particle(f"b{k}", bob, m))
        coordinates += [alpha, beta]
        speeds += [a, b]
        kinematic += [alpha.diff() - a, beta.diff() - b]
    kane = me.KanesMethod(inertial, coordinates, speeds, kinematic)
    kane.kanes_equations(bodies, loads)
    return kane, coordinates, speeds, [*push, *couple], [*bobs[0], *bobs[1]]


def to_angles(x):
    """Return (q, alpha1, ..., V, Omega, a1, ...) of a state of the task at rest."""
    arms = x[10:].reshape(2, 2, 3)[:, 0]
    angles = [(np.arctan2(-s[1], -s[0]), np.arcsin(s[2])) for s in arms]
    return np.concatenate([x[6:10], *angles, x[:6], np.zeros(4)])


def to_state(y):
    """Return the state of the task."""
    bobs = []
    for (alpha, beta), (a, b) in zip(y[4:8].reshape(2, 2), y[14:].reshape(2, 2), strict=True):
        ca, sa, cb, sb = np.cos(alpha), np.sin(alpha), np.cos(beta), np.sin(beta)
        arm = np.array([-ca * cb, -sa * cb, sb])
        slip = a * np.array([sa * cb, -ca * cb, 0]) + b * np.array([ca * sb, sa * sb, cb])
        bobs += [arm, slip + np.cross(y[11:14], arm)]
    return np.concatenate([y[8:14], y[:4], *bobs])


def make(tolerance):
    kane, coordinates, speeds, inputs, constants = equations()
    known = np.ravel(task.BOBS)
    right = generate_ode_function(
        kane.forcing_full, coordinates, speeds, constants, mass_matrix=kane.mass_matrix_full, specifieds=inputs,
        generator="cython", constants_arg_type="array", specifieds_arg_type="array",
    )  # fmt: skip

    def one(x):
        y = to_angles(x)
        for _ in range(task.SAMPLES):
            u = np.concatenate(task.wrench(task.law(to_state(y))))
            options = {"args": (u,), "rtol": tolerance, "atol": tolerance}
            y = solve_ivp(lambda t, z, r: right(z, t, r, known), (0, task.PERIOD), y, "DOP853", **options).y[:, -1]
        return to_state(y)

    return lambda starts: np.array([one(x) for x in task.initial(starts)])


if __name__ == "__main__":
    task.measure(make, 20)
