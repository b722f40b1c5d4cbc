# SPDX-License-Identifier: Apache-2.0
"""Checks of argument types from Python callers; further conditions are checked where a value is used."""

from __future__ import annotations

import ast
import contextlib
import os
import warnings
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Literal

from mehvar.base.errors import bad_value

if TYPE_CHECKING:
    import xarray

Argument = Literal["text", "path", "mapping", "truth", "function"]

_TYPES: Mapping[Argument, tuple[Callable[[object], bool], str]] = {
    "text": (lambda value: isinstance(value, str), "a text"),
    "path": (lambda value: isinstance(value, str | os.PathLike) and "\0" not in str(value), "a path"),
    "mapping": (
        lambda value: isinstance(value, Mapping) and all(isinstance(name, str) for name in value),
        "a mapping of names, such as a dict",
    ),
    "truth": (lambda value: isinstance(value, bool), "True or False"),
    "function": (callable, "a function"),
}


def number(text: str) -> int | float | None:
    """Return the number in a text, or None. Forms that only Python accepts, such as `1_0`, are refused."""
    if text.isascii() and "_" not in text:
        for kind in (int, float):  # a whole number exactly; as a float above 2^53 it would lose digits
            with contextlib.suppress(ValueError):
                return kind(text)
    return None


def parsed(text: str) -> ast.expr:
    """Return a parsed expression in Python's syntax.

    Raises
    ------
    ValueError
        If it is none, or `number` cannot read one of its numbers; Python's parser also accepts `1_0` and `0x10`.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # Python warns of texts such as `1if` before it refuses them
            tree = ast.parse(text, mode="eval").body
    except (SyntaxError, MemoryError, RecursionError, Warning) as error:
        raise ValueError(text) from error
    lines = text.encode().splitlines()  # once: ast.get_source_segment splits the text for each node
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and type(node.value) in (int, float):
            literal = lines[node.lineno - 1][node.col_offset : node.end_col_offset]
            if number(literal.decode()) is None:
                raise ValueError(text)
    return tree


def check_arguments(kind: Argument, origin: str, /, **arguments: object) -> None:
    """Refuse arguments of a wrong type; None stands for a missing argument.

    Parameters
    ----------
    kind : {"text", "path", "mapping", "truth", "function"}
        Expected type of each argument.
    origin : str
        How error messages call the arguments.
    **arguments
        Arguments by name.

    Raises
    ------
    InputError
        For the first argument of another type.
    """
    holds, allowed = _TYPES[kind]
    for name, value in arguments.items():
        if value is not None and not holds(value):
            raise bad_value(name, value, allowed, origin)


def check_units(data: xarray.Dataset, units: Mapping[str, str], origin: str) -> None:
    """Refuse variables of a dataset whose unit differs from the model's, and all but real numbers.

    Parameters
    ----------
    data : xarray.Dataset
        Its variables may have an attribute `units`.
    units : mapping of str to str
        Names of variables, and the unit that each must have.
    origin : str
        How error messages call the dataset.

    Raises
    ------
    InputError
        For the first variable with another unit.
    """
    for name, unit in units.items():
        if data[name].dtype.kind in "mMcSU":  # NumPy would cast them: a date to nanoseconds, a complex number to a part
            raise bad_value(f"values of {name}", str(data[name].dtype), f"real numbers in {unit}", origin)
        given = data[name].attrs.get("units")
        if given not in (None, "", unit):
            raise bad_value(f"unit of {name}", given, f"{unit}, or left out", origin)
