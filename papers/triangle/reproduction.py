# SPDX-License-Identifier: Apache-2.0
"""The paper on the planar three-mass triangle: its words, and the functions that draw and check."""

from __future__ import annotations

from pathlib import Path

from mehvar.reproduction import read_reproduction

from .claims import CHECKS
from .picture import disturbed_runs, path_run, picture, sliding_run
from .readings import READINGS
from .shapes import polar_plane, schematic, shape_grid, shifted_origin
from .surfaces import cylinder, limited_arc, nested_surfaces, xi_curve

REPRODUCTION = read_reproduction(
    Path(__file__).parent,
    draw={
        1: schematic,
        2: shape_grid,
        3: polar_plane,
        4: shifted_origin,
        5: nested_surfaces,
        6: cylinder,
        7: xi_curve,
        8: limited_arc,
        9: sliding_run,
        10: path_run,
        11: disturbed_runs,
    },
    checks=CHECKS,
    readings=READINGS,
    picture=picture,
)
