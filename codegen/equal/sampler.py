# SPDX-License-Identifier: Apache-2.0
"""Drawn values of free names, reproducible and within bounds."""

from __future__ import annotations

import random
from collections.abc import Iterator, Mapping
from fractions import Fraction

_FAR = Fraction(10) ** 32
"""A number above any limit of a model: the square of a double's sixteen digits."""
Point = Mapping[str, Fraction]


class _Drawn(Mapping[str, Fraction]):
    """A point whose coordinates are drawn at first use."""

    def __init__(self, sampler: PointSampler, number: int) -> None:
        self._sampler = sampler
        self._number = number

    def __getitem__(self, name: str) -> Fraction:
        return self._sampler.value(name, self._number)

    def __iter__(self) -> Iterator[str]:
        return iter(self._sampler.names)

    def __len__(self) -> int:
        return len(self._sampler.names)


class PointSampler:
    """Sampler of values of free names, within bounds, around defaults or over many decades.

    Parameters
    ----------
    names : mapping
        For each name: lower bound, upper bound, default; None if missing.
    angles : set of str
        Names of angles.
    """

    def __init__(
        self, names: dict[str, tuple[Fraction | None, Fraction | None, Fraction | None]], angles: frozenset[str]
    ) -> None:
        self.names = names
        self.angles = angles

    def point(self, number: int) -> Point:
        """Return point `number` of a reproducible sequence."""
        return _Drawn(self, number)

    def value(self, name: str, number: int) -> Fraction:
        """Return one coordinate of a point."""
        generator = random.Random(f"{number} {name}")
        low, high, default = self.names.get(name, (None, None, None))
        if low is not None and high is not None:
            if number % 4 == 3:
                return generator.choice((low, high, (low + high) / 2))
            return low + (high - low) * Fraction(generator.randrange(1, 1000), 1000)
        if default and number % 2:
            return self._inside(default * Fraction(generator.randrange(500, 2000), 1000), low, high)
        if name in self.angles:
            return self._inside(Fraction(generator.randrange(-3000, 3000), 1000), low, high)
        decades = (1, 1, 3, 6)[number % 4]
        value = Fraction(f"{10 ** generator.uniform(-decades, decades):.4g}") * generator.choice((1, -1))
        return self._inside(value, low, high)

    def extremes(self, name: str) -> list[Fraction]:
        """Return extreme values of a name within its bounds."""
        low, high, _ = self.names.get(name, (None, None, None))
        return [v for v in (_FAR, -_FAR) if (low is None or v >= low) and (high is None or v <= high)]

    def simple(self, name: str, value: Fraction) -> Iterator[Fraction]:
        """Yield simple replacements of a drawn value, simplest first."""
        low, high, default = self.names.get(name, (None, None, None))
        rounded = Fraction(f"{float(value):.2g}")
        for candidate in (Fraction(0), Fraction(1), Fraction(1, 2), default, rounded):
            if candidate is not None and (low is None or low <= candidate) and (high is None or candidate <= high):
                yield candidate

    @staticmethod
    def _inside(value: Fraction, low: Fraction | None, high: Fraction | None) -> Fraction:
        if low is not None and value < low:
            return low + (low - value)
        if high is not None and value > high:
            return high - (value - high)
        return value
