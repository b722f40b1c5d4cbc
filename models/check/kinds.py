# SPDX-License-Identifier: Apache-2.0
"""Check that each field of a system has its declared type; for example, a list is not a tuple."""

from __future__ import annotations

import functools
import types
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

import sympy as sp

from mehvar.base.errors import either, value_text

from ..quantities import Located, ModelError
from ..system import System


def check_kinds(system: object) -> None:
    """Refuse anything but a `System`, and fields of the wrong type."""
    if not isinstance(system, System):
        raise ModelError(f"system() returns a {type(system).__name__}: must be a System")
    _check_record(system, "", system.origin)


def _check_record(record: Any, where: str, origin: str) -> None:
    origin = record.origin if isinstance(record, Located) else origin
    hints = _hints(record.__class__)
    for field in fields(record):
        place = f"{where}.{field.name}" if where else field.name
        _check(getattr(record, field.name), hints[field.name], place, origin)


@functools.cache
def _hints(kind: type) -> dict[str, Any]:
    return get_type_hints(kind)


def _check(value: Any, hint: Any, where: str, origin: str) -> None:
    """Refuse a value that does not fit its type hint; `where` names the value in the message."""
    kind, inner = get_origin(hint), get_args(hint)
    if kind in (Union, types.UnionType):
        options = [part for part in inner if part is not type(None)]
        if value is None and len(options) < len(inner):
            return
        if len(options) > 1 and not any(_is(value, option) for option in options):
            raise _wrong(value, " or ".join(option.__name__ for option in options), where, origin)
        hint = type(value) if len(options) > 1 else options[0]
        kind, inner = get_origin(hint), get_args(hint)
    if kind is tuple:
        _check_tuple(value, inner, where, origin)
    elif kind is Mapping:
        if not isinstance(value, Mapping):
            raise _wrong(value, "mapping", where, origin)
        for key, entry in value.items():
            _check(key, inner[0], f"name {key!r} of {where}", origin)
            _check(entry, inner[1], f"{where}[{key!r}]", origin)
    elif kind is Literal:
        if not isinstance(value, str) or value not in inner:
            raise ModelError(f"{origin}: {where} = {value_text(value)}: must be {either(inner)}")
    elif not _is(value, hint):
        raise _wrong(value, "SymPy expression" if hint is sp.Expr else hint.__name__, where, origin)
    elif is_dataclass(value):
        _check_record(value, where, origin)


def _is(value: object, kind: type) -> bool:
    """Return True if a value has a type. An integer counts as a float; a boolean does not count as a number."""
    return isinstance(value, (int, float) if kind is float else kind) and (kind is bool or not isinstance(value, bool))


def _check_tuple(value: Any, inner: tuple[Any, ...], where: str, origin: str) -> None:
    every = len(inner) == 2 and inner[1] is Ellipsis
    if not isinstance(value, tuple) or not (every or len(value) == len(inner)):
        raise _wrong(value, "tuple" if every else f"tuple of {len(inner)}", where, origin)
    for k, entry in enumerate(value):
        _check(entry, inner[0] if every else inner[k], f"{where}[{k}]", origin)


def _wrong(value: object, allowed: str, where: str, origin: str) -> ModelError:
    text = value_text(value)
    shown = text if len(text) <= _LONGEST else text[:_LONGEST] + "..."
    return ModelError(f"{origin}: {where} = {shown} is a {type(value).__name__}: must be a {allowed}")


_LONGEST = 60
"""Largest number of characters of a value in a message, so that value and location fit one line."""
