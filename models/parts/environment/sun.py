# SPDX-License-Identifier: Apache-2.0
"""Place of the Sun over the years.

The formulas are the low-precision ones of the Astronomical Almanac, page C5, in axes of the mean equator and equinox of
date. ERFA confirms them to 0.015 degrees from 1950 to 2050. (Vallado, Fundamentals of Astrodynamics, 2013, 5.1.)
"""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, datetime, timedelta

import sympy as sp

from ...derivation import Expr
from ...quantities import TIME, ModelError
from ..part import Mounted

DAY = 86400
_SPAN = 18263 * DAY
SPAN = f"[{-_SPAN}, {_SPAN}]"
"""From 1950 to 2050, s since 2000-01-01 12:00."""
_START = datetime(2000, 1, 1, 12, tzinfo=UTC)


def seconds(text: str) -> float:
    """Return seconds since 2000-01-01 12:00 of a date; without a time zone it is UTC.

    Terrestrial time is a minute ahead, in which the Sun moves by 0.0007 degrees.

    Raises
    ------
    ModelError
        If the text is no date of ISO 8601, or the formulas do not hold then.
    """
    try:
        date = datetime.fromisoformat(text)
    except ValueError:
        raise ModelError(f"orbit: epoch = {text!r}: must be a date such as 2026-11-28 12:00, or a number, s") from None
    result = ((date if date.tzinfo else date.replace(tzinfo=UTC)) - _START).total_seconds()
    if abs(result) > _SPAN:
        raise ModelError(f"orbit: epoch = {text!r}: must be from 1950 to 2050")
    return result


def date(epoch: float) -> str:
    """Return the date, UTC, of seconds since 2000-01-01 12:00, between 1950 and 2050."""
    return (_START + timedelta(seconds=epoch)).replace(tzinfo=None).isoformat(" ")


@dataclass(frozen=True)
class Solar:
    """The Sun as a function of time.

    Parameters
    ----------
    orbit : Mounted
        The orbit, after which its steps are named.
    epoch : Expr
        Start, s since 2000-01-01 12:00.
    """

    orbit: Mounted
    epoch: Expr

    @property
    def direction(self) -> sp.Matrix:
        """Direction to the Sun in inertial axes."""
        days, g, define = self._days, self._anomaly, self.orbit.define
        centre = 1.915 * sp.sin(g) + 0.020 * sp.sin(2 * g)
        longitude = define("sun_lon", _radians(280.460 + 0.9856474 * days + centre), "longitude of the Sun", "rad")
        tilt = define("sun_eps", _radians(23.439 - 4e-7 * days), "obliquity of the ecliptic", "rad")
        return sp.Matrix([sp.cos(longitude), sp.cos(tilt) * sp.sin(longitude), sp.sin(tilt) * sp.sin(longitude)])

    @property
    def distance(self) -> Expr:
        """Distance of the Sun, in astronomical units."""
        g = self._anomaly
        value = 1.00014 - 0.01671 * sp.cos(g) - 0.00014 * sp.cos(2 * g)
        return self.orbit.define("sun_r", value, "distance of the Sun over 1 au", "1")

    @property
    def _days(self) -> Expr:
        age = (self.epoch + TIME.symbol) / self.orbit.values.day
        return self.orbit.define("days", age, "days since 2000-01-01 12:00", "1")

    @property
    def _anomaly(self) -> Expr:
        value = _radians(357.528 + 0.9856003 * self._days)
        return self.orbit.define("sun_g", value, "mean anomaly of the Sun", "rad")


def _radians(degrees: Expr) -> Expr:
    return degrees * sp.pi / 180
