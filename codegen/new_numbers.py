# SPDX-License-Identifier: Apache-2.0
"""New numbers in a model's tables, old equations: the manifest is brought up to date without deriving anything.

Numbers are inputs of the generated functions, so no other file depends on them. A model's manifest holds a hash of
its tables without their numbers, and only where putting the numbers in again gives the very manifest that was derived:
a model that computes with its numbers, or that has two of one name, is derived again.
"""

from __future__ import annotations

import hashlib
import json
import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mehvar.models.quantities import Group, Parameter

TABLES = ("parameters.toml", "scenarios.toml")


def shapes(folder: Path) -> dict[str, str]:
    """Return the SHA-256 of each table of a model with every number in it taken as zero, by file name."""
    found = {}
    for name in TABLES:
        try:
            table = tomllib.loads((folder / name).read_text(encoding="utf-8-sig"))
        except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError):
            continue
        found[name] = hashlib.sha256(json.dumps(_shape(table)).encode()).hexdigest()
    return found


def _shape(value: object) -> object:
    if isinstance(value, dict):
        return {key: _shape(entry) for key, entry in value.items()}
    if isinstance(value, list):
        return [_shape(entry) for entry in value]
    return 0 if isinstance(value, int | float) and not isinstance(value, bool) else value


def renumber(document: Mapping[str, Any], folder: Path) -> dict[str, Any] | None:
    """Put the numbers of a model's tables into its manifest.

    Parameters
    ----------
    document : mapping
        The manifest; left as it is.
    folder : Path
        The model's folder with parameters.toml and scenarios.toml.

    Returns
    -------
    dict or None
        The new manifest; None where a name stands for two numbers or the tables hold other names than the manifest.

    Raises
    ------
    ModelError
        If a table is malformed or a number is outside its bounds.
    """
    from mehvar.models.tables import check_values, read_parameters, read_scenarios

    groups = read_parameters(folder / "parameters.toml")
    scenarios, metrics = read_scenarios(folder / "scenarios.toml")
    new: dict[str, Any] = json.loads(json.dumps(document))
    shared = _by_name(groups.values())
    laws = {law: shared | _by_name([groups[law]]) if law in groups else shared for law in new["controllers"]}
    tables = [(row, shared) for row in (*new["parameters"], *new["scenario_parameters"])]
    tables += [(row, laws[law]) for law, entry in new["controllers"].items() for row in entry["parameters"]]
    if any(known.get(row["name"]) is None for row, known in tables):
        return None
    if set(new["scenarios"]) != {s.name for s in scenarios} or set(new["metrics"]) != {m.name for m in metrics}:
        return None
    for row, known in tables:
        if row["formula"] is None:
            row["default"] = _number(known[row["name"]])
    for scenario in scenarios:
        where = f"scenario {scenario.name!r} of {document['model']}"
        check_values(scenario.values, _unambiguous(shared), where)
        for law, values in scenario.controllers.items():
            check_values(values, _unambiguous(laws[law]), f"{where}, law {law!r}")
        entry = new["scenarios"][scenario.name]
        entry |= {"duration": scenario.duration, "step": scenario.step, "set": dict(scenario.values)}
        entry["controllers"] = {law: dict(values) for law, values in scenario.controllers.items()}
        entry["expect"] = {law: dict(values) for law, values in scenario.expect.items()}
    for metric in metrics:
        new["metrics"][metric.name] |= {"band": metric.band, "since": metric.since, "until": metric.until}
    finite: dict[str, Any] = _without_infinity(new)
    return finite


def manifest_text(document: Mapping[str, Any]) -> str:
    """Write a manifest as JSON."""
    return json.dumps(document, indent=1, ensure_ascii=False) + "\n"


def _by_name(groups: Iterable[Group]) -> dict[str, Parameter | None]:
    """Return the parameters of some groups; None for a name with two numbers or bounds."""
    from mehvar.models.quantities import Parameter

    found: dict[str, Parameter | None] = {}
    for q in (q for group in groups for q in group if isinstance(q, Parameter)):
        other = found.setdefault(q.name, q)
        if other is None or (other.default, other.bounds) != (q.default, q.bounds):
            found[q.name] = None
    return found


def _unambiguous(parameters: Mapping[str, Parameter | None]) -> dict[str, Parameter]:
    return {name: parameter for name, parameter in parameters.items() if parameter is not None}


def _number(parameter: Parameter | None) -> float | None:
    return parameter.default if parameter and isinstance(parameter.default, float) else None


def _without_infinity(value: Any) -> Any:
    """Write infinite numbers as the manifest does."""
    if isinstance(value, dict):
        return {key: _without_infinity(entry) for key, entry in value.items()}
    if isinstance(value, list):
        return [_without_infinity(entry) for entry in value]
    return None if value in (float("inf"), float("-inf")) else value
