# SPDX-License-Identifier: Apache-2.0
"""Check that the system contains every entry of the model's tables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from mehvar.base.errors import suggestion

from ..quantities import ModelError
from ..system import System
from ..tables import place_in, read_parameters, read_scenarios


def check_tables(system: System, folder: Path, choices: Mapping[str, Sequence[str]]) -> None:
    """Refuse entries of parameters.toml and scenarios.toml that the system lacks, such as an unused group.

    A group whose name is or begins with CHOICE_VALUE, such as [masses_general] or [masses_general_start], is checked
    in a structure with that value. All other groups are checked in the default structure.

    Parameters
    ----------
    system : System
        As derived, before code generation.
    folder : Path
        Folder of the model.
    choices : mapping of str to sequence of str
        Its structural choices and their values, the default first.

    Raises
    ------
    ModelError
        With the file and its unused entries.
    """
    groups = [system.parameters, system.scenario_parameters, *(law.parameters for law in system.controllers)]
    parameters, scenarios = folder / "parameters.toml", folder / "scenarios.toml"
    default = all(system.structure.get(choice, values[0]) == values[0] for choice, values in choices.items())
    theirs = {f"{choice}_{value}": (choice, value) for choice, values in choices.items() for value in values}
    if parameters.is_file():
        names = {q.name for group in groups for q in group}
        for group in read_parameters(parameters).values():
            choice, value = next((theirs[own] for own in theirs if f"{group.name}_".startswith(f"{own}_")), ("", ""))
            here = system.structure.get(choice, choices[choice][0]) == value if choice else default
            for name in (q.name for q in group if here and q.name not in names):
                where = f"{place_in(parameters, group.name, name)}: [{group.name}.{name}]"
                elsewhere = "; parameters of another structure need a group named CHOICE_VALUE" if choices else ""
                raise ModelError(
                    f"{where} would be ignored: the system has no {name!r}{suggestion(name, names)}{elsewhere}"
                )
    if default and scenarios.is_file():
        rows, metrics = read_scenarios(scenarios)
        for kind, written, read in (("scenarios", rows, system.scenarios), ("metrics", metrics, system.metrics)):
            names = {entry.name for entry in read}
            for entry in written:
                if entry.name not in names:
                    where = place_in(scenarios, kind, entry.name)
                    raise ModelError(f"{where}: [{kind}.{entry.name}] would be ignored: it is not in the system")
