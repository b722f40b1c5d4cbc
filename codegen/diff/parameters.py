# SPDX-License-Identifier: Apache-2.0
"""Names, units, bounds, sources and numbers that differ between two documents and their manifests."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from mehvar.manifest import Manifest

from ..equations.document import Document, Symbol
from .report import ParameterChange

_QUIET = frozenset(("rate", "shown", "time", "argument"))
"""Roles of names that only stand in equations; their change shows there."""
_OWN = ("scenario ", "metric ")
"""Roles whose rows have no symbol that would tell when one comes or goes."""
_LATEST = '"bears_loss"'
"""The youngest field of a law: a manifest without it does not say what it is for."""


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


def _value_changes(old: Manifest | None, new: Manifest | None, renamed: Mapping[str, str]) -> Iterator[ParameterChange]:
    before, after = dict(_numbers(old)), dict(_numbers(new))
    if old is not None and new is not None and all(_LATEST in manifest.text for manifest in (old, new)):
        before, after = before | dict(_loops(old)), after | dict(_loops(new))
    for (role, name), value in after.items():
        origin = before.pop((role, renamed.get(name, name)), None)
        if origin is None and role.startswith(_OWN):
            yield ParameterChange(name, role, "added", "", value)
        elif origin is not None and origin != value:
            yield ParameterChange(name, role, "value", origin, value)
    for (role, name), value in before.items():
        if role.startswith(_OWN):
            yield ParameterChange(name, role, "removed", value, "")


def _numbers(manifest: Manifest | None) -> Iterator[tuple[tuple[str, str], str]]:
    if manifest is None:
        return
    groups = {"parameter": manifest.parameters, "scenario": manifest.scenario_parameters}
    groups |= {f"law {name}": law.parameters for name, law in manifest.controllers.items()}
    for role, rows in groups.items():
        for row in rows:
            yield (role, row.name), str(row.default if row.formula is None else row.formula)
    for name, scenario in manifest.scenarios.items():
        role = f"scenario {name}"
        yield (role, "duration"), str(scenario.duration)
        yield (role, "step"), str(scenario.step)
        for key, value in scenario.values.items():
            yield (role, key), str(value)
        for law, values in scenario.controllers.items():
            for key, value in values.items():
                yield (role, f"{law}.{key}"), str(value)
        for law, values in scenario.expect.items():
            for key, value in values.items():
                yield (role, f"{law}.{key} expected"), str(value)
    for metric in manifest.metrics.values():
        for what in ("kind", "of", "band", "since", "until"):
            yield (f"metric {metric.name}", what), str(getattr(metric, what))


def _loops(manifest: Manifest) -> Iterator[tuple[tuple[str, str], str]]:
    """Yield what of a law decides how its loop runs."""
    for name, law in manifest.controllers.items():
        for what in ("period", "delay", "bears_loss"):
            yield (f"law {name}", what), str(getattr(law, what))
