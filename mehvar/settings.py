# SPDX-License-Identifier: Apache-2.0
"""Settings as a command line takes them: NAME=VALUE."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated

import typer

from mehvar.errors import InputError, bad_value

SettingTexts = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="NAME=VALUE", help="Set a parameter or an option; repeat as needed."),
]


def read_settings(texts: Iterable[str] | None, flag: str = "--set") -> dict[str, str]:
    """Return texts of values by name; raise InputError for a text of another form, or a name that comes twice.

    Parameters
    ----------
    texts : iterable of str, optional
        NAME=VALUE each.
    flag : str
        What they were given with.
    """
    settings: dict[str, str] = {}
    for text in texts or ():
        name, _, value = text.partition("=")
        if not name or not value:
            raise bad_value(flag, text, "NAME=VALUE")
        if name in settings:
            raise InputError(f"{flag} {name} is given twice")
        settings[name] = value
    return settings


def read_values(texts: Iterable[str] | None) -> dict[str, float | str]:
    """Return what `--set` gives, by name: a number where the text is one, for only a command line writes numbers so."""
    return {name: read_value(text) for name, text in read_settings(texts).items()}


def read_value(text: str) -> float | str:
    """Return the number that a text of the command line is, or the text."""
    for kind in (int, float):  # a whole number to its last digit, which a float above 2^53 has lost
        try:
            return kind(text)
        except ValueError:
            continue
    return text
