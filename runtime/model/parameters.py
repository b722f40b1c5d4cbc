# SPDX-License-Identifier: Apache-2.0
"""Parameter vectors with values from user, scenario and tables, and the origin of each value."""

from __future__ import annotations

import math
import re
import string
from collections.abc import Collection, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from mehvar.base.errors import InputError, bad_value, run_checks, unknown_name
from mehvar.base.manifest import Controller, Manifest, Parameter, Scenario
from mehvar.base.names import identifier

from .functions import FloatArray, Functions, unmasked


class Setting(NamedTuple):
    """A value and its origin, as in "--set" or "scenario paper"."""

    value: object
    origin: str


@dataclass(frozen=True)
class Resolved:
    """Parameter vectors of one run.

    Parameters
    ----------
    p, c, s : array
        Values of the plant, the law and the scenario, in the manifest's order.
    values : mapping of str to float
        The values by name.
    origins : mapping of str to str
        Origin of each value.
    """

    p: FloatArray
    c: FloatArray
    s: FloatArray
    values: Mapping[str, float]
    origins: Mapping[str, str]


class _Number(float):
    """A float that messages show with six digits."""

    def __format__(self, spec: str) -> str:
        return super().__format__(spec or ".6g")


def number(name: str, value: object, origin: str = "") -> float:
    """Return a value as a finite float, or raise InputError, also for booleans and texts."""
    if type(value) is float and math.isfinite(value):
        return value
    try:
        if isinstance(value, (bool, np.bool_, str, bytes, bytearray)):
            raise TypeError
        result = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError) as error:
        raise bad_value(name, value, "a number", origin) from error
    except OverflowError:
        result = math.inf
    if not math.isfinite(result):
        raise bad_value(name, value, "a finite number", origin)
    return result


def number_above(least: float, name: str, value: object, allowed: str, origin: str = "") -> float:
    """Return a value as a finite float above `least`; for all others InputError says what is allowed."""
    with suppress(InputError):
        if (result := number(name, value)) > least:
            return result
    raise bad_value(name, value, allowed, origin)


def checked(parameter: Parameter, setting: Setting) -> float:
    """Return a parameter's value, or raise InputError if it is out of bounds."""
    value = number(parameter.name, setting.value, setting.origin)
    if not parameter.allows(value):
        raise bad_value(
            parameter.name, value, f"in {parameter.allowed}{_degrees_hint(parameter, value)}", setting.origin
        )
    return value


def vector(parameters: Sequence[Parameter], settings: Mapping[str, Setting]) -> FloatArray:
    """Return parameter values in order: given ones, else defaults.

    Raises
    ------
    InputError
        If a value is missing, not a number or out of bounds.
    """
    return np.array([_value(q, settings) for q in parameters], dtype=np.float64)


def law_vector(functions: Functions, controller: Controller, values: Mapping[str, object]) -> FloatArray:
    """Return the parameter vector c of a law: given values, else defaults or formulas.

    Raises
    ------
    InputError
        For an unknown name, a value that is not a finite number, or one out of bounds.
    """
    settings = given(controller.parameters, values, f"the law {controller.name}")
    return vector(controller.parameters, settings | _formulas(functions, controller, settings))


def given(parameters: Sequence[Parameter], values: Mapping[str, object], owner: str) -> dict[str, Setting]:
    """Return a caller's values by parameter, with arrays split into elements; raise InputError for an unknown name."""
    names = [q.name for q in parameters]
    each = elements(values, names)
    for name in each:
        if name not in names:
            raise unknown_name(f"parameter of {owner}", name, names)
    return {name: Setting(value, "") for name, value in each.items()}


def all_parameters(manifest: Manifest, controller: Controller) -> tuple[Parameter, ...]:
    """Return the parameters of plant, law and scenario."""
    return (*manifest.parameters, *controller.parameters, *manifest.scenario_parameters)


def elements(values: Mapping[str, Any], names: Collection[str], origin: str = "") -> dict[str, Any]:
    """Return values with arrays split into elements: `K_1_2` is in row 1, column 2 of `K`.

    Parameters
    ----------
    values : mapping of str to object
        Numbers by parameter; arrays or nested lists for arrays of parameters.
    names : collection of str
        All parameters. A symmetric matrix has parameters on and above its diagonal.
    origin : str
        Origin of the values.

    Raises
    ------
    InputError
        If an array has the wrong shape, or a value of a symmetric matrix is not symmetric.
    """
    each: dict[str, Any] = {}
    for name, value in values.items():
        own = [other for other in names if re.fullmatch(rf"{re.escape(name)}(_[0-9]+)+", other)]
        if name in names or not own or np.ndim(value) == 0:
            each[name] = value
        else:
            each |= _elements(name, value, own, origin)
    return each


def _elements(name: str, value: Any, own: Collection[str], origin: str) -> dict[str, Any]:
    """Return an array by the names of its elements; of mirrored elements only one is a parameter."""
    numbers = unmasked(value)
    places = np.ndindex(numbers.shape)
    given = {"_".join((name, *(str(k + 1) for k in place))): numbers[place].item() for place in places}
    mirrored = {place: "_".join((name, *reversed(place.removeprefix(f"{name}_").split("_")))) for place in given}
    if not set(own) <= set(given) or any(mirrored[place] not in own for place in set(given) - set(own)):
        raise bad_value(name, value, f"an array with the elements {', '.join(own)}", origin)
    for place, number in given.items():
        if place not in own and number != given[mirrored[place]]:
            raise bad_value(name, value, f"symmetric: {place} and {mirrored[place]} differ", origin)
    return {place: given[place] for place in own}


def named_values(
    quantities: Sequence[str], kind: str, values: Mapping[str, object], origin: str = "", others: Sequence[str] = ()
) -> dict[str, float]:
    """Return finite floats by name, or raise InputError for unknown names; `others` are parameters of the scenario."""
    for name in values:
        if name not in quantities:
            other = next((other for other in (name, f"{name}_0") if other in others), "")
            note = f"{other} is a parameter of the scenario: give it beside initial" if other else ""
            raise unknown_name(kind, name, quantities, origin, note)
    return {name: number(name, value, origin) for name, value in values.items()}


def say(message: str, values: Mapping[str, float]) -> str:
    """Fill the `{name}` placeholders of a manifest's message that have a value."""
    try:
        return message.format_map({name: _Number(value) for name, value in values.items()})
    except (KeyError, ValueError, IndexError):
        return message


def resolve(
    manifest: Manifest,
    functions: Functions,
    controller: Controller,
    scenario: Scenario,
    values: Mapping[str, object],
    origin: str,
    options: Iterable[str] = (),
) -> Resolved:
    """Determine every parameter of a run.

    A user's value has priority, then the scenario's for this law, then the scenario's, then the default or formula. A
    name that two groups share is set in both.

    Parameters
    ----------
    values : mapping of str to object
        The user's values of plant, law and scenario parameters.
    origin : str
        Origin of the user's values in messages, as in "--set".
    options : iterable of str
        Further names that a message about an unknown name may suggest.

    Raises
    ------
    InputError
        If a name is unknown, a value is out of bounds, or a constraint is violated.
    """
    parameters = all_parameters(manifest, controller)
    check_values(manifest, controller, values, origin, options)
    settings = _settings(controller, scenario, values, origin)
    p = vector(manifest.parameters, settings)
    s = vector(manifest.scenario_parameters, settings)
    settings |= _formulas(functions, controller, settings)
    c = vector(controller.parameters, settings)
    resolved = Resolved(
        p=p,
        c=c,
        s=s,
        values={q.name: float(v) for q, v in zip(parameters, np.concatenate([p, c, s]), strict=True)},
        origins={q.name: (settings.get(q.name) or _default(q)).origin for q in parameters},
    )
    _check_constraints(manifest, functions, controller, resolved)
    return resolved


def check_values(
    manifest: Manifest, controller: Controller, values: Mapping[str, object], origin: str, options: Iterable[str] = ()
) -> None:
    """Refuse invalid single values: unknown names, not numbers, out of bounds.

    The arguments are those of `resolve`, which calls this function before it checks constraints.

    Raises
    ------
    InputError
        With a line for each.
    """
    parameters: dict[str, list[Parameter]] = {}
    for q in all_parameters(manifest, controller):
        parameters.setdefault(q.name, []).append(q)

    def check(name: str, value: object) -> None:
        if name not in parameters:
            kind = f"parameter or option of {manifest.model} with {controller.name}"
            state = any(q.name == name for q in manifest.states) and f"{name}_0" not in parameters
            note = f"{name} is a state, whose start follows from parameters of the scenario or, in Python, from initial"
            raise unknown_name(kind, name, [*parameters, *options], origin, note if state else "")
        for q in parameters[name]:
            checked(q, Setting(value, origin))

    run_checks(*(partial(check, name, value) for name, value in values.items()))


def _settings(
    controller: Controller, scenario: Scenario, values: Mapping[str, object], origin: str
) -> dict[str, Setting]:
    """Return values with their origins; the user's have precedence, then the scenario's for this law."""
    law = controller.name
    special = scenario.controllers.get(law, {})
    return {
        **{name: Setting(value, f"scenario {scenario.name}") for name, value in scenario.values.items()},
        **{name: Setting(value, f"scenario {scenario.name}, {law}") for name, value in special.items()},
        **{name: Setting(value, origin) for name, value in values.items()},
    }


def _default(parameter: Parameter) -> Setting:
    if parameter.default is None:
        raise InputError(f"{parameter.name} has no default: set it to a value in {parameter.allowed}")
    return Setting(parameter.default, "default")


def _formulas(functions: Functions, controller: Controller, settings: Mapping[str, Setting]) -> dict[str, Setting]:
    """Return the law parameters whose values follow from formulas.

    Formulas may use each other; each pass evaluates at least one.
    """
    derived = [q for q in controller.parameters if q.formula is not None]
    missing = [q for q in derived if q.name not in settings]
    if not missing:
        return {}
    formulas = functions[f"{identifier(controller.name)}_defaults"]
    results: dict[str, Setting] = {}
    for _ in missing:
        open_names = {q.name for q in missing} - results.keys()
        all_settings = {**settings, **results}
        c = [math.nan if q.name in open_names else _value(q, all_settings) for q in controller.parameters]
        for parameter, value in zip(derived, formulas(np.array(c, dtype=np.float64)), strict=True):
            if parameter in missing and not math.isnan(value):
                results[parameter.name] = Setting(float(value), f"formula {parameter.formula}")
    return results


def _value(parameter: Parameter, settings: Mapping[str, Setting]) -> float:
    return checked(parameter, settings.get(parameter.name) or _default(parameter))


def _check_constraints(manifest: Manifest, functions: Functions, controller: Controller, resolved: Resolved) -> None:
    law = f"{identifier(controller.name)}_constraints"
    if manifest.constraints:
        _check(manifest.constraints, functions["constraints"](resolved.p, resolved.s), resolved)
    if controller.constraints:
        _check(controller.constraints, functions[law](resolved.p, resolved.c, resolved.s), resolved)


def _check(messages: Sequence[str], margins: FloatArray, resolved: Resolved) -> None:
    for message, margin in zip(messages, margins, strict=True):
        if not margin > 0:
            raise InputError(say(message, resolved.values) + _origins(message, resolved))


def advice(functions: Functions, controller: Controller, resolved: Resolved) -> tuple[str, ...]:
    """Return the warnings of a law about accepted but unwise parameters."""
    if not controller.warnings:
        return ()
    margins = functions[f"{identifier(controller.name)}_warnings"](resolved.p, resolved.c, resolved.s)
    messages, place = [], 0
    for warning in controller.warnings:
        margin, *shown = margins[place : place + 1 + warning.shown]
        place += 1 + warning.shown
        if not margin > 0:
            values = {name: _Number(value) for name, value in resolved.values.items()}
            messages.append(warning.message.format(*map(float, shown), **values))
    return tuple(messages)


def _degrees_hint(parameter: Parameter, value: float) -> str:
    """Return a hint if an angle out of bounds would be valid in degrees."""
    radians = math.radians(value)
    return f"; {value:g} degrees are {radians:.6g} rad" if parameter.unit == "rad" and parameter.allows(radians) else ""


def _origins(message: str, resolved: Resolved) -> str:
    """Return the origins of the values in a message."""
    names = [field for _, field, _, _ in string.Formatter().parse(message) if field in resolved.origins]
    text = ", ".join(f"{name} from {resolved.origins[name]}" for name in dict.fromkeys(names) if name)
    return f" ({text})" if text else ""
