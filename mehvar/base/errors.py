# SPDX-License-Identifier: Apache-2.0
"""The root of every error, and the words in which a value or a name is refused."""

from __future__ import annotations

import difflib
import re
import reprlib
from collections.abc import Callable, Iterable, Mapping
from pathlib import PurePath

_LONGEST = 200
"""Characters of a value in a message: a few lines of a terminal, and more than any path or condition people type."""


class MehvarError(Exception):
    """Root of every error that mehvar raises on purpose.

    Attributes
    ----------
    exit_status : int
        What the command line ends with: 2 for bad usage or input, 3 when the run itself failed.
    resumable : bool
        True where results so far are kept, and the same command continues from them.
    """

    exit_status = 2
    resumable = False


class InputError(MehvarError, ValueError):
    """A value given by the user is wrong; the message has its name, its origin and the allowed values."""


class MissingError(InputError):
    """A needed compiler, emulator or package is not installed; the message has the install command."""


class FunctionNameError(MehvarError, KeyError):
    """A generated function that a model does not have; the message names those that it has."""

    def __str__(self) -> str:
        return str(self.args[0])  # where KeyError shows the quoted text


class BuildError(MehvarError, RuntimeError):
    """The C compiler failed on a generated file; the message has the command and its output."""

    exit_status = 3


class Origin(str):
    """Origin of values, with exceptions by name.

    Parameters
    ----------
    rest : str
        Origin of every value that `names` does not have; an `Origin` keeps its own names.
    names : mapping of str to str
        Origin of single values.
    """

    names: Mapping[str, str]

    def __new__(cls, rest: str, names: Mapping[str, str]) -> Origin:
        """Return the text `rest`, with the names."""
        origin = super().__new__(cls, rest)
        origin.names = {**(rest.names if isinstance(rest, Origin) else {}), **names}
        return origin

    def __getnewargs__(self) -> tuple[str, Mapping[str, str]]:  # type: ignore[override]  # a text has one argument
        return str(self), self.names


def is_shortage(error: BaseException) -> bool:
    """Return True if an error means a lack of memory; for a thread without memory, Python raises another type."""
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
        What was given.
    allowed : str
        What would have been right, as in "a number > 0".
    origin : str, optional
        Where the value came from, as in "--set" or "scenario paper".
    """
    return InputError(f"{field} = {shown(value)}{whence(origin, field)}: must be {allowed}")


def either(words: Iterable[str]) -> str:
    """Return words joined as in "a, b or c"."""
    *others, last = words
    return f"{', '.join(others)} or {last}" if others else last


def unknown_name(kind: str, name: object, known: Iterable[str], origin: str = "") -> InputError:
    """Return the error for a name that does not exist, with the nearest ones that do.

    Parameters
    ----------
    kind : str
        Its kind and place, as in "parameter", "controller of triangle" or "variable in metric T_theta".
    name : object
        What was given.
    known : iterable of str
        Every name that is allowed.
    origin : str, optional
        Where the name came from.
    """
    names = list(dict.fromkeys(known))
    close = difflib.get_close_matches(name if isinstance(name, str) else shown(name), names, n=3, cutoff=0.6)
    hint = f"did you mean {' or '.join(close)}? " if close else ""
    listed = ", ".join(names) if names else "none"
    noun, place = re.fullmatch(r"(.*?)((?: of | in | under | \().*)?", kind).groups("")  # type: ignore[union-attr]
    return InputError(f"unknown {noun} {shown(name)}{place}{whence(origin)}: {hint}known: {listed}")


def together(*checks: Callable[[], object]) -> None:
    """Run checks, and collect all refusals in one message, a line for each.

    Raises
    ------
    InputError
        If any check raises it; the other checks run anyway.
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


def shown(value: object) -> str:
    """Return a value as a message shows it: on one line, and its middle left out when it is long.

    The `repr` of a long list fills the terminal, and Python refuses to spell out an integer of 5000 digits.
    """
    try:
        text = repr(str(value) if isinstance(value, PurePath) else value)
    except ValueError:
        return f"an integer of {value.bit_length()} bits" if isinstance(value, int) else reprlib.repr(value)
    text = " ".join(text.split())
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST // 2]} ... {text[-_LONGEST // 4 :]}"


_CONTROL = re.compile("[\\x00-\\x08\\x0b-\\x1f\\x7f-\\x9f\\ud800-\\udfff]")
"""Characters that HTML and XML do not allow and terminals take for commands, without line ends and tabs."""


def printable(text: str) -> str:
    """Return an untrusted text with a replacement mark for each control character."""
    return _CONTROL.sub("\N{REPLACEMENT CHARACTER}", text)


def whence(origin: str, name: str = "") -> str:
    """Return the part of a message that names the origin of a value."""
    source = origin.names.get(name, origin) if isinstance(origin, Origin) else origin
    return f" (from {source})" if source else ""
