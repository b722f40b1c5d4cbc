# SPDX-License-Identifier: Apache-2.0
"""Accelerations of hinges, sliders and ball joints against MuJoCo, which shares no equation with the parts."""

import mujoco
import numpy as np
import pytest

from mehvar.models.parts import Bob, ExternalForce, Hinge, Hub, Slider, Spacecraft, Torquer

from .balances import Balances

FULL = ((10.0, 0.1, 0.2), (0.1, 12.0, 0.3), (0.2, 0.3, 15.0))
SMALL = ((1.0, 0.1, 0.2), (0.1, 1.5, 0.05), (0.2, 0.05, 2.0))
HUB = Hub("hub", mass=30.0, inertia=FULL, centre=(0.01, 0.02, 0.1))
JOINT = {"axis": (0.3, 1.0, -0.4), "at": (0.1, 0.5, 0.2), "centre": (0.2, 0.7, 0.1)}
CASES = {
    "hinge": [Hinge("a", mass=5.0, inertia=SMALL, stiffness=3.0, damping=0.2, **JOINT)],
    "slider": [Slider("a", mass=5.0, inertia=SMALL, stiffness=3.0, damping=0.2, **JOINT)],
    "bob": [Bob("a", mass=5.0, length=0.4, at=(0.1, 0.5, 0.2))],
    "three": [
        Hinge("a", mass=5.0, inertia=SMALL, axis=(1, 0, 0), at=(0, 0.5, 0), centre=(0, 0.7, 0), stiffness=1.0),
        Hinge("b", mass=4.0, inertia=SMALL, axis=(1, 0, 0), at=(0, -0.5, 0), centre=(0, -0.7, 0), damping=0.1),
        Slider("c", mass=2.0, inertia=SMALL, axis=(0, 0, 1), at=(0.2, 0, 0)),
    ],
}


def words(values) -> str:
    return " ".join(f"{value:.17g}" for value in values)


def inertial(mass, centre, inertia) -> str:
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = inertia
    full = words((xx, yy, zz, xy, xz, yz))
    return f'<inertial mass="{mass:.17g}" pos="{words(centre)}" fullinertia="{full}"/>'


def body(part) -> str:
    if isinstance(part, Bob):  # a point mass: MuJoCo takes no zero inertia, and what turns about the rod does not act
        joint, tiny = '<joint type="ball"/>', np.diag([1e-12] * 3)
        return f'<body pos="{words(part.at)}">{joint}{inertial(part.mass, (-part.length, 0, 0), tiny)}</body>'
    kind = "hinge" if isinstance(part, Hinge) else "slide"
    spring = f'stiffness="{part.stiffness or 0.0}" damping="{part.damping or 0.0}"'
    joint = f'<joint type="{kind}" axis="{words(part.axis)}" {spring}/>'
    return f'<body pos="{words(part.at)}">{joint}{inertial(part.mass, part.centre, part.inertia)}</body>'


def engine(parts) -> mujoco.MjModel:
    text = "".join(body(part) for part in parts)
    hub = f"<freejoint/>{inertial(HUB.mass, HUB.centre, HUB.inertia)}"
    option = '<compiler boundmass="0" boundinertia="0"/><option gravity="0 0 0"/>'
    return mujoco.MjModel.from_xml_string(f"<mujoco>{option}<worldbody><body>{hub}{text}</body></worldbody></mujoco>")


def turned(e, u, w):
    """Return quaternion and rate of a body, in its own axes, whose -x axis is e and turns with u."""
    basis = np.linalg.qr(np.column_stack([-e, np.eye(3)[np.argmin(np.abs(e))]]))[0]
    first, second = -e, basis[:, 1]
    matrix = np.column_stack([first, second, np.cross(first, second)])
    quaternion = np.empty(4)
    mujoco.mju_mat2Quat(quaternion, matrix.ravel())
    return quaternion, matrix.T @ (np.cross(e, u) - w)


@pytest.mark.parametrize("case", CASES)
def test_accelerations_agree(case):
    craft = Spacecraft("craft")
    for part in (HUB, ExternalForce("push"), Torquer("turn"), *CASES[case]):
        craft.add(part)
    balances, rng = Balances(craft.system()), np.random.default_rng(3)
    names = balances.x_names
    model = engine(CASES[case])
    data = mujoco.MjData(model)
    for _ in range(5):
        x, u = balances.state(rng), rng.normal(size=6)
        at = dict(zip(names, x, strict=True))
        v, w = (np.array([at[f"{letter}{a}"] for a in "xyz"]) for letter in "vw")
        quaternion = np.array([at[f"q{k}"] for k in range(4)])
        rotation = np.empty(9)
        mujoco.mju_quat2Mat(rotation, quaternion)
        rotation = rotation.reshape(3, 3)
        places, speeds = [*np.zeros(3), *quaternion], [*(rotation @ v), *w]
        for part in CASES[case]:
            if isinstance(part, Bob):
                e, turning = (np.array([at[f"{part.name}_{letter}{a}"] for a in "xyz"]) for letter in "eu")
                place, speed = turned(e, turning, w)
                places, speeds = [*places, *place], [*speeds, *speed]
            else:
                (coordinate,) = part.coordinates()
                places, speeds = [*places, at[coordinate.place.name]], [*speeds, at[coordinate.speed.name]]
        data.qpos[:], data.qvel[:] = places, speeds
        data.xfrc_applied[1, :3], data.xfrc_applied[1, 3:] = 0.0, 0.0
        mujoco.mj_forward(model, data)
        force, torque = np.array(u[:3]), np.array(u[3:])
        com = rotation @ np.array(HUB.centre)
        data.xfrc_applied[1, :3] = rotation @ force
        data.xfrc_applied[1, 3:] = rotation @ torque - np.cross(com, rotation @ force)
        mujoco.mj_forward(model, data)
        dx = dict(zip(names, balances.rhs(x, u), strict=True))
        expected = {f"v{a}": value for a, value in zip("xyz", rotation.T @ data.qacc[:3] - np.cross(w, v), strict=True)}
        expected |= {f"w{a}": value for a, value in zip("xyz", data.qacc[3:6], strict=True)}
        for k, part in enumerate(p for p in CASES[case] if not isinstance(p, Bob)):
            expected[part.coordinates()[0].speed.name] = data.qacc[6 + k]
        size = max(1.0, *(abs(value) for value in expected.values()))
        worst = max(abs(dx[name] - value) for name, value in expected.items()) / size
        assert worst < 1e-9, (worst, expected, {n: dx[n] for n in expected})
