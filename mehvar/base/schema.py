# SPDX-License-Identifier: Apache-2.0
"""Conversion of dataclasses to and from JSON, and from TOML, with their type hints as the schema.

A hint is str, int, float, bool, a union of these, Any, Path, a Literal of texts, `X | None`, `tuple[X, ...]`,
`tuple[X, Y]`, `Mapping[str, X]`, a dataclass, or a NamedTuple, which is a list in JSON. Three rules are special:

- In a mapping of dataclasses with a `name` the key is the entry's name.
- `Upper` and `Lower` are floats whose infinity becomes null, because JSON has no infinity.
- `json_key` gives a field another key in JSON, or omits it.

The module that defines a manifest must not postpone the evaluation of hints (`from __future__ import annotations`),
because evaluating them costs more than reading a manifest.
"""

from __future__ import annotations

import functools
import json
import math
import re
import types
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import MISSING, Field, fields, is_dataclass
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar, cast, get_args, get_origin, get_type_hints

from mehvar.base.errors import InputError, MehvarError, either, printable, suggestion, value_text

Upper = Annotated[float, math.inf]
Lower = Annotated[float, -math.inf]

T = TypeVar("T")
_Convert = Callable[..., Any]
_KEY = "json_key"
_WIDTH = 120
"""Largest number of characters in a line of JSON that people read."""
_MAY_CONTROL = re.compile(r"[\x7f-\x9f]|\\(?:u|[bfr])")
"""Pattern of control characters in JSON, plain or escaped; most files have none."""
_SCALARS = {str: "a text", int: "a whole number", float: "a number", bool: "true or false"}


class SchemaError(MehvarError, ValueError):
    """Error for data that contradict the schema; the message begins with a location such as "controllers.pd.delay"."""

    def __init__(self, problem: str, *place: str | int) -> None:
        super().__init__(problem, *place)
        self.problem, self.place = problem, place

    def __str__(self) -> str:
        steps = (f"[{step}]" if isinstance(step, int) else f".{step}" for step in self.place)
        return f"{''.join(steps)}{self.problem}".removeprefix("." if self.place else ": ")

    def within(self, *place: str | int) -> SchemaError:
        """Return the error with the place of the surrounding data."""
        return SchemaError(self.problem, *place, *self.place)


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
            _check_texts(data)
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
    import tomllib  # a run reads none

    try:
        return tomllib.loads(text)
    except RecursionError as error:
        raise tomllib.TOMLDecodeError("it is nested too deeply") from error


def json_text(table: Mapping[str, Any]) -> str:
    """Return JSON with one line per entry, in which long entries are split in the same way.

    A list of texts or numbers stays on one line.
    """
    return _json_lines(table, "\n") + "\n"


_json = json.JSONEncoder(ensure_ascii=False).encode  # `json.dumps` makes an encoder for each call


def _json_lines(value: Any, start: str) -> str:
    """Return JSON text in which all lines except the first begin with `start`."""
    entries = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    nested = any(isinstance(entry, dict | list) for entry in entries)
    # an entry of a table has at least six characters, one of a list three; a text would else be made at every level
    fits = len(entries) * (6 if isinstance(value, dict) else 3) <= _WIDTH or (isinstance(value, list) and not nested)
    if not entries or (start != "\n" and fits):
        line = _json(value)
        if not entries or len(start + line) <= _WIDTH or (isinstance(value, list) and not nested):
            return line
    inner = start + " "
    if isinstance(value, dict):
        parts = [f"{_json(key)}: {_json_lines(v, inner)}" for key, v in value.items()]
    else:
        parts = [_json_lines(entry, inner) for entry in value]
    opening, closing = "{}" if isinstance(value, dict) else "[]"
    return f"{opening}{inner}{f',{inner}'.join(parts)}{start}{closing}"


def _check_texts(data: object, *place: str | int) -> None:
    """Refuse texts with control characters, because texts appear on terminals, pages and pictures."""
    if isinstance(data, str) and printable(data) != data:
        raise _wrong(data, "a text without control characters").within(*place)
    for step, value in data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ():
        _check_texts(step, *place)
        _check_texts(value, *place, step)


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    table = dict(pairs)
    if len(table) < len(pairs):
        keys = [key for key, _ in pairs]
        twice = next(key for key in table if keys.count(key) > 1)
        raise SchemaError(f": the key {twice!r} is defined twice in one table")
    return table


def _no_number(word: str) -> float:
    raise ValueError(f"{word} is not a JSON number")


def read_data(path: Path, kind: type[T]) -> T:
    """Read a TOML file as a dataclass.

    Parameters
    ----------
    path : Path
        The file.
    kind : type
        The dataclass.

    Raises
    ------
    InputError
        For a file that cannot be read, is not TOML, or has a field that is missing, unknown or of the wrong type; the
        message names file and field.
    """
    try:
        return read(kind, parse_toml(path.read_text(encoding="utf-8-sig")), "table")
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror or error}") from error
    except SchemaError as error:
        raise InputError(f"{path}: {error}") from error
    except ValueError as error:  # of the decoder or of tomllib
        raise InputError(f"{path} is not TOML: {error}") from error


Form = Literal["exact", "table", "any_age"]
"""Demands on data: exactly the fields; a table that people write, without fields that have a default; data of another
version, also with unknown fields."""


def read(schema: type[T], data: object, form: Form = "exact") -> T:
    """Convert JSON or TOML data to a dataclass.

    Parameters
    ----------
    schema : type
        The dataclass.
    data : object
        What `json.loads` or `tomllib.loads` returns.
    form : {"exact", "table", "any_age"}
        Fields that data must and may have. A table has fields by their names, not by their keys in JSON.

    Raises
    ------
    SchemaError
        If a field is missing, unknown or of the wrong type.
    """
    return cast(T, _codec(cast(Any, schema), form)[0](data))


def plain(schema: type, value: object) -> Any:
    """Convert a dataclass to JSON data, with keys in the order of its fields.

    Parameters
    ----------
    schema : type
        The dataclass.
    value : object
        Object of that class, or with the same attributes.
    """
    return _codec(schema)[1](value)


@functools.cache
def _codec(kind: Any, form: Form = "exact") -> tuple[_Convert, _Convert]:
    """Return the functions that read a type from plain data, and write it."""
    origin, inner = get_origin(kind), get_args(kind)
    if kind is Any:
        return _same, _same
    if origin is Literal:
        return partial(_read_word, inner), str
    if origin is types.UnionType and types.NoneType not in inner:
        return partial(_read_either, inner), _same
    if origin is Annotated or origin is types.UnionType:
        (read, write), null = _codec(inner[0], form), inner[1] if origin is Annotated else None
        return (
            lambda value: null if value is None else read(value),
            lambda value: None if value == null else write(value),
        )
    if origin is tuple and inner[-1] is not ...:
        return partial(_read_row, tuple, f"a list of {len(inner)}", [_codec(hint, form)[0] for hint in inner]), list
    if origin is tuple:
        read, write = _codec(inner[0], form)
        return partial(_read_list, read), lambda values: [write(value) for value in values]
    if origin is Mapping:
        (read, write), named = _codec(inner[1], form), _is_named(inner[1])
        return partial(_read_mapping, read, named, form), partial(_write_mapping, write, named)
    if is_dataclass(kind):
        rows = [(f, key, *_codec(hint, form)) for f, key, hint in _rows(kind)]
        reads = {f.name if form == "table" else key: (f, read) for f, key, read, _ in rows}
        writes = [(f.name, key, write) for f, key, _, write in rows]
        return partial(_read_record, kind, reads, form), partial(_write_record, writes)
    if issubclass(kind, tuple):
        converts = [_codec(hint, form)[0] for hint in kind.__annotations__.values()]
        return partial(_read_row, kind._make, f"[{', '.join(kind._fields)}]", converts), list
    if kind is Path:
        return lambda value: Path(_read_scalar(str, value)), str
    return partial(_read_scalar, kind), kind


def _same(value: Any) -> Any:
    return value


def _read_scalar(kind: Any, value: Any) -> Any:
    if type(value) is kind:
        return value
    if kind is float and type(value) is int and abs(value) < 2**1023:
        return float(value)
    raise _wrong(value, _SCALARS[kind])


def _read_either(kinds: Sequence[Any], value: Any) -> Any:
    for kind in kinds:
        with suppress(SchemaError):
            return _read_scalar(kind, value)
    raise _wrong(value, either([_SCALARS[kind] for kind in kinds]))


def _read_word(words: Sequence[str], value: Any) -> Any:
    if not isinstance(value, str) or value not in words:
        raise _wrong(value, either(words))
    return value


def _read_list(convert: _Convert, values: Any) -> Any:
    """Return the converted values; an error names the index of its value."""
    if type(values) is not list:
        raise _wrong(values, "a list")
    result: list[Any] = []
    try:
        for value in values:
            result.append(convert(value))
    except SchemaError as error:
        raise error.within(len(result)) from None
    return tuple(result)


def _read_mapping(convert: _Convert, named: bool, form: Form, values: Any) -> Any:
    """Return the converted values by name; a named record takes its name from the key, not from a field."""
    entries, result = _table(values), {}
    try:
        for name, value in entries.items():
            if named and type(value) is dict:
                if "name" in value and form != "any_age":
                    raise SchemaError(" is not known: the name of the table is the name", "name")
                value = {**value, "name": name}
            result[name] = convert(value)
    except SchemaError as error:
        raise error.within(name) from None
    return result


def _read_row(make: _Convert, allowed: str, converts: Sequence[_Convert], values: Any) -> Any:
    if type(values) is not list or len(values) != len(converts):
        raise _wrong(values, allowed)
    return make([convert(value) for convert, value in zip(converts, values, strict=True)])


def _read_record(kind: Any, rows: Mapping[str, tuple[Field[Any], _Convert]], form: Form, data: Any) -> Any:
    """Return a record; "exact" data have every key, and only data of any age may have unknown ones."""
    if _table(data).keys() != rows.keys():
        for key in data:
            if key not in rows and form != "any_age":
                near = suggestion(key, rows) or f"; known: {', '.join(rows)}"
                raise SchemaError(f" is not known{near if form == 'table' else ''}", key)
        for key, (f, _) in rows.items():
            if key not in data and (form == "exact" or (f.default, f.default_factory) == (MISSING, MISSING)):
                raise SchemaError(" is missing", key)
        rows = {key: row for key, row in rows.items() if key in data}
    values = {}
    try:
        for key, (f, convert) in rows.items():
            values[f.name] = convert(data[key])
    except SchemaError as error:
        raise error.within(key) from None
    return kind(**values)


def _rows(kind: Any) -> list[tuple[Field[Any], str, Any]]:
    """Return each field that JSON has, with its key and type hint."""
    late = any(isinstance(f.type, str) for f in fields(kind))
    hints = get_type_hints(kind, include_extras=True) if late else {f.name: f.type for f in fields(kind)}
    keys = [(f, key_of(f)) for f in fields(kind)]
    return [(f, key, hints[f.name]) for f, key in keys if key is not None]


def _is_named(kind: Any) -> bool:
    """Return True for a dataclass whose entries in a mapping have their names as keys."""
    return is_dataclass(kind) and any(f.name == "name" for f in fields(kind))


def _table(value: Any) -> dict[str, Any]:
    if type(value) is not dict:
        raise _wrong(value, "a table")
    return value


def _wrong(value: object, allowed: str) -> SchemaError:
    return SchemaError(f" = {value_text(value)}: must be {allowed}")


def _write_mapping(write: _Convert, named: bool, values: Any) -> Any:
    entries = {name: write(value) for name, value in values.items()}
    return (
        {name: {k: v for k, v in entry.items() if k != "name"} for name, entry in entries.items()} if named else entries
    )


def _write_record(rows: Sequence[tuple[str, str, _Convert]], record: Any) -> Any:
    return {key: write(getattr(record, name)) for name, key, write in rows}
