# SPDX-License-Identifier: Apache-2.0
"""Physics of the satellite with wheels."""

from __future__ import annotations

import numpy as np

from mehvar.physics.gates import Gate, Symmetry, balance, dot, identity, measures, never_rises, symmetric
from mehvar.physics.machine import Array, Machine, Points
from tests.mehvar.physics import rotations


def gates_of(subject: Machine) -> list[Gate]:
    """Return the gates of a chart."""
    quaternion = subject.system.structure["chart"] == "quaternion"
    read = shown if quaternion else np.asarray
    found = [
        identity("energy of body and wheels", _energy, _energy_of_parts),
        identity("momentum of body and wheels", lambda at: at.call("momentum"), _momentum_of_parts),
        balance("angular momentum", lambda at: at.call("momentum"), _external),
        balance("energy", _energy, _power),
        balance("Jacobi integral", _jacobi, _relative_power),
        balance("momentum of wheels", _wheels, lambda at: -at["wheels"][:, None] * _wheel_torque(at)),
        never_rises("energy without inputs", _energy, lambda at: _idle(at).moved(wheels=1.0, omega0=0.0)),
        balance("place on the orbit", lambda at: at["latitude"], lambda at: at["omega0"]),
        identity("locked wheels", lambda at: _spinning(_locked(at)), _rigid_rates),
        identity("rest in orbit axes", lambda at: _resting(at).call("rhs")[:, :-1], _nothing),
        *_outputs(quaternion),
        identity("initial state", lambda at: at.call("initial"), _initial),
        identity("square wave", lambda at: at.call("reference"), square_wave),
        identity("Sun and satellite further on", lambda at: _no_field(at).call("rhs"), _further_on),
        symmetric(_OPPOSITE_NODE),
        symmetric(_half_turn(quaternion)),
        identity("order of axes", lambda at: _spinning(_free(at)), _relabelled),
        measures(lambda at: read(at.values["x"]), read, unrounded),
    ]
    if quaternion:
        found.append(
            balance(
                "unit quaternion", lambda at: dot(attitude(at), attitude(at)), lambda at: np.zeros(len(attitude(at)))
            )
        )
        found.append(symmetric(Symmetry("quaternion of either sign", frozenset({"q0", "q1", "q2", "q3"}))))
    return found


def unit_quaternion() -> Gate:
    """Return the gate of the quaternion's length."""
    return balance(
        "unit quaternion", lambda at: dot(attitude(at), attitude(at)), lambda at: np.zeros(len(attitude(at)))
    )


def unrounded(at: Points) -> Points:
    """Return the points with a star tracker that does not round."""
    return at.moved(quantum=0.0)


def shown(x: Array) -> Array:
    """Return vectors that begin with a quaternion as products of its elements, which do not depend on its sign."""
    q = x[:, :4]
    return np.hstack([np.einsum("ni,nj->nij", q, q).reshape(-1, 16), x[:, 4:]])


_OPPOSITE_NODE = Symmetry(
    "opposite node", frozenset({"inclination"}), shifts={"latitude": np.pi, "sun_latitude": np.pi}
)
_FLIPPED = frozenset(f"{name}{axis}" for name in ("w", "h", "T", "dipole_", "arm_") for axis in "yz")


def _half_turn(quaternion: bool) -> Symmetry:
    """Return the half turn of the body about its x axis, a symmetry of the inertia."""
    if quaternion:
        swaps = {"q0": "q1", "q1": "q0", "q2": "q3", "q3": "q2"}
        return Symmetry("half turn of the body", _FLIPPED | {"q0", "q3"}, swaps)
    return Symmetry("half turn of the body", _FLIPPED, shifts={"roll": np.pi})


def _outputs(quaternion: bool) -> list[Gate]:
    axes = ("roll", "pitch", "yaw")
    expected = {
        "reference": (tuple(f"ref_{a}" for a in axes), lambda at: at.vector(*(f"ref_{a}" for a in axes))),
        "errors": (
            tuple(f"{a}_error" for a in axes),
            lambda at: angles(at) - at.vector(*(f"ref_{a}" for a in axes)),
        ),
        "relative rate": (names("rate_"), relative_rate),
        "wheel speed": (names("wheel_"), _speed),
        "environment": (names("Tenv_"), environment),
    }
    if quaternion:
        expected["angles"] = (axes, angles)
    return [
        identity(f"outputs: {title}", lambda at, names=names: at.result("outputs", *names), reading)
        for title, (names, reading) in expected.items()
    ]


def names(stem: str, labels: str = "xyz") -> tuple[str, ...]:
    """Return names with a common beginning."""
    return tuple(f"{stem}{label}" for label in labels)


def _energy(at: Points) -> Array:
    return at.call("energy")[:, 0]


def _jacobi(at: Points) -> Array:
    """Return the energy in axes that turn with the orbit, about -y."""
    return _energy(at) + at["omega0"] * at.call("momentum")[:, 1]


def _energy_of_parts(at: Points) -> Array:
    """Return the energy of rotation of body and wheels, and the potential of the gravity gradient."""
    nadir = rotation(at)[:, :, 2]
    body = dot(at.vector("I_x", "I_y", "I_z") * rate(at), rate(at))
    wheels = dot(_wheels(at), _absolute_speed(at))
    return (body + wheels + 3 * at["omega0"] ** 2 * dot(nadir, _total_inertia(at) * nadir)) / 2


def _momentum_of_parts(at: Points) -> Array:
    own = at.vector("I_x", "I_y", "I_z") * rate(at) + _wheels(at)
    return rotations.back(rotations.about(1, -at["latitude"]), rotations.back(rotation(at), own))


def _initial(at: Points) -> Array:
    """Return rest in the orbit axes at the scenario's angles."""
    a = np.deg2rad(at.vector("roll_0_deg", "pitch_0_deg", "yaw_0_deg"))
    turning = -at["omega0"][:, None] * rotations.of_angles(a)[:, :, 1]
    placed = rotations.quaternion(a) if at.machine.system.structure["chart"] == "quaternion" else a
    return np.hstack([placed, turning, at.vector("hx_0", "hy_0", "hz_0", "latitude_0")])


def square_wave(at: Points) -> Array:
    """Return the reference."""
    side = np.where(np.floor(at["t"] / at["half_period"]) % 2 == 0, 1.0, -1.0)
    steps = np.deg2rad(at.vector("roll_step_deg", "pitch_step_deg", "yaw_step_deg"))
    return side[:, None] * steps


def _power(at: Points) -> Array:
    """Return the power of all torques: torques on the body, and on wheels that turn relative to it."""
    outside = dot(rate(at), environment(at)) + dot(orbit_rate(at), _gradient(at))
    return outside + dot(_wheel_torque(at), rate(at) - at["wheels"][:, None] * _absolute_speed(at))


def _relative_power(at: Points) -> Array:
    share = at["wheels"][:, None]
    between = relative_rate(at) + share * (orbit_rate(at) - _absolute_speed(at))
    return dot(relative_rate(at), environment(at)) + dot(_wheel_torque(at), between)


def _external(at: Points) -> Array:
    """Return the torque on body and wheels together, in inertial axes."""
    total = _gradient(at) + environment(at) + (1 - at["wheels"][:, None]) * _wheel_torque(at)
    return rotations.back(rotations.about(1, -at["latitude"]), rotations.back(rotation(at), total))


def _gradient(at: Points) -> Array:
    nadir = rotation(at)[:, :, 2]
    return 3 * at["omega0"][:, None] ** 2 * np.cross(nadir, _total_inertia(at) * nadir)


def _total_inertia(at: Points) -> Array:
    return at.vector("I_x", "I_y", "I_z") + at.vector(*names("Iw_"))


def _rigid_rates(at: Points) -> Array:
    """Return w' and h' of one rigid body with locked wheels, by Euler's equations."""
    inertia, w = _total_inertia(at), rate(at)
    acceleration = (_gradient(at) + environment(at) - np.cross(w, inertia * w)) / inertia
    return np.hstack([acceleration, at.vector(*names("Iw_")) * acceleration])


def _locked(at: Points) -> Points:
    """Return the points with wheels that motors lock to the body."""
    holding = -_rigid_rates(at)[:, 3:]
    speeds = at.vector(*names("Iw_")) * rate(at)
    values = {f"h{i}": speeds[:, k] for k, i in enumerate("xyz")} | {
        f"T{i}": holding[:, k] for k, i in enumerate("xyz")
    }
    return at.moved(wheels=1.0, **values)


def environment(at: Points) -> Array:
    """Return the torques of the Earth's dipole field, of air and of sunlight."""
    nu, tilt, zero = at["latitude"], at["inclination"], np.zeros_like(at["latitude"])
    field = np.column_stack([np.cos(nu) * np.sin(tilt), -np.cos(tilt), 2 * np.sin(nu) * np.sin(tilt)])
    field *= (at["field_moment"] / at["orbit_radius"] ** 3)[:, None]
    ahead, up = at["sun_latitude"] - nu, at["sun_elevation"]
    sun = np.column_stack([np.cos(up) * np.sin(ahead), -np.sin(up), -np.cos(up) * np.cos(ahead)])
    light = -(at["solar_pressure"] * (1 + at["reflectance"]) * at["area"])[:, None] * sun
    speed = at["omega0"] * at["orbit_radius"]
    drag = -at["air_density"] * speed**2 * at["drag_coefficient"] * at["area"] / 2
    push = rotations.apply(rotation(at), light + np.column_stack([drag, zero, zero]))
    magnetic = np.cross(at.vector(*names("dipole_")), rotations.apply(rotation(at), field))
    return magnetic + np.cross(at.vector(*names("arm_")), push)


def _wheel_torque(at: Points) -> Array:
    return at.vector(*names("T")) + (at["wheels"] * at["wheel_friction"])[:, None] * _speed(at)


def _speed(at: Points) -> Array:
    return _absolute_speed(at) - rate(at)


def _absolute_speed(at: Points) -> Array:
    return _wheels(at) / at.vector(*names("Iw_"))


def orbit_rate(at: Points) -> Array:
    """Return the rate of the orbit axes in body axes."""
    return -at["omega0"][:, None] * rotation(at)[:, :, 1]


def relative_rate(at: Points) -> Array:
    """Return the rate relative to the orbit axes."""
    return rate(at) - orbit_rate(at)


def rotation(at: Points) -> Array:
    """Return the matrices from orbit to body axes."""
    if at.machine.system.structure["chart"] == "quaternion":
        return rotations.of_quaternion(attitude(at))
    return rotations.of_angles(at.vector("roll", "pitch", "yaw"))


def angles(at: Points) -> Array:
    """Return roll, pitch and yaw."""
    C = rotation(at)
    roll, yaw = np.arctan2(C[:, 1, 2], C[:, 2, 2]), np.arctan2(C[:, 0, 1], C[:, 0, 0])
    return np.column_stack([roll, -np.arcsin(C[:, 0, 2]), yaw])


def attitude(at: Points) -> Array:
    """Return the quaternion."""
    return at.vector("q0", "q1", "q2", "q3")


def rate(at: Points) -> Array:
    """Return the inertial rate."""
    return at.vector(*names("w"))


def _wheels(at: Points) -> Array:
    return at.vector(*names("h"))


def _no_field(at: Points) -> Points:
    return at.moved(field_moment=0.0)


def _idle(at: Points) -> Points:
    """Return the points without torque of motors and environment."""
    still = dict.fromkeys((*names("T"), "field_moment", "solar_pressure", "air_density"), 0.0)
    return at.moved(**still)


def _free(at: Points) -> Points:
    return at.moved(omega0=0.0, field_moment=0.0, solar_pressure=0.0)


def _resting(at: Points) -> Points:
    """Return the points at rest in the orbit axes, wheels too."""
    level = {"q0": 1.0, "q1": 0.0, "q2": 0.0, "q3": 0.0}
    if at.machine.system.structure["chart"] == "euler":
        level = {"roll": 0.0, "pitch": 0.0, "yaw": 0.0}
    w, h = -at["omega0"], -at["omega0"] * at["Iw_y"]
    return _idle(at).moved(**level, wx=0.0, wy=w, wz=0.0, hx=0.0, hy=h, hz=0.0)


def _nothing(at: Points) -> Array:
    return np.zeros((len(at["omega0"]), at.values["x"].shape[1] - 1))


def _further_on(at: Points) -> Array:
    moved = _no_field(at).moved(latitude=at["latitude"] + 0.7, sun_latitude=at["sun_latitude"] + 0.7)
    return moved.call("rhs")


def _spinning(at: Points) -> Array:
    return at.result("rhs", *names("w"), *names("h"))


def _relabelled(at: Points) -> Array:
    """Return the rates with axes x, y, z renamed to y, z, x."""
    following = {"x": "y", "y": "z", "z": "x"}
    moved = _free(at).moved(
        **{f"{n}{new}": at[f"{n}{old}"] for n in ("w", "h", "T", "I_", "Iw_") for old, new in following.items()}
    )
    found = [f"{n}{following[axis]}" for n in ("w", "h") for axis in "xyz"]
    return moved.result("rhs", *found)
