# SPDX-License-Identifier: Apache-2.0
"""Structural choices of the satellite and their parameters in parameters.toml."""

from __future__ import annotations

from collections.abc import Mapping

from ..system import Group

STRUCTURE = {
    "chart": ("euler", "quaternion"),
    "inertia": ("principal", "full"),
    "wheels": ("axes", "any"),
}
"""Structural choices with their values; the first value is the default."""

_REPLACED = {
    "inertia_full": ("I_x", "I_y", "I_z"),
    "wheels_any": ("Iw_x", "Iw_y", "Iw_z", "wheels", "hx_0", "hy_0", "hz_0"),
}
"""Parameters of the paper's plant and scenario that a choice replaces."""


def beyond(choices: Mapping[str, str]) -> dict[str, str]:
    """Return the choices that differ from the paper's, except the chart, which only changes coordinates."""
    return {name: value for name, value in choices.items() if name != "chart" and value != STRUCTURE[name][0]}


def group(name: str, tables: Mapping[str, Group], table: str, choices: Mapping[str, str]) -> Group:
    """Return the paper's parameters of a table, extended and replaced according to the choices.

    Parameters
    ----------
    name : str
        Of the vector.
    tables : mapping of str to Group
        Groups of parameters.toml.
    table : str
        The table. The groups of a choice have the names CHOICE_VALUE for the plant, else CHOICE_VALUE_TABLE.
    choices : mapping of str to str
        Name and value of each choice.
    """
    taken = ["_".join(choice) for choice in beyond(choices).items()]
    replaced = {name for choice in taken for name in _REPLACED[choice]}
    suffix = "" if table == "plant" else f"_{table}"
    added = (tables[f"{choice}{suffix}"] for choice in taken if f"{choice}{suffix}" in tables)
    return Group(name, (*(q for q in tables[table] if q.name not in replaced), *(q for of in added for q in of)))
