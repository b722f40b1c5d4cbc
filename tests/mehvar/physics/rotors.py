# SPDX-License-Identifier: Apache-2.0
"""Wheels off balance as rings of point masses, of which some are taken from one place and put at another.

Momenta and energy are sums over the points; the rest of the craft is one rigid body that has what is left of the mass,
its first moment and its inertia.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from mehvar.physics.gates import dot
from mehvar.physics.machine import Array, Points

RADIUS, HEIGHT = 0.4, 0.3
"""Distance of a wheel's points from its axis and along it, m; no sum depends on them."""


@dataclass(frozen=True)
class Point:
    """A mass of a wheel, shape (n,), and its place from the wheel's centre in body axes, shape (n, 3)."""

    mass: Array
    place: Array


@dataclass(frozen=True)
class Rotors:
    """A craft and its wheels, at n points.

    Attributes
    ----------
    at : Points
        The points.
    inertia : array, shape (n, 3, 3)
        J.
    axes : array, shape (n, 3, wheels)
        Unit axes.
    spin, speeds : array, shape (n, wheels)
        Spin inertias, and speeds relative to the body.
    """

    at: Points
    inertia: Array
    axes: Array
    spin: Array
    speeds: Array

    def momentum(self) -> Array:
        """Return the angular momentum about the centre of mass of all, in body axes."""
        inertia, _, first = self._hub()
        total = np.einsum("nij,nj->ni", inertia, self._rate) + np.cross(first, self._velocity())
        for mass, place, slip in self._masses():
            total += mass[:, None] * np.cross(place, self._velocity() + slip)
        return np.asarray(total)

    def kinetic(self) -> Array:
        """Return the energy beside that of the centre of mass of all."""
        inertia, mass, first = self._hub()
        rate, velocity = self._rate, self._velocity()
        total = dot(rate, np.einsum("nij,nj->ni", inertia, rate)) / 2 + mass * dot(velocity, velocity) / 2
        total += dot(velocity, np.cross(rate, first))
        for mass, _, slip in self._masses():
            total += mass * dot(velocity + slip, velocity + slip) / 2
        return np.asarray(total)

    def about_axes(self) -> tuple[Array, Array]:
        """Return sum m v.(a x rho) of each wheel, the momentum that its motor changes, and sum m v.(a x rho)'."""
        held, carried = np.zeros_like(self.spin), np.zeros_like(self.spin)
        for k in range(self.spin.shape[1]):
            axis, whole = self.axes[:, :, k], self._whole(k)
            for point in self._wheel(k):
                slip = np.cross(self._rate, self._center(k)) + np.cross(whole, point.place)
                turned = np.cross(np.cross(self._rate, axis), point.place) + np.cross(
                    axis, np.cross(whole, point.place)
                )
                held[:, k] += point.mass * dot(self._velocity() + slip, np.cross(axis, point.place))
                carried[:, k] += point.mass * dot(self._velocity() + slip, turned)
        return held, carried

    @property
    def _rate(self) -> Array:
        return self.at.vector("wx", "wy", "wz")

    def _whole(self, k: int) -> Array:
        """Return the rate of a wheel."""
        return self._rate + self.speeds[:, k, None] * self.axes[:, :, k]

    def _center(self, k: int) -> Array:
        return self.at.vector(*(f"wheel_places_{i}_{k + 1}" for i in "123"))

    def _masses(self) -> Iterator[tuple[Array, Array, Array]]:
        """Yield mass, place and velocity of the points of all wheels, beside the body's origin O."""
        for k in range(self.spin.shape[1]):
            center, whole = self._center(k), self._whole(k)
            for point in self._wheel(k):
                yield (
                    point.mass,
                    center + point.place,
                    np.cross(self._rate, center) + np.cross(whole, point.place),
                )

    def _velocity(self) -> Array:
        """Return the velocity of O beside the centre of mass of all: with it the momenta add up to nothing."""
        total = np.cross(self._rate, self._hub()[2])
        for mass, _, slip in self._masses():
            total += mass[:, None] * slip
        return np.asarray(-total / self.at["mass"][:, None])

    def _hub(self) -> tuple[Array, Array, Array]:
        """Return inertia about O, mass and first moment of the craft without its wheels at balance."""
        inertia = self.inertia + np.einsum("nik,nk,njk->nij", self.axes, self.spin, self.axes)
        mass, first = self.at["mass"].copy(), np.zeros((len(self.spin), 3))
        for k in range(self.spin.shape[1]):
            for point in self._ring(k):
                place = self._center(k) + point.place
                square = np.einsum("ni,nj->nij", place, place)
                inertia -= point.mass[:, None, None] * (dot(place, place)[:, None, None] * np.eye(3) - square)
                mass -= point.mass
                first -= point.mass[:, None] * place
        return inertia, mass, first

    def _wheel(self, k: int) -> Iterator[Point]:
        """Yield the ring, and what is moved: from one side to the other, and between corners of a rectangle."""
        yield from self._ring(k)
        angle = self.at[f"angle{k + 1}"]
        heavy = RADIUS * _directed(self.axes[:, :, k], angle)
        tilted = RADIUS * _directed(self.axes[:, :, k], angle + self.at[f"imbalance_phase_{k + 1}"])
        above = HEIGHT * self.axes[:, :, k]
        side = self.at[f"static_imbalance_{k + 1}"] / (2 * RADIUS)
        corner = self.at[f"dynamic_imbalance_{k + 1}"] / (4 * RADIUS * HEIGHT)
        yield from (Point(side, heavy), Point(-side, -heavy))
        yield from (Point(corner, above + tilted), Point(corner, -above - tilted))
        yield from (Point(-corner, above - tilted), Point(-corner, tilted - above))

    def _ring(self, k: int) -> Iterator[Point]:
        for angle in np.arange(4) * np.pi / 2:
            place = _directed(self.axes[:, :, k], np.full(len(self.spin), angle))
            yield Point(self.spin[:, k] / (4 * RADIUS**2), RADIUS * place)


def _directed(axis: Array, angle: Array) -> Array:
    """Return the direction across an axis at an angle: axes x, y, z, or x, -y, -z, turned the short way to the axis."""
    side = np.where(axis[:, 2] >= 0, 1.0, -1.0)
    up = side[:, None] * np.array([0.0, 0.0, 1.0])
    flat = np.column_stack([np.cos(angle), side * np.sin(angle), np.zeros_like(angle)])
    turn, cosine = np.cross(up, axis), dot(up, axis)[:, None]
    return np.asarray(flat + np.cross(turn, flat) + np.cross(turn, np.cross(turn, flat)) / (1 + cosine))
