# SPDX-License-Identifier: Apache-2.0
"""The Earth's field of a craft on an orbit against ppigrf, with all coefficients of its table."""

from __future__ import annotations

from datetime import datetime
from importlib.metadata import version

import numpy as np
import ppigrf

import mehvar
from mehvar.parts import Hub, Magnetometer, Orbit, Spacecraft
from tests.validation.table import record

DATE = datetime(2020, 1, 1)


def test_field_of_the_earth() -> None:
    g, h = (table.loc[DATE] for table in ppigrf.ppigrf.read_shc(ppigrf.ppigrf.shc_fn))
    rows = tuple((n, m, float(g[n, m]), float(h[n, m]) if m else 0.0) for n, m in g.index)
    craft = Spacecraft("igrf", orbit=Orbit(harmonics=rows))
    craft.add(Hub("hub", mass=1.0, inertia=(1.0, 1.0, 1.0)))
    craft.add(Magnetometer("mag"))
    model, random, errors = mehvar.build(craft), np.random.default_rng(1), []
    for _ in range(100):
        radius, theta, phi = random.uniform(6.6e6, 8e6), random.uniform(0.1, 3.0), random.uniform(-3, 3)
        up = np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])
        south = np.array([np.cos(theta) * np.cos(phi), np.cos(theta) * np.sin(phi), -np.sin(theta)])
        east = np.array([-np.sin(phi), np.cos(phi), 0.0])
        parts = ppigrf.igrf_gc(radius / 1e3, np.degrees(theta), np.degrees(phi), DATE)
        theirs = sum(float(np.ravel(b)[0]) * e for b, e in zip(parts, (up, south, east), strict=True))
        state = model.state(q0=1.0, **dict(zip(("orbit_x", "orbit_y", "orbit_z"), radius * up, strict=True)))
        errors.append(1e9 * model.functions["measure"](state, [], model.parameters())[:3] - theirs)
    record(
        "parts: magnetic field of the Earth to degree 13, 200 to 1600 km", "ppigrf", version("ppigrf"), errors, 1e-9,
        "nT", "rounding of sums of 195 terms of up to 3e4 nT",
    )  # fmt: skip
