# SPDX-License-Identifier: Apache-2.0
"""The paper on a spacecraft with sloshing fuel: its words, and the functions that draw and check."""

from __future__ import annotations

from pathlib import Path

from mehvar.reproduction import read_reproduction

from .claims import CHECKS
from .figures import attitude, gimbals, laws, moments, pendulums, thrust, velocities
from .picture import picture
from .readings import READINGS
from .rows import row_claims
from .schematic import craft, pendulums_drawn

REPRODUCTION = read_reproduction(
    Path(__file__).parent,
    draw={
        1: velocities,
        2: attitude,
        3: lambda runs: pendulums(runs, "phi", "varphi", (700.0, 700.0)),
        4: lambda runs: pendulums(runs, "theta", "theta", (700.0, 100.0)),
        5: moments,
        6: gimbals,
        7: lambda runs: laws(runs, "phi", "varphi"),
        8: lambda runs: laws(runs, "theta", "theta"),
        9: craft,
        10: pendulums_drawn,
        11: thrust,
    },
    checks=CHECKS,
    readings=READINGS,
    more_claims=row_claims,
    picture=picture,
)
