# SPDX-License-Identifier: Apache-2.0
"""Base class of all errors, and the wording of messages about bad values and names."""

from __future__ import annotations

import difflib
import re
import reprlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import PurePath

_LONGEST = 200
"""Largest number of characters of a value in a message: a few lines of a terminal. Usual paths and conditions are
shorter."""


class MehvarError(Exception):
    """Base class of all errors that mehvar raises on purpose.

    Attributes
    ----------
    exit_status : int
        Exit status of the command: 2 for bad usage or input, 3 for a failed run.
    resumable : bool
        True if results are kept and the same command continues from them.
    """

    exit_status = 2
    resumable = False


class InputError(MehvarError, ValueError):
    """A value given by the user is wrong; the message has its name, its origin and the allowed values."""


class MissingError(InputError):
    """A needed compiler, emulator or package is not installed; the message has the install command."""


class FunctionNameError(MehvarError, KeyError):
    """The model has no generated function of this name; the message lists its functions."""

    def __str__(self) -> str:
        return str(self.args[0])  # where KeyError shows the quoted text


class BuildError(MehvarError, RuntimeError):
    """The C compiler failed on a generated file; the message has the command and its output."""

    exit_status = 3


class Origin(str):
    """Origin of a set of values, for messages; single names may have other origins.

    Parameters
    ----------
    rest : str
        Origin of every value that `names` does not have; an `Origin` keeps its own names.
    names : mapping of str to str
        Origin of single values.
    """

    names: Mapping[str, str]

    def __new__(cls, rest: str, names: Mapping[str, str]) -> Origin:
        """Return the origin `rest` with the separate origins of some names."""
        origin = super().__new__(cls, rest)
        origin.names = {**(rest.names if isinstance(rest, Origin) else {}), **names}
        return origin

    def __getnewargs__(self) -> tuple[str, Mapping[str, str]]:  # type: ignore[override]  # a text has one argument
        return str(self), self.names


def is_shortage(error: BaseException) -> bool:
    """Return True if an error means a lack of memory.

    If Python cannot start a thread, the error has another type than MemoryError.
    """
    return isinstance(error, MemoryError) or (
        isinstance(error, RuntimeError) and "can't start new thread" in str(error)
    )


def bad_value(field: str, value: object, allowed: str, origin: str = "") -> InputError:
    """Return the error for a value that is not allowed.

    Parameters
    ----------
    field : str
        Name of the parameter or argument.
    value : object
        The given value.
    allowed : str
        Allowed values, as in "a number > 0".
    origin : str, optional
        Where the value came from, as in "--set" or "scenario paper".
    """
    return InputError(f"{field} = {value_text(value)}{origin_text(origin, field)}: must be {allowed}")


def either(words: Iterable[str]) -> str:
    """Return words joined as in "a, b or c"."""
    *others, last = words
    return f"{', '.join(others)} or {last}" if others else last


def first_names(names: Sequence[str], most: int, spare: int = 0) -> str:
    """Return the first names and the number of others; up to `spare` more than `most` are all named."""
    if len(names) <= most + spare:
        return ", ".join(names)
    return f"{', '.join(names[:most])} and {len(names) - most} more"


def suggestion(word: str, names: Iterable[str]) -> str:
    """Return " (did you mean ...?)" with the most similar names; empty if none is similar."""
    near = difflib.get_close_matches(word, list(names), n=1)
    return f" (did you mean {near[0]!r}?)" if near else ""


def unknown_name(kind: str, name: object, known: Iterable[str], origin: str = "", note: str = "") -> InputError:
    """Return the error for an unknown name, with the most similar known names.

    Parameters
    ----------
    kind : str
        Its kind and place, as in "parameter", "controller of triangle" or "variable in metric T_theta".
    name : object
        The given value.
    known : iterable of str
        Every name that is allowed.
    origin : str, optional
        Where the name came from.
    note : str, optional
        What the name may mean instead.
    """
    names = list(dict.fromkeys(known))
    close = difflib.get_close_matches(name if isinstance(name, str) else value_text(name), names, n=3, cutoff=0.6)
    hint = f"did you mean {' or '.join(close)}? " if close else ""
    hint = f"{note}; " if note else hint
    listed = f"{': ' if hint else '; '}{hint}known: {', '.join(names) or 'none'}"
    noun, place = re.fullmatch(r"(.*?)((?: of | in | under | \().*)?", kind).groups("")  # type: ignore[union-attr]
    return InputError(f"unknown {noun} {value_text(name)}{place}{origin_text(origin)}{listed}")


def run_checks(*checks: Callable[[], object]) -> None:
    """Run several checks and raise one error with all their messages, one per line.

    Raises
    ------
    InputError
        If any check raises it; all other checks still run.
    """
    errors = []
    for check in checks:
        try:
            check()
        except InputError as error:
            errors.append(error)
    if len(errors) > 1:
        raise InputError("\n".join(dict.fromkeys(map(str, errors))))
    if errors:
        raise errors[0]


def value_text(value: object) -> str:
    """Return a value as messages show it: on one line, shortened in the middle if it is long.

    The `repr` of a long list would fill the terminal, and Python refuses to print an integer of 5000 digits. Numbers of
    NumPy are written as Python's, also inside of lists.
    """
    try:
        text = repr(str(value) if isinstance(value, PurePath) else value)
    except ValueError:
        return f"an integer of {value.bit_length()} bits" if isinstance(value, int) else reprlib.repr(value)
    return shortened(_NUMPY.sub(lambda number: number[1] or number[2], text))


_NUMPY = re.compile(r"\bnp\.(?:\w+\(([^()]+)\)|(True|False)_)")
"""A scalar of NumPy, as in np.float64(1.5)."""


def shortened(text: str) -> str:
    """Return a text on one line, shortened in the middle if it is long."""
    text = " ".join(text.split())
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST // 2]} ... {text[-_LONGEST // 4 :]}"


_CONTROL = re.compile("[\\x00-\\x08\\x0b-\\x1f\\x7f-\\x9f\\ud800-\\udfff]")
"""Control characters, which HTML and XML forbid and terminals execute; tabs and line ends are allowed."""


def printable(text: str) -> str:
    """Return an untrusted text with each control character replaced by a mark."""
    return _CONTROL.sub("\N{REPLACEMENT CHARACTER}", text)


def origin_text(origin: str, name: str = "") -> str:
    """Return the part of a message that names the origin of a value."""
    source = origin.names.get(name, origin) if isinstance(origin, Origin) else origin
    return f" (from {source})" if source else ""
