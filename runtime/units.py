# SPDX-License-Identifier: Apache-2.0
"""Reader of numbers with units in text, such as `30deg` or `uniform(5ms, 20ms)`."""

from __future__ import annotations

import functools
import re
from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import TYPE_CHECKING

from mehvar.base.errors import bad_value
from mehvar.base.manifest import Manifest
from mehvar.base.units import radians, unit_text

from .arguments import number
from .run.options import OPTIONS

if TYPE_CHECKING:
    from pint import UnitRegistry

_FACTOR = r"(?:°|[^\W\d]+)(?:(?:\^|\*\*)(?:-?\d|\(-?\d(?:/\d)?\)))?"
_NUMBER = r"(?>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)"
"""Pattern of a complete number, in which the `e` of 1e-3 is not the electron's charge."""

_WITH_UNIT = re.compile(rf"([+-]?{_NUMBER})\s*((?:1?/\s*)?{_FACTOR}(?:(?:\s*[*/]\s*|\s+){_FACTOR})*)")
"""Pattern of a number with a unit: products of units with powers of one digit or a fraction, as in s^(1/2). Pint
would evaluate any text, such as 9**9**9."""

_WORD = rf"(?!(?:and|or|not|if|else|in|is)\b){_FACTOR}"
_QUANTITY = re.compile(rf"(?<![\w.])(?P<number>{_NUMBER})\s*(?P<unit>{_WORD}(?:(?:\s*/\s*|\s+){_WORD})*)(?!\w)")
"""Pattern of a number with unit in a formula, where `*` multiplies numbers."""

_BASE = {
    "kilogram": "kg", "meter": "m", "second": "s", "ampere": "A", "kelvin": "K", "mole": "mol", "candela": "cd",
    "radian": "rad",
}  # fmt: skip
"""Pint's names of the SI base units, and of the radian, which counts as one."""

_ARGUMENT = re.compile(rf"(?<=[(\[,=\s])({_WITH_UNIT.pattern})(?=\s*[,)\]])")
_LOCATIONS = ("normal", "uniform", "triangular", "choice", "values", "sphere")
"""Distributions whose arguments have the unit of the drawn value."""


def setting_units(manifest: Manifest) -> dict[str, str]:
    """Return the units of a run's parameters and options."""
    laws = (law.parameters for law in manifest.controllers.values())
    groups = (*laws, manifest.scenario_parameters, manifest.parameters)
    return {name: row.unit for name, row in OPTIONS.items()} | {q.name: q.unit for group in groups for q in group}


def distribution(names: str, text: str, units: Mapping[str, str], origin: str) -> str:
    """Return a distribution's text with units converted to that of the drawn value.

    Parameters
    ----------
    names : str
        Names, separated by commas.
    text : str
        Text such as "uniform(10deg, 20deg)".
    units : mapping of str to str
        By name.
    origin : str
        For the message.

    Raises
    ------
    InputError
        If pint does not know a unit, its dimension is wrong, or the distribution takes no units.
    """
    targets = {units.get(name.strip()) for name in names.split(",")}
    kind = text.partition("(")[0].strip()
    if len(targets) > 1 or kind not in _LOCATIONS or (kind == "normal" and "," in names):
        if kind in (*_LOCATIONS, "lognormal") and _ARGUMENT.search(text):
            reason = "logarithms, covariances and names of different units take none"
            allowed = f"a distribution of numbers without units: {reason}"
            raise bad_value(names, text, allowed, origin)
        return text
    (unit,) = targets
    return _ARGUMENT.sub(lambda match: str(read_value(match[1], unit, names, origin)), text)


def read_value(text: str, unit: str | None = None, name: str = "value", origin: str = "") -> float | str:
    """Return the number in a text of the command line, converted to the unit of its name; other texts unchanged.

    Parameters
    ----------
    text : str
        Text such as "0.5", "30deg" or "5 mN m".
    unit : str, optional
        Unit of the number, if known.
    name, origin : str
        For the message.

    Raises
    ------
    InputError
        If pint does not know a unit, or its dimension is wrong.
    """
    value = number(text)
    if value is not None:
        return value
    parts = _WITH_UNIT.fullmatch(text.strip())
    return _converted(text, parts[1], parts[2], unit, name, origin) if unit and parts else text


def without_units(text: str, quantity: Callable[[float, float, str, str], str], name: str) -> str:
    """Return a formula in which other texts replace numbers with units.

    Parameters
    ----------
    text : str
        As in "T_x < 2 min and final(roll) < 5 deg".
    quantity : callable
        Returns the replacement of a quantity, given number, opposite and unit in SI, and its text. The opposite is
        the number with the other sign before its unit.
    name : str
        For the message.

    Raises
    ------
    InputError
        For a unit that pint does not know.
    """
    return _QUANTITY.sub(lambda match: quantity(*_in_si(match, text, name), match[0]), text)


def _in_si(match: re.Match[str], text: str, name: str) -> tuple[float, float, str]:
    """Return a number, the number with the other sign before its unit, and the unit, in SI."""
    from pint import PintError

    try:
        number = float(match["number"])
        value, opposite = (_units().Quantity(n, match["unit"]).to_base_units() for n in (number, -number))
        powers = {_BASE[base]: Fraction(power).limit_denominator(12) for base, power in value.unit_items()}
    except (PintError, ArithmeticError, AssertionError, KeyError) as error:
        raise bad_value(name, text, f"numbers in known units: {match['unit']!r} is unknown") from error
    return float(value.magnitude), float(opposite.magnitude), unit_text(powers)


def _converted(text: str, number: str, given: str, unit: str, name: str, origin: str) -> float:
    """Return a number in `unit`; unlike pint, which takes angles for numbers, refuse 1 Hz or 1 deg^2 for an angle."""
    from pint import PintError

    units = _units()
    try:
        value = units.Quantity(float(number), f"1{given}" if given.startswith("/") else given)
        converted = float(value.to(unit.replace(" ", "*")).magnitude)
    except (PintError, ArithmeticError, AssertionError) as error:
        allowed = "a number" if unit == "1" else f"a number in {unit}, or with a unit of that kind"
        raise bad_value(name, text, allowed, origin) from error
    power = dict(value.to_base_units().unit_items()).get("radian", 0)
    if radians(unit) not in (0, Fraction(power).limit_denominator(12)):
        raise bad_value(name, text, f"a number in {unit}, or with a unit that has an angle as {unit} has", origin)
    return converted


@functools.cache
def _units() -> UnitRegistry:
    """Return pint's registry of units, loaded at first use because this takes half a second."""
    import pint

    units = pint.UnitRegistry()
    units.define("@alias ohm = Ohm")  # as mehvar's own tables spell it
    return units
