# SPDX-License-Identifier: Apache-2.0
"""What a command line takes: names of models, laws and scenarios, which complete, and settings NAME=VALUE."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated

import typer

from mehvar.errors import InputError, bad_value
from mehvar.runtime.model.catalogue import find_model, list_models

SettingTexts = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="NAME=VALUE", help="Set a parameter or an option; repeat as needed."),
]

AsJson = Annotated[bool, typer.Option("--json", help="Print the facts as JSON.")]


def complete_models(incomplete: str) -> list[str]:
    """Return the models that a text may become: those of mehvar and of the project that one stands in."""
    return [name for name in list_models() if name.startswith(incomplete)]


def complete_controllers(ctx: typer.Context, incomplete: str) -> list[str]:
    """Return the laws that a text may become, of the model that the command line has so far."""
    return _of_model(ctx, "controllers", incomplete)


def complete_scenarios(ctx: typer.Context, incomplete: str) -> list[str]:
    """Return the scenarios that a text may become."""
    return _of_model(ctx, "scenarios", incomplete)


def _of_model(ctx: typer.Context, kind: str, incomplete: str) -> list[str]:
    try:
        names = getattr(find_model(ctx.params.get("model") or ""), kind)
    except InputError:  # no model yet: a shell that completes shows no messages
        return []
    return [name for name in names if name.startswith(incomplete)]


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
