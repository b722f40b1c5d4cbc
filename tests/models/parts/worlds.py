# SPDX-License-Identifier: Apache-2.0
"""Assemblies of hinges, sliders, ball joints and chains in MuJoCo, which shares no equation with the parts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import mujoco
import numpy as np

from mehvar.models.parts import Bob, Chain, Hinge, Hub, Link, Part, Slider

Numbers = Mapping[str, float]
_TYPES = {"hinge": "hinge", "slider": "slide", "ball": "ball"}


def words(values: Sequence[float]) -> str:
    return " ".join(f"{value:.17g}" for value in values)


def inertial(mass: float, centre: Sequence[float], inertia: Sequence) -> str:
    rows = np.array(inertia, dtype=float)
    rows = np.diag(rows) if rows.ndim == 1 else rows
    full = words((*np.diag(rows), rows[0, 1], rows[0, 2], rows[1, 2]))
    return f'<inertial mass="{mass:.17g}" pos="{words(centre)}" fullinertia="{full}"/>'


def links_of(part: Part) -> list[tuple[str, Link]]:
    """Return a hinge, a slider or a chain as links, with the prefixes of their states' names."""
    if isinstance(part, Chain):
        return [(f"{part.name}_{k}", link) for k, link in enumerate(part.links, 1)]
    assert isinstance(part, Hinge | Slider)
    joint = "hinge" if isinstance(part, Hinge) else "slider"
    given = {name: getattr(part, name) for name in ("mass", "inertia", "axis", "at", "centre", "stiffness", "damping")}
    return [(part.name, Link(joint=joint, motor=part.motor, **given))]


def body(part: Part) -> str:
    if isinstance(part, Bob):  # a point mass: MuJoCo takes no zero inertia, and what turns about the rod does not act
        joint, tiny = '<joint type="ball"/>', [1e-12] * 3
        return f'<body pos="{words(part.at)}">{joint}{inertial(part.mass, (-part.length, 0, 0), tiny)}</body>'
    text = ""
    for _, link in reversed(links_of(part)):
        axis = "" if link.axis is None else f'axis="{words(link.axis)}"'
        spring = f'stiffness="{link.stiffness or 0.0}" damping="{link.damping or 0.0}"'
        joint = f'<joint type="{_TYPES[link.joint]}" {axis} {spring}/>'
        own = inertial(link.mass, link.centre, link.inertia)
        text = f'<body pos="{words(link.at)}">{joint}{own}{text}</body>'
    return text


def engine(hub: Hub, parts: Sequence[Part]) -> mujoco.MjModel:
    text = "".join(body(part) for part in parts)
    base = f"<freejoint/>{inertial(hub.mass, hub.centre, hub.inertia)}"
    option = '<compiler boundmass="0" boundinertia="0"/><option gravity="0 0 0"/>'
    return mujoco.MjModel.from_xml_string(f"<mujoco>{option}<worldbody><body>{base}{text}</body></worldbody></mujoco>")


def rotation_of(quaternion: Sequence[float]) -> np.ndarray:
    matrix = np.empty(9)
    mujoco.mju_quat2Mat(matrix, np.array(quaternion))
    return matrix.reshape(3, 3)


def turned(e: np.ndarray, u: np.ndarray, w: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return quaternion and rate of a body, in its own axes, whose -x axis is e and turns with u."""
    basis = np.linalg.qr(np.column_stack([-e, np.eye(3)[np.argmin(np.abs(e))]]))[0]
    first, second = -e, basis[:, 1]
    matrix = np.column_stack([first, second, np.cross(first, second)])
    quaternion = np.empty(4)
    mujoco.mju_mat2Quat(quaternion, matrix.ravel())
    return quaternion, matrix.T @ (np.cross(e, u) - w)


def _joint(name: str, link: Link, x: Numbers) -> tuple[list[float], list[float]]:
    """Return position and velocity of a joint as MuJoCo has them: the rate of a ball in the axes of its body."""
    if link.joint == "ball":
        q = [x[f"{name}_q{k}"] for k in range(4)]
        return q, list(rotation_of(q).T @ [x[f"{name}{axis}"] for axis in "xyz"])
    place, speed = ("angle", "rate") if link.joint == "hinge" else ("place", "speed")
    return [x[f"{name}_{place}"]], [x[f"{name}_{speed}"]]


def accelerations(model: mujoco.MjModel, hub: Hub, parts: Sequence[Part], x: Numbers, u: Numbers) -> dict[str, float]:
    """Return the rates of the speeds, by the names of the assembly's states; of a bob none."""
    data = mujoco.MjData(model)
    pairs = (("v", x), ("w", x), ("push", u), ("turn", u))
    v, w, force, torque = (np.array([of[f"{n}{a}"] for a in "xyz"]) for n, of in pairs)
    quaternion = [x[f"q{k}"] for k in range(4)]
    rotation = rotation_of(quaternion)
    places, speeds, pushes = [0.0, 0.0, 0.0, *quaternion], [*(rotation @ v), *w], [0.0] * 6
    for part in parts:
        if isinstance(part, Bob):
            place, speed = turned(*(np.array([x[f"{part.name}_{n}{a}"] for a in "xyz"]) for n in "eu"), w)
            places, speeds, pushes = [*places, *place], [*speeds, *speed], [*pushes, 0.0, 0.0, 0.0]
            continue
        for name, link in links_of(part):
            place, speed = _joint(name, link, x)
            motor = [value for n, value in u.items() if n.startswith(f"{name}_")] or [0.0] * len(speed)
            places, speeds, pushes = [*places, *place], [*speeds, *speed], [*pushes, *motor]
    data.qpos[:], data.qvel[:], data.qfrc_applied[:] = places, speeds, pushes
    mujoco.mj_forward(model, data)
    com = rotation @ np.array(hub.centre)
    data.xfrc_applied[1, :3] = rotation @ force
    data.xfrc_applied[1, 3:] = rotation @ torque - np.cross(com, rotation @ force)
    mujoco.mj_forward(model, data)
    result = {f"v{a}": value for a, value in zip("xyz", rotation.T @ data.qacc[:3] - np.cross(w, v), strict=True)}
    result |= {f"w{a}": value for a, value in zip("xyz", data.qacc[3:6], strict=True)}
    at = 6
    for part in parts:
        if isinstance(part, Bob):
            at += 3
            continue
        for name, link in links_of(part):
            if link.joint == "ball":
                turn = rotation_of([x[f"{name}_q{k}"] for k in range(4)])
                own = turn @ data.qacc[at : at + 3]
                result |= {f"{name}{a}": value for a, value in zip("xyz", own, strict=True)}
                at += 3
                continue
            result[f"{name}_{'rate' if link.joint == 'hinge' else 'speed'}"] = data.qacc[at]
            at += 1
    return result
