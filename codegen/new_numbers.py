# SPDX-License-Identifier: Apache-2.0
"""Update of a manifest with new numbers from a model's tables, without a derivation.

Numbers are inputs of the generated functions, so no other file depends on them. A manifest contains a hash of the
tables without numbers only if inserting the numbers again reproduces the derived manifest. A model that computes with
its numbers, or has two numbers of one name, is derived again.
"""

from __future__ import annotations

import hashlib
import json
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from mehvar.base.manifest import Manifest
from mehvar.base.schema import parse_toml

if TYPE_CHECKING:
    from mehvar.base import manifest as numeric
    from mehvar.models.quantities import Group, Parameter

_WORDS = frozenset(("title", "description"))
"""Descriptive texts of scenarios and metrics, which only the manifest contains."""
TABLES = ("parameters.toml", "scenarios.toml")


def shapes(folder: Path) -> dict[str, str]:
    """Return the SHA-256 of each table of a model, without numbers and descriptive texts, by file name."""
    hashes = {}
    for name in TABLES:
        try:
            table = parse_toml((folder / name).read_text(encoding="utf-8-sig"))
        except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError):
            continue
        words = _WORDS if name == "scenarios.toml" else frozenset()
        hashes[name] = hashlib.sha256(json.dumps(_shape(table, words), default=str).encode()).hexdigest()
    return hashes


def _shape(value: object, words: frozenset[str]) -> object:
    if isinstance(value, dict):
        return {key: "" if key in words else _shape(entry, words) for key, entry in value.items()}
    if isinstance(value, list):
        return [_shape(entry, words) for entry in value]
    return 0 if isinstance(value, int | float) and not isinstance(value, bool) else value


def renumber(manifest: Manifest, folder: Path) -> Manifest | None:
    """Copy the numbers of a model's tables into its manifest.

    Parameters
    ----------
    manifest : Manifest
        Of the model.
    folder : Path
        The model's folder with parameters.toml and scenarios.toml.

    Returns
    -------
    Manifest or None
        None if a name has two numbers, or if tables and manifest have different names.

    Raises
    ------
    ModelError
        If a table is malformed or a number is outside its bounds.
    """
    from mehvar.models.tables import check_values, read_parameters, read_scenarios

    groups = read_parameters(folder / "parameters.toml")
    scenario_rows, metric_rows = read_scenarios(folder / "scenarios.toml")
    scenarios, metrics = {row.name: row for row in scenario_rows}, {row.name: row for row in metric_rows}
    if set(scenarios) != set(manifest.scenarios) or set(metrics) != set(manifest.metrics):
        return None
    shared = _by_name(groups.values())
    laws = {law: shared | _by_name([groups[law]]) if law in groups else shared for law in manifest.controllers}
    plant, scenario_own = (_numbered(rows, shared) for rows in (manifest.parameters, manifest.scenario_parameters))
    law_own = {name: _numbered(law.parameters, laws[name]) for name, law in manifest.controllers.items()}
    if plant is None or scenario_own is None or None in law_own.values():
        return None
    for name, scenario in scenarios.items():
        where = f"scenario {name!r} of {manifest.model}"
        check_values(scenario.values, shared, where)
        for law, values in scenario.controllers.items():
            check_values(values, laws[law], f"{where}, law {law!r}")
    return replace(
        manifest,
        parameters=plant,
        scenario_parameters=scenario_own,
        controllers={n: replace(law, parameters=law_own[n] or ()) for n, law in manifest.controllers.items()},
        scenarios={name: scenarios[name] for name in manifest.scenarios},
        metrics={name: metrics[name] for name in manifest.metrics},
    )


def _numbered(
    rows: tuple[numeric.Parameter, ...], table: Mapping[str, Parameter]
) -> tuple[numeric.Parameter, ...] | None:
    """Return parameters with defaults from a table; None if a default is missing or ambiguous."""
    if any(row.name not in table for row in rows):
        return None
    defaults = {row.name: table[row.name].default for row in rows}
    numbers = {name: default if isinstance(default, float) else None for name, default in defaults.items()}
    return tuple(row if row.formula is not None else replace(row, default=numbers[row.name]) for row in rows)


def _by_name(groups: Iterable[Group]) -> dict[str, Parameter]:
    """Return the parameters of some groups by name, without names that have two defaults or bounds."""
    from mehvar.models.quantities import Parameter

    parameters = [q for group in groups for q in group if isinstance(q, Parameter)]
    values: dict[str, list[object]] = {}
    for q in parameters:
        values.setdefault(q.name, []).append((q.default, q.bounds))
    return {q.name: q for q in parameters if all(value == values[q.name][0] for value in values[q.name])}
