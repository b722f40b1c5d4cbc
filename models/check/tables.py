# SPDX-License-Identifier: Apache-2.0
"""Whether everything that a model's tables say has come into its system."""

from __future__ import annotations

from pathlib import Path

from ..quantities import ModelError
from ..system import System
from ..tables import place_in, read_parameters, read_scenarios, suggestion


def check_tables(system: System, folder: Path) -> None:
    """Refuse what parameters.toml and scenarios.toml hold and the system has not, such as a group that nobody reads.

    Of a model without structural choices: with them a part of the tables is of another structure.

    Raises
    ------
    ModelError
        Naming the file and what in it is ignored.
    """
    groups = [system.parameters, system.scenario_parameters, *(law.parameters for law in system.controllers)]
    parameters, scenarios = folder / "parameters.toml", folder / "scenarios.toml"
    if parameters.is_file():
        names = {q.name for group in groups for q in group}
        for group in read_parameters(parameters).values():
            for name in (q.name for q in group if q.name not in names):
                where = f"{place_in(parameters, group.name, name)}: [{group.name}.{name}]"
                raise ModelError(f"{where} would be ignored: the system has no {name!r}{suggestion(name, names)}")
    if scenarios.is_file():
        rows, metrics = read_scenarios(scenarios)
        for kind, written, read in (("scenarios", rows, system.scenarios), ("metrics", metrics, system.metrics)):
            names = {entry.name for entry in read}
            for entry in written:
                if entry.name not in names:
                    where = place_in(scenarios, kind, entry.name)
                    raise ModelError(f"{where}: [{kind}.{entry.name}] would be ignored: it is not in the system")
