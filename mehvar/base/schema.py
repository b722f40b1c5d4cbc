# SPDX-License-Identifier: Apache-2.0
"""Conversion of frozen dataclasses to and from JSON, with their type hints as the schema.

A hint is str, int, float, bool, `X | None`, `tuple[X, ...]`, `Mapping[str, X]`, a dataclass, or a NamedTuple, which
is a list in JSON. Three rules are special:

- In a mapping of dataclasses the key is the entry's `name`.
- `Upper` and `Lower` are floats whose infinity becomes null, because JSON has no infinity.
- `json_key` gives a field another key in JSON, or omits it.

The module that defines the classes must not postpone the evaluation of hints (`from __future__ import annotations`),
because evaluating them costs more than reading a manifest.
"""

from __future__ import annotations

import functools
import json
import math
import re
import tomllib
import types
from collections.abc import Callable, Mapping, Sequence
from dataclasses import MISSING, Field, fields, is_dataclass
from functools import partial
from typing import Annotated, Any, TypeVar, cast, get_args, get_origin

from mehvar.base.errors import MehvarError, printable

Upper = Annotated[float, math.inf]
Lower = Annotated[float, -math.inf]

T = TypeVar("T")
_Convert = Callable[..., Any]
_KEY = "json_key"
_LONGEST = 60
"""Largest number of characters of a value in a message, so that value and location fit one line."""
_WIDTH = 120
"""Largest number of characters in a line of JSON that people read."""
_MAY_CONTROL = re.compile(r"[\x7f-\x9f]|\\(?:u|[bfr])")
"""Pattern of control characters in JSON, plain or escaped; most files have none."""
_SCALARS = {str: "a text", int: "a whole number", float: "a number", bool: "true or false"}


class SchemaError(MehvarError, ValueError):
    """Error for data that contradict the schema; the message begins with a location such as "controllers.pd.delay"."""

    def __init__(self, problem: str, place: str = "") -> None:
        super().__init__(problem, place)
        self.problem, self.place = problem, place

    def __str__(self) -> str:
        place = self.place.removeprefix(".")
        return f"{place}{self.problem}" if place else self.problem.removeprefix(": ")

    def within(self, place: str) -> SchemaError:
        """Return the error with the place of the surrounding data."""
        return SchemaError(self.problem, place + self.place)


def json_key(key: str | None) -> dict[str, str | None]:
    """Return metadata that give a field another key in JSON, or with None omit it."""
    return {_KEY: key}


def key_of(field: Field[Any]) -> str | None:
    """Return the JSON key of a field, or None if JSON omits it."""
    key: str | None = field.metadata.get(_KEY, field.name)
    return key


def parse(text: str) -> Any:
    """Return the value of a JSON text.

    Raises
    ------
    SchemaError
        If it is not JSON, is nested too deeply, repeats a key, or has a text with control characters.
    """
    try:
        data = json.loads(text, parse_constant=_no_number, object_pairs_hook=_once)
        if _MAY_CONTROL.search(text):
            _check_texts(data, "")
        return data
    except SchemaError:
        raise
    except RecursionError as error:
        raise SchemaError(": is nested too deeply to be read") from error
    except ValueError as error:
        raise SchemaError(f": is not JSON: {error}") from error


def parse_toml(text: str) -> dict[str, Any]:
    """Return the value of a TOML text.

    Raises
    ------
    tomllib.TOMLDecodeError
        If it is not TOML, or is nested too deeply.
    """
    try:
        return tomllib.loads(text)
    except RecursionError as error:
        raise tomllib.TOMLDecodeError("it is nested too deeply") from error


def json_text(table: Mapping[str, Any]) -> str:
    """Return JSON with one line per entry, in which long entries are split in the same way.

    A list of texts or numbers stays on one line.
    """
    return _json_lines(table, "\n") + "\n"


def _json_lines(value: Any, start: str) -> str:
    """Return JSON text in which all lines except the first begin with `start`."""
    line = json.dumps(value, ensure_ascii=False)
    entries = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    nested = any(isinstance(entry, dict | list) for entry in entries)
    if not entries or (start != "\n" and (len(start + line) <= _WIDTH or (isinstance(value, list) and not nested))):
        return line
    inner = start + " "
    if isinstance(value, dict):
        parts = [f"{json.dumps(key, ensure_ascii=False)}: {_json_lines(v, inner)}" for key, v in value.items()]
    else:
        parts = [_json_lines(entry, inner) for entry in value]
    opening, closing = "{}" if isinstance(value, dict) else "[]"
    return f"{opening}{inner}{f',{inner}'.join(parts)}{start}{closing}"


def _check_texts(data: object, place: str) -> None:
    """Refuse texts with control characters, because texts appear on terminals, pages and pictures."""
    if isinstance(data, str) and printable(data) != data:
        raise SchemaError(_wrong(data, "a text without control characters").problem, place)
    if isinstance(data, dict):
        for key, value in data.items():
            _check_texts(key, place)
            _check_texts(value, f"{place}.{key}")
    elif isinstance(data, list):
        for number, value in enumerate(data):
            _check_texts(value, f"{place}[{number}]")


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    table = dict(pairs)
    if len(table) < len(pairs):
        keys = [key for key, _ in pairs]
        twice = next(key for key in table if keys.count(key) > 1)
        raise SchemaError(f": the key {twice!r} is defined twice in one table")
    return table


def _no_number(word: str) -> float:
    raise ValueError(f"{word} is not a JSON number")


def read(schema: type[T], data: object, any_age: bool = False, **others: object) -> T:
    """Convert JSON data to a dataclass.

    Parameters
    ----------
    schema : type
        The dataclass.
    data : object
        What `json.loads` returns.
    any_age : bool
        Accept data of another version: ignore unknown keys and use defaults for missing fields.
    **others : object
        Values of fields that JSON omits.

    Raises
    ------
    SchemaError
        If a field is missing, unknown or of the wrong type.
    """
    record = _reader(cast(Any, schema), any_age)(data)
    record.__dict__.update(others)
    return cast(T, record)


def plain(schema: type, value: object) -> Any:
    """Convert a dataclass to JSON data, with keys in the order of its fields.

    Parameters
    ----------
    schema : type
        The dataclass.
    value : object
        Object of that class, or with the same attributes.
    """
    return _writer(schema)(value)


@functools.cache
def _reader(kind: Any, any_age: bool) -> _Convert:
    """Return the function that converts JSON data to a type."""
    origin, inner = get_origin(kind), get_args(kind)
    if origin is Annotated or origin is types.UnionType:
        convert, null = _reader(inner[0], any_age), inner[1] if origin is Annotated else None
        return lambda value: null if value is None else convert(value)
    if origin is tuple:
        return partial(_read_list, _reader(inner[0], any_age))
    if origin is Mapping:
        return partial(_read_mapping, _reader(inner[1], any_age), is_dataclass(inner[1]))
    if is_dataclass(kind):
        rows = {key: (name, _reader(hint, any_age)) for name, key, hint in _rows(kind)}
        return partial(_read_record, kind, rows, any_age)
    if issubclass(kind, tuple):
        return partial(_read_row, kind, [_reader(hint, any_age) for hint in kind.__annotations__.values()])
    return partial(_read_scalar, kind)


def _read_scalar(kind: Any, value: Any) -> Any:
    if type(value) is kind:
        return value
    if kind is float and type(value) is int and abs(value) < 2**1023:
        return float(value)
    raise _wrong(value, _SCALARS[kind])


def _read_list(convert: _Convert, values: Any) -> Any:
    if type(values) is not list:
        raise _wrong(values, "a list")
    result: list[Any] = []
    try:
        for value in values:
            result.append(convert(value))
    except SchemaError as error:
        raise error.within(f"[{len(result)}]") from None
    return tuple(result)


def _read_mapping(convert: _Convert, named: bool, values: Any) -> Any:
    entries, result = _table(values), {}
    try:
        for name, value in entries.items():
            result[name] = convert({**value, "name": name} if named and type(value) is dict else value)
    except SchemaError as error:
        raise error.within(f".{name}") from None
    return result


def _read_row(kind: Any, converts: Sequence[_Convert], values: Any) -> Any:
    if type(values) is not list or len(values) != len(converts):
        raise _wrong(values, f"[{', '.join(kind._fields)}]")
    return kind(*[convert(value) for convert, value in zip(converts, values, strict=True)])


def _read_record(kind: Any, rows: Mapping[str, tuple[str, _Convert]], any_age: bool, data: Any) -> Any:
    if _table(data).keys() != rows.keys():
        optional = {f.name for f in fields(kind) if (f.default, f.default_factory) != (MISSING, MISSING)}
        required = {key for key, (name, _) in rows.items() if not any_age or name not in optional}
        problems = [f"{key!r} is missing" for key in sorted(required - data.keys())]
        problems += [] if any_age else [f"{key!r} is not known" for key in sorted(data.keys() - rows.keys())]
        if problems:
            raise SchemaError(f": {' and '.join(problems)}")
        rows = {key: row for key, row in rows.items() if key in data}
    values = {}
    try:
        for key, (name, convert) in rows.items():
            values[name] = convert(data[key])
    except SchemaError as error:
        raise error.within(f".{key}") from None
    return kind(**values)


def _rows(kind: Any) -> list[tuple[str, str, Any]]:
    """Return name, key and type hint of each field that JSON has."""
    keys = [(f, key_of(f)) for f in fields(kind)]
    return [(f.name, key, f.type) for f, key in keys if key is not None]


def _table(value: Any) -> dict[str, Any]:
    if type(value) is not dict:
        raise _wrong(value, "a table")
    return value


def _wrong(value: object, allowed: str) -> SchemaError:
    text = repr(value)
    return SchemaError(f" = {text if len(text) <= _LONGEST else text[:_LONGEST] + '...'}: must be {allowed}")


@functools.cache
def _writer(kind: Any) -> Callable[[Any], Any]:
    origin, inner = get_origin(kind), get_args(kind)
    if origin is Annotated or origin is types.UnionType:
        null, write = inner[1] if origin is Annotated else None, _writer(inner[0])
        return lambda value: None if value == null else write(value)
    if origin is tuple:
        write = _writer(inner[0])
        return lambda values: [write(value) for value in values]
    if origin is Mapping:
        write, named = _writer(inner[1]), is_dataclass(inner[1])
        return lambda values: {name: _nameless(write(value), named) for name, value in values.items()}
    if is_dataclass(kind):
        rows = [(name, key, _writer(hint)) for name, key, hint in _rows(kind)]
        return lambda value: {key: write(getattr(value, name)) for name, key, write in rows}
    return list if issubclass(kind, tuple) else kind


def _nameless(entry: Any, named: bool) -> Any:
    return {key: value for key, value in entry.items() if key != "name"} if named else entry
