# SPDX-License-Identifier: Apache-2.0
"""The structural choices, and which parameters each takes from parameters.toml."""

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
"""Structural choices and their values; the first is the default."""

_BEFORE = {("wheels", "unbalanced"): "any"}
"""A value of a choice, which shares or replaces the parameters of another value."""

_REPLACED = {
    ("inertia", "full"): ("I_x", "I_y", "I_z"),
    ("wheels", "any"): ("Iw_x", "Iw_y", "Iw_z", "wheels", "hx_0", "hy_0", "hz_0"),
    ("orbit", "keplerian"): ("omega0", "orbit_radius", "sun_latitude", "sun_elevation", "latitude_0"),
}
"""Parameters of the paper's plant and scenario that a choice replaces."""


def beyond(choices: Mapping[str, str]) -> dict[str, str]:
    """Return the choices that differ from the paper's; the chart is one of coordinates, and none of these."""
    return {name: value for name, value in choices.items() if name != "chart" and value != STRUCTURE[name][0]}


def group(name: str, tables: Mapping[str, Group], table: str, choices: Mapping[str, str]) -> Group:
    """Return the paper's group without the replaced quantities, with those of the choices.

    Parameters
    ----------
    name : str
        Of the vector.
    tables : mapping of str to Group
        Groups of parameters.toml.
    table : {"plant", "scenario"}
        Which; those of a choice are called CHOICE_VALUE and CHOICE_VALUE_scenario.
    choices : mapping of str to str
        Name and value of each choice.
    """
    gone = {gone for choice in _taken(choices) for gone in _REPLACED.get(choice, ())}
    kept = (q for q in tables[table].quantities if q.name not in gone)
    suffix = "" if table == "plant" else f"_{table}"
    return Group(name, (*kept, *added(tables, choices, suffix)))


def added(tables: Mapping[str, Group], choices: Mapping[str, str], suffix: str) -> tuple[Quantity, ...]:
    """Return the contents of the groups CHOICE_VALUE with a suffix, where they exist."""
    names = (f"{choice}_{value}{suffix}" for choice, value in _taken(choices))
    return tuple({q.name: q for name in names if name in tables for q in tables[name].quantities}.values())


def _taken(choices: Mapping[str, str]) -> Iterator[tuple[str, str]]:
    """Yield the choices other than the paper's, each after the value that shares parameters with it."""
    for name, value in beyond(choices).items():
        if (name, value) in _BEFORE:
            yield name, _BEFORE[name, value]
        yield name, value
