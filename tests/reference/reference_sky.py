# SPDX-License-Identifier: Apache-2.0
"""Field, light, air and Sun of an orbit from their definitions, for CasADi's symbols; no recursion, no closed form."""

from __future__ import annotations

from math import factorial, sqrt

import casadi as ca
import numpy as np
from numpy.polynomial import Legendre, Polynomial

RINGS = 60
"""Points of Gauss on the radius of a disc; the covered share then has an error of 1e-13."""


def potential(place, rows, radius):
    """Return the potential of Gauss coefficients, nT, at a place in axes of the Earth."""
    size = ca.norm_2(place)
    sine, cosine, longitude = place[2] / size, ca.norm_2(place[:2]) / size, ca.atan2(place[1], place[0])
    result = ca.SX(0)
    for n, m, g, h in rows:
        norm = sqrt((2 if m else 1) * factorial(n - m) / factorial(n + m))  # of Schmidt
        legendre = ca.polyval(ca.DM(Legendre.basis(n).deriv(m).convert(kind=Polynomial).coef[::-1]), sine)
        wave = g * ca.cos(m * longitude) + h * ca.sin(m * longitude)
        result += 1e-9 * radius * (radius / size) ** (n + 1) * norm * cosine**m * legendre * wave
    return result


def visible(apart, earth, sun):
    """Return the share of the Sun's disc beside the Earth's: a sum over its rings, of each the arc that is free.

    A ring is cut from the radius |apart - earth| on, where the arc has a root; squares of equidistant steps remove it.
    """
    steps, weights = np.polynomial.legendre.leggauss(RINGS)
    edge = ca.fmin(sun, ca.fabs(apart - earth))
    covered = ca.if_else(apart < earth, np.pi * edge**2, 0)
    for step, weight in zip((steps + 1) / 2, weights / 2, strict=True):
        ring = edge + (sun - edge) * step**2
        cosine = (ring**2 + apart**2 - earth**2) / (2 * ring * apart)
        arc = 2 * ca.acos(ca.fmax(-1, ca.fmin(1, cosine)))
        covered += weight * 2 * step * (sun - edge) * ring * arc
    return 1 - covered / (np.pi * sun**2)


def density(height, rows):
    """Return the density of the air between rows of height and density, whose logarithms lie on lines."""
    heights, densities = np.array(rows, dtype=float).T
    return ca.exp(ca.pw_lin(height, ca.DM(heights), ca.DM(np.log(densities))))


def almanac(days):
    """Return the Sun's distance, au, its longitude and the ecliptic's obliquity (Astronomical Almanac, page C5)."""
    radian = np.pi / 180
    mean, anomaly = radian * (280.460 + 0.9856474 * days), radian * (357.528 + 0.9856003 * days)
    longitude = mean + radian * 1.915 * ca.sin(anomaly) + radian * 0.020 * ca.sin(2 * anomaly)
    distance = 1.00014 - 0.01671 * ca.cos(anomaly) - 0.00014 * ca.cos(2 * anomaly)
    return distance, longitude, radian * (23.439 - 0.0000004 * days)


def station(latitude, height, flattening, radius):
    """Return distance from the Earth's axis and height over the equator, of a place on an ellipsoid.

    It is where the normal has the latitude: the slope of x^2/a^2 + z^2/b^2 points there.
    """
    a, b = radius, radius * (1 - flattening)
    along = np.array([np.cos(latitude), np.sin(latitude)])
    point = along * [a**2, b**2]
    return point / np.sqrt((point**2 / [a**2, b**2]).sum()) + height * along
