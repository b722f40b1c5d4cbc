# SPDX-License-Identifier: Apache-2.0
"""Intervals of allowed values, as tables and documents write them."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Interval:
    """Allowed values of a parameter, written "(0, inf)" or "[0, 1]" in a table."""

    lower: float
    upper: float
    lower_open: bool
    upper_open: bool

    def __contains__(self, value: float) -> bool:
        return bool(self.allows(value))

    def allows(self, values: Any) -> Any:
        """Return True for allowed values: a number gives a truth value, an array an array."""
        above = values > self.lower if self.lower_open else values >= self.lower
        below = values < self.upper if self.upper_open else values <= self.upper
        return above & below

    def __str__(self) -> str:
        return f"{'(['[not self.lower_open]}{_exact(self.lower)}, {_exact(self.upper)}{')]'[not self.upper_open]}"

    @property
    def positive(self) -> bool:
        """True if every allowed value is above zero."""
        return self.lower > 0 or (self.lower == 0 and self.lower_open)

    def common(self, other: Interval) -> Interval | None:
        """Return the values that both intervals allow; None if these are not several."""
        lower, lower_open = max((self.lower, self.lower_open), (other.lower, other.lower_open))
        upper, closed = min((self.upper, not self.upper_open), (other.upper, not other.upper_open))
        return Interval(lower, upper, lower_open, not closed) if lower < upper else None

    @classmethod
    def parse(cls, text: str) -> Interval:
        """Parse "(0, inf)" or "[0, 1]".

        Raises
        ------
        ValueError
            If the text is not an interval or is empty.
        """
        match = _INTERVAL.match(str(text))
        if not match:
            raise ValueError(f"bounds {text!r} must be an interval such as '(0, inf)' or '[0, 1]'")
        left, lower, upper, right = match.groups()
        try:
            interval = cls(float(lower), float(upper), left == "(", right == ")")
        except ValueError:
            raise ValueError(f"bounds {text!r} must contain two numbers") from None
        if not interval.lower < interval.upper:
            raise ValueError(f"bounds {text!r} are an empty interval: the first must be below the second")
        return interval


def _exact(number: float) -> str:
    """Return a short text that `float` reads as the same number."""
    short = f"{number:g}"
    return short if float(short) == number else repr(number)


_INTERVAL = re.compile(r"^([(\[])\s*([^,\s_]+)\s*,\s*([^,\s_]+)\s*([)\]])$", re.ASCII)
REALS = Interval(-float("inf"), float("inf"), True, True)
"""Every finite number."""
