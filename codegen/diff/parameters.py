# SPDX-License-Identifier: Apache-2.0
"""Names, units, bounds, sources and numbers that differ between two documents and their manifests."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from ..equations.document import Document, Symbol
from .report import ParameterChange

_QUIET = frozenset(("rate", "shown", "time", "argument"))
"""Roles of names that only stand in equations; their change shows there."""


def parameter_changes(old: Document, new: Document, renamed: Mapping[str, str]) -> tuple[ParameterChange, ...]:
    """Compare names and numbers.

    Parameters
    ----------
    old, new : Document
        With the manifests beside them, if there are any.
    renamed : mapping
        Old names by new ones.
    """
    return tuple(
        dict.fromkeys((*_symbol_changes(old, new, renamed), *_value_changes(old.manifest, new.manifest, renamed)))
    )


def _symbol_changes(old: Document, new: Document, renamed: Mapping[str, str]) -> Iterator[ParameterChange]:
    before, after = (_by_role(document) for document in (old, new))
    for (role, name), symbol in after.items():
        origin = before.pop((role, renamed.get(name, name)), None)
        if origin is None:
            yield ParameterChange(name, role, "added", "", symbol.description)
            continue
        if name in renamed:
            yield ParameterChange(name, role, "renamed", origin.name, name)
        for what in ("unit", "bounds", "source", "sign"):
            if getattr(origin, what) != getattr(symbol, what):
                yield ParameterChange(name, role, what, getattr(origin, what), getattr(symbol, what))
    for (role, name), symbol in before.items():
        yield ParameterChange(name, role, "removed", symbol.description, "")


def _by_role(document: Document) -> dict[tuple[str, str], Symbol]:
    return {(symbol.role, symbol.name): symbol for symbol in document.symbols if symbol.role not in _QUIET}


def _value_changes(
    old: Mapping[str, Any], new: Mapping[str, Any], renamed: Mapping[str, str]
) -> Iterator[ParameterChange]:
    before, after = dict(_numbers(old)), dict(_numbers(new))
    for (role, name), value in after.items():
        origin = before.pop((role, renamed.get(name, name)), None)
        if origin is None and role.startswith("scenario "):
            yield ParameterChange(name, role, "added", "", value)
        elif origin is not None and origin != value:
            yield ParameterChange(name, role, "value", origin, value)
    for (role, name), value in before.items():
        if role.startswith("scenario "):
            yield ParameterChange(name, role, "removed", value, "")


def _numbers(manifest: Mapping[str, Any]) -> Iterator[tuple[tuple[str, str], str]]:
    groups = {"parameter": manifest.get("parameters", ()), "scenario": manifest.get("scenario_parameters", ())}
    groups |= {f"law {name}": law["parameters"] for name, law in manifest.get("controllers", {}).items()}
    for role, rows in groups.items():
        for row in rows:
            yield (role, row["name"]), str(row["formula"] if row.get("formula") is not None else row["default"])
    for name, scenario in manifest.get("scenarios", {}).items():
        role = f"scenario {name}"
        for key in ("duration", "step"):
            yield (role, key), str(scenario[key])
        for key, value in scenario["set"].items():
            yield (role, key), str(value)
        for law, values in scenario["controllers"].items():
            for key, value in values.items():
                yield (role, f"{law}.{key}"), str(value)
