# SPDX-License-Identifier: Apache-2.0
"""Strict reader of parameters.toml and scenarios.toml: unknown keys are refused with a suggestion."""

from __future__ import annotations

import difflib
import functools
import math
import re
import tomllib
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator

from mehvar.base.errors import either
from mehvar.base.intervals import REALS, Interval
from mehvar.base.manifest import METRIC_KINDS, OF_SECONDS, Metric, Scenario
from mehvar.base.schema import parse_toml
from mehvar.base.units import dimension

from .arrays import INCREASING, Table, Tensor, array_of, elements
from .quantities import Group, ModelError, Parameter, place, wrong

OF_COUNTS = ("sign_changes",)
"""Kinds of metrics that use the band; kinds in seconds require it."""


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True)


_Table = TypeVar("_Table", bound=_Strict)


class _ParameterRow(_Strict):
    unit: str
    default: float | str | list[float] | list[list[float]]
    bounds: str = str(REALS)
    source: str = ""
    description: str = ""
    latex: str = ""
    form: str = ""
    over: list[str] = []
    outside: str = ""

    @field_validator("default", mode="before")
    @classmethod
    def _number(cls, value: object) -> object:
        if isinstance(value, list):
            return [cls._number(entry) for entry in value]
        if not isinstance(value, int | float | str) or isinstance(value, bool):
            raise ValueError("must be a number, a formula or a list of numbers")
        return float(value) if isinstance(value, int) else value

    @field_validator("unit")
    @classmethod
    def _unit(cls, value: str) -> str:
        dimension(value)
        return value

    @field_validator("bounds")
    @classmethod
    def _bounds(cls, value: str) -> str:
        Interval.parse(value)
        return value


class _MetricRow(_Strict):
    kind: str
    of: list[str]
    unit: str
    description: str
    band: float = 0.0
    since: float = 0.0
    until: float = float("inf")

    @field_validator("kind")
    @classmethod
    def _kind(cls, value: str) -> str:
        if value not in METRIC_KINDS:
            raise ValueError(f"must be {either(METRIC_KINDS)}")
        return value


class _ScenarioRow(_Strict):
    title: str
    duration: float = Field(gt=0)
    step: float = Field(gt=0)
    values: dict[str, float] = {}
    controllers: dict[str, dict[str, float]] = {}
    expect: dict[str, dict[str, float]] = {}


class _ScenarioFile(_Strict):
    scenarios: dict[str, _ScenarioRow]
    metrics: dict[str, _MetricRow] = {}


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
    table = _validate(_ScenarioFile, read_toml(path), path)
    metrics = tuple(Metric(name, **{**row.model_dump(), "of": tuple(row.of)}) for name, row in table.metrics.items())
    scenarios = tuple(Scenario(name, **row.model_dump()) for name, row in table.scenarios.items())
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
    """Refuse a band or window that a metric's kind does not use."""
    if metric.kind not in (*OF_SECONDS, *OF_COUNTS) and metric.band != 0:
        raise ModelError(f"{where}: band = {metric.band:g} would be ignored: {metric.kind} uses none")
    least = "above zero" if metric.kind in OF_SECONDS else "zero or above"
    if not math.isfinite(metric.band) or metric.band < 0 or (metric.kind in OF_SECONDS and metric.band == 0):
        raise ModelError(f"{where}: band = {metric.band:g}: must be {least}")
    if not 0 <= metric.since < metric.until:
        raise ModelError(
            f"{where}: since = {metric.since:g} and until = {metric.until:g}: must be 0 <= since < until, in seconds"
        )


def suggestion(word: str, names: Iterable[str]) -> str:
    """Return " (did you mean ...?)" with the most similar names; empty if none is similar."""
    near = difflib.get_close_matches(word, list(names), n=1)
    return f" (did you mean {near[0]!r}?)" if near else ""


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
    entry = _validate(_ParameterRow, row, path, group, name)
    bounds, default = Interval.parse(entry.bounds), entry.default
    where = f"{place_in(path, group, name, 'default')}: [{group}.{name}]"
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


def _validate(model: type[_Table], row: object, path: Path, *keys: str) -> _Table:
    try:
        return model.model_validate(row)
    except ValidationError as error:
        problems = error.errors()
        where = place_in(path, *keys, *map(str, problems[0]["loc"]))
        named = f" [{'.'.join(keys)}]:" if keys else ""
        raise ModelError(f"{where}:{named} {'; '.join(_explain(model, dict(e)) for e in problems)}") from None


def _explain(model: type[_Strict], error: Mapping[str, Any]) -> str:
    place = ".".join(str(part) for part in error["loc"])
    if error["type"] == "extra_forbidden":
        return f"unknown key {place!r}{suggestion(str(error['loc'][-1]), _fields(model))}"
    if error["type"] == "missing":
        return f"{place!r} is missing"
    return f"{place or 'entry'} = {error['input']!r}: {error['msg'].removeprefix('Value error, ')}"


def _fields(model: type[_Strict]) -> set[str]:
    nested = {"_ScenarioFile": (_ScenarioRow, _MetricRow)}.get(model.__name__, ())
    return set(model.model_fields).union(*(set(inner.model_fields) for inner in nested))
