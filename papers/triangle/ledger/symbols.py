# SPDX-License-Identifier: Apache-2.0
"""The symbols of the triangle's paper and what the derivation says they mean."""

from __future__ import annotations

from collections.abc import Mapping

import sympy as sp
from sympy import Expr

from mehvar import Derivation, Group, System
from mehvar.ledger import Case, Equation, Names, insert_definitions
from mehvar.mechanics import matrix_rate, planar_cross, time_derivative
from mehvar.models.triangle.dynamics import (
    LENGTHS,
    MU,
    PHI,
    RHO,
    THETA,
    W1,
    W2,
    W3,
    ZETA1,
    ZETA1_RATE,
    ZETA2,
    ZETA2_RATE,
    base_triangle,
    stretch,
)

ROOT3 = sp.sqrt(3)
_QUARTER_TURN = sp.Matrix([[0, -1], [1, 0]])
"""The paper's J."""
EVEN = ((1, 2, 3), (2, 3, 1), (3, 1, 2))
"""Even permutations (i, j, k); the entry for l_k is EVEN[k - 1] read as (k, i, j)."""


class Kinematics:
    """Symbols of section 2: shape and attitude, in the coordinates rho, phi, mu, theta and their rates."""

    def __init__(self, system: System, names: Names) -> None:
        self.rho = names.free(RHO, 0, "7/10")
        self.phi = names.free(PHI, -3, 3)
        self.mu = names.free(MU, "1/20", 2)
        self.theta = names.free(THETA, -3, 3)
        self.w1, self.w2, self.w3 = (names.free(w, -2, 2) for w in (W1, W2, W3))
        self.theta_dot = names.free("theta_dot", -2, 2, latex=r"\dot\theta")
        self.motion = {self.rho: self.w1, self.phi: self.w2, self.mu: self.w3, self.theta: self.theta_dot}
        self._cut = _polar(system)
        self._definitions = system.definitions
        self._masses(names)
        self._matrices(names)
        self._rods(system, names)
        self._momentum(system, names)
        self._table(names)
        self._laws_of_motion(system, names)

    def _follow(self, name: str) -> Expr:
        symbol = next(symbol for symbol in self._definitions if symbol.name == name)
        return insert_definitions(symbol, self._definitions, self._cut)

    def _masses(self, names: Names) -> None:
        """Place the base triangle of three masses from its edges; the centre of mass is the origin."""
        self.m = tuple(names.free(f"m_{i}", "1/10", 4) for i in (1, 2, 3))
        self.m_bar = names.derived("m_bar", r"\bar m", sp.Add(*self.m) / 3, positive=True)
        self.mass, self.m_i = (
            names.free("m_0", "1/10", 4, latex="m", text="m"),
            names.family("m_i", "m_i", positive=True),
        )
        self.equal: Case = dict.fromkeys(self.m, sp.S.One)
        edges = _edges(self.m)
        total = sp.Add(*self.m)
        corners = {i: (self.m[k - 1] * edges[j] - self.m[j - 1] * edges[k]) / total for i, j, k in EVEN}
        self.x = {i: names.matrix(f"x_{i}", f"x_{i}", corners[i]) for i in (1, 2, 3)}
        self.x_i, self.x_j = (names.matrix_family(f"x_{i}", f"x_{i}", 2) for i in "ij")
        self.d_i, self.d_k = (names.matrix_family(f"d_{i}", f"d_{i}", 2) for i in "ik")
        self.d = {k: names.matrix(f"d_{k}", f"d_{k}", edges[k].subs(self.equal)) for k in (1, 2, 3)}
        self.d_row = names.matrix(
            "d_all", r"\begin{bmatrix}d_1 & d_2 & d_3\end{bmatrix}", sp.Matrix.hstack(*self._plain(self.d, names))
        )

    @staticmethod
    def _plain(columns: Mapping[int, Expr], names: Names) -> list[sp.Matrix]:
        return [sp.Matrix(names.meaning(column)) for column in columns.values()]

    def _matrices(self, names: Names) -> None:
        """Q, S, A = QS and the positions X_i = QS x_i, with their rates along a motion."""
        d = Derivation()
        shape = stretch(d).applyfunc(lambda entry: insert_definitions(entry, d.definitions, self._cut))
        turn = sp.cos(self.theta) * sp.eye(2) + sp.sin(self.theta) * _QUARTER_TURN
        self.J = names.matrix("J", "J", _QUARTER_TURN)
        self.I = names.matrix("I_2", "I", sp.eye(2), text="I")
        self.S = names.matrix("S", "S", shape)
        self.S_rate = names.matrix("S_rate", r"\frac{d}{dt}S", matrix_rate(shape, self.motion), text="dS/dt")
        self.S_dot = names.matrix("S_dot", r"\dot S", matrix_rate(shape, self.motion))
        self.Q = names.matrix("Q", "Q", turn)
        corners = self._plain(self.x, names)
        moved = turn * shape
        moved_rate = matrix_rate(moved, self.motion)
        places, rates = ([matrix * corner for corner in corners] for matrix in (moved, moved_rate))
        self.X = {i: names.matrix(f"X_{i}", f"X_{i}", place) for i, place in enumerate(places, 1)}
        self.X_dot = {i: names.matrix(f"X_dot{i}", rf"\dot X_{i}", rate) for i, rate in enumerate(rates, 1)}
        self.X_i, self.X_j = (names.matrix_family(f"X_{i}", f"X_{i}", 2) for i in "ij")
        self.X_dot_i = names.matrix_family("X_dot_i", r"\dot X_i", 2)
        base = sp.Matrix.hstack(corners[1] - corners[0], corners[2] - corners[0])
        placed = sp.Matrix.hstack(places[1] - places[0], places[2] - places[0])
        self.A = names.matrix("A", "A", placed * base.adjugate() / base.det())
        sides = {k: moved * edge for k, edge in enumerate(self._plain(self.d, names), 1)}
        self.D = {k: names.matrix(f"D_{k}", f"D_{k}", side) for k, side in sides.items()}
        self.D_i, self.D_j, self.D_k = (names.matrix_family(f"D_{i}", f"D_{i}", 2) for i in "ijk")
        self.D_row = names.matrix(
            "D_all", r"\begin{bmatrix}D_1 & D_2 & D_3\end{bmatrix}", sp.Matrix.hstack(*sides.values())
        )

    def _rods(self, system: System, names: Names) -> None:
        """Rod lengths (20) and their rates, as the derivation gives them."""
        rate = dict(zip((ZETA1_RATE.symbol, ZETA2_RATE.symbol), _rates(system), strict=True))
        lengths = [self._follow(f"length{k}") for k in (1, 2, 3)]
        rod_rates = [self._follow(f"rod_rate{k}").subs(rate, simultaneous=True) for k in (1, 2, 3)]
        self.l = tuple(
            names.derived(q.name, q.latex, length, positive=True) for q, length in zip(LENGTHS, lengths, strict=True)
        )
        self.u = tuple(names.derived(f"u_{k}", f"u_{k}", rod_rate) for k, rod_rate in enumerate(rod_rates, 1))
        self.l_dot = tuple(
            names.derived(f"l_dot{k}", rf"\dot l_{k}", time_derivative(length, self.motion))
            for k, length in enumerate(lengths, 1)
        )
        self.l_i, self.l_j, self.l_k = (names.family(f"l_{i}", f"l_{i}", positive=True) for i in "ijk")
        self.u_i = names.family("u_i", "u_i")
        # The directions of the base edges, doubled, are the angles of (20).
        base = base_triangle((sp.S.One,) * 3, Derivation())
        angles = [sp.atan2(sine, cosine) for sine, cosine in zip(base.sine, base.cosine, strict=True)]
        self.delta = tuple(
            names.derived(f"Delta_phi{k}", rf"\Delta\varphi_{k}", angle) for k, angle in enumerate(angles, 1)
        )
        self.delta_i = names.family("Delta_phi_i", r"\Delta\varphi_i")

    def _momentum(self, system: System, names: Names) -> None:
        """H from the positions; Ibar and t_s as derived for the equal masses of the system."""
        total = sp.S.Zero
        for m, X, X_dot in zip(self.m, self.X.values(), self.X_dot.values(), strict=True):
            total += m * planar_cross(names.meaning(X), names.meaning(X_dot))
        self.H = names.derived("H", "H", total)
        shown = {step.left: step.expr for step in system.steps if isinstance(step, Equation)}
        rate = dict(zip((ZETA1_RATE.symbol, ZETA2_RATE.symbol), _rates(system), strict=True))
        inertia, shape_term = (
            insert_definitions(shown[left], {}, {**self._cut, **rate}) for left in (r"\bar I", "t_s")
        )
        self.I_bar = names.derived("I_bar", r"\bar I", inertia, positive=True)
        self.t_s = names.derived("t_s", "t^{ss}", shape_term)
        self.I_read = names.free("I_read", "1/10", 4, latex="I", text="I")
        self.t_read = names.free("t_read", -2, 2, latex=r"t^{\ddot S S}", text="t^SS_ddot")

    def _table(self, names: Names) -> None:
        """Symbols of Table 1. What the paper only defines (c_i, p_i) means its definition; S, rho and phi test it."""
        mu_any, open_any = (self._follow(f"{name}_any") for name in ("mu", "open"))
        self.eta = names.derived("eta", r"\eta", open_any * mu_any**2 / 3, positive=True)
        stretched = names.meaning(self.S)
        self.d_0 = names.derived("d_0", "d", stretched.trace() / 2, positive=True, text="d")
        self.c = tuple(names.derived(f"c_{k}", f"c_{k}", self.l[k - 1] ** 2 / (3 * self.d_0)) for k in (1, 2, 3))
        self.c_i = names.family("c_i", "c_i")
        edges = self._plain(self.d, names)
        self.varphi = tuple(
            names.matrix(f"varphi_{k}", rf"\varphi_{k}", 2 * edge * edge.T - sp.eye(2))
            for k, edge in enumerate(edges, 1)
        )
        self.varphi_i = names.matrix_family("varphi_i", r"\varphi_i", 2, 2)
        c1, c2, c3 = (names.meaning(length) ** 2 / (3 * names.meaning(self.d_0)) for length in self.l)
        differences = (c1 - c2, c2 - c3, c3 - c1)
        self.p = tuple(names.derived(f"p_{k}", f"p_{k}", p) for k, p in enumerate(differences, 1))
        self.p_dot = tuple(
            names.derived(f"p_dot{k}", rf"\dot p_{k}", time_derivative(p, self.motion))
            for k, p in enumerate(differences, 1)
        )

    def _laws_of_motion(self, system: System, names: Names) -> None:
        """Take the right-hand side of the system, without momentum and disturbance."""
        still = {system.parameters.H: 0, system.parameters.disturbance: 0}
        self.rates = tuple(expr.subs(still) for expr in system.rhs)
        self.rho_dot, self.phi_dot, self.mu_dot = (
            names.derived(name, latex, rate)
            for name, latex, rate in zip(
                ("rho_dot", "phi_dot", "mu_dot"), (r"\dot\rho", r"\dot\varphi", r"\dot\mu"), self.rates[:3], strict=True
            )
        )
        self.still: Case = {self.theta_dot: self.rates[3]}


def _polar(system: System) -> dict[Expr, Expr]:
    """Our regular coordinates in the paper's, and the rods of the triangle that is placed as those of this one."""
    assert system.coordinates is not None
    cut = dict(zip((ZETA1.symbol, ZETA2.symbol), system.coordinates.from_state, strict=False))
    lengths = {q.symbol: f"length{k}" for k, q in enumerate(LENGTHS, 1)}
    definitions = system.definitions
    named = {symbol.name: symbol for symbol in definitions}
    return cut | {symbol: insert_definitions(named[name], definitions, cut) for symbol, name in lengths.items()}


def _rates(system: System) -> tuple[Expr, ...]:
    assert system.coordinates is not None
    return system.coordinates.from_input[:2]


def _edges(masses: tuple[Expr, ...]) -> dict[int, sp.Matrix]:
    """Edges d_k of the base triangle: its angles are acute, so edge 1 points up and left, edge 2 down and left."""
    d = Derivation()
    base = base_triangle(masses, d)
    edges = {}
    for k, (right, up) in enumerate(((-1, 1), (-1, -1), (1, 0)), 1):
        length, cosine = (
            insert_definitions(values[k - 1], d.definitions) for values in (base.length_squared, base.cosine)
        )
        across = up * sp.sqrt((1 - cosine) / 2) if up else sp.S.Zero
        along = right * sp.sqrt((1 + cosine) / 2)
        edges[k] = sp.sqrt(length) * sp.Matrix([along, across])
    return edges


def parameters(groups: tuple[Group, ...]) -> dict[str, sp.Symbol]:
    """Return the symbols of parameter groups by name."""
    return {quantity.name: quantity.symbol for group in groups for quantity in group}
