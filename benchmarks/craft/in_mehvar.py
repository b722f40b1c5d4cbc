# SPDX-License-Identifier: Apache-2.0
"""mehvar: the craft from parts; a batch, or single runs."""

from __future__ import annotations

import functools
import json
from collections.abc import Callable

import numpy as np
from scipy.spatial.transform import Rotation

import mehvar
from benchmarks.craft import task
from benchmarks.craft.task import Array, Fly
from mehvar.parts import Bob, Chain, ExternalForce, Hub, Link, Spacecraft, Wheel

INPUTS = {"pushx": task.FORCE, "pushy": 0.0, "pushz": 0.0} | {
    f"wheel{k}_torque": torque for k, torque in enumerate(task.TORQUES, 1)
}


def assembled() -> Spacecraft:
    """Return the craft."""
    mass, centre, inertia = task.composite(locked=False)
    craft = Spacecraft("craft16")
    craft.add(Hub("hub", mass=mass, centre=centre.tolist(), inertia=inertia.tolist()))
    for k, axis in enumerate(task.AXES, 1):
        craft.add(Wheel(f"wheel{k}", axis=axis.tolist(), inertia=task.SPIN))
    spring = {"axis": (1, 0, 0), "stiffness": task.STIFFNESS, "damping": task.DAMPING}
    for k, side in enumerate(task.SIDES, 1):
        body = spring | {"mass": task.BODY, "inertia": task.PLATE.tolist(), "centre": (0, side * task.LONG / 2, 0)}
        places = (side * task.EDGE, side * task.LONG)
        craft.add(Chain(f"panel{k}", [Link(**body, at=(0, place, 0)) for place in places]))
    craft.add(Bob("bob", mass=task.BOB, length=task.ROD, at=task.PIVOT.tolist(), rest=(-1, 0, 0)))
    craft.add(ExternalForce("push"))
    return craft


@functools.cache
def model() -> mehvar.Model:
    return mehvar.build(assembled())


def canonical(x: Array) -> Array:
    """Return the task's final states."""
    names = list(model().state_names)
    at = {name: x[:, k] for k, name in enumerate(names)}
    turn = Rotation.from_quat(np.stack([at[f"q{k}"] for k in range(4)], axis=-1), scalar_first=True).as_matrix()
    columns = ["wx", "wy", "wz", "vx", "vy", "vz"]
    columns += [f"panel{k}_{link}_{what}" for k in (1, 2) for what in ("angle", "rate") for link in (1, 2)]
    moving = np.stack([at[name] for name in [*columns, "bob_ex", "bob_ey", "bob_ez"]], axis=-1)
    speeds = np.stack([at[f"wheel{k}_speed"] for k in range(1, 5)], axis=-1) / task.SPEED
    return np.concatenate([turn.reshape(-1, 9), moving, speeds], axis=-1)


def batch(**options: object) -> Fly:
    """Return the batch of some starts."""

    def fly(starts: Array) -> Array:
        vary = {f"{name}_0": column for name, column in zip(task.STARTS, starts.T, strict=True)}
        given = {"inputs": INPUTS, "t_end": task.SPAN, "dt_out": task.SPAN, "threads": 1} | options
        return canonical(mehvar.batch(model(), None, vary=vary, **given)["final"].values)

    return fly


def single(**options: object) -> Fly:
    """Return single runs from Python, one after the other."""

    def fly(starts: Array) -> Array:
        given = {"inputs": INPUTS, "t_end": task.SPAN, "dt_out": task.SPAN} | options
        given = {name: value for name, value in given.items() if value is not None}
        final = []
        for start in starts:
            values = {f"{name}_0": value for name, value in zip(task.STARTS, start, strict=True)}
            run = mehvar.simulate(model(), None, **values, **given)
            final.append([float(run[name][-1]) for name in model().state_names])
        return canonical(np.array(final))

    return fly


def rhs() -> Callable[[], object]:
    """Return one call of the right-hand side from Python."""
    own = model()
    x, p = own.state(q0=1.0, bob_ex=-1.0), own.parameters()
    u = np.array([INPUTS[q.name] for q in own.manifest.inputs])
    return lambda: own.rhs(x, u, p)


def evaluations(setting: str, start: Array) -> int:
    """Return how often a run at a tolerance evaluates the right-hand side."""
    values = {f"{name}_0": value for name, value in zip(task.STARTS, start, strict=True)}
    options = {"inputs": INPUTS, "t_end": task.SPAN, "dt_out": task.SPAN, "rtol": float(setting)}
    run = mehvar.simulate(model(), None, **values, **options, atol=float(setting))
    return int(json.loads(run.attrs["statistics"])["evaluations"])
