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

AsJson = Annotated[bool, typer.Option("--json", help="Print the facts as JSON.")]


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
