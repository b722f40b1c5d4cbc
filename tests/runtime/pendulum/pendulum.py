# SPDX-License-Identifier: Apache-2.0
"""The functions of pendulum.c in NumPy, in the form of a generated module."""

import numpy as np

HASH = "0000000000000000000000000000000000000000000000000000000000000000"
STATES = ("angle", "rate")
INPUTS = ("torque",)
REFERENCES = ("angle_ref",)
OUTPUTS = ("energy", "angle_error", "power")
PARAMETERS = ("m", "l", "g", "b", "wall", "k_wall", "cube", "rate_max", "torque_max", "Ts")
SCENARIO_PARAMETERS = ("angle_0", "rate_0", "angle_ref", "ref_rate")
COORDINATES = ("double_angle", "rate")
PD_PARAMETERS = ("k_p", "k_d")
P_SUM_PARAMETERS = ("k_p", "k_i")
P_SUM_MEMORY = ("sum",)
SIZES = {
    "rhs": {"x": 2, "u": 1, "p": 10, "dx": 2},
    "outputs": {"x": 2, "u": 1, "r": 1, "p": 10, "y": 3},
    "limits": {"x": 2, "u": 1, "p": 10, "margin": 2},
    "to_coordinates": {"x": 2, "q": 2},
    "from_coordinates": {"q": 2, "x": 2},
    "initial": {"p": 10, "s": 4, "x": 2},
    "reference": {"t": None, "p": 10, "s": 4, "r": 1},
    "constraints": {"p": 10, "s": 4, "margin": 1},
    "pd": {"x": 2, "r": 1, "p": 10, "c": 2, "u": 1},
    "pd_loop": {"q": 2, "r": 1, "p": 10, "c": 2, "dq": 2},
    "pd_observe": {"q": 2, "r": 1, "p": 10, "c": 2, "x": 2, "u": 1},
    "pd_defaults": {"c": 2, "derived": 1},
    "pd_constraints": {"p": 10, "c": 2, "s": 4, "margin": 1},
    "p-sum": {"x": 2, "r": 1, "v": 1, "z": 1, "p": 10, "c": 2, "u": 1, "z_next": 1},
    "p_sum_start": {"x": 2, "r": 1, "p": 10, "c": 2, "z": 1},
    "swing": {"l": None, "g": None, "period": None, "omega": None},
    "jac_x": {"x": 2, "u": 1, "p": 10, "J": 4},
    "jac_u": {"x": 2, "u": 1, "p": 10, "J": 2},
    "outputs_jac": {"x": 2, "u": 1, "r": 1, "p": 10, "J_x": 6, "J_u": 3, "J_r": 3},
    "pd_jvp": {"x": 2, "r": 1, "p": 10, "c": 2, "along_x": 2, "along_r": 1, "change": 1},
    "p_sum_jvp": {
        "x": 2,
        "r": 1,
        "v": 1,
        "z": 1,
        "p": 10,
        "c": 2,
        "along_x": 2,
        "along_r": 1,
        "along_v": 1,
        "along_z": 1,
        "change_u": 1,
        "change_z_next": 1,
    },
}


def _vector(*elements):
    return np.stack(np.broadcast_arrays(*elements), axis=-1)


def rhs(x, u, p):
    m, arm, g, b, wall, k_wall, cube, *_ = np.moveaxis(p, -1, 0)
    torque = u[..., 0] - b * x[..., 1] - m * g * arm * np.sin(x[..., 0])
    extra = k_wall * np.sqrt(wall - x[..., 0]) + cube * x[..., 0] * x[..., 0] * x[..., 0]
    return _vector(x[..., 1], torque / (m * arm * arm) + extra)


def outputs(x, u, r, p):
    m, arm, g = p[..., 0], p[..., 1], p[..., 2]
    energy = 0.5 * m * arm * arm * x[..., 1] * x[..., 1] + m * g * arm * (1.0 - np.cos(x[..., 0]))
    return _vector(energy, x[..., 0] - r[..., 0], u[..., 0] * x[..., 1])


def limits(x, u, p):
    return _vector(p[..., 7] - np.abs(x[..., 1]), p[..., 8] - np.abs(u[..., 0]))


def to_coordinates(x):
    return _vector(2.0 * x[..., 0], x[..., 1])


def from_coordinates(q):
    return _vector(0.5 * q[..., 0], q[..., 1])


def initial(p, s):
    return _vector(s[..., 0], s[..., 1])


def reference(t, p, s):
    return _vector(s[..., 2] + s[..., 3] * t)


def constraints(p, s):
    return _vector(np.pi - np.abs(s[..., 0]))


def pd(x, r, p, c):
    return _vector(-c[..., 0] * (x[..., 0] - r[..., 0]) - c[..., 1] * x[..., 1])


def pd_observe(q, r, p, c):
    x = from_coordinates(q)
    return x, pd(x, r, p, c)


def pd_loop(q, r, p, c):
    x, u = pd_observe(q, r, p, c)
    dx = rhs(x, u, p)
    return _vector(2.0 * dx[..., 0], dx[..., 1])


def pd_defaults(c):
    return _vector(2.0 * np.sqrt(c[..., 0]))


def pd_constraints(p, c, s):
    return _vector(c[..., 0] - p[..., 0] * p[..., 2] * p[..., 1])


def p_sum_start(x, r, p, c):
    return _vector(0.25 + 0.0 * x[..., 0])


def p_sum(x, r, v, z, p, c):
    error = x[..., 0] - r[..., 0]
    return _vector(-c[..., 0] * error - c[..., 1] * z[..., 0]), _vector(z[..., 0] + error)


def swing(arm, g):
    omega = np.sqrt(g / arm)
    return 6.283185307179586 / omega, omega


def jac_x(x, u, p):
    m, arm, g, b, wall, k_wall, cube, *_ = np.moveaxis(p, -1, 0)
    angle = x[..., 0]
    stiffness = 3.0 * cube * angle * angle - g / arm * np.cos(angle) - 0.5 * k_wall / np.sqrt(wall - angle)
    J = _vector(0.0, 1.0, stiffness, -b / (m * arm * arm))
    return J.reshape(*J.shape[:-1], 2, 2)


def jac_u(x, u, p):
    J = _vector(0.0, 1.0 / (p[..., 0] * p[..., 1] * p[..., 1]) + 0.0 * x[..., 0])
    return J.reshape(*J.shape[:-1], 2, 1)


def outputs_jac(x, u, r, p):
    m, arm, g = p[..., 0], p[..., 1], p[..., 2]
    J_x = _vector(m * g * arm * np.sin(x[..., 0]), m * arm * arm * x[..., 1], 1.0, 0.0, 0.0, u[..., 0])
    J_u, J_r = _vector(0.0, 0.0, x[..., 1]), _vector(0.0, -1.0, 0.0 * x[..., 0])
    return tuple(J.reshape(*J.shape[:-1], 3, -1) for J in (J_x, J_u, J_r))


def pd_jvp(x, r, p, c, along_x, along_r):
    return _vector(-c[..., 0] * (along_x[..., 0] - along_r[..., 0]) - c[..., 1] * along_x[..., 1])


def p_sum_jvp(x, r, v, z, p, c, along_x, along_r, along_v, along_z):
    error = along_x[..., 0] - along_r[..., 0]
    return _vector(-c[..., 0] * error - c[..., 1] * along_z[..., 0]), _vector(along_z[..., 0] + error)
