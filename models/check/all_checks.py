# SPDX-License-Identifier: Apache-2.0
"""Check of a whole system before generation."""

from __future__ import annotations

from pathlib import Path

from ..forms import with_samples
from ..system import System
from .dimensions import check_dimensions
from .entries import check_entries
from .features import check_features, check_sensor
from .kinds import check_kinds
from .metrics import check_metrics
from .names import check_names
from .scenarios import check_scenarios
from .vectors import vectors


def check(system: System, folder: Path | None = None) -> None:
    """Refuse a system with contradictory parts.

    Each vector has one expression per quantity of its group, in allowed symbols and in the quantity's unit. Names are
    unique, every declaration has an effect, and scenarios and metrics refer to existing quantities.

    Parameters
    ----------
    system : System
        As derived, before code generation.
    folder : Path, optional
        Folder of the model; errors in scenarios and metrics then name the line of its table.

    Raises
    ------
    ModelError
        With file and line, vector, row and symbol, and the allowed values.
    """
    check_kinds(system)
    check_features(system)
    listing = vectors(system)
    check_names(with_samples(system))
    check_entries(system, listing)
    check_scenarios(system, listing, folder)
    check_dimensions(system, listing)
    check_sensor(system)
    check_metrics(system, folder)
