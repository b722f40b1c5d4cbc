# SPDX-License-Identifier: Apache-2.0
"""The paper's laws, converted to rod forces that track their rod rates, and thrust.

A law of the paper determines the rate of the shape and thereby the rod rates. The forces make the rod rates approach
these exponentially; the model compensates all other effects along the rods (computed forces).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import sympy as sp

from ...derivation import vector
from ...mechanics import QUARTER_TURN
from ...system import Actuator, Controller, Derivation, Expr, Group, Output, Quantity
from ..dynamics import W3, zeta_rate
from .motion import Motion
from .plant import Plant
from .states import FORCES, INPUTS, MOMENTUM, THRUST, rates

_WANTED = tuple(Quantity(f"u_l{k}_wanted", "m/s", f"rate that the law asks of rod {k}", f"u_{k}^*") for k in (1, 2, 3))


def computed_forces(accelerations: Sequence[Expr], plant: Plant, tag: str, d: Derivation) -> tuple[Expr, ...]:
    """Solve the rods' equations of motion for the forces of given accelerations."""
    missing = [wanted - free for wanted, free in zip(accelerations, plant.free, strict=True)]
    title = "acceleration of rod * that forces are to give"
    missing = vector(f"push*_{tag}", missing, title, "m/s^2", "w_*", d, labels="123")
    coupling = plant.coupling
    determinant = d.define(
        f"mobility_{tag}",
        coupling.det(),
        title="determinant of the mobilities; zero for collinear masses",
        latex=r"|B|",
    )
    return tuple((coupling.adjugate() * missing) / determinant)


def _wanted_rates(law: Controller, rod_rates: Sequence[Expr], limit: Expr, d: Derivation) -> tuple[Expr, ...]:
    """Return the rod rates that a law demands, scaled together if one exceeds the limit."""
    tag = law.name
    d.section(f"Forces of the law {tag}")
    command = dict(zip((*zeta_rate, W3.symbol), law.command, strict=True))
    commanded = [rate.xreplace(command) for rate in rod_rates]
    title = "rate that the law asks of rod *"
    commanded = vector(f"rod_rate*_{tag}", commanded, title, "m/s", "u_*", d, "(22)", "123")
    share = d.define(
        f"share_{tag}",
        limit / sp.Max(limit, *(sp.Abs(rate) for rate in commanded)),
        title="part of these rates that keeps every rod within its largest rate: the path in shape stays the same",
        latex="s",
    )
    return tuple(share * rate for rate in commanded)


def with_forces(
    law: Controller,
    rod_rates: Sequence[Expr],
    plant: Plant,
    tracking: Group,
    d: Derivation,
) -> Controller:
    """Convert a law of rates into a law of forces.

    Parameters
    ----------
    law : Controller
        Law that commands the rates of zeta and mu.
    rod_rates : sequence of Expr
        Rod rates as functions of the rates of zeta and mu.
    plant : Plant
        Plant to invert.
    tracking : Group
        Parameters that are added to the law's.
    d : Derivation
        Receives the steps, in a section of their own.
    """
    parameters = Group("c", (*law.parameters.quantities, *tracking.quantities))
    wanted = _wanted_rates(law, rod_rates, parameters.rate_max, d)
    follow = [parameters.k_v * (goal - rate) for goal, rate in zip(wanted, rates, strict=True)]
    push = computed_forces(follow, plant, law.name, d)
    return dataclasses.replace(
        law,
        parameters=parameters,
        command=(*push, *(sp.S.Zero for _ in THRUST)),
        outputs=tuple(Output(q, rate) for q, rate in zip(_WANTED, wanted, strict=True)),
    )


def with_thrust(law: Controller, motion: Motion, plant: Plant, parameters: Group) -> Controller:
    """Add thrusters that compensate the gravity torque and remove angular momentum.

    The thrust m_i J X_i acts like a rigid rotation: it neither moves the centre of mass nor stretches a rod. m_i X_i
    is the sum of m_i m_j/M (X_i - X_j) over its rods, also for rods with mass.
    """
    own = Group("c", (*law.parameters.quantities, *parameters.quantities))
    torque = -own.k_H * MOMENTUM.symbol - plant.torque
    pulled = [mass * rod for mass, rod in zip(motion.bodies.reduced, motion.rods, strict=True)]
    turning = (torque / motion.inertia * QUARTER_TURN * (pulled[i - 2] - pulled[i - 1]) for i in range(3))
    command = (*law.command[: -len(THRUST)], *(force for pair in turning for force in pair))
    return dataclasses.replace(
        law, name="path-thrust", title=f"{law.title}, beside thrust that takes up angular momentum", parameters=own,
        command=command,
    )  # fmt: skip


def limits(p: Group) -> Actuator:
    """Return the commanded inputs with their bounded values."""
    bounds = (*(p.F_max for _ in FORCES), *(p.thrust_max for _ in THRUST))
    commanded = Group(
        "u_cmd", tuple(dataclasses.replace(q, name=f"{q.name}_cmd", latex=f"{q.latex}^*") for q in INPUTS)
    )
    return Actuator(commanded, tuple(sp.Max(-b, sp.Min(b, u)) for b, u in zip(bounds, commanded.symbols, strict=True)))
