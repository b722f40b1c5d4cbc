# SPDX-License-Identifier: Apache-2.0
"""What a command line takes: names of models, laws and scenarios, which complete, and settings NAME=VALUE."""

from __future__ import annotations

import functools
import re
from collections.abc import Iterable
from typing import TYPE_CHECKING, Annotated

import typer

from mehvar.errors import InputError, bad_value, together
from mehvar.manifest import Manifest
from mehvar.runtime.model.catalogue import find_model, list_models
from mehvar.runtime.run.options import OPTIONS, either

if TYPE_CHECKING:
    from pint import UnitRegistry

_FACTOR = r"(?:°|[^\W\d]+)(?:(?:\^|\*\*)-?\d)?"
_WITH_UNIT = re.compile(
    rf"([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*((?:1?/\s*)?{_FACTOR}(?:(?:\s*[*/]\s*|\s+){_FACTOR})*)"
)
"""A number and a product of units with powers of one digit: pint computes what else a text says, such as 9**9**9."""

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


def required_law(manifest: Manifest, controller: str | None) -> str:
    """Return the law that is given, or raise InputError with the names of those that the model has."""
    if controller is None:
        raise InputError(f"a run of {manifest.model} needs a law: --controller {either(manifest.controllers)}")
    return controller


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


def read_values(texts: Iterable[str] | None, manifest: Manifest) -> dict[str, float | str]:
    """Return what `--set` gives a run of a model, by name, each as `read_value` does.

    Raises
    ------
    InputError
        For a text of another form than NAME=VALUE, a name that comes twice, or a unit of another kind.
    """
    units = setting_units(manifest)
    values: dict[str, float | str] = {}

    def read(name: str, text: str) -> None:
        values[name] = read_value(text, units.get(name), name, "--set")

    together(*(functools.partial(read, name, text) for name, text in read_settings(texts).items()))
    return values


def setting_units(manifest: Manifest) -> dict[str, str]:
    """Return the units of what can be set: parameters of plant, laws and scenario, and options of a run."""
    laws = (law.parameters for law in manifest.controllers.values())
    groups = (*laws, manifest.scenario_parameters, manifest.parameters)
    return {name: row.unit for name, row in OPTIONS.items()} | {q.name: q.unit for group in groups for q in group}


def read_value(text: str, unit: str | None = None, name: str = "value", origin: str = "") -> float | str:
    """Return the number that a text of the command line is, in the unit that its name has, or the text.

    Parameters
    ----------
    text : str
        As in "0.5", "30deg" or "5 mN m"; only a command line writes numbers so.
    unit : str, optional
        What a number is in, where that is known.
    name, origin : str
        For the message.

    Raises
    ------
    InputError
        For a unit that pint does not know, or that is of another kind.
    """
    for kind in (int, float):  # a whole number to its last digit, which a float above 2^53 has lost
        try:
            return kind(text)
        except ValueError:
            continue
    parts = _WITH_UNIT.fullmatch(text.strip())
    return _converted(text, parts[1], parts[2], unit, name, origin) if unit and parts else text


def _converted(text: str, number: str, given: str, unit: str, name: str, origin: str) -> float:
    from pint import PintError

    units = _units()
    try:
        value = units.Quantity(float(number), f"1{given}" if given.startswith("/") else given)
        return float(value.to(unit.replace(" ", "*")).magnitude)
    except (PintError, ArithmeticError, AssertionError) as error:
        allowed = "a number" if unit == "1" else f"a number in {unit}, or with a unit of that kind"
        raise bad_value(name, text, allowed, origin) from error


@functools.cache
def _units() -> UnitRegistry:
    """Return pint's units; half a second, for those who write one."""
    import pint

    units = pint.UnitRegistry()
    units.define("@alias ohm = Ohm")  # as mehvar's own tables spell it
    return units
