# SPDX-License-Identifier: Apache-2.0
"""Accelerations of a hub and its parts: elimination of each part's equations, then solution for the hub.

Each part's coordinates are eliminated, which changes the hub's six equations by matrices of rank one. The structure
decides how the remaining equations are solved:

- If the hub's matrix without followers depends only on parameters, the equations are written about the centre of
  mass, where acceleration and rotation decouple. The pulls of a few followers are then the unknowns.
- Otherwise the six equations with the followers' terms are factorised about O or the centre of mass.

The cost is linear in the number of parts.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

import sympy as sp

from ..derivation import Expr
from ..mechanics import cross_matrix
from .frame import AXES, ZERO, Frame, point_inertia
from .motion import Motion, gyroscopic, transport
from .part import Craft, Mounted, Part
from .terms import Contribution, Follower, Load, Moments, Point
from .values import Parameters, directions

MOST_PULLS = 5
"""Largest number of followers for which the pulls are solved; for more, the hub's six equations are cheaper.

Operations that depend on state or input, for bobs on one axis, by pulls and by factors: 579 and 690 for four, 756 and
829 for five, 955 and 968 for six, 1178 and 1107 for seven. Both give the same accelerations.
"""


@dataclass(frozen=True)
class _Pivot:
    """An eliminated coordinate: q'' = right - share . (a, W') - terms of later q''."""

    right: Expr
    share: sp.Matrix
    later: tuple[Expr, ...]


@dataclass(frozen=True)
class _Reduced:
    """A part after elimination.

    Attributes
    ----------
    pivots : tuple of _Pivot
        Its coordinates.
    matrix, right : sympy.Matrix
        Its terms in the hub's matrix (6, 6) and right side (6, 1) about O.
    at : sympy.Matrix
        Point for which the shares of its pivots hold.
    """

    pivots: tuple[_Pivot, ...]
    matrix: sp.Matrix
    right: sp.Matrix
    at: sp.Matrix


@dataclass(frozen=True)
class _Sums(Moments):
    """Sums over all parts, about the hub's origin O.

    Attributes
    ----------
    matrix : sympy.Matrix
        Symmetric (6, 6): terms of the parts in the hub's matrix beside those of a rigid body.
    right : sympy.Matrix
        (6, 1): the same in the right side.
    """

    matrix: sp.Matrix = field(default_factory=lambda: sp.zeros(6, 6))
    right: sp.Matrix = field(default_factory=lambda: sp.zeros(6, 1))


def mount(craft: Craft, parts: Iterable[Part], parameters: Parameters | None = None) -> None:
    """Mount parts on a craft.

    Parameters
    ----------
    craft : Craft
        Receives the parts.
    parts : iterable of Part
        Fields that are expressions are used unchanged.
    parameters : Parameters, optional
        Receives a parameter for each number among the fields.
    """
    frame, parameters = craft.frame, parameters or Parameters()
    values = [(part, part.values(parameters)) for part in parts]
    frame.constants.update(q.symbol for q in parameters.quantities.values())
    frame.derivation.section("Mounts")
    for part, v in values:
        for name in (f for f in directions(part) if getattr(v, f) is not None):
            axis = frame.vector(f"{part.name}_{name}_", getattr(v, name), f"{part.name}: {name}, of length one")
            setattr(v, name, axis)
        craft.parts.append((part, Mounted(part.name, v, craft)))


def contributions(craft: Craft) -> list[Contribution]:
    """Return the terms of each part in the equations of the hub, with external loads."""
    for part, at in craft.parts[len(craft.contributions) :]:
        craft.frame.derivation.section(f"Part {part.name}")
        own = part.contribution(at)
        craft.contributions.append(replace(own, loads=(*own.loads, *part.loads(at))))
    return craft.contributions


@dataclass(frozen=True)
class Balance:
    """Equations K (a, W') = b of the hub, with the terms of its parts.

    Attributes
    ----------
    centre : sympy.Matrix
        Point of the hub, from O, m, with acceleration a; reference point of moments.
    matrix, right : sympy.Matrix
        K and b.
    """

    centre: sp.Matrix
    matrix: sp.Matrix
    right: sp.Matrix


def balance(craft: Craft) -> Balance:
    """Return the hub's equations, from which `moved` computes accelerations."""
    frame, names, parts = craft.frame, [part.name for part, _ in craft.parts], contributions(craft)
    frame.derivation.section("Equations of the hub")
    sums = _sums(frame, parts, [_reduced(frame, name, part) for name, part in zip(names, parts, strict=True)])
    return _with_followers(frame, names, parts, _without_followers(frame, names, parts, sums))


def moved(craft: Craft, loads: Sequence[Load] = (), unknowns: Sequence[int] = range(6)) -> list[Motion]:
    """Solve the equations of a craft for its accelerations.

    With `mount`, a system that declares its own symbols, states and charts can use the accelerations of parts.

    Parameters
    ----------
    craft : Craft
        With its parts.
    loads : sequence of Load
        On the hub, besides those of the parts.
    unknowns : sequence of int
        Indices of the components of a (0 to 2) and W' (3 to 5) that are not structurally zero.

    Returns
    -------
    list of Motion
        For each part, with its own accelerations.
    """
    frame, names, parts = craft.frame, [part.name for part, _ in craft.parts], contributions(craft)
    frame.derivation.section("Accelerations")
    reduced = [_reduced(frame, name, part) for name, part in zip(names, parts, strict=True)]
    sums = _sums(frame, parts, reduced)
    rigid = _without_followers(frame, names, parts, sums)
    rigid = replace(rigid, applied=_wrench(frame, "loads", loads, rigid.centre))
    few = sum(len(part.followers) for part in parts) <= MOST_PULLS
    solve_hub = _by_pulls if rigid.decoupled and few else _by_factors
    motion, pulls = solve_hub(frame, names, parts, rigid, unknowns)
    solution = sp.Matrix([*(ZERO if rigid.decoupled else motion.linear), *motion.angular])
    return [
        Motion(frame, motion.centre, motion.linear, motion.angular, _own(frame, name, part, solution), values)
        for name, part, values in zip(names, reduced, pulls, strict=True)
    ]


def _reduced(frame: Frame, name: str, part: Contribution) -> _Reduced:
    """Eliminate the coordinates of a part one by one."""
    rows, size = part.rows, len(part.rows)
    coupling = [list(row.coupling) for row in rows]
    right = [frame.define(f"{name}_Q{i + 1}", row.right, f"{name}: generalised force") for i, row in enumerate(rows)]
    shares = [
        _named(frame, f"{name}_G{i + 1}", [*row.linear, *row.angular], f"{name}: coupling to the hub")
        for i, row in enumerate(rows)
    ]
    pivots, pairs, right_hub = [], [], sp.zeros(6, 1)
    for i in range(size):
        inverse = frame.define(f"{name}_D{i + 1}", 1 / coupling[i][i], f"{name}: inverse inertia of coordinate {i + 1}")
        scaled = _named(frame, f"{name}_S{i + 1}", inverse * shares[i], f"{name}: share of the hub")
        pairs.append((scaled, shares[i]))
        value = frame.define(f"{name}_q{i + 1}", inverse * right[i], f"{name}: acceleration on a fixed hub")
        right_hub -= scaled * right[i]
        later = []
        for j in range(i + 1, size):
            factor = frame.define(f"{name}_L{j + 1}{i + 1}", coupling[j][i] * inverse, f"{name}: factor")
            later.append(factor)
            if factor == 0:
                continue
            for k in range(i + 1, size):
                entry = coupling[j][k] - factor * coupling[i][k]
                coupling[j][k] = frame.define(f"{name}_D{j + 1}{k + 1}_{i + 1}", entry, f"{name}: inertia")
            entries = shares[j] - factor * shares[i]
            shares[j] = _named(frame, f"{name}_G{j + 1}_{i + 1}", entries, f"{name}: coupling to the hub")
            right[j] = frame.define(f"{name}_Q{j + 1}_{i + 1}", right[j] - factor * right[i], f"{name}: force")
        pivots.append(_Pivot(value, scaled, tuple(later)))
    matrix = sp.Matrix(6, 6, lambda i, j: sp.Add(*(-s[max(i, j)] * g[min(i, j)] for s, g in pairs), part.matrix[i, j]))
    if part.point is None:
        return _Reduced(tuple(pivots), matrix, right_hub, ZERO)
    return _Reduced(tuple(pivots), *_about_hub(frame, name, part.point, matrix, right_hub), part.point.at)


def _about_hub(
    frame: Frame, name: str, point: Point, matrix: sp.Matrix, right: sp.Matrix
) -> tuple[sp.Matrix, sp.Matrix]:
    """Move the terms of a part from its point to O."""
    hat = cross_matrix(point.at)
    mass = frame.tensor(f"{name}_M", matrix[:3, :3] + point.mass * sp.eye(3), f"{name}: mass that the hub moves", "kg")
    mixed = frame.matrix(f"{name}_B", matrix[3:, :3], f"{name}: moment at its point for an acceleration")
    moved = frame.matrix(f"{name}_N", mixed + hat * mass, f"{name}: moment about O for an acceleration")
    turned = matrix[3:, 3:] + hat * mixed.T - moved * hat
    force = frame.vector(f"{name}_f", right[:3, :] + point.force, f"{name}: force on the hub", "N")
    whole = sp.Matrix(sp.BlockMatrix([[mass, moved.T], [moved, turned]]))
    return whole, sp.Matrix([*force, *(right[3:, :] + point.at.cross(force))])


def _named(frame: Frame, name: str, entries: Sequence[Expr], title: str) -> sp.Matrix:
    """Name the six components of a vector."""
    linear = frame.vector(f"{name}t", sp.Matrix(entries[:3]), f"{title}, force")
    angular = frame.vector(f"{name}r", sp.Matrix(entries[3:]), f"{title}, moment")
    return sp.Matrix([*linear, *angular])


def _sums(frame: Frame, parts: Sequence[Contribution], reduced: Sequence[_Reduced]) -> _Sums:
    """Return the sums over all parts about O; an entry of the inertia and its mirror image share a step."""
    inertia = sp.zeros(3, 3)
    for i in range(3):
        for j in range(i + 1):
            entry = frame.total(
                f"total_J{AXES[j]}{AXES[i]}", [p.inertia[i, j] for p in parts], "inertia about O", "kg m^2"
            )
            inertia[i, j] = inertia[j, i] = entry
    matrix = sp.Matrix(6, 6, lambda i, j: sp.Add(*(r.matrix[max(i, j), min(i, j)] for r in reduced)))
    return _Sums(
        frame.total("total_mass", [p.mass for p in parts], "mass", "kg"),
        _sum(frame, "total_s", [p.first for p in parts], "first moment about O", "kg m"),
        inertia,
        _sum(frame, "total_p", [p.momentum for p in parts], "relative momentum", "kg m/s"),
        _sum(frame, "total_h", [p.angular for p in parts], "relative angular momentum about O", "kg m^2/s"),
        matrix,
        sum((r.right for r in reduced), sp.zeros(6, 1)),
    )


def _sum(frame: Frame, name: str, vectors: Sequence[sp.Matrix], title: str, unit: str) -> sp.Matrix:
    return sp.Matrix(
        [frame.total(f"{name}{axis}", [v[k] for v in vectors], f"{title}, {axis}", unit) for k, axis in enumerate(AXES)]
    )


@dataclass(frozen=True)
class _Rigid:
    """Equations of the hub about a point, without followers.

    Attributes
    ----------
    centre : sympy.Matrix
        The point, from O.
    decoupled : bool
        True if the point is a centre of mass fixed in the hub, so that translation and rotation decouple.
    mass : Expr
        kg.
    terms : mapping
        Terms of the matrix by row and column, of the lower triangle.
    right : tuple of Expr
        Force, and moment about the point.
    applied : sympy.Matrix
        The same of loads besides those of the parts.
    """

    centre: sp.Matrix
    decoupled: bool
    mass: Expr
    terms: dict[tuple[int, int], list[Expr]]
    right: sp.Matrix
    applied: sp.Matrix = field(default_factory=lambda: sp.zeros(6, 1))


def _without_followers(frame: Frame, names: Sequence[str], parts: Sequence[Contribution], sums: _Sums) -> _Rigid:
    fixed = all(frame.is_constant(e) for e in (sums.mass, *sums.first, *sums.inertia, *sums.matrix))
    if fixed and sums.matrix[:3, :].is_zero_matrix:
        return _about_centre(frame, names, parts, sums)
    return _about_origin(frame, names, parts, sums)


def _about_centre(frame: Frame, names: Sequence[str], parts: Sequence[Contribution], sums: _Sums) -> _Rigid:
    """Write the equations about a centre of mass that is fixed in the hub."""
    w = frame.rate
    over = frame.define("over_mass", 1 / sums.mass, "inverse mass", "1/kg")
    centre = frame.vector("centre_", over * sums.first, "centre of mass", "m")
    inertia = frame.tensor(
        "central_J", sums.inertia - point_inertia(sums.mass, centre), "inertia about the centre of mass"
    )
    held = frame.tensor("held_J", inertia + sums.matrix[3:, 3:], "inertia about the centre of mass, wheels free")
    angular = sums.angular - centre.cross(sums.momentum)
    right = sp.Matrix([*(-w.cross(2 * sums.momentum)), *(-gyroscopic(frame, inertia, angular) + sums.right[3:, :])])
    for name, part in zip(names, parts, strict=True):
        right += _wrench(frame, name, part.loads, centre)
    terms = {(k, k): [sums.mass] for k in range(3)}
    terms |= {(i + 3, j + 3): [held[i, j]] for i in range(3) for j in range(i + 1)}
    return _Rigid(centre, True, sums.mass, terms, right)


def _wrench(frame: Frame, name: str, loads: Sequence[Load], centre: sp.Matrix) -> sp.Matrix:
    """Return force and moment about a point of the hub."""
    result = sp.zeros(6, 1)
    for k, load in enumerate(loads):
        arm = frame.vector(f"{name}_arm{k}_", load.at - centre, f"{name}: arm of a load", "m")
        result += sp.Matrix([*load.force, *(arm.cross(load.force) + load.couple)])
    return result


def _by_pulls(
    frame: Frame, names: Sequence[str], parts: Sequence[Contribution], rigid: _Rigid, unknowns: Sequence[int]
) -> tuple[Motion, list[tuple[Expr, ...]]]:
    """Solve for the followers' pulls, with equations about the centre of mass of all other parts."""
    over = frame.define("over_mass", 1 / rigid.mass, "inverse mass", "1/kg")
    right = rigid.right + rigid.applied
    force, moment = right[:3, :], frame.vector("moment_", right[3:, :], "moment about the centre of mass", "N m")
    held = sp.Matrix(3, 3, lambda i, j: rigid.terms[max(i, j) + 3, min(i, j) + 3][0])
    inverse = _inverse(frame, held, unknowns)
    keep = [k for k in range(3) if k in unknowns], [k - 3 for k in range(3, 6) if k in unknowns]
    free, without = ("free", " without followers") if any(part.followers for part in parts) else ("hub", "")
    linear, turning = sp.zeros(3, 1), sp.zeros(3, 1)
    for k in keep[0]:
        linear[k] = frame.define(f"{free}_a{AXES[k]}", over * force[k], f"acceleration{without}, {AXES[k]}", "m/s^2")
    for k in keep[1]:
        value, title = inverse.row(k).dot(moment), f"angular acceleration{without}, {AXES[k]}"
        turning[k] = frame.define(f"{free}_alpha{AXES[k]}", value, title, "rad/s^2")
    pulls = _Pulls(frame, names, parts, rigid.centre, inverse, sp.diag(*(int(k in keep[0]) for k in range(3))))
    return pulls.solved(Motion(frame, rigid.centre, linear, turning), rigid.mass)


def _inverse(frame: Frame, inertia: sp.Matrix, unknowns: Sequence[int]) -> sp.Matrix:
    """Return the inverse of a constant inertia in the equations of rotation."""
    keep = [k - 3 for k in unknowns if k > 2]
    block = inertia.extract(keep, keep)
    if block.is_diagonal():
        inverse = sp.diag(*(1 / moment for moment in block.diagonal()))
    else:
        inverse = block.adjugate() / frame.define("held_det", block.det(method="berkowitz"), "its determinant")
    result = sp.zeros(3, 3)
    for i, row in enumerate(keep):
        for j, column in enumerate(keep[: i + 1]):
            value, title = inverse[i, j], f"inverse inertia, {AXES[column]}{AXES[row]}"
            entry = frame.define(f"held_N{AXES[column]}{AXES[row]}", value, title, "1/(kg m^2)")
            result[row, column] = result[column, row] = entry
    return result


class _Pulls:
    """Equations of the followers' pulls over mass: a = a_free - sum P e tau, W' = W'_free - sum N (r x e) m tau.

    P (`moves`) projects on the axes along which the hub can move: all of them, or those of the plane of motion.
    """

    def __init__(
        self, frame: Frame, names: Sequence[str], parts: Sequence[Contribution],
        centre: sp.Matrix, inverse: sp.Matrix, moves: sp.Matrix,
    ) -> None:  # fmt: skip
        self.frame, self.inverse, self.moves = frame, inverse, moves
        self.counts = [len(part.followers) for part in parts]
        named = [(name, k, f) for name, part in zip(names, parts, strict=True) for k, f in enumerate(part.followers)]
        self.names = [f"{name}_{k + 1}" for name, k, _ in named]
        self.followers: list[Follower] = [f for *_, f in named]
        self.arms = [
            frame.vector(f"{name}_r_", f.at - centre, f"{name}: place from the centre of mass", "m")
            for name, f in zip(self.names, self.followers, strict=True)
        ]

    def solved(self, free: Motion, mass: Expr) -> tuple[Motion, list[tuple[Expr, ...]]]:
        """Return the motion with followers, and the pull of each follower."""
        frame, size = self.frame, len(self.followers)
        if not size:
            return free, [() for _ in self.counts]
        levers = [self._lever(i, mass) for i in range(size)]
        matrix, right = sp.zeros(size, size), []
        for i, follower in enumerate(self.followers):
            name, e, arm = self.names[i], follower.along, self.arms[i]
            pivot = free.linear + transport(frame, free.angular, "free_turn_", arm)
            still = frame.define(
                f"{name}_still", follower.pull / follower.mass, f"{name}: acceleration without pull", "m/s^2"
            )
            title = f"{name}: acceleration along it without followers"
            right.append(frame.define(f"{name}_r0", e.dot(pivot) - still, title, "m/s^2"))
            for j in range(i + 1):
                matrix[i, j] = matrix[j, i] = self._entry(i, j, levers[j], mass)
        tau = solve(frame, matrix, right, self.names)
        pulls = [
            frame.vector(f"{name}_pull_", value * f.along, f"{name}: pull over the mass", "m/s^2")
            for name, value, f in zip(self.names, tau, self.followers, strict=True)
        ]
        turned = [lever * pull for lever, pull in zip(levers, pulls, strict=True)]
        pushed = free.linear - self.moves * sum(pulls, ZERO)
        linear = frame.vector("hub_a", pushed, "acceleration of the centre of mass", "m/s^2")
        angular = frame.vector("hub_alpha", free.angular - sum(turned, ZERO), "angular acceleration", "rad/s^2")
        rest = iter(mass * t for t in tau)
        return Motion(frame, free.centre, linear, angular), [tuple(itertools.islice(rest, n)) for n in self.counts]

    def _lever(self, i: int, mass: Expr) -> sp.Matrix:
        """Return m N [r x], the effect on the hub's rotation of a pull divided by its mass."""
        entries = mass * self.inverse * cross_matrix(self.arms[i])
        return self.frame.matrix(f"{self.names[i]}_u", entries, f"{self.names[i]}: turn by a pull", "1/m")

    def _entry(self, i: int, j: int, lever: sp.Matrix, mass: Expr) -> Expr:
        """Return the deceleration of point i along its direction by the pull j."""
        names = f"{self.names[i]}_{self.names[j]}"
        share = cross_matrix(self.arms[i]).T * lever
        share = (share + share.T) / 2 + self.moves - sp.eye(3) if i == j else share + self.moves
        named = self.frame.matrix(f"{names}_c", share, f"{names}: share")
        value = self.followers[i].along.dot(named * self.followers[j].along)
        if i == j:  # a direction has the length one
            title = f"{self.names[i]}: mass over its own, and one"
            value += self.frame.define(f"{self.names[i]}_share", 1 + mass / self.followers[i].mass, title)
        return self.frame.define(f"{names}_A", value, f"{names}: matrix of the pulls")


def _about_origin(frame: Frame, names: Sequence[str], parts: Sequence[Contribution], sums: _Sums) -> _Rigid:
    """Return the equations about O: the entries of the symmetric mass matrix as terms, and the right-hand side."""
    w = frame.rate
    terms: dict[tuple[int, int], list[Expr]] = {}
    arm = cross_matrix(sums.first)
    for i in range(3):
        terms[i, i] = [sums.mass]
        for j in range(3):
            terms.setdefault((i + 3, j), []).append(arm[i, j])
        for j in range(i + 1):
            terms.setdefault((i + 3, j + 3), []).append(sums.inertia[i, j])
    for i in range(6):
        for j in range(i + 1):
            terms.setdefault((i, j), []).append(sums.matrix[i, j])
    stream = frame.vector(
        "stream_", w.cross(sums.first) + 2 * sums.momentum, "momentum of rotation and relative motion"
    )
    right = sp.Matrix([*(-w.cross(stream)), *(-gyroscopic(frame, sums.inertia, sums.angular))]) + sums.right
    for name, part in zip(names, parts, strict=True):
        right += _wrench(frame, name, part.loads, ZERO)
    return _Rigid(ZERO, False, sums.mass, terms, right)


def _with_followers(frame: Frame, names: Sequence[str], parts: Sequence[Contribution], rigid: _Rigid) -> Balance:
    """Add the terms of the followers to the equations of the hub."""
    terms, right = {at: list(of) for at, of in rigid.terms.items()}, rigid.right
    for name, part in zip(names, parts, strict=True):
        for k, follower in enumerate(part.followers):
            label = f"{name}_{k + 1}"
            arm = frame.vector(f"{label}_r_", follower.at - rigid.centre, f"{label}: place from the centre", "m")
            moment = frame.vector(f"{label}_g", arm.cross(follower.along), f"{label}: moment arm", "m")
            row = sp.Matrix([*follower.along, *moment])
            bias = frame.define(
                f"{label}_bias", follower.along.dot(transport(frame, ZERO, "still_turn_", arm)),
                f"{label}: centripetal acceleration along it", "m/s^2",
            )  # fmt: skip
            scaled = _named(frame, f"{label}_m", follower.mass * row, f"{label}: mass times direction")
            still = follower.mass * bias - follower.pull
            pull = frame.define(f"{label}_pull", still, f"{label}: pull without accelerations", "N")
            right -= pull * row
            for i in range(6):
                for j in range(i + 1):
                    terms.setdefault((i, j), []).append(scaled[i] * row[j])
    matrix = sp.zeros(6, 6)
    for (i, j), entries in terms.items():
        matrix[i, j] = matrix[j, i] = frame.total(f"hub_K{i + 1}{j + 1}", entries, "matrix of the hub")
    named = [frame.define(f"hub_b{k + 1}", value, "right side of the hub") for k, value in enumerate(right)]
    return Balance(rigid.centre, matrix, sp.Matrix(named))


def _by_factors(
    frame: Frame, names: Sequence[str], parts: Sequence[Contribution], rigid: _Rigid, unknowns: Sequence[int]
) -> tuple[Motion, list[tuple[Expr, ...]]]:
    """Factorise the six equations of the hub."""
    whole, keep = _with_followers(frame, names, parts, rigid), list(unknowns)
    values = solve(
        frame,
        whole.matrix.extract(keep, keep),
        [whole.right[k] + rigid.applied[k] for k in keep],
        [f"hub_{('a', 'alpha')[k // 3]}{AXES[k % 3]}" for k in keep],
    )
    solution = sp.zeros(6, 1)
    for k, value in zip(keep, values, strict=True):
        solution[k] = value
    motion = Motion(frame, whole.centre, solution[:3, :], solution[3:, :])
    return motion, [
        tuple(
            follower.mass * follower.along.dot(motion.at(follower.at, f"{name}_aP{k or ''}", f"pivot of {name}"))
            - follower.pull
            for k, follower in enumerate(part.followers)
        )
        for name, part in zip(names, parts, strict=True)
    ]


@dataclass(frozen=True)
class Factors:
    """Factors of a symmetric positive definite matrix K = L D L'.

    Attributes
    ----------
    lower : sympy.Matrix
        L without its diagonal of ones; structural zeros stay zero.
    inverse : tuple of Expr
        Inverse of D.
    """

    lower: sp.Matrix
    inverse: tuple[Expr, ...]


def factorise(frame: Frame, matrix: sp.Matrix, names: Sequence[str]) -> Factors:
    """Factorise a symmetric positive definite matrix, skipping structural zeros; `names` are those of its rows."""
    size = matrix.rows
    lower, scaled = sp.zeros(size, size), sp.zeros(size, size)  # L, and L D
    inverse: list[Expr] = []
    for j in range(size):
        for i in range(j, size):
            entry = matrix[i, j] - sp.Add(*(lower[j, k] * scaled[i, k] for k in range(j)))
            scaled[i, j] = frame.define(f"k{names[i]}{names[j]}", entry, "matrix after elimination")
        inverse.append(frame.define(f"i{names[j]}", 1 / scaled[j, j], "inverse of a pivot"))
        for i in range(j + 1, size):
            lower[i, j] = frame.define(f"l{names[i]}{names[j]}", scaled[i, j] * inverse[j], "factor")
    return Factors(lower, tuple(inverse))


def substitute(frame: Frame, factors: Factors, right: Sequence[Expr], names: Sequence[str]) -> list[Expr]:
    """Solve K x = right; `names` are those of x."""
    lower, values, size = factors.lower, list(right), len(right)
    for i in range(size):
        value = values[i] - sp.Add(*(lower[i, j] * values[j] for j in range(i)))
        values[i] = frame.define(f"y{names[i]}", value, "forward step")
    for i in reversed(range(size)):
        value = values[i] * factors.inverse[i] - sp.Add(*(lower[k, i] * values[k] for k in range(i + 1, size)))
        values[i] = frame.define(f"{names[i]}", value, "solution")
    return values


def solve(frame: Frame, matrix: sp.Matrix, right: Sequence[Expr], names: Sequence[str]) -> list[Expr]:
    """Solve a symmetric positive definite system."""
    return substitute(frame, factorise(frame, matrix, names), right, names)


def _own(frame: Frame, name: str, part: _Reduced, solution: sp.Matrix) -> tuple[Expr, ...]:
    """Return the accelerations of a part's coordinates by back substitution."""
    pivots = part.pivots
    if pivots and not part.at.is_zero_matrix:
        here = frame.vector(
            f"{name}_aP",
            solution[:3, :] + solution[3:, :].cross(part.at),
            f"{name}: acceleration of the hub at its point",
        )
        solution = sp.Matrix([*here, *solution[3:, :]])
    values: list[Expr] = [sp.S.Zero] * len(pivots)
    for i in reversed(range(len(pivots))):
        pivot = pivots[i]
        later = sp.Add(*(f * values[i + 1 + k] for k, f in enumerate(pivot.later)))
        value = pivot.right - pivot.share.dot(solution) - later
        values[i] = frame.define(f"{name}_a{i + 1}", value, f"{name}: acceleration of coordinate {i + 1}")
    return tuple(values)
