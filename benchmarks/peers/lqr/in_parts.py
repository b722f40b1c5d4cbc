# SPDX-License-Identifier: Apache-2.0
"""mehvar, the craft assembled from parts: no equation is written."""

from __future__ import annotations

import numpy as np
import task

import mehvar
from mehvar.parts import Bob, ExternalForce, Hub, Spacecraft, Torquer

STARTS = ("vy", "vz", "roll", "pitch", "yaw", "bob1_phi", "bob1_theta", "bob2_phi", "bob2_theta")


def assembled():
    """Return the craft."""
    mass, centre, inertia = task.hull()
    craft = Spacecraft("craft")
    craft.add(Hub("hub", mass=mass, centre=centre, inertia=inertia))
    for k, (mass, length, pivot, damping) in enumerate(task.BOBS, 1):
        craft.add(Bob(f"bob{k}", mass=mass, length=length, at=(pivot, 0, 0), damping=damping))
    craft.add(ExternalForce("force"))
    craft.add(Torquer("torque"))
    return craft


def law(t, x):
    """Command force and torque for a column of states each."""
    return np.concatenate(task.wrench(task.law(np.asarray(x).T)), axis=-1).T


def make(tolerance):
    """Build, and return the batch of the first runs."""
    model = mehvar.build(assembled())
    options = {"rtol": tolerance, "atol": tolerance, "threads": 1, "t_end": task.SAMPLES * task.PERIOD, "vx_0": task.VX}

    def fly(starts):
        vary = {f"{name}_0": column for name, column in zip(STARTS, starts.T, strict=True)}
        return mehvar.batch(model, law, period=task.PERIOD, vary=vary, **options)["final"].values

    return fly


if __name__ == "__main__":
    task.measure(make, task.RUNS)
