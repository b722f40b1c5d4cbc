# SPDX-License-Identifier: Apache-2.0
"""Slosh against MuJoCo: all conventions of inertia, one to six pendulums, random and extreme states and parameters.

MuJoCo solves M a = f in double precision: its own bound is what the rounding of the parts of f makes of a.
"""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from tests.models.slosh import test_mujoco as worlds
from tests.models.slosh.variants import CONVENTIONS, Slosh, slosh
from tests.reference import reference_slosh as reference
from tests.validation.table import record

SAMPLES = 40
EPS = np.finfo(float).eps


def states(model: Slosh, extreme: bool) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Return samples; extreme ones turn ten times as fast, with masses and lengths from a tenth to ten times.

    Moments of inertia stay those of bodies: the hull's grow together, the fuel's shrink.
    """
    rng, result = np.random.default_rng(model.count), []
    for _ in range(SAMPLES):
        x, u, p = model.sample(rng)
        p[3:6] = model.p[3:6] * rng.uniform(0.6, 1.6)
        if extreme:
            x[3:6] *= 10
            own = model.index("s1x" if model.convention == "ball" else "phi1")
            if model.convention == "ball":
                x[own:] = np.ravel(x[own:].reshape(-1, 6) * [1, 1, 1, 10, 10, 10])
            else:
                x[own + 2 * model.count :] *= 10
            p = _extreme(p, rng)
        result.append((x, u, p))
    return result


def _extreme(p: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    scale = 10 ** rng.uniform(-1, 1, len(p))
    scale[3:6] = 10 ** rng.uniform(0, 1)
    scale[2] = 10 ** rng.uniform(-1, 0)
    scale[10:12] = 1
    scale[12:].reshape(-1, 5)[:, 3] = 10 ** rng.uniform(-1, 0, (len(p) - 12) // 5)
    return p * scale


def reduced(
    model: Slosh, x: np.ndarray, u: np.ndarray, p: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return MuJoCo's mass matrix, force, sizes of the terms of the force, and the order of the model."""
    craft, motion = reference.spacecraft(p), model.motion(x)
    if model.convention == "hinge":
        built = worlds.world(craft, "".join(worlds.hinged(b, b.inertia, b.eps) for b in craft.pendulums), craft.J)
        gears = np.eye(built.nv)
        order = np.ravel(np.arange(6, built.nv).reshape(-1, 2)[:, ::-1])
        velocity = np.concatenate([motion.V, motion.W, worlds.interleaved(motion, motion.qd)])
    else:
        built, gears = geared(craft)
        order = np.arange(6, gears.shape[1])
        velocity = gears @ np.concatenate([motion.V, motion.W, motion.qd.ravel()])
    data = mujoco.MjData(built)
    for k in range(model.count):
        at = 7 + (4 if model.convention == "paper" else 2) * k
        data.qpos[at : at + 2] = motion.q[k][::-1]
    data.qvel[:] = velocity
    mujoco.mj_forward(built, data)
    full = np.zeros((built.nv, built.nv))
    mujoco.mj_fullM(built, data, full)
    push = np.zeros(gears.shape[1])
    push[:6] = worlds.applied(craft, u, np.eye(3))
    damping = np.ravel([b.eps * rates for b, rates in zip(craft.pendulums, motion.qd, strict=True)])
    push[order] -= damping
    bias = gears.T @ data.qfrc_bias
    sizes = np.abs(push) + np.abs(gears.T) @ np.abs(data.qfrc_bias)
    return gears.T @ full @ gears, push - bias, sizes, np.concatenate([np.arange(6), order])


def geared(craft: reference.Spacecraft) -> tuple[mujoco.MjModel, np.ndarray]:
    """Return two discs a pendulum, geared to phi about x and to theta about z: the paper's terms of inertia."""
    k, total = worlds.K, sum(bob.inertia for bob in craft.pendulums)
    text = "".join(
        worlds.hinged(b, worlds.TINY, 0.0)
        + worlds.disc("1 0 0", (b.inertia, k * b.inertia, k * b.inertia))
        + worlds.disc("0 0 1", (k * b.inertia, k * b.inertia, b.inertia))
        for b in craft.pendulums
    )
    count = len(craft.pendulums)
    built = worlds.world(craft, text, craft.J + total * np.array([-k, 1 - 2 * k, -k]))
    gears = np.zeros((built.nv, 6 + 2 * count))
    gears[:6, :6] = np.eye(6)
    for i in range(count):
        row, column = 6 + 4 * i, 6 + 2 * i
        gears[row, column + 1] = gears[row + 1, column] = gears[row + 2, column] = gears[row + 3, column + 1] = 1
    return built, gears


def carried(model: Slosh, x: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Return the sizes of cancelling terms in MuJoCo's forces: centripetal terms and their arms."""
    craft, motion = reference.spacecraft(p), model.motion(x)
    mass = craft.m + craft.m0 + sum(bob.m for bob in craft.pendulums)
    arm = max(craft.b, abs(craft.h0), *(abs(bob.h) + bob.length for bob in craft.pendulums))
    rate = np.linalg.norm(motion.W) + np.abs(motion.qd).max()
    force = mass * rate * (np.linalg.norm(motion.V) + rate * arm)
    return force * np.array([1.0] * 3 + [arm] * (3 + 2 * model.count))


def rounding(matrix: np.ndarray, sizes: np.ndarray) -> float:
    """Return the error of MuJoCo's accelerations caused by rounding errors of its forces."""
    root = np.sqrt(np.diag(matrix))
    spread = np.linalg.norm(np.linalg.inv(matrix / np.outer(root, root)), 2)
    return float(len(sizes) * EPS * spread * np.linalg.norm(sizes / root) / root.min())


@pytest.mark.parametrize("extreme", [False, True], ids=["random", "extreme"])
@pytest.mark.parametrize("convention", ["paper", "hinge"])
@pytest.mark.parametrize("count", range(1, 7))
def test_accelerations_on_hinges(count: int, convention: str, extreme: bool) -> None:
    model, errors, bounds = slosh(str(count), convention), [], []
    for x, u, p in states(model, extreme):
        matrix, force, sizes, order = reduced(model, x, u, p)
        errors.append(model.accelerations(x, u, p) - np.linalg.solve(matrix, force)[order])
        bounds.append(rounding(matrix, sizes + carried(model, x, p)))
        if convention == "paper":
            weightless = worlds.TINY / min(bob.inertia for bob in reference.spacecraft(p).pendulums)
            bounds[-1] += 4 * count * weightless * np.abs(np.linalg.solve(matrix, force)).max()
    write(count, convention, extreme, errors, bounds)


@pytest.mark.parametrize("extreme", [False, True], ids=["random", "extreme"])
@pytest.mark.parametrize("count", range(1, 7))
def test_accelerations_on_ball_joints(count: int, extreme: bool) -> None:
    model, errors, bounds = slosh(str(count), "ball"), [], []
    for x, u, p in states(model, extreme):
        expected, bound = on_balls(model, x, u, p)
        errors.append(model.accelerations(x, u, p) - expected)
        bounds.append(bound)
    write(count, "ball", extreme, errors, bounds)


def on_balls(model: Slosh, x: np.ndarray, u: np.ndarray, p: np.ndarray) -> tuple[np.ndarray, float]:
    """Return accelerations on ball joints, and their error by rounding."""
    built, data, expected = worlds.on_balls(model, x, u, p)
    full = np.zeros((built.nv, built.nv))
    mujoco.mj_fullM(built, data, full)
    sizes = np.abs(data.qfrc_applied) + np.abs(data.qfrc_bias)
    pull = carried(model, x, p)
    return expected, rounding(full, sizes + np.concatenate([pull[:6], np.full(len(sizes) - 6, pull[-1])]))


def write(count: int, convention: str, extreme: bool, errors: list[np.ndarray], bounds: list[float]) -> None:
    kind = "extreme" if extreme else "random"
    record(
        f"slosh: accelerations, {count} pendulum{'s' if count > 1 else ''}, {convention}, {SAMPLES} {kind} points",
        "MuJoCo",
        mujoco.__version__,
        np.array(errors) / np.array(bounds)[:, None],
        1,
        "of the bound of each point",
        "rounding of MuJoCo's forces over the least eigenvalue of its mass matrix; paper: its discs weigh 1e-11 kg",
    )


assert set(CONVENTIONS) == {"paper", "hinge", "ball"}
