# SPDX-License-Identifier: Apache-2.0
"""The paper's laws as references of rod rates, the forces that make the rods follow, and thrust beside them.

A law of the paper says how the shape is to change, and with it at which rates the rods are to move. The forces make the
rods' rates approach those exponentially, with all that acts along the rods taken off by the model: computed forces.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence

import sympy as sp

from ...mechanics import QUARTER_TURN
from ...system import Controller, Derivation, Expr, Group, Output, Quantity
from ..dynamics import W3, zeta_rate
from .motion import Motion
from .plant import Plant
from .states import FORCES, INPUTS, MOMENTUM, THRUST, rates

_WANTED = tuple(Quantity(f"u_l{k}_wanted", "m/s", f"rate that the law asks of rod {k}", f"u_{k}^*") for k in (1, 2, 3))


def computed_forces(accelerations: Sequence[Expr], plant: Plant, tag: str, d: Derivation) -> tuple[Expr, ...]:
    """Solve the rods' equations of motion for the forces that give them accelerations."""
    missing = sp.Matrix(
        [
            d.define(
                f"push{k}_{tag}",
                wanted - free,
                title=f"acceleration of rod {k} that forces are to give",
                unit="m/s^2",
                latex=rf"w_{k}",
            )
            for k, (wanted, free) in enumerate(zip(accelerations, plant.free, strict=True), 1)
        ]
    )
    coupling = plant.coupling
    determinant = d.define(
        f"mobility_{tag}",
        coupling.det(),
        title="determinant of the mobilities; zero for collinear masses",
        latex=r"|B|",
    )
    return tuple((coupling.adjugate() * missing) / determinant)


def with_forces(
    law: Controller,
    rod_rates: Sequence[Expr],
    plant: Plant,
    tracking: Group,
    d: Derivation,
) -> Controller:
    """Turn a law of rates into one of forces.

    Parameters
    ----------
    law : Controller
        Whose command are the rates of zeta and mu.
    rod_rates : sequence of Expr
        Rates of the rods as a function of those.
    plant : Plant
        What is inverted.
    tracking : Group
        Parameters that are added to the law's.
    d : Derivation
        Receives the steps, in a section of their own.
    """
    tag = law.name
    d.section(f"Forces of the law {tag}")
    command = dict(zip((*zeta_rate, W3.symbol), law.command, strict=True))
    asked = [
        d.define(
            f"rod_rate{k}_{tag}",
            rate.xreplace(command),
            "(22)",
            f"rate that the law asks of rod {k}",
            "m/s",
            f"u_{k}",
        )
        for k, rate in enumerate(rod_rates, 1)
    ]
    parameters = Group("c", (*law.parameters.quantities, *tracking.quantities))
    limit = parameters.rate_max
    share = d.define(
        f"share_{tag}",
        limit / sp.Max(limit, *(sp.Abs(rate) for rate in asked)),
        title="part of these rates that keeps every rod within its largest rate: the path in shape stays the same",
        latex="s",
    )
    wanted = [share * rate for rate in asked]
    follow = [parameters.k_v * (goal - rate) for goal, rate in zip(wanted, rates, strict=True)]
    push = computed_forces(follow, plant, tag, d)
    return dataclasses.replace(
        law,
        parameters=parameters,
        command=(*push, *(sp.S.Zero for _ in THRUST)),
        outputs=tuple(Output(q, rate) for q, rate in zip(_WANTED, wanted, strict=True)),
    )


def with_thrust(law: Controller, motion: Motion, plant: Plant, parameters: Group) -> Controller:
    """Let thrusters take up the torque of gravity and angular momentum beside the rods.

    The thrust m_i J X_i is that of a rigid turn: it pushes the centre of mass nowhere and no rod along itself.
    """
    own = Group("c", (*law.parameters.quantities, *parameters.quantities))
    torque = -own.k_H * MOMENTUM.symbol - plant.torque
    turning = (
        torque / motion.inertia * mass * QUARTER_TURN * place
        for mass, place in zip(motion.masses, motion.places, strict=True)
    )
    command = (*law.command[: len(FORCES)], *(force for pair in turning for force in pair))
    return dataclasses.replace(
        law, name="path-thrust", title=f"{law.title}, beside thrust that takes up angular momentum", parameters=own,
        command=command,
    )  # fmt: skip


def limits(p: Group) -> tuple[Group, tuple[Expr, ...]]:
    """Return the commanded inputs, and what rods and thrusters make of them."""
    commanded = Group(
        "u_cmd",
        tuple(dataclasses.replace(q, name=f"{q.name}_cmd", latex=f"{q.latex}^*") for q in INPUTS),
    )
    bounds: Mapping[str, Expr] = {"F": p.F_max, "f": p.thrust_max}
    applied = tuple(
        sp.Max(-bounds[q.name[0]], sp.Min(bounds[q.name[0]], force.symbol))
        for q, force in zip(INPUTS, commanded, strict=True)
    )
    return commanded, applied
