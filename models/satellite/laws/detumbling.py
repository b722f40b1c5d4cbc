# SPDX-License-Identifier: Apache-2.0
"""Detumbling with torquers only: the dipole opposes the rate of the measured field (B-dot)."""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp

from ...system import Controller, Derivation, Expr, Group, Quantity
from ..drive import Drive
from ..naming import vector

LAST = tuple(
    Quantity(f"B_last_{i}", "Wb/m^2", f"magnetic field along {i} one sample ago", f"B_{i}(k-1)") for i in "xyz"
)


def b_dot(drive: Drive, first: Sequence[Expr], law: Group, plant: Group, d: Derivation) -> Controller:
    """Return the law m = -k B'/|B|^2, with B' from two samples.

    Parameters
    ----------
    drive : Drive
        The actuators.
    first : sequence of Expr
        Field in body axes at the start, Wb/m^2.
    law, plant : Group
        Parameters.
    d : Derivation
        Receives the steps.

    Notes
    -----
    If the field is nearly constant in inertial axes, B' = -w x B in body axes. Then m x B is -k times the component
    of w normal to B, which is damped. The orbit changes the direction of B, so that in time all components are
    damped.
    """
    d.section("Law b-dot: the torquers against the change of the field")
    field, last = sp.Matrix(drive.field), sp.Matrix([q.symbol for q in LAST])
    dipole = -law.damping * (field - last) / (plant.Ts * field.dot(field))
    named = list(vector("m_*_b_dot", dipole, "dipole along *", "A m^2", "m_*", d))
    return Controller(
        "b-dot",
        "torquers against the change of the field, wheels at rest",
        law,
        drive.torquers_only(named),
        period="Ts",
        memory=Group("z", LAST),
        start=tuple(first),
        update=tuple(field),
    )
