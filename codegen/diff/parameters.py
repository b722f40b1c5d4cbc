# SPDX-License-Identifier: Apache-2.0
"""Differences in names, units, bounds, sources and numbers of two documents and manifests."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import MISSING, fields, replace
from typing import Any

from mehvar.base.manifest import (
    Choice,
    Controller,
    Event,
    Manifest,
    Metric,
    Output,
    Parameter,
    Quantity,
    Scenario,
    Shape,
)
from mehvar.base.schema import key_of

from ..equations import VECTORS
from ..equations.document import Document, Symbol
from .names import Renaming
from .report import ParameterChange

_QUIET = frozenset(("rate", "shown", "time", "argument"))
"""Roles of names that occur only in equations, which show their changes."""
EXEMPT = {
    "Manifest.schema": "of the file, not of the model",
    "Manifest.model": "the models that are compared have one name",
    "Manifest.title": "words",
    "Manifest.source": "words",
    "Manifest.structure": "compared as the structure of the equations",
    "Manifest.hash": "follows from everything else",
    "Manifest.parts": "told part by part, before the equations",
    "Manifest.functions": "follow from the equations; their operations are among the consequences",
    "Manifest.versions": "of libraries, not of the model",
    "Manifest.inputs_sha256": "of files, whose meaning is compared",
    "Manifest.files_sha256": "of files, whose meaning is compared",
    "Manifest.shapes_sha256": "of files, whose meaning is compared",
    "Manifest.digest": "of the file, not of the model",
    "Manifest.folder": "where it was read",
    "Manifest.text": "what was read",
    "Quantity.description": "words",
    "Output.description": "words",
    "Parameter.description": "words",
    "Parameter.readers": "follow from the equations",
    "Parameter.source": "compared with the symbols",
    "Choice.description": "words",
    "Controller.title": "words",
    "Scenario.title": "words",
    "Metric.description": "words",
    "Event.title": "words",
}
"""Fields of a manifest that are not compared as numbers, with the reason."""
_ROLES = VECTORS | {
    "parameters": "parameter", "scenario_parameters": "scenario", "controllers": "law", "choices": "choice",
    "scenarios": "scenario", "metrics": "metric", "geometry": "shape", "events": "event", "delays": "delay",
}  # fmt: skip
"""Reported names of manifest fields, equal to the roles of symbols."""
_OWN = {"parameters": "law", "memory": "memory", "outputs": "law output", "events": "law event"}
"""Reported names of a law's own quantities, equal to the roles of symbols."""
_WHAT = {"default": "value", "formula": "value"} | dict.fromkeys(
    ("lower", "upper", "lower_open", "upper_open"), "bounds"
)
"""Reported names of groups of parameter fields."""
_CONDITIONS = ("constraints", "limits")
"""Fields with conditions in words."""
_TIMES = {"duration": "s", "step": "s"}
"""Units of a scenario's own numbers."""
PARTS = "parts"
"""Name of the order of parts, which stands for the orders of vectors that follow from it."""
Place = tuple[str, str, str]
"""Role, name and field of a value."""


def parameter_changes(old: Document, new: Document, renaming: Renaming) -> tuple[ParameterChange, ...]:
    """Compare names and numbers of two documents and manifests.

    Parameters
    ----------
    old, new : Document
        With their manifests, if there are any; both with the new names.
    renaming : Renaming
        Names that the old version had; a renamed part stands for its quantities.
    """
    symbols = (*_symbol_changes(old, new, renaming), *_event_changes(old, new))
    known = {(change.role, change.name, change.what) for change in symbols}
    values = _value_changes(old.manifest, new.manifest)
    rows = " ".join(row.name for side in (old, new) for row in side.results if row.kind in ("constraint", "limit"))
    others = (
        change
        for change in values
        if (change.role, change.name, change.what) not in known
        and not (change.name in _CONDITIONS and (change.old or change.new) in rows)  # those are told as equations
    )
    return tuple(_by_array(_with_units((*symbols, *others), (old, new)), (old, new)))


def _with_units(changes: Iterable[ParameterChange], sides: Iterable[Document]) -> Iterator[ParameterChange]:
    """Yield the changes, with units of numbers."""
    symbols = [symbol for side in sides for symbol in side.symbols]
    units = {symbol.name: symbol.unit for symbol in symbols}
    own = {(symbol.role, symbol.name): symbol.unit for symbol in symbols}
    for change in changes:
        known = _TIMES if change.role.startswith("scenario ") and change.name in _TIMES else units
        if change.role == "delay":  # of an input, as the name of a parameter
            known = {}
        unit = own.get((change.role, change.name), known.get(change.name, "1"))
        yield replace(change, unit=unit) if change.what in ("value", "bounds") and unit != "1" else change


def _by_array(changes: Iterable[ParameterChange], sides: Iterable[Document]) -> Iterator[ParameterChange]:
    """Merge the changes of an array's elements."""
    arrays = {(s.role, s.name): s.array for side in sides for s in side.symbols if s.array}
    groups: dict[tuple[str, str, str], list[ParameterChange]] = {}
    for change in changes:
        whole = arrays.get((change.role, change.name), "")
        groups.setdefault((change.role, whole or change.name, change.what), []).append(change)
    for (_, name, _), members in groups.items():
        one = replace(members[0], name=name, old=_together(members, "old"), new=_together(members, "new"))
        yield one if len(members) > 1 else members[0]


def _together(members: Sequence[ParameterChange], side: str) -> str:
    """Return the values of elements on one side, with names unless all are equal or are names themselves."""
    texts = [getattr(change, side) for change in members]
    if len({*texts}) == 1:
        return str(texts[0])
    named = members[0].what == "renamed"
    return ", ".join(text if named else f"{change.name} = {text}" for change, text in zip(members, texts, strict=True))


def _symbol_changes(old: Document, new: Document, renaming: Renaming) -> Iterator[ParameterChange]:
    """Yield renamed, added and removed names, and differing units, bounds, sources and signs."""
    for role, names in (("law", renaming.laws), ("scenario", renaming.scenarios)):
        yield from (ParameterChange(name, role, "renamed", former, name) for former, name in names.items())
    renamed = {name: former for former, name in renaming.quantities.items()}
    before, after = (_by_role(document) for document in (old, new))
    for (role, name), symbol in after.items():
        origin = before.pop((role, name), None)
        if origin is None:
            yield ParameterChange(name, role, "added", "", symbol.description)
            continue
        if name in renamed:
            yield ParameterChange(name, role, "renamed", renamed[name], name)
        for what in ("unit", "bounds", "source", "sign"):
            if getattr(origin, what) != getattr(symbol, what):
                yield ParameterChange(name, role, what, getattr(origin, what), getattr(symbol, what))
    for (role, name), symbol in before.items():
        yield ParameterChange(name, role, "removed", symbol.description, "")


def event_of(guard: str) -> tuple[str, dict[str, str]]:
    """Return the event and law of a guard, and the properties that the guard's name encodes."""
    event, _, text = guard.rpartition(": ")
    direction, _, ends = text.partition(" ends ")
    return event, {"direction": direction, "ends": ends}


def _event_changes(old: Document, new: Document) -> Iterator[ParameterChange]:
    """Compare direction and effect of each event of both sides."""
    before, after = (dict(event_of(row.name) for row in side.results if row.kind == "guard") for side in (old, new))
    for name in [name for name in after if name in before]:
        law, _, event = name.rpartition(": ")
        for what, value in after[name].items():
            if value != before[name][what]:
                yield ParameterChange(event, f"law event {law}" if law else "event", what, before[name][what], value)


def _by_role(document: Document) -> dict[tuple[str, str], Symbol]:
    return {(symbol.role, symbol.name): symbol for symbol in document.symbols if symbol.role not in _QUIET}


def _value_changes(old: Manifest | None, new: Manifest | None) -> Iterator[ParameterChange]:
    """Compare all fields that both manifests have, except exempt ones."""
    if old is None or new is None:
        return
    skipped = _unsaid(old) | _unsaid(new) | EXEMPT.keys()
    before, after = (dict(_entries(manifest, skipped)) for manifest in (old, new))
    entries = [place for place in {**before, **after} if place[2] == "entry"]
    for place in [place for place in entries if (place in before) != (place in after)]:
        for side in (before, after):  # one change for the whole entry, not one for each of its fields
            for other in [other for other in side if other[0].endswith(f" {place[1]}")]:
                del side[other]
    yield from _sided(after, before, "added")
    yield from _sided(before, after, "removed")
    for (role, name, what), value in after.items():
        origin = before.get((role, name, what), value)
        if origin != value:
            yield ParameterChange(name, role, what, origin, value)
    orders = list(_order_changes(dict(_orders(old)), dict(_orders(new))))
    parts = any(change.name == PARTS for change in orders)
    yield from (change for change in orders if change.name == PARTS or not (parts and change.only_names))


def _sided(side: Mapping[Place, str], other: Mapping[Place, str], what: str) -> Iterator[ParameterChange]:
    """Yield what only one side has: one change for a condition, and one for a record with the names of its fields."""
    records: dict[Place, list[str]] = {}
    for (role, name, field), value in side.items():
        if (role, name, field) not in other:
            texts = records.setdefault((role, name, field if name in _CONDITIONS else ""), [])
            alone = field in ("entry", "value") or name in _CONDITIONS
            texts += [value if alone else f"{field} = {value}"] * bool(value)
    for (role, name, _), texts in records.items():
        text = ", ".join(texts)
        yield ParameterChange(name, role, what, *(("", text) if what == "added" else (text, "")))


def _orders(manifest: Manifest) -> Iterator[tuple[str, list[str]]]:
    """Yield the names whose order matters, by kind.

    Order matters for elements of vectors (positions in C and in arrays), for scenarios (the first is the default of a
    run) and for simultaneous events (each acts on the result of the previous one). The order of parts is that of all.
    """
    yield PARTS, [*manifest.parts]
    yield "events", [event.name for event in manifest.events if event.resets or event.ends]
    yield "scenarios", list(manifest.scenarios)
    vectors = (*VECTORS, "parameters", "scenario_parameters")
    for owner, record, fields_of in (
        ("", manifest, vectors),
        *((f"{name} ", law, ("parameters", "memory", "outputs")) for name, law in manifest.controllers.items()),
    ):
        for key in fields_of:
            yield f"{owner}{key}", [q.name for q in getattr(record, key)]


def _order_changes(old: Mapping[str, list[str]], new: Mapping[str, list[str]]) -> Iterator[ParameterChange]:
    """Compare the order of names that both sides have."""
    for what in [what for what in new if what in old]:
        order, common = [name for name in old[what] if name in new[what]], [n for n in new[what] if n in old[what]]
        if order != common:
            yield ParameterChange(what, "model", "order", ", ".join(order), ", ".join(common))


def _unsaid(manifest: Manifest) -> set[str]:
    """Return the fields that older manifests do not have; their values are unknown."""
    kinds = (Quantity, Parameter, Output, Choice, Controller, Scenario, Metric, Shape, Event, Manifest)
    optional = (
        (kind, f) for kind in kinds for f in fields(kind) if (f.default, f.default_factory) != (MISSING, MISSING)
    )
    return {f"{kind.__name__}.{f.name}" for kind, f in optional if f'"{key_of(f)}"' not in manifest.text}


def _entries(manifest: Manifest, skipped: Collection[str]) -> Iterator[tuple[Place, str]]:
    """Yield the values in a manifest with their places."""
    for key, value in _fields(manifest, skipped):
        role = _ROLES.get(key, "model")
        if isinstance(value, Mapping):
            for name, record in value.items():
                yield (role, name, "entry"), name
                if isinstance(record, str):
                    yield (role, name, "value"), record
                else:
                    yield from _record(record, role, name, skipped)
        elif role == "model":
            yield from _whole(role, key, value)
        else:
            yield from _rows(value, role, skipped)


def _record(record: object, role: str, name: str, skipped: Collection[str]) -> Iterator[tuple[Place, str]]:
    """Yield the values of a law, a scenario, a metric or a choice."""
    for key, value in _fields(record, skipped):
        if isinstance(value, Mapping):
            yield from (((f"{role} {name}", n, "value"), text) for n, text in _numbers(key, value))
        elif key in _OWN:
            yield from _rows(value, f"{_OWN[key]} {name}", skipped)
        else:
            yield from _whole(f"{role} {name}", key, value)


def _whole(role: str, key: str, value: object) -> Iterator[tuple[Place, str]]:
    """Yield a value without parts; the order of conditions has no meaning."""
    if key in _CONDITIONS and isinstance(value, tuple):
        yield from (((role, key, message), message) for message in value)
    else:
        yield (role, key, "value"), _text(value)


def _rows(rows: Iterable[Any], role: str, skipped: Collection[str]) -> Iterator[tuple[Place, str]]:
    """Yield the values of quantities, parameters and shapes."""
    for row in rows:
        for key, value in _fields(row, skipped):
            what = _WHAT.get(key, key)
            if what == "bounds":
                yield (role, row.name, what), row.interval
            elif value is not None:
                yield (role, row.name, what), _text(value)


def _fields(record: Any, skipped: Collection[str]) -> Iterator[tuple[str, Any]]:
    kinds = [kind.__name__ for kind in type(record).__mro__]
    for f in fields(record):
        if f.name != "name" and not any(f"{kind}.{f.name}" in skipped for kind in kinds):
            yield f.name, getattr(record, f.name)


def _numbers(key: str, values: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield the numbers of a scenario and of its laws."""
    for name, value in values.items():
        if isinstance(value, Mapping):
            for inner, number in value.items():
                yield f"{name}.{inner} expected" if key == "expect" else f"{name}.{inner}", str(number)
        else:
            yield name, str(value)


def _text(value: object) -> str:
    return ", ".join(map(_text, value)) if isinstance(value, tuple) else str(value)
