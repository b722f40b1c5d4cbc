# SPDX-License-Identifier: Apache-2.0
"""SI units of tables and quantities, and their dimensions."""

from __future__ import annotations

import functools
import re
from collections.abc import Iterator, Mapping
from fractions import Fraction

Dimension = Mapping[str, Fraction]
"""Exponents of base units, without zeros."""

UNITS: Mapping[str, Mapping[str, int]] = {
    "kg": {"kg": 1}, "m": {"m": 1}, "s": {"s": 1}, "A": {"A": 1}, "K": {"K": 1}, "mol": {"mol": 1}, "cd": {"cd": 1},
    "1": {}, "rad": {}, "deg": {"deg": 1}, "sr": {},
    "Hz": {"s": -1}, "N": {"kg": 1, "m": 1, "s": -2}, "Pa": {"kg": 1, "m": -1, "s": -2},
    "J": {"kg": 1, "m": 2, "s": -2}, "W": {"kg": 1, "m": 2, "s": -3}, "C": {"A": 1, "s": 1},
    "V": {"kg": 1, "m": 2, "s": -3, "A": -1}, "F": {"kg": -1, "m": -2, "s": 4, "A": 2},
    "Ohm": {"kg": 1, "m": 2, "s": -3, "A": -2}, "S": {"kg": -1, "m": -2, "s": 3, "A": 2},
    "Wb": {"kg": 1, "m": 2, "s": -2, "A": -1}, "T": {"kg": 1, "s": -2, "A": -1},
    "H": {"kg": 1, "m": 2, "s": -2, "A": -2},
}  # fmt: skip
"""Base and derived units of the SI. A radian is a plain number. A degree is a separate base unit, so that sums of
degrees and radians are refused.
"""

_FACTOR = re.compile(r"([A-Za-z]+|1)(?:\^(-?\d+|\(-?\d+(?:/\d+)?\)))?")
_SLASH = re.compile(r"/(?![^()]*\))")
_SUPERSCRIPTS = str.maketrans("+-0123456789", "⁺⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_FORM = "written like 'kg m^2/s', '1/(kg m)' or 'kg^(1/2) m', or '1' for a dimensionless number"


@functools.cache
def dimension(unit: str) -> Dimension:
    """Return the dimension of a unit such as "N m s/rad" or "1/(kg m)".

    Raises
    ------
    ValueError
        If the text is not a unit, or contains a unit outside the SI.
    """
    total: dict[str, Fraction] = {}
    for name, power in _factors(unit):
        for base, exponent in UNITS[name].items():
            total[base] = total.get(base, Fraction()) + exponent * power
    return {base: exponent for base, exponent in total.items() if exponent}


def radians(unit: str) -> Fraction:
    """Return the power of radians in a unit, which dimensions ignore: rad/s and Hz have the same dimension.

    Raises
    ------
    ValueError
        As of `dimension`.
    """
    return sum((power for name, power in _factors(unit) if name == "rad"), Fraction())


def _factors(unit: str) -> Iterator[tuple[str, Fraction]]:
    """Yield the units in the text of a unit with their powers."""
    above, *below = _SLASH.split(unit)
    for part, sign in ((above, 1), *((part, -1) for part in below)):
        inside = part.removeprefix("(").removesuffix(")") if re.fullmatch(r"\([^()]* [^()]*\)", part) else part
        for factor in inside.split(" "):
            match = _FACTOR.fullmatch(factor)
            if match is None:
                raise ValueError(f"unit {unit!r} is not {_FORM}")
            name, power = match.groups()
            if name not in UNITS:
                raise ValueError(f"unit {unit!r} has {name!r}, which is not one of {', '.join(UNITS)}")
            yield name, sign * Fraction((power or "1").strip("()"))


def product(*factors: tuple[Dimension, Fraction | int]) -> Dimension:
    """Return the dimension of a product of powers of units."""
    total: dict[str, Fraction] = {}
    for factor, power in factors:
        for base, exponent in factor.items():
            raised = exponent if power == 1 else exponent * power
            total[base] = total[base] + raised if base in total else raised
    return {base: exponent for base, exponent in total.items() if exponent}


def unit_text(dimension: Dimension) -> str:
    """Return a dimension in base units, as in "kg m^2/s^2"."""
    above = [_power(base, e) for base, e in dimension.items() if e > 0]
    below = [_power(base, -e) for base, e in dimension.items() if e < 0]
    return "/".join((" ".join(above) or "1", *below))


def _power(base: str, exponent: Fraction) -> str:
    if exponent == 1:
        return base
    return f"{base}^{exponent}" if exponent.denominator == 1 else f"{base}^({exponent})"


def pretty_unit(unit: str) -> str:
    """Return a unit with raised exponents."""
    return re.sub(r"\^([+-]?\d+)(?!\.?\d)", lambda match: match[1].translate(_SUPERSCRIPTS), unit)
