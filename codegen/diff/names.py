# SPDX-License-Identifier: Apache-2.0
"""New names of parts, laws, scenarios and quantities, and the old version written with them."""

from __future__ import annotations

import functools
import re
from collections.abc import Container, Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any

from mehvar.base.manifest import Manifest
from mehvar.base.parts import exchanged_parts, renamed_parts

from ..equations.document import Document, Row, Symbol

_WORD = re.compile(r"\w+")
_KEPT = frozenset(("unit", "text", "folder", "functions", "versions", "inputs_sha256", "files_sha256", "shapes_sha256"))
"""Fields of a manifest without names of the model; a unit may look like a name, such as m."""


@dataclass(frozen=True)
class Renaming:
    """New names by old ones.

    Attributes
    ----------
    parts, laws, scenarios : mapping of str to str
        Parts of an assembly, laws, and scenarios.
    names : mapping of str to str
        Symbols and definitions, also of these parts and laws.
    quantities : mapping of str to str
        The names that no part or law explains.
    """

    parts: Mapping[str, str]
    laws: Mapping[str, str]
    scenarios: Mapping[str, str]
    names: Mapping[str, str]
    quantities: Mapping[str, str]

    @property
    def wholes(self) -> dict[str, str]:
        """All new names except those of quantities."""
        return {**self.scenarios, **self.laws, **self.parts}

    def document(self, old: Document, new: Document) -> Document:
        """Return the old version with the new names, where the new version has these."""
        roles = {symbol.role for symbol in new.symbols}
        rows: dict[str, set[str]] = {}
        for row in new.rows:
            rows.setdefault(row.kind, set()).add(row.name)

        one = self.names.get

        def named(row: Row) -> Row:
            return replace(
                row, name=one(row.name, row.name) if row.named else self.text(row.name, rows.get(row.kind, ()))
            )

        return replace(
            old,
            symbols=tuple(replace(s, name=one(s.name, s.name), role=self.text(s.role, roles)) for s in old.symbols),
            definitions=tuple(map(named, old.definitions)),
            results=tuple(map(named, old.results)),
            nodes=tuple(("sym", one(node[1], node[1])) if node[0] == "sym" else node for node in old.nodes),
            rates={one(state, state): one(rate, rate) for state, rate in old.rates.items()},
            manifest=self._manifest(old.manifest, new.manifest),
        )

    @functools.cached_property
    def exchanged(self) -> frozenset[str]:
        """Names that both versions have, for different things."""
        names = {**self.wholes, **self.names}
        return frozenset(names) & frozenset(names.values())

    def text(self, text: str, known: Container[str]) -> str:
        """Return a text with the new names: all of them, those of quantities, or the first word; else unchanged."""
        if text in known and self.exchanged.isdisjoint(_WORD.findall(text)):
            return text
        wholes = self.wholes
        for words, count in (({**wholes, **self.names}, 0), (self.names, 0), (wholes, 1)):
            other = _replaced(text, words, count)
            if other in known:
                return other
        return text

    def _manifest(self, old: Manifest | None, new: Manifest | None) -> Manifest | None:
        return old and new and self._value(old, frozenset(_texts(new)))

    def _value(self, value: Any, known: Container[str]) -> Any:
        if isinstance(value, str):
            return self.names.get(value) or self.text(value, known)
        if is_dataclass(value) and not isinstance(value, type):
            own = {f.name: getattr(value, f.name) for f in fields(value) if f.name not in _KEPT}
            return replace(value, **{name: self._value(entry, known) for name, entry in own.items()})
        if isinstance(value, Mapping):
            return {self._value(name, known): self._value(entry, known) for name, entry in value.items()}
        return tuple(self._value(entry, known) for entry in value) if isinstance(value, tuple) else value


def exchange(old: Document, new: Document) -> Renaming | None:
    """Return the renaming by which parts took names of others, if some did."""
    parts = exchanged_parts(old.manifest.parts, new.manifest.parts) if old.manifest and new.manifest else {}
    return _renaming(old, new, parts) if parts else None


def renaming(old: Document, new: Document) -> Renaming:
    """Match parts, laws, scenarios and quantities that only one side has."""
    return _renaming(
        old, new, renamed_parts(old.manifest.parts, new.manifest.parts) if old.manifest and new.manifest else {}
    )


def _renaming(old: Document, new: Document, parts: Mapping[str, str]) -> Renaming:
    """Match laws, scenarios and quantities that only one side has, and the quantities of renamed parts."""
    before, after = old.manifest, new.manifest
    laws, scenarios = (
        renamed_parts(described(before), described(after)) if before and after else {}
        for described in (_laws, _scenarios)
    )
    owned = dict(_owned({**parts, **laws}, _words(old), _words(new)))
    first = Renaming(parts, laws, scenarios, owned, {})
    quantities = _quantities(first.document(old, new), new)
    changes = {f"d{name}": f"d{other}" for name, other in quantities.items()}  # rows of process noise
    return Renaming(parts, laws, scenarios, {**owned, **changes, **quantities}, quantities)


def _replaced(text: str, words: Mapping[str, str], count: int) -> str:
    return _WORD.sub(lambda word: words.get(word[0], word[0]), text, count)


def _laws(manifest: Manifest) -> dict[str, dict[str, str]]:
    """Return what describes each law; laws with other parameters or another memory are different laws."""
    return {
        name: {
            "": str([[q.name for q in group] for group in (law.parameters, law.memory)]),
            "title": law.title,
            "period": str(law.period),
            "outputs": str([q.name for q in law.outputs]),
        }
        for name, law in manifest.controllers.items()
    }


def _scenarios(manifest: Manifest) -> dict[str, dict[str, str]]:
    """Return what describes each scenario."""
    fields_of = ("title", "duration", "step", "values", "controllers")
    return {
        name: {field: str(getattr(scenario, field)) for field in fields_of}
        for name, scenario in manifest.scenarios.items()
    }


def _words(document: Document) -> set[str]:
    names = (*(s.name for s in document.symbols), *(r.name for r in document.rows))
    return {word for name in names for word in _WORD.findall(name)}


def _owned(owners: Mapping[str, str], old: set[str], new: set[str]) -> Iterator[tuple[str, str]]:
    """Yield the names that contain an owner's old name, such as wheel1_speed, and exist with its new name.

    An owner's name may also occur by chance, as m occurs in m_m: its first place as a word counts then.
    """
    if not owners:
        return
    any_of = "|".join(sorted(map(re.escape, owners), key=len, reverse=True))
    apart = rf"(?<![A-Za-z0-9])(?:{any_of})(?![A-Za-z0-9])"
    shared = old & new if owners.keys() & {*owners.values()} else set()  # where parts exchanged their names
    for name in sorted((old - new) | shared):
        for pattern, count in ((apart, 0), (any_of, 0), (apart, 1)):
            other = re.sub(pattern, lambda owner: owners[owner[0]], name, count=count)
            if other != name and other in (new - old) | shared:
                yield name, other
                break


def _quantities(old: Document, new: Document) -> dict[str, str]:
    """Return quantities that were only renamed.

    A removed and an added quantity count as the same if role, unit and sign agree, and LaTeX or description agrees or
    no other pair fits.
    """
    removed = [s for s in old.declared.values() if s.name not in new.declared and s.name not in new.named]
    come = [s for s in new.declared.values() if s.name not in old.declared and s.name not in old.named]
    pairs = {}
    for symbol in come:
        fitting = [s for s in removed if (s.role, s.unit, s.sign) == (symbol.role, symbol.unit, symbol.sign)]
        alike = [s for s in fitting if _alike(s, symbol)] or (fitting if len(fitting) == 1 else [])
        rivals = [s for s in come if (s.role, s.unit, s.sign) == (symbol.role, symbol.unit, symbol.sign)]
        if len(alike) == 1 and (_alike(alike[0], symbol) or len(rivals) == 1):
            pairs[alike[0].name] = symbol.name
            removed.remove(alike[0])
    return pairs


def _alike(old: Symbol, new: Symbol) -> bool:
    return bool((old.latex and old.latex == new.latex) or (old.description and old.description == new.description))


def _texts(value: Any) -> Iterator[str]:
    """Yield all texts in a manifest."""
    if isinstance(value, str):
        yield value
    elif is_dataclass(value):
        for f in fields(value):
            if f.name not in _KEPT:
                yield from _texts(getattr(value, f.name))
    elif isinstance(value, Mapping):
        yield from _texts((*value, *value.values()))
    elif isinstance(value, tuple):
        for entry in value:
            yield from _texts(entry)
