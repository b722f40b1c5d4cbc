# SPDX-License-Identifier: Apache-2.0
"""Bodies with mass: three points, optionally with rods.

The velocity of a uniform, evenly stretched rod is linear from end to end. Its kinetic energy is m (v_i.v_i + v_i.v_j
+ v_j.v_j)/6, which equals that of half its mass at each end minus m |v_j - v_i|^2/12. About the centre of mass, sums
over bodies are therefore sums over rods with mu_ij = m_i m_j/M - m/6. Three point masses have the same mu_ij: each is
the sum of products of the mu, divided by the opposite mu. A triangle of rods with mass therefore moves like one of
point masses, and the paper's kinematics hold.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp

from ...derivation import vector
from ...system import Condition, Derivation, Expr, Group

ENDS = ((1, 2), (2, 0), (0, 1))
"""Masses at the ends of rod k: D_k = X_j - X_i (14), counted from zero."""


@dataclass(frozen=True)
class Bodies:
    """Point masses that are equivalent to the triangle with its rods.

    Attributes
    ----------
    masses : tuple of Expr
        Masses of three points that move like the triangle about its centre.
    lumps : tuple of Expr
        Mass at each corner with half of its rods, which give the triangle's centre of mass.
    reduced : tuple of Expr
        mu_ij of the ends of rod k: sums over bodies about their centre are sums over rods with these.
    """

    masses: tuple[Expr, ...]
    lumps: tuple[Expr, ...]
    reduced: tuple[Expr, ...]

    @property
    def total(self) -> Expr:
        """Total mass."""
        return sp.Add(*self.lumps)


def bodies(p: Group, masses: str, rods: str, d: Derivation) -> Bodies:
    """Return the equivalent point masses.

    Parameters
    ----------
    p : Group
        The plant's parameters.
    masses : {"equal", "general"}
        One mass for all three, or m1, m2, m3; likewise for the rods.
    rods : {"light", "uniform"}
        Without mass or with.
    d : Derivation
        Receives the steps.
    """
    d.section("Bodies")
    points = (p.mass,) * 3 if masses == "equal" else (p.m1, p.m2, p.m3)
    if rods == "light":
        return Bodies(points, points, _reduced(points, (sp.S.Zero,) * 3, d))
    beams = (p.rod_mass,) * 3 if masses == "equal" else (p.rod_mass1, p.rod_mass2, p.rod_mass3)
    if masses == "equal":
        lumps = (points[0] + beams[0],) * 3
        return Bodies((points[0] + beams[0] / 2,) * 3, lumps, _reduced(lumps, beams, d))
    whole = _with_rods(points, beams)
    title = "mass at corner * with half of its rods"
    lumps = tuple(vector("lump*", whole, title, "kg", r"\tilde m_*", d, labels="123", positive=True))
    reduced = _reduced(lumps, beams, d)
    a, b, c = reduced
    pairs = d.define(
        "pairs", a * b + b * c + c * a, title="sum of the products of two reduced masses", latex=r"q", positive=True
    )
    alike, title = [pairs / mass for mass in reduced], "mass * of the points that move as the triangle does"
    points = tuple(vector("point*", alike, title, "kg", r"\hat m_*", d, labels="123", positive=True))
    return Bodies(points, lumps, reduced)


def _with_rods(points: Sequence[Expr], beams: Sequence[Expr]) -> list[Expr]:
    """Return the mass at each corner with half of its rods."""
    return [points[i] + (beams[(i + 1) % 3] + beams[(i + 2) % 3]) / 2 for i in range(3)]


def _reduced(lumps: Sequence[Expr], beams: Sequence[Expr], d: Derivation) -> tuple[Expr, ...]:
    """Return mu_ij of the ends of each rod, in kg; `lumps` include half of the rods, `beams` are the rods."""
    total = sp.Add(*lumps)
    return tuple(
        d.define(
            f"reduced{k}",
            lumps[i] * lumps[j] / total - beams[k - 1] / 6,
            title=f"reduced mass of the ends of rod {k}",
            unit="kg",
            latex=rf"\mu_{{{i + 1}{j + 1}}}",
            positive=True,
        )
        for k, (i, j) in enumerate(ENDS, 1)
    )


def not_too_heavy(p: Group) -> Condition:
    """Return the conditions that the equivalent point masses are positive."""
    points, beams = (p.m1, p.m2, p.m3), (p.rod_mass1, p.rod_mass2, p.rod_mass3)
    lumps = _with_rods(points, beams)
    margins = [6 * lumps[i] * lumps[j] - beams[k] * sp.Add(*lumps) for k, (i, j) in enumerate(ENDS)]
    return Condition(
        sp.Min(*margins),
        "rods of {rod_mass1:g}, {rod_mass2:g}, {rod_mass3:g} kg with masses of {m1:g}, {m2:g}, {m3:g} kg: one is "
        "heavier than six times the reduced mass of its ends, each with half of its rods",
    )
