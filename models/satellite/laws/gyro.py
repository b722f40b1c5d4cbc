# SPDX-License-Identifier: Apache-2.0
"""Rate of the gyro minus its bias, which is estimated with the star tracker."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import sympy as sp

from ...mechanics import quaternion_product
from ...system import Derivation, Expr, Group, Quantity

BIAS = tuple(Quantity(f"bias_est_{i}", "rad/s", f"estimated bias of the gyro about {i}", rf"\hat b_{i}") for i in "xyz")
LAST = tuple(
    Quantity(f"q{k}_last", "1", f"component {k} of the attitude one sample ago", f"q_{k}(k-1)") for k in range(4)
)


@dataclass(frozen=True)
class Rate:
    """A rate relative to the orbit axes, and the law's memory for it.

    Attributes
    ----------
    omega : sympy.Matrix
        The rate that the law uses, rad/s.
    memory, start, update : tuple
        Of the filter; empty if the measured rate is used unchanged.
    """

    omega: sp.Matrix
    memory: tuple[Quantity, ...] = ()
    start: tuple[Expr, ...] = ()
    update: tuple[Expr, ...] = ()


def without_bias(omega: Iterable[Expr], q: Sequence[Expr], law: Group, plant: Group, tag: str, d: Derivation) -> Rate:
    """Return the rate minus its bias, the filtered difference between gyro rate and attitude rate.

    Parameters
    ----------
    omega : iterable of Expr
        Measured rate relative to the orbit axes, rad/s.
    q : sequence of Expr
        Measured attitude, a quaternion.
    law, plant : Group
        Parameters.
    tag : str
        End of the names of the steps.
    d : Derivation
        Receives the steps.
    """
    last, bias = (tuple(part.symbol for part in group) for group in (LAST, BIAS))
    turn = quaternion_product((last[0], *(-part for part in last[1:])), tuple(q))
    side = sp.Piecewise((1, turn[0] > 0), (-1, True))
    measured = sp.Matrix(list(omega))
    after = []
    for k, i in enumerate("xyz"):
        shown = d.define(
            f"turned_{i}_{tag}", 2 * side * turn[k + 1] / plant.Ts, "", f"rate about {i} by the star tracker", "rad/s"
        )
        after.append(bias[k] + law.bias_gain * plant.Ts * (measured[k] - shown - bias[k]))
    return Rate(measured - sp.Matrix(bias), (*BIAS, *LAST), (*[sp.S.Zero] * 3, *q), (*after, *q))
