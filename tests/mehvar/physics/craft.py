# SPDX-License-Identifier: Apache-2.0
"""Physics of the satellite beyond the paper: any inertia, wheels, orbit and torquers, in a quaternion.

All is written in inertial axes from places and velocities, where the model has orbit axes and angles.
"""

from __future__ import annotations

import numpy as np

from mehvar.physics.gates import Gate, PointFunction, Symmetry, balance, dot, identity, measures, symmetric
from mehvar.physics.machine import Array, Machine, Points
from tests.mehvar.physics import rotations
from tests.mehvar.physics.rotors import Rotors
from tests.mehvar.physics.satellite import shown, unrounded

AXES = ("roll", "pitch", "yaw")


def gates_of(subject: Machine) -> list[Gate]:
    """Return the gates of a set of wheels along any axes, balanced or not, on an ellipse."""
    return [
        identity("energy of body and wheels", lambda at: at.call("energy")[:, 0], _energy),
        identity("momentum of body and wheels", lambda at: at.call("momentum"), _momentum),
        balance("angular momentum", _momentum, lambda at: _inertial(at, _outside(at))),
        balance("work", _kinetic, _power),
        balance("attitude", lambda at: _body_axes(at).reshape(-1, 9), _turning),
        balance("unit quaternion", lambda at: dot(_q(at), _q(at)), lambda at: np.zeros(len(_q(at)))),
        balance("momentum of wheels", lambda at: _about_axes(at)[0], lambda at: _about_axes(at)[1] - _motor(at)),
        *([balance("angles of wheels", _turned, _speed)] if _unbalanced(subject) else []),
        balance("mean anomaly", _mean_anomaly, _mean_motion),
        balance("place on the ellipse", _place, _velocity, where=lambda at: at.moved(J2=0.0)),
        identity("drift of the ellipse", lambda at: at.result("rhs", "perigee", "node"), _drift),
        identity("shadow", lambda at: _around(at, _lit_outputs), lambda at: _around(at, _environment)),
        identity("bias that no time changes", lambda at: at.result("rhs", *_names("bias_"), "clock"), _still),
        *(
            identity(f"outputs: {title}", lambda at, names=names: at.result("outputs", *names), reading)
            for title, names, reading in _OUTPUTS
        ),
        identity("initial state", lambda at: at.call("initial"), _initial),
        identity("square wave", lambda at: at.call("reference"), _square_wave),
        symmetric(Symmetry("quaternion of either sign", frozenset({"q0", "q1", "q2", "q3"}))),
        measures(lambda at: shown(_measured(at)), shown, unrounded),
    ]


def _names(stem: str, labels: str = "xyz") -> tuple[str, ...]:
    return tuple(f"{stem}{label}" for label in labels)


def _q(at: Points) -> Array:
    return at.vector("q0", "q1", "q2", "q3")


def _w(at: Points) -> Array:
    return at.vector(*_names("w"))


def _h(at: Points) -> Array:
    return at.vector(*_names("h", "1234"))


def _wheel_axes(at: Points) -> Array:
    """Return the unit axes, shape (n, 3, wheels)."""
    names = [[f"wheel_axes_{i}_{k}" for k in "1234"] for i in "123"]
    columns = np.stack([at.vector(*row) for row in names], axis=1)
    return columns / np.linalg.norm(columns, axis=1, keepdims=True)


def _spin_inertia(at: Points) -> Array:
    return at.vector(*_names("wheel_inertia_", "1234"))


def _inertia(at: Points) -> Array:
    """Return J, shape (n, 3, 3)."""
    return np.stack([at.vector(*(f"I_{min(i, j)}_{max(i, j)}" for j in (1, 2, 3))) for i in (1, 2, 3)], axis=1)


def _total(at: Points) -> Array:
    axes = _wheel_axes(at)
    return _inertia(at) + np.einsum("nik,nk,njk->nij", axes, _spin_inertia(at), axes)


def _orbit_axes(at: Points) -> Array:
    """Return the matrices from inertial to orbit axes, from place and velocity."""
    place, ahead = _place(at), _velocity(at)
    down = -place / np.linalg.norm(place, axis=1, keepdims=True)
    normal = np.cross(place, ahead)
    side = -normal / np.linalg.norm(normal, axis=1, keepdims=True)
    return np.stack([np.cross(side, down), side, down], axis=1)


def _body_axes(at: Points) -> Array:
    """Return the matrices from inertial to body axes."""
    return rotations.of_quaternion(_q(at)) @ _orbit_axes(at)


def _inertial(at: Points, vector: Array) -> Array:
    return rotations.back(_body_axes(at), vector)


def _frame(at: Points) -> Array:
    """Return the matrices from axes along perigee, motion there and normal to inertial ones."""
    to = rotations.about(2, at["perigee"]) @ rotations.about(0, at["inclination"]) @ rotations.about(2, at["node"])
    return np.swapaxes(to, 1, 2)


def _latus_rectum(at: Points) -> Array:
    return at["semi_major_axis"] * (1 - at["eccentricity"] ** 2)


def _place(at: Points) -> Array:
    radius = _latus_rectum(at) / (1 + at["eccentricity"] * np.cos(at["anomaly"]))
    zero = np.zeros_like(radius)
    return rotations.apply(
        _frame(at), np.column_stack([radius * np.cos(at["anomaly"]), radius * np.sin(at["anomaly"]), zero])
    )


def _velocity(at: Points) -> Array:
    scale, zero = np.sqrt(at["mu"] / _latus_rectum(at)), np.zeros_like(at["mu"])
    parts = [-scale * np.sin(at["anomaly"]), scale * (at["eccentricity"] + np.cos(at["anomaly"])), zero]
    return rotations.apply(_frame(at), np.column_stack(parts))


def _mean_motion_alone(at: Points) -> Array:
    return np.sqrt(at["mu"] / at["semi_major_axis"] ** 3)


def _oblate(at: Points) -> Array:
    return at["J2"] * (at["earth_radius"] / _latus_rectum(at)) ** 2 * _mean_motion_alone(at)


def _mean_anomaly(at: Points) -> Array:
    e = at["eccentricity"]
    eccentric = 2 * np.arctan(np.sqrt((1 - e) / (1 + e)) * np.tan(at["anomaly"] / 2))
    return eccentric - e * np.sin(eccentric)


def _mean_motion(at: Points) -> Array:
    """Return Kepler's third law and what oblateness adds (Kozai)."""
    root = np.sqrt(1 - at["eccentricity"] ** 2)
    return _mean_motion_alone(at) + 0.75 * _oblate(at) * root * (3 * np.cos(at["inclination"]) ** 2 - 1)


def _drift(at: Points) -> Array:
    cosine = np.cos(at["inclination"])
    return np.column_stack([0.75 * _oblate(at) * (5 * cosine**2 - 1), -1.5 * _oblate(at) * cosine])


def _turning(at: Points) -> Array:
    """Return C' = -[w x] C of body axes in inertial ones."""
    return -np.cross(_w(at)[:, None, :], np.swapaxes(_body_axes(at), 1, 2)).swapaxes(1, 2).reshape(-1, 9)


def _unbalanced(subject: Machine) -> bool:
    return subject.system.structure["wheels"] == "unbalanced"


def _rotors(at: Points) -> Rotors:
    return Rotors(at, _inertia(at), _wheel_axes(at), _spin_inertia(at), _speed(at))


def _about_axes(at: Points) -> tuple[Array, Array]:
    """Return the momenta that motors change, and by how much without them."""
    return _rotors(at).about_axes() if _unbalanced(at.machine) else (_h(at), np.zeros_like(_h(at)))


def _turned(at: Points) -> Array:
    return at.vector(*_names("angle", "1234"))


def _momentum(at: Points) -> Array:
    if _unbalanced(at.machine):
        return _inertial(at, _rotors(at).momentum())
    own = rotations.apply(_inertia(at), _w(at)) + rotations.apply(_wheel_axes(at), _h(at))
    return _inertial(at, own)


def _kinetic(at: Points) -> Array:
    if _unbalanced(at.machine):
        return _rotors(at).kinetic()
    return (dot(_w(at), rotations.apply(_inertia(at), _w(at))) + dot(_h(at), _h(at) / _spin_inertia(at))) / 2


def _power(at: Points) -> Array:
    on_wheels = rotations.back(_wheel_axes(at), _w(at)) - _h(at) / _spin_inertia(at)
    return dot(_outside(at), _w(at)) + dot(_motor(at), on_wheels)


def _energy(at: Points) -> Array:
    down = _down(at)
    return _kinetic(at) + 1.5 * _pull(at) * dot(down, rotations.apply(_total(at), down))


def _down(at: Points) -> Array:
    place = _place(at)
    return rotations.apply(_body_axes(at), -place / np.linalg.norm(place, axis=1, keepdims=True))


def _pull(at: Points) -> Array:
    return at["mu"] / np.linalg.norm(_place(at), axis=1) ** 3


def _outside(at: Points) -> Array:
    """Return the torques of gravity, environment and torquers."""
    down = _down(at)
    gradient = 3 * _pull(at)[:, None] * np.cross(down, rotations.apply(_total(at), down))
    return gradient + _environment(at) + np.cross(at.vector(*_names("coil_")), _field(at))


def _speed(at: Points) -> Array:
    return _h(at) / _spin_inertia(at) - rotations.back(_wheel_axes(at), _w(at))


def _motor(at: Points) -> Array:
    return at.vector(*_names("T", "1234")) + at["wheel_friction"][:, None] * _speed(at)


def _direction(ascension: Array, declination: Array) -> Array:
    across = np.cos(declination)
    return np.column_stack([across * np.cos(ascension), across * np.sin(ascension), np.sin(declination)])


def _field(at: Points) -> Array:
    """Return the field of a dipole that turns with the Earth, in body axes."""
    north = _direction(at["pole_longitude"] + at["earth_rate"] * at["clock"], np.pi / 2 - at["pole_tilt"])
    place = _place(at)
    radius = np.linalg.norm(place, axis=1)[:, None]
    away = place / radius
    field = at["field_moment"][:, None] / radius**3 * (north - 3 * dot(north, away)[:, None] * away)
    return rotations.apply(_body_axes(at), field)


def _measured(at: Points) -> Array:
    """Return the true readings of the instruments: the state with the gyro's bias, field and Sun in body axes."""
    sun = rotations.apply(_body_axes(at), _direction(at["sun_ascension"], at["sun_declination"]))
    truth = {f"w{i}": at[f"w{i}"] + at[f"bias_{i}"] for i in "xyz"}
    truth |= dict(zip(_names("mag_"), _field(at).T, strict=True))
    truth |= dict(zip(_names("sensed_"), _lit(at) * sun.T, strict=True))
    names = [q.name for q in at.machine.system.seen]
    return np.column_stack([truth[name] if name in truth else at[name] for name in names])


def _lit(at: Points) -> Array:
    """Return 1 outside the cylinder behind the Earth."""
    place, sun = _place(at), _direction(at["sun_ascension"], at["sun_declination"])
    along = dot(place, sun)
    off = np.linalg.norm(place - along[:, None] * sun, axis=1)
    return np.where((along < 0) & (off < at["earth_radius"]), 0.0, 1.0)


def _around(at: Points, reading: PointFunction) -> Array:
    """Return a reading at places around the orbit: some lie in shadow, some at its edge."""
    places = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    return np.hstack([reading(at.moved(anomaly=at["anomaly"] + place)) for place in places])


def _lit_outputs(at: Points) -> Array:
    return at.result("outputs", *_names("Tenv_"))


def _environment(at: Points) -> Array:
    sun = _direction(at["sun_ascension"], at["sun_declination"])
    light = -(at["solar_pressure"] * (1 + at["reflectance"]) * at["area"] * _lit(at))[:, None] * sun
    height = np.linalg.norm(_place(at), axis=1) - at["semi_major_axis"] * (1 - at["eccentricity"])
    density = at["air_density"] * np.exp(-height / at["scale_height"])
    velocity = _velocity(at)
    drag = (density * at["drag_coefficient"] * at["area"] / 2 * np.linalg.norm(velocity, axis=1))[:, None] * velocity
    push = rotations.apply(_body_axes(at), light - drag)
    return np.cross(at.vector(*_names("dipole_")), _field(at)) + np.cross(at.vector(*_names("arm_")), push)


def _orbit_rate(at: Points) -> Array:
    """Return the rate of the orbit axes in body axes: along the orbit in its plane, and the node about the pole."""
    place = _place(at)
    normal = _frame(at)[:, :, 2]
    share = _mean_motion(at) / _mean_motion_alone(at)
    around = np.sqrt(at["mu"] * _latus_rectum(at)) / dot(place, place) * share
    perigee, node = _drift(at).T
    pole = np.zeros_like(normal)
    pole[:, 2] = node
    return rotations.apply(_body_axes(at), (around + perigee)[:, None] * normal + pole)


def _relative_rate(at: Points) -> Array:
    return _w(at) - _orbit_rate(at)


def _angles(at: Points) -> Array:
    C = rotations.of_quaternion(_q(at))
    roll, yaw = np.arctan2(C[:, 1, 2], C[:, 2, 2]), np.arctan2(C[:, 0, 1], C[:, 0, 0])
    return np.column_stack([roll, -np.arcsin(C[:, 0, 2]), yaw])


def _references(at: Points) -> Array:
    return at.vector(*(f"ref_{axis}" for axis in AXES))


def _summary(at: Points) -> Array:
    """Return the angle of the rotation between body and wanted axes by its trace, and sizes of vectors."""
    between = rotations.of_quaternion(_q(at)) @ np.swapaxes(rotations.of_angles(_references(at)), 1, 2)
    held, motors = rotations.apply(_wheel_axes(at), _h(at)), at.vector(*_names("T", "1234"))
    return np.column_stack(
        [
            np.arccos((np.trace(between, axis1=1, axis2=2) - 1) / 2),
            np.linalg.norm(_relative_rate(at), axis=1),
            np.linalg.norm(held, axis=1),
            np.abs(_h(at)).max(axis=1),
            np.abs(motors).max(axis=1),
        ]
    )


_OUTPUTS = (
    ("reference", tuple(f"ref_{axis}" for axis in AXES), _references),
    ("errors", tuple(f"{axis}_error" for axis in AXES), lambda at: _angles(at) - _references(at)),
    ("relative rate", _names("rate_"), _relative_rate),
    ("wheel speed", _names("wheel_", "1234"), _speed),
    ("environment", _names("Tenv_"), _environment),
    ("angles", AXES, _angles),
    ("summary", ("pointing", "tumbling", "stored", "fullest", "strongest"), _summary),
)


def _initial(at: Points) -> Array:
    """Return rest in the orbit axes at the scenario's angles, and a tumble."""
    a = np.deg2rad(at.vector("roll_0_deg", "pitch_0_deg", "yaw_0_deg"))
    q = rotations.quaternion(a)
    there = at.moved(
        anomaly=at["anomaly_0"], perigee=at["perigee_0"], node=at["node_0"],
        **{f"q{k}": q[:, k] for k in range(4)},
    )  # fmt: skip
    rate = _orbit_rate(there) + at.vector(*_names("tumble_"))
    wheels = at.vector(*_names("wheel_momentum_0_", "1234"))
    if _unbalanced(at.machine):
        wheels = np.hstack([wheels, at.vector(*_names("wheel_angle_0_", "1234"))])
    orbit = at.vector("anomaly_0", "perigee_0", "node_0")
    bias = at.vector("bias_x_0", "bias_y_0", "bias_z_0")
    return np.hstack([q, rate, wheels, orbit, bias, np.zeros((len(q), 1))])


def _square_wave(at: Points) -> Array:
    side = np.where(np.floor(at["t"] / at["half_period"]) % 2 == 0, 1.0, -1.0)
    return side[:, None] * np.deg2rad(at.vector("roll_step_deg", "pitch_step_deg", "yaw_step_deg"))


def _still(at: Points) -> Array:
    return np.tile([0.0, 0.0, 0.0, 1.0], (len(at["clock"]), 1))
