# SPDX-License-Identifier: Apache-2.0
"""Strict reader of parameters.toml and scenarios.toml: unknown keys are refused with a suggestion."""

from __future__ import annotations

import functools
import math
import re
import tomllib
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, TypeVar

from mehvar.base.errors import either, suggestion, value_text
from mehvar.base.intervals import REALS, Interval
from mehvar.base.manifest import METRIC_KINDS, OF_SECONDS, Metric, Scenario
from mehvar.base.schema import SchemaError, parse_toml, read
from mehvar.base.units import dimension

from .arrays import INCREASING, Table, Tensor, array_of, elements
from .quantities import Group, ModelError, Parameter, place, wrong

OF_COUNTS = ("sign_changes",)
"""Kinds of metrics that use the band; kinds in seconds require it."""
_Row = TypeVar("_Row")


@dataclass(frozen=True)
class _ParameterRow:
    unit: str
    default: Any
    bounds: str = str(REALS)
    source: str = ""
    description: str = ""
    latex: str = ""
    form: str = ""
    over: tuple[str, ...] = ()
    outside: str = ""


@dataclass(frozen=True)
class _ScenarioFile:
    scenarios: Mapping[str, Scenario]
    metrics: Mapping[str, Metric] = field(default_factory=dict)


def read_parameters(path: Path) -> dict[str, Group]:
    """Read a parameter table: one TOML table per group, one entry per parameter.

    Parameters
    ----------
    path : Path
        A parameters.toml.

    Returns
    -------
    dict of str to Group
        Groups of `Parameter` by name, in the order of the file.

    Raises
    ------
    ModelError
        If the file is unreadable or malformed, a key is unknown, a unit is missing, or a value is out of bounds.
    """
    groups = {}
    for group, rows in read_toml(path).items():
        if not isinstance(rows, dict):
            raise ModelError(
                f"{place_in(path, group)}: {group!r} is outside of a group; write it into one, as in [plant.{group}]"
            )
        quantities = tuple(q for name, row in rows.items() for q in _parameters(path, group, name, row))
        groups[group] = Group(group, quantities)
        _check_axes(path, groups[group])
    return groups


def read_scenarios(path: Path) -> tuple[tuple[Scenario, ...], tuple[Metric, ...]]:
    """Read the scenarios and metrics of a model.

    Parameters
    ----------
    path : Path
        A scenarios.toml.

    Raises
    ------
    ModelError
        If the file is unreadable or malformed or a key is unknown.
    """
    table = _read(_ScenarioFile, read_toml(path), path)
    scenarios, metrics = tuple(table.scenarios.values()), tuple(table.metrics.values())
    for scenario in scenarios:
        check_scenario_numbers(scenario, f"{place_in(path, 'scenarios', scenario.name)}: scenario {scenario.name!r}")
    for metric in metrics:
        check_metric_numbers(metric, f"{place_in(path, 'metrics', metric.name)}: metric {metric.name!r}")
    return scenarios, metrics


def check_scenario_numbers(scenario: Scenario, where: str) -> None:
    """Refuse times that are not positive, and expected values that are not numbers."""
    for what, seconds in (("duration", scenario.duration), ("step", scenario.step)):
        if not 0 < seconds < math.inf:
            raise ModelError(f"{where}: {what} = {seconds}: must be finite and above zero")
    for law, values in scenario.expect.items():
        for name, value in values.items():
            if math.isnan(value):  # infinite is a settling time that never comes
                raise ModelError(f"{where}: expect.{law}.{name} = nan: must be a number, or inf")


def check_metric_numbers(metric: Metric, where: str) -> None:
    """Refuse an unknown kind of metric, and a band or window that the kind does not use."""
    if metric.kind not in METRIC_KINDS:
        raise ModelError(f"{where}: kind = {metric.kind!r}: must be {either(METRIC_KINDS)}")
    if metric.kind not in (*OF_SECONDS, *OF_COUNTS) and metric.band != 0:
        raise ModelError(f"{where}: band = {metric.band:g} would be ignored: {metric.kind} uses none")
    least = "above zero" if metric.kind in OF_SECONDS else "zero or above"
    if not math.isfinite(metric.band) or metric.band < 0 or (metric.kind in OF_SECONDS and metric.band == 0):
        raise ModelError(f"{where}: band = {metric.band:g}: must be {least}")
    if not 0 <= metric.since < metric.until:
        raise ModelError(
            f"{where}: since = {metric.since:g} and until = {metric.until:g}: must be 0 <= since < until, in seconds"
        )


def check_names(names: Iterable[str], allowed: Collection[str], what: str) -> None:
    """Refuse a name that is not allowed, with a suggestion."""
    for name in names:
        if name not in allowed:
            raise ModelError(f"{what} {name!r} is not known{suggestion(name, allowed)}")


def check_values(values: Mapping[str, float], allowed: Mapping[str, Parameter], where: str) -> None:
    """Refuse a value that is out of bounds, or whose name is no parameter."""
    check_names(values, allowed, f"{where}: parameter")
    for name, value in values.items():
        if value not in allowed[name].bounds:
            raise ModelError(f"{where}: {name} = {value:g} is outside its bounds {allowed[name].bounds}")


def place_in(path: Path, *keys: str) -> str:
    """Return file and line of an entry in a TOML file, or of the enclosing table.

    Parameters
    ----------
    path : Path
        The file.
    *keys : str
        Names of the tables, outermost first, and of the entry.
    """
    lines = _lines_of(path.read_text(encoding="utf-8-sig"))
    beginnings = (keys[:depth] for depth in range(len(keys), 0, -1))
    return place(str(path), next((lines[start] for start in beginnings if start in lines), 1))


@functools.lru_cache(maxsize=8)
def _lines_of(text: str) -> dict[tuple[str, ...], int]:
    """Return the first line of each table and entry of a TOML file."""
    table, lines = tuple[str, ...](), dict[tuple[str, ...], int]()
    for number, line in enumerate(text.splitlines(), 1):
        header, entry = _HEADER.match(line), _ENTRY.match(line)
        if header:
            table = _keys_of(header[1])
        if header or entry:
            lines.setdefault((*table, *_keys_of(entry[1])) if entry and not header else table, number)
    return lines


def place_of(folder: Path | None, kind: str, name: str, otherwise: str) -> str:
    """Return the origin of a scenario or metric: a table in the model's folder, or the code of the system.

    Parameters
    ----------
    folder : Path or None
        Folder of the model, if known.
    kind, name : str
        "scenarios" or "metrics", and the name.
    otherwise : str
        File and line of the system.
    """
    path = None if folder is None else folder / "scenarios.toml"
    written = path is not None and path.is_file() and name in _names_of(path, path.read_bytes(), kind)
    return place_in(path, kind, name) if path is not None and written else otherwise


@functools.lru_cache(maxsize=8)
def _names_of(path: Path, _contents: bytes, kind: str) -> frozenset[str]:
    return frozenset(read_toml(path).get(kind, {}))


_HEADER = re.compile(r"\s*\[([^\[\]]+)\]")
_ENTRY = re.compile(r"""\s*([\w."' -]+?)\s*=""")


def _keys_of(text: str) -> tuple[str, ...]:
    return tuple(part.strip().strip("\"'") for part in text.split("."))


def read_toml(path: Path) -> dict[str, Any]:
    """Return the contents of a TOML file; errors name its line."""
    if not isinstance(path, Path):
        raise wrong("path", path, "a pathlib.Path")
    try:
        return parse_toml(path.read_text(encoding="utf-8-sig"))
    except OSError as error:
        raise ModelError(f"cannot read {path}: {error.strerror}") from error
    except UnicodeDecodeError as error:
        line = path.read_bytes()[: error.start].count(b"\n") + 1
        raise ModelError(f"{place(str(path), line)}: is not UTF-8 text: {error}") from error
    except tomllib.TOMLDecodeError as error:
        at = re.search(r"at line (\d+)", str(error))  # or "at end of document"
        line = int(at[1]) if at else len(path.read_text(encoding="utf-8-sig").splitlines())
        raise ModelError(f"{place(str(path), line)}: is not valid TOML: {error}") from error


def _parameters(path: Path, group: str, name: str, row: object) -> Iterator[Parameter]:
    """Yield the parameter of an entry, or all parameters of an array."""
    entry = _read(_ParameterRow, row, path, group, name)
    for key, check in (("unit", dimension), ("bounds", Interval.parse)):
        try:
            check(getattr(entry, key))
        except ValueError as error:
            raise ModelError(f"{place_in(path, group, name, key)}: [{group}.{name}]: {error}") from None
    where = f"{place_in(path, group, name, 'default')}: [{group}.{name}]"
    bounds, default = Interval.parse(entry.bounds), _default(entry.default, where)
    whole = Parameter(name, entry.unit, entry.description, entry.latex, bounds.positive, 0.0, bounds, entry.source)
    if isinstance(default, list):
        array = array_of(name, default, entry.form, entry.over, entry.outside, where)
        parameters = list(elements(whole, array, default))
    else:
        for key in ("form", "over", "outside"):
            if getattr(entry, key):
                text = f"{where}: {key} = {getattr(entry, key)!r} has no effect, as only an array has {key}: remove it"
                raise ModelError(text)
        parameters = [replace(whole, default=default)]
    for q in parameters:
        if isinstance(q.default, float) and q.default not in bounds:
            raise ModelError(f"{where}: {_called(name, q)} = {q.default:g} is outside its bounds {bounds}")
    yield from parameters


def _default(value: Any, where: str) -> Any:
    """Return a number, a formula, or a list of numbers or of lists of numbers."""
    if isinstance(value, list):
        rows = [entry if isinstance(entry, list) else [entry] for entry in value]
        if all(type(number) in (int, float) for row in rows for number in row):
            return [_default(entry, where) for entry in value]
    elif isinstance(value, str):
        return value
    elif type(value) is float or (type(value) is int and abs(value) < 2**1023):
        return float(value)
    raise ModelError(f"{where}: default = {value_text(value)}: must be a number, a formula or a list of numbers")


def _called(name: str, parameter: Parameter) -> str:
    return "default" if parameter.name == name else f"default of {parameter.name}"


def _check_axes(path: Path, group: Group) -> None:
    """Refuse a table whose values do not match the points of its axes, which must be increasing arrays."""
    arrays = {q.array.name: q.array for q in group if isinstance(q, Parameter) and q.array is not None}
    for table in arrays.values():
        if isinstance(table, Table):
            where = f"{place_in(path, group.name, table.name, 'over')}: [{group.name}.{table.name}]"
            for axis, size in zip(table.over, table.shape, strict=True):
                points = arrays.get(axis)
                if not isinstance(points, Tensor) or points.form != INCREASING:
                    raise ModelError(
                        f"{where}: over = {list(table.over)}: {axis!r} must be an array in [{group.name}] with "
                        f"form = {INCREASING!r}{suggestion(axis, arrays)}"
                    )
                if points.shape != (size,):
                    raise ModelError(
                        f"{where}: default has {size} values along {axis!r}, which has {points.shape[0]} points"
                    )


def _read(kind: type[_Row], data: object, path: Path, *keys: str) -> _Row:
    """Read an entry of a table; an error names file, line and entry."""
    try:
        return read(kind, data, "table")
    except SchemaError as error:
        whole = error.within(*keys)
        raise ModelError(f"{place_in(path, *map(str, whole.place))}: {whole}") from None
