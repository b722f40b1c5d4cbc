# SPDX-License-Identifier: Apache-2.0
"""Arguments of the command line: completion of names, and reading of settings NAME=VALUE."""

from __future__ import annotations

import functools
from collections.abc import Iterable, Mapping, Sequence
from typing import Annotated, Any

import typer

from mehvar.base.errors import InputError, bad_value, either, run_checks, unknown_name
from mehvar.base.manifest import WITHOUT_LAW, Manifest, Parameter, Quantity
from mehvar.runtime.arguments import number
from mehvar.runtime.model.catalogue import find_model, list_models
from mehvar.runtime.run.options import OPTIONS
from mehvar.runtime.units import read_value, setting_units


def whole_number(text: str) -> int:
    """Return an integer from the command line; refuse Python's form `1_0`."""
    value = number(str(text))
    if not isinstance(value, int):
        raise typer.BadParameter(f"{text!r} is not a whole number.")
    return value


AsJson = Annotated[bool, typer.Option("--json", help="Print the results as JSON.")]


def complete_models(incomplete: str) -> list[str]:
    """Return the models, of mehvar and the current project, whose names complete a text."""
    return [name for name in list_models() if name.startswith(incomplete)]


def complete_controllers(ctx: typer.Context, incomplete: str) -> list[str]:
    """Return the laws that complete a text, for the model in the command."""
    return _of_model(ctx, "controllers", incomplete)


def complete_scenarios(ctx: typer.Context, incomplete: str) -> list[str]:
    """Return the scenarios that complete a text."""
    return _of_model(ctx, "scenarios", incomplete)


def complete_settings(ctx: typer.Context, incomplete: str) -> list[tuple[str, str]]:
    """Return `NAME=` for all settings of a run: options, choices and parameters."""
    manifest = _manifest(ctx)
    if manifest is None:
        return []
    options = {name: row.text for name, row in OPTIONS.items()} | {
        c.name: c.description for c in manifest.choices.values()
    }
    return _assignments(options | _parameters(ctx, manifest), incomplete)


def complete_varied(ctx: typer.Context, incomplete: str) -> list[tuple[str, str]]:
    """Return `NAME=` for the names that a batch can draw: parameters and states."""
    manifest = _manifest(ctx)
    if manifest is None:
        return []
    return _assignments(_described(manifest.states) | _parameters(ctx, manifest), incomplete)


def complete_inputs(ctx: typer.Context, incomplete: str) -> list[tuple[str, str]]:
    """Return `NAME=` of the inputs of an open loop."""
    manifest = _manifest(ctx)
    return [] if manifest is None else _assignments(_described(manifest.inputs), incomplete)


def _parameters(ctx: typer.Context, manifest: Manifest) -> dict[str, str]:
    """Return the parameters of the law in the command, or of all laws, by name."""
    laws = manifest.controllers
    law = laws.get(ctx.params.get("controller") or "")
    groups = [q.parameters for q in ((law,) if law else laws.values())]
    return _described([q for group in (*groups, manifest.scenario_parameters, manifest.parameters) for q in group])


def _described(quantities: Sequence[Quantity | Parameter]) -> dict[str, str]:
    return {q.name: q.description if q.unit == "1" else f"{q.description} [{q.unit}]" for q in quantities}


def _assignments(texts: Mapping[str, str], incomplete: str) -> list[tuple[str, str]]:
    return [(f"{name}=", text) for name, text in texts.items() if f"{name}=".startswith(incomplete)]


def _of_model(ctx: typer.Context, kind: str, incomplete: str) -> list[str]:
    return [name for name in getattr(_manifest(ctx), kind, ()) if name.startswith(incomplete)]


def _manifest(ctx: typer.Context) -> Manifest | None:
    """Return the manifest of the model in the command; None on errors, because completion shows no messages.

    If the option to complete has no value yet, click leaves the preceding arguments in `ctx.args`.
    """
    try:
        return find_model(ctx.params.get("model") or next(iter(ctx.args), ""))
    except InputError:
        return None


ModelName = Annotated[
    str, typer.Argument(metavar="MODEL", help="A model or a generated folder.", autocompletion=complete_models)
]
Scenario = Annotated[
    str | None,
    typer.Option(metavar="S", help="The scenario; default: the first.", autocompletion=complete_scenarios),
]
EndTime = Annotated[str | None, typer.Option(metavar="T", help=OPTIONS["t_end"].help)]
SettingTexts = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="NAME=VALUE",
        help="Set a parameter or an option; repeat as needed.",
        autocompletion=complete_settings,
    ),
]


def end_time(text: str | None) -> dict[str, Any]:
    """Return --t-end as an option by name; nothing if it is not given."""
    if text is None:
        return {}
    return {"t_end": OPTIONS["t_end"].check(read_value(text, "s", "t_end", "--t-end"), "--t-end")}


def required_law(manifest: Manifest, controller: str | None) -> str:
    """Return the given law, or raise InputError with the names of all laws."""
    if controller is None and not manifest.controllers:
        raise InputError(f"{manifest.model} has no law: {WITHOUT_LAW}")
    if controller is None:
        raise InputError(f"a run of {manifest.model} needs a law: --controller {either(manifest.controllers)}")
    return controller


def check_names(names: Iterable[str], manifest: Manifest) -> None:
    """Refuse names that are neither options nor parameters of any law of a model, in one message."""

    def check(name: str) -> None:
        if name not in known:
            raise unknown_name(f"parameter or option of {manifest.model}", name, known, "--set")

    known = (*setting_units(manifest), *manifest.choices)
    run_checks(*(functools.partial(check, name) for name in names))


def read_settings(texts: Iterable[str] | None, flag: str = "--set", allowed: str = "NAME=VALUE") -> dict[str, str]:
    """Return settings by name; raise InputError for a malformed text or a name given twice.

    Parameters
    ----------
    texts : iterable of str, optional
        NAME=VALUE each.
    flag, allowed : str
        Option that gave them, and their form, for messages.
    """
    settings: dict[str, str] = {}
    for text in texts or ():
        name, value = (part.strip() for part in text.partition("=")[::2])
        if not name or not value:
            raise bad_value(flag, text, allowed)
        if name in settings:
            raise InputError(f"{flag} {name} is given twice")
        settings[name] = value
    return settings


def read_values(texts: Iterable[str] | None, manifest: Manifest) -> dict[str, float | str]:
    """Return the values of `--set` by name, each converted by `read_value`.

    Raises
    ------
    InputError
        If a text is not NAME=VALUE, a name occurs twice, or a unit has the wrong dimension.
    """
    units = setting_units(manifest)
    values: dict[str, float | str] = {}

    def read(name: str, text: str) -> None:
        values[name] = read_value(text, units.get(name), name, "--set")

    run_checks(*(functools.partial(read, name, text) for name, text in read_settings(texts).items()))
    return values
