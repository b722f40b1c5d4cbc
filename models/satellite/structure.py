# SPDX-License-Identifier: Apache-2.0
"""Structural choices of the satellite and their parameters in parameters.toml."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from ..system import Group, Quantity

STRUCTURE = {
    "chart": ("euler", "quaternion"),
    "inertia": ("principal", "full"),
    "wheels": ("axes", "any", "unbalanced"),
    "orbit": ("circular", "keplerian"),
    "torquers": ("none", "three"),
    "sensors": ("states", "instruments"),
    "laws": ("paper", "more"),
}
"""Structural choices with their values; the first value is the default."""

_BEFORE = {("wheels", "unbalanced"): "any"}
"""For some values of a choice, another value whose parameters they share or replace."""

_REPLACED = {
    ("inertia", "full"): ("I_x", "I_y", "I_z"),
    ("wheels", "any"): ("Iw_x", "Iw_y", "Iw_z", "wheels", "hx_0", "hy_0", "hz_0"),
    ("orbit", "keplerian"): ("omega0", "orbit_radius", "sun_latitude", "sun_elevation", "latitude_0"),
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
    table : {"plant", "scenario"}
        The table. The groups of a choice have the names CHOICE_VALUE and CHOICE_VALUE_scenario.
    choices : mapping of str to str
        Name and value of each choice.
    """
    replaced = {replaced for choice in _taken(choices) for replaced in _REPLACED.get(choice, ())}
    kept = (q for q in tables[table].quantities if q.name not in replaced)
    suffix = "" if table == "plant" else f"_{table}"
    return Group(name, (*kept, *added(tables, choices, suffix)))


def added(tables: Mapping[str, Group], choices: Mapping[str, str], suffix: str) -> tuple[Quantity, ...]:
    """Return the parameters of the groups CHOICE_VALUE with a suffix, where such groups exist."""
    names = (f"{choice}_{value}{suffix}" for choice, value in _taken(choices))
    return tuple({q.name: q for name in names if name in tables for q in tables[name].quantities}.values())


def _taken(choices: Mapping[str, str]) -> Iterator[tuple[str, str]]:
    """Yield the choices that differ from the paper's, each preceded by the value whose parameters it shares."""
    for name, value in beyond(choices).items():
        if (name, value) in _BEFORE:
            yield name, _BEFORE[name, value]
        yield name, value
