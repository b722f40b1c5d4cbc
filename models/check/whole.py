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

    Every vector has one expression for each quantity of its group, of symbols that it receives, in the quantity's unit;
    names are unique; what is declared has an effect; scenarios and metrics name existing quantities.

    Parameters
    ----------
    system : System
        As its text makes it.
    folder : Path, optional
        Of the model: what is wrong with a scenario or a metric is then placed in its table, if that has it.

    Raises
    ------
    ModelError
        Naming file and line, vector, row and symbol, and what would be right.
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
