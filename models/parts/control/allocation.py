# SPDX-License-Identifier: Apache-2.0
"""Allocation of torque or force to actuators by least squares; saturation preserves the direction.

Each column of B holds an actuator's effect on the hub per unit input. The smallest inputs with B u = wanted are B' (B
B')^-1 wanted. Thrusters only push: inputs from the null space of B are added until none is negative. If an input
exceeds its limit, all are scaled down together, which preserves the torque's direction.
"""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp

from ...derivation import Expr
from ...quantities import ModelError
from ..assembly import solve
from ..frame import AXES, ZERO, Frame
from ..hub import Thruster
from ..part import Mounted, Part

Actuators = Sequence[tuple[Part, Mounted]]


def effects(parts: Actuators, centre: sp.Matrix) -> sp.Matrix:
    """Return B, (6, n): force and torque about `centre` on the hub, per unit of each input."""
    columns = [sp.Matrix([*force, *couple]) for part, at in parts for force, couple in _effects(part, at, centre)]
    return sp.Matrix.hstack(*columns) if columns else sp.zeros(6, 0)


def _effects(part: Part, at: Mounted, centre: sp.Matrix) -> list[tuple[sp.Matrix, sp.Matrix]]:
    """Return force and torque about the centre per unit of each input of a part, in hub axes."""
    loads, of = part.mean_loads(at), part.total(at)
    result = []
    for u in (q.symbol for q in part.inputs()):
        force, couple = ZERO, ZERO
        for load in loads:
            force += load.force.diff(u)
            couple += (load.at - centre).cross(load.force.diff(u)) + load.couple.diff(u)
        for coordinate, own in zip(part.coordinates(), of.forces, strict=bool(of.forces)):
            v = coordinate.speed.symbol  # the hub answers a motor: -G/D times its force, on a hub at rest
            share = own.diff(u) / of.energy.diff(v, 2)
            force -= of.momentum.diff(v) * share
            couple -= of.angular.diff(v) * share
        result.append((force, couple))
    return result


def allocated(
    frame: Frame, name: str, wanted: Sequence[Expr], parts: Actuators, matrix: sp.Matrix, limits: Sequence[Expr]
) -> list[Expr]:
    """Return the inputs that produce a demanded force and torque.

    Parameters
    ----------
    frame : Frame
        Receives the steps.
    name : str
        Start of their names.
    wanted : sequence of Expr
        One per row of `matrix`.
    parts : sequence of (Part, Mounted)
        The actuators.
    matrix : sympy.Matrix
        B, which depends only on parameters.
    limits : sequence of Expr
        Limit of each input, which may be infinite.
    """
    rows, size = matrix.shape
    named = sp.Matrix(
        rows, size, lambda i, j: frame.define(f"{name}_B{i + 1}_{j + 1}", matrix[i, j], "effect of an actuator")
    )
    normal = named * named.T
    for i in range(rows):
        for j in range(i + 1):
            entry = frame.define(f"{name}_BB{i + 1}_{j + 1}", normal[i, j], "effect times its transpose")
            normal[i, j] = normal[j, i] = entry
    multipliers = solve(frame, normal, list(wanted), [f"{name}{k + 1}" for k in range(rows)])
    inputs = list(named.T * sp.Matrix(multipliers))
    inputs = [frame.define(f"{name}_u{k + 1}", u, "least input") for k, u in enumerate(inputs)]
    pushes = [isinstance(part, Thruster) for part, _ in parts for _ in part.inputs()]
    if all(pushes):
        inputs = _pushing(frame, name, inputs, named, normal)
    elif any(pushes):
        raise ModelError(f"{name}: thrusters only push; command them and other actuators in separate calls")
    over = [sp.Abs(u) / limit for u, limit in zip(inputs, limits, strict=True) if limit != sp.oo]
    if not over:
        return inputs
    scale = frame.define(f"{name}_over", sp.Max(1, *over), "largest input over its limit, at least 1")
    return [u / scale for u in inputs]


def _pushing(frame: Frame, name: str, inputs: Sequence[Expr], matrix: sp.Matrix, normal: sp.Matrix) -> list[Expr]:
    """Add inputs from the null space of B until no input is negative."""
    rows, size = matrix.shape
    together = matrix * sp.ones(size, 1)
    seen = solve(frame, normal, list(together), [f"{name}_e{k + 1}" for k in range(rows)])
    idle = sp.ones(size, 1) - matrix.T * sp.Matrix(seen)
    free = [frame.define(f"{name}_n{k + 1}", v, "push without effect") for k, v in enumerate(idle)]
    lift = sp.Max(0, *(-u / n for u, n in zip(inputs, free, strict=True)))
    lift = frame.define(f"{name}_lift", lift, "push that makes no input negative")
    return [u + n * lift for u, n in zip(inputs, free, strict=True)]


def check_effects(name: str, matrix: sp.Matrix, parts: Sequence[Part], values: dict[sp.Symbol, float]) -> None:
    """Refuse actuators that cannot produce every demanded direction, at default parameters.

    Raises
    ------
    ModelError
        If their effects are linearly dependent, or all thrusters push into one half space.
    """
    numbers = sp.Matrix(matrix.xreplace(values)).evalf()
    rank = numbers.rank(iszerofunc=lambda v: abs(v) < _DEPENDENT)
    names = ", ".join(part.name for part in parts)
    if rank < matrix.rows:
        what = "torques about" if matrix.rows <= len(AXES) else "forces and torques along"
        raise ModelError(
            f"{name}: {names} produce {what} only {rank} of {matrix.rows} axes: add actuators, or tilt these"
        )
    if all(isinstance(part, Thruster) for part in parts):
        one = sp.ones(matrix.cols, 1)
        idle = one - numbers.T * ((numbers * numbers.T).inv() * (numbers * one))
        if min(idle) <= _DEPENDENT:
            raise ModelError(f"{name}: {names} can only push to one side; add thrusters for the other side")


_DEPENDENT = 1e-9
"""Tolerance of effects of order one: far above rounding, far below an actuator's effect."""
