# SPDX-License-Identifier: Apache-2.0
"""Accelerations of a hub and its parts: sums of what the parts add, each part's equations eliminated first.

The unknowns of the parts are eliminated part by part, which changes the six equations of the hub by matrices of rank
one; these six are solved by a factorisation that keeps structural zeros. The cost is linear in the number of parts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp

from ..derivation import Expr
from .frame import AXES, Frame, cross_matrix
from .part import Contribution, Motion, Row

_LINEAR, _ANGULAR = range(3), range(3, 6)


@dataclass(frozen=True)
class _Pivot:
    """A coordinate solved for the accelerations of the hub: q'' = right - share . (a, W') - later q''."""

    right: Expr
    share: sp.Matrix
    later: tuple[Expr, ...]


@dataclass(frozen=True)
class _Reduced:
    """Rows of a part after elimination: pivots, and what they take from the hub's matrix and right side."""

    pivots: tuple[_Pivot, ...]
    matrices: tuple[tuple[sp.Matrix, sp.Matrix], ...]
    right: sp.Matrix


def accelerations(
    frame: Frame, names: Sequence[str], parts: Sequence[Contribution], unknowns: Sequence[int]
) -> list[Motion]:
    """Solve an assembly.

    Parameters
    ----------
    frame : Frame
        The axes of the hub; receives the steps.
    names : sequence of str
        Of the parts.
    parts : sequence of Contribution
        What each adds.
    unknowns : sequence of int
        Which of a (0 to 2) and W' (3 to 5) are not zero by structure.

    Returns
    -------
    list of Motion
        For each part, with its own accelerations.
    """
    reduced = [_reduced(frame, name, part.rows) for name, part in zip(names, parts, strict=True)]
    matrix, right = _balance(frame, parts, reduced)
    solution = sp.zeros(6, 1)
    values = solve(
        frame,
        matrix.extract(list(unknowns), list(unknowns)),
        [right[k] for k in unknowns],
        [f"{('a', 'alpha')[k // 3]}{AXES[k % 3]}" for k in unknowns],
    )
    for k, value in zip(unknowns, values, strict=True):
        solution[k] = value
    linear, angular = solution[:3, :], solution[3:, :]
    return [
        Motion(linear, angular, _own(frame, name, part.pivots, solution))
        for name, part in zip(names, reduced, strict=True)
    ]


def _reduced(frame: Frame, name: str, rows: Sequence[Row]) -> _Reduced:
    """Eliminate the coordinates of a part, the first of them first."""
    size = len(rows)
    coupling = [list(row.coupling) for row in rows]
    shares = [sp.Matrix([*row.linear, *row.angular]) for row in rows]
    right = [frame.define(f"{name}_Q{i + 1}", row.right, f"{name}: generalised force") for i, row in enumerate(rows)]
    shares = [_named(frame, f"{name}_G{i + 1}", share, f"{name}: coupling to the hub") for i, share in enumerate(shares)]
    pivots, matrices, taken = [], [], sp.zeros(6, 1)
    for i in range(size):
        inverse = frame.define(f"{name}_D{i + 1}", 1 / coupling[i][i], f"{name}: inverse inertia of coordinate {i + 1}")
        scaled = _named(frame, f"{name}_S{i + 1}", inverse * shares[i], f"{name}: share of the hub")
        matrices.append((scaled, shares[i]))
        value = frame.define(f"{name}_q{i + 1}", inverse * right[i], f"{name}: acceleration on a fixed hub")
        taken += shares[i] * value
        later = []
        for j in range(i + 1, size):
            factor = frame.define(f"{name}_L{j + 1}{i + 1}", coupling[j][i] * inverse, f"{name}: factor")
            later.append(factor)
            if factor == 0:
                continue
            for k in range(i + 1, size):
                entry = coupling[j][k] - factor * coupling[i][k]
                coupling[j][k] = frame.define(f"{name}_D{j + 1}{k + 1}_{i + 1}", entry, f"{name}: inertia")
            shares[j] = _named(
                frame, f"{name}_G{j + 1}_{i + 1}", shares[j] - factor * shares[i], f"{name}: coupling to the hub"
            )
            right[j] = frame.define(f"{name}_Q{j + 1}_{i + 1}", right[j] - factor * right[i], f"{name}: force")
        pivots.append(_Pivot(value, scaled, tuple(later)))
    return _Reduced(tuple(pivots), tuple(matrices), taken)


def _named(frame: Frame, name: str, vector: sp.Matrix, title: str) -> sp.Matrix:
    """Name six components."""
    linear = frame.vector(f"{name}t", vector[:3, :], f"{title}, force")
    angular = frame.vector(f"{name}r", vector[3:, :], f"{title}, moment")
    return sp.Matrix([*linear, *angular])


def _balance(frame: Frame, parts: Sequence[Contribution], reduced: Sequence[_Reduced]) -> tuple[sp.Matrix, sp.Matrix]:
    """Return matrix and right side of the equations of the hub."""
    w = frame.rate
    mass = frame.total("total_mass", [p.mass for p in parts], "mass", "kg")
    first = _sum(frame, "total_s", [p.first for p in parts], "first moment about O", "kg m")
    matrix = sp.zeros(6, 6)
    terms: dict[tuple[int, int], list[Expr]] = {}
    for i in range(3):
        terms[i, i] = [mass]
    arm = cross_matrix(first)
    for i in range(3):
        for j in range(3):
            terms.setdefault((i + 3, j), []).append(arm[i, j])
    inertia = sp.zeros(3, 3)
    for i in range(3):
        for j in range(i + 1):
            entry = frame.total(f"total_J{AXES[j]}{AXES[i]}", [p.inertia[i, j] for p in parts], "inertia about O", "kg m^2")
            inertia[i, j] = inertia[j, i] = entry
            terms.setdefault((i + 3, j + 3), []).append(entry)
    outers = [(o.factor * g, g) for p in parts for o in p.outer for g in [sp.Matrix([*o.linear, *o.angular])]]
    outers += [(-scaled, share) for r in reduced for scaled, share in r.matrices]
    for scaled, share in outers:
        for i in range(6):
            for j in range(i + 1):
                terms.setdefault((i, j), []).append(scaled[i] * share[j])
    for (i, j), entries in terms.items():
        matrix[i, j] = frame.total(f"K{i + 1}{j + 1}", entries, "matrix of the hub")
        matrix[j, i] = matrix[i, j]
    momentum = _sum(frame, "total_p", [p.momentum for p in parts], "relative momentum", "kg m/s")
    angular = _sum(frame, "total_h", [p.angular for p in parts], "relative angular momentum about O", "kg m^2/s")
    stream = frame.vector("stream_", w.cross(first) + 2 * momentum, "momentum of rotation, twice the relative one added")
    spin = frame.vector("total_H", inertia * w + angular, "angular momentum about O")
    taken = sum((r.right for r in reduced), sp.zeros(6, 1))
    force = [*(-w.cross(stream)), *(-w.cross(spin))]
    loads = [[*p.force, *p.moment] for p in parts]
    right = [
        frame.define(f"b{k + 1}", sp.Add(force[k], -taken[k], *(load[k] for load in loads)), "right side of the hub")
        for k in range(6)
    ]
    return matrix, sp.Matrix(right)


def _sum(frame: Frame, name: str, vectors: Sequence[sp.Matrix], title: str, unit: str) -> sp.Matrix:
    return sp.Matrix(
        [frame.total(f"{name}{axis}", [v[k] for v in vectors], f"{title}, {axis}", unit) for k, axis in enumerate(AXES)]
    )


def solve(frame: Frame, matrix: sp.Matrix, right: Sequence[Expr], names: Sequence[str]) -> list[Expr]:
    """Solve a symmetric positive definite system by K = L D L', skipping structural zeros."""
    size = len(right)
    rest = matrix.copy()
    lower = sp.zeros(size, size)
    inverse: list[Expr] = []
    values = list(right)
    for j in range(size):
        inverse.append(frame.define(f"i{names[j]}", 1 / rest[j, j], "inverse of a pivot"))
        for i in range(j + 1, size):
            if rest[i, j] != 0:
                lower[i, j] = frame.define(f"l{names[i]}{names[j]}", rest[i, j] * inverse[j], "factor")
        for i in range(j + 1, size):
            if lower[i, j] == 0:
                continue
            for k in range(j + 1, i + 1):
                if rest[k, j] != 0:
                    entry = rest[i, k] - lower[i, j] * rest[k, j]
                    rest[i, k] = frame.define(f"k{names[i]}{names[k]}{j + 1}", entry, "matrix after elimination")
                    rest[k, i] = rest[i, k]
    for i in range(size):
        value = values[i] - sp.Add(*(lower[i, j] * values[j] for j in range(i)))
        values[i] = frame.define(f"y{names[i]}", value, "forward step")
    for i in reversed(range(size)):
        value = values[i] * inverse[i] - sp.Add(*(lower[k, i] * values[k] for k in range(i + 1, size)))
        values[i] = frame.define(names[i], value, "acceleration of the hub")
    return values


def _own(frame: Frame, name: str, pivots: Sequence[_Pivot], solution: sp.Matrix) -> tuple[Expr, ...]:
    """Return the accelerations of a part's coordinates, the last first solved."""
    values: list[Expr] = [sp.S.Zero] * len(pivots)
    for i in reversed(range(len(pivots))):
        pivot = pivots[i]
        later = sp.Add(*(f * values[i + 1 + k] for k, f in enumerate(pivot.later)))
        value = pivot.right - pivot.share.dot(solution) - later
        values[i] = frame.define(f"{name}_a{i + 1}", value, f"{name}: acceleration of coordinate {i + 1}")
    return tuple(values)
