# SPDX-License-Identifier: Apache-2.0
"""Actuators of the satellite: inputs, limits, and commands of wheels and torquers for a torque."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp

from ..system import Actuator, Derivation, Expr, Group, Quantity
from .wheels import FEWEST, Wheels

COILS = tuple(Quantity(f"coil_{i}", "A m^2", f"dipole of the torquer along {i}", f"m_{{c,{i}}}") for i in "xyz")
coils = sp.Matrix([q.symbol for q in COILS])


@dataclass(frozen=True)
class Drive:
    """Actuators as a law sees them.

    Attributes
    ----------
    wheels : Wheels
        The wheels.
    field : tuple of Expr
        Magnetic field in body axes, measured or known, Wb/m^2; none without torquers.
    """

    wheels: Wheels
    field: tuple[Expr, ...] = ()

    @property
    def inputs(self) -> Group:
        """Inputs of the plant."""
        return Group("u", (*self.wheels.inputs, *(COILS if self.field else ())))

    @property
    def commanded(self) -> Group:
        """Commanded inputs."""
        return self._renamed("u_cmd", "cmd", "commanded", "c")

    @property
    def applied(self) -> Group:
        """Inputs that acted over the last sample."""
        return self._renamed("v", "applied", "applied", "a")

    @property
    def torque(self) -> sp.Matrix:
        """Torque of the wheels' motors on the body over the last sample."""
        return self.wheels.axes * sp.Matrix(self.applied.symbols[: len(self.wheels.labels)])

    @property
    def measured(self) -> tuple[Expr, ...]:
        """Arguments of the commands besides the torque."""
        return (*(self.wheels.momenta if self.field or self._spare else ()), *self.field)

    def commands(self, torque: Sequence[Expr], law: Group) -> tuple[Expr, ...]:
        """Return the inputs that produce a torque on the body and unload the wheels.

        Notes
        -----
        With more than three wheels, `spread_gain` evens out their momenta without a torque on the body. The torquers'
        dipole k (h x B)/|B|^2 exerts the torque -k h without its component along B. The wheels compensate this torque
        and thereby lose momentum.
        """
        motors = self.wheels.pseudoinverse * sp.Matrix(torque)
        if self._spare:
            motors += law.spread_gain * self.wheels.idle * self.wheels.momenta
        return (*motors, *(self._unloading(law) if self.field else ()))

    def torquers_only(self, dipole: Sequence[Expr]) -> tuple[Expr, ...]:
        """Return the inputs that produce a torque with the torquers only."""
        return (*(sp.S.Zero for _ in self.wheels.labels), *dipole)

    def _unloading(self, law: Group) -> sp.Matrix:
        field = sp.Matrix(self.field)
        return law.unload_gain * self.wheels.momentum.cross(field) / field.dot(field)

    @property
    def _spare(self) -> bool:
        return len(self.wheels.labels) > FEWEST

    def _renamed(self, group: str, suffix: str, title: str, mark: str) -> Group:
        renamed = (
            Quantity(f"{q.name}_{suffix}", q.unit, f"{title} {q.description}", f"{q.latex}^{mark}") for q in self.inputs
        )
        return Group(group, tuple(renamed))

    def actuator(self, plant: Group, d: Derivation) -> Actuator:
        """Limit the wheels' momentum at the end of a sample, their torque, and the torquers' dipoles.

        The torque limit comes last, so that no torque exceeds umax. For wheels within hmax, as in every allowed run,
        zero torque fulfils both limits; then both hold in either order.
        """
        d.section("Wheels and sensor")
        wheels, wanted = self.wheels, self.commanded.symbols
        applied = []
        for k, i in enumerate(wheels.labels):
            momentum = wheels.momenta[k]
            lower, upper = (momentum - plant.hmax) / plant.Ts, (momentum + plant.hmax) / plant.Ts
            inside = sp.Max(lower, sp.Min(upper, wanted[k]))
            if wheels.share.free_symbols:
                inside = sp.Piecewise((inside, wheels.share > sp.Rational(1, 2)), (wanted[k], True))
            inside = d.define(f"T{i}_inside", inside, "", f"torque about {i} within hmax", "N m", f"T_{{{i},1}}")
            applied.append(sp.Max(-plant.umax, sp.Min(plant.umax, inside)))
        limited = (sp.Max(-plant.coil_max, sp.Min(plant.coil_max, w)) for w in wanted[len(wheels.labels) :])
        return Actuator(self.commanded, (*applied, *limited))
