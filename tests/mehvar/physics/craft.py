# SPDX-License-Identifier: Apache-2.0
"""Physics of the satellite with any inertia and wheels along any axes, in a quaternion."""

from __future__ import annotations

import numpy as np

from mehvar.physics.gates import Gate, Symmetry, balance, dot, identity, measures, symmetric
from mehvar.physics.machine import Array, Machine, Points
from tests.mehvar.physics import rotations
from tests.mehvar.physics.satellite import (
    angles,
    environment,
    names,
    orbit_rate,
    rate,
    relative_rate,
    rotation,
    shown,
    square_wave,
    unit_quaternion,
    unrounded,
)

AXES = ("roll", "pitch", "yaw")


def gates_of(_: Machine) -> list[Gate]:
    """Return the gates of a full inertia tensor with four wheels along any axes."""
    return [
        identity("energy of body and wheels", lambda at: at.call("energy")[:, 0], _energy),
        identity("momentum of body and wheels", lambda at: at.call("momentum"), _momentum),
        balance("angular momentum", _momentum, lambda at: _inertial(at, _outside(at))),
        balance("work", _kinetic, _power),
        balance("attitude", lambda at: _body_axes(at).reshape(-1, 9), _turning),
        unit_quaternion(),
        balance("momentum of wheels", _h, lambda at: -_motor(at)),
        balance("place on the orbit", lambda at: at["latitude"], lambda at: at["omega0"]),
        *(
            identity(f"outputs: {title}", lambda at, names=names: at.result("outputs", *names), reading)
            for title, names, reading in _OUTPUTS
        ),
        identity("initial state", lambda at: at.call("initial"), _initial),
        identity("square wave", lambda at: at.call("reference"), square_wave),
        symmetric(Symmetry("quaternion of either sign", frozenset({"q0", "q1", "q2", "q3"}))),
        measures(lambda at: shown(at.values["x"]), shown, unrounded),
    ]


def _h(at: Points) -> Array:
    return at.vector(*names("h", "1234"))


def _wheel_axes(at: Points) -> Array:
    """Return the unit axes, shape (n, 3, wheels)."""
    columns = np.stack([at.vector(*(f"wheel_axes_{i}_{k}" for k in "1234")) for i in "123"], axis=1)
    return columns / np.linalg.norm(columns, axis=1, keepdims=True)


def _spin_inertia(at: Points) -> Array:
    return at.vector(*names("wheel_inertia_", "1234"))


def _inertia(at: Points) -> Array:
    """Return J, shape (n, 3, 3)."""
    return np.stack([at.vector(*(f"I_{min(i, j)}_{max(i, j)}" for j in (1, 2, 3))) for i in (1, 2, 3)], axis=1)


def _total(at: Points) -> Array:
    axes = _wheel_axes(at)
    return _inertia(at) + np.einsum("nik,nk,njk->nij", axes, _spin_inertia(at), axes)


def _body_axes(at: Points) -> Array:
    """Return the matrices from inertial to body axes."""
    return rotation(at) @ rotations.about(1, -at["latitude"])


def _inertial(at: Points, vector: Array) -> Array:
    return rotations.back(_body_axes(at), vector)


def _turning(at: Points) -> Array:
    """Return C' = -[w x] C of body axes in inertial ones."""
    return -np.cross(rate(at)[:, None, :], np.swapaxes(_body_axes(at), 1, 2)).swapaxes(1, 2).reshape(-1, 9)


def _momentum(at: Points) -> Array:
    own = rotations.apply(_inertia(at), rate(at)) + rotations.apply(_wheel_axes(at), _h(at))
    return _inertial(at, own)


def _kinetic(at: Points) -> Array:
    return (dot(rate(at), rotations.apply(_inertia(at), rate(at))) + dot(_h(at), _h(at) / _spin_inertia(at))) / 2


def _power(at: Points) -> Array:
    on_wheels = rotations.back(_wheel_axes(at), rate(at)) - _h(at) / _spin_inertia(at)
    return dot(_outside(at), rate(at)) + dot(_motor(at), on_wheels)


def _energy(at: Points) -> Array:
    down = rotation(at)[:, :, 2]
    return _kinetic(at) + 1.5 * at["omega0"] ** 2 * dot(down, rotations.apply(_total(at), down))


def _outside(at: Points) -> Array:
    """Return the torques of gravity and environment."""
    down = rotation(at)[:, :, 2]
    gradient = 3 * at["omega0"][:, None] ** 2 * np.cross(down, rotations.apply(_total(at), down))
    return gradient + environment(at)


def _speed(at: Points) -> Array:
    return _h(at) / _spin_inertia(at) - rotations.back(_wheel_axes(at), rate(at))


def _motor(at: Points) -> Array:
    return at.vector(*names("T", "1234")) + at["wheel_friction"][:, None] * _speed(at)


def _references(at: Points) -> Array:
    return at.vector(*(f"ref_{axis}" for axis in AXES))


_OUTPUTS = (
    ("reference", tuple(f"ref_{axis}" for axis in AXES), _references),
    ("errors", tuple(f"{axis}_error" for axis in AXES), lambda at: angles(at) - _references(at)),
    ("relative rate", names("rate_"), relative_rate),
    ("wheel speed", names("wheel_", "1234"), _speed),
    ("environment", names("Tenv_"), environment),
    ("angles", AXES, angles),
)


def _initial(at: Points) -> Array:
    """Return rest in the orbit axes at the scenario's angles."""
    quaternion = rotations.quaternion(np.deg2rad(at.vector("roll_0_deg", "pitch_0_deg", "yaw_0_deg")))
    there = at.moved(**{f"q{k}": quaternion[:, k] for k in range(4)})
    wheels = at.vector(*names("wheel_momentum_0_", "1234"))
    return np.hstack([quaternion, orbit_rate(there), wheels, at.vector("latitude_0")])
