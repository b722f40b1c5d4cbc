# SPDX-License-Identifier: Apache-2.0
"""The symbols of sections 3 to 5 of the triangle's paper, in the shifted coordinates, and what the derivation says."""

from __future__ import annotations

import sympy as sp
from sympy import Expr

from mehvar import Controller, Parameter, System
from mehvar.ledger import Case, Names, insert_definitions
from mehvar.mechanics import time_derivative
from mehvar.models.triangle.controllers import arc_area
from mehvar.models.triangle.dynamics import ZETA1, ZETA2

from .symbols import Kinematics


class Shifted:
    """Symbols of the shifted coordinates, (24)-(28): distance and direction of the target, shifted attitude.

    Most equations take them as coordinates of their own. `chart` gives them their meaning in rho, phi, theta.
    """

    def __init__(self, system: System, names: Names, k: Kinematics) -> None:
        reference = {q.name: q for q in system.references}
        self.a = names.free(reference["rho_ref"], 0, "3/5", latex="a", text="a")
        self.phi_f = names.free(reference["phi_ref"], -3, 3, text="phi_f")
        self.mu_f = names.free(reference["mu_ref"], "1/20", 2, text="mu_f")
        self.theta_f = names.free(reference["theta_ref"], -3, 3, text="theta_f")
        self.rho = names.free("rho_t", "1/20", "6/5", latex=r"\tilde\rho")
        self.phi = names.free("phi_t", -3, 3, latex=r"\tilde\varphi")
        self.theta = names.free("theta_t", -3, 3, latex=r"\tilde\theta")
        self.rho_dot = names.free("rho_t_dot", -2, 2, latex=r"\dot{\tilde\rho}")
        self.phi_dot = names.free("phi_t_dot", -2, 2, latex=r"\dot{\tilde\varphi}")
        # (26), which is checked in the chart.
        self.theta_dot = names.derived("theta_t_dot", r"\dot{\tilde\theta}", self.rho**2 * self.phi_dot)
        self.v1, self.v2 = names.family("v_1", "v_1"), names.free("v_2", -2, 2)
        self.start = tuple(
            names.family(f"{name}_0", f"{latex}_0")
            for name, latex in (
                ("rho_t", r"\tilde\rho"),
                ("phi_t", r"\tilde\varphi"),
                ("theta_t", r"\tilde\theta"),
                ("theta", r"\theta"),
            )
        )
        self.motion = {self.rho: self.rho_dot, self.phi: self.phi_dot, self.theta: self.rho**2 * self.phi_dot}
        self.chart = self._chart(system, k)

    def _chart(self, system: System, k: Kinematics) -> Case:
        """Give the shifted coordinates and their rates as functions of the coordinates before the shift."""
        assert system.coordinates is not None
        cut = dict(zip((ZETA1.symbol, ZETA2.symbol), system.coordinates.from_state, strict=False))
        definitions = system.definitions
        along, across, rho, theta = (
            insert_definitions(next(s for s in definitions if s.name == name), definitions, cut)
            for name in ("w_along", "w_across", "rho_t", "theta_exact")
        )
        phi = sp.atan2(across, along)
        motion = {k.rho: k.w1, k.phi: k.w2, k.theta: k.rates[3]}
        rates = [time_derivative(expr, motion) for expr in (rho, phi, theta)]
        return {
            self.rho: rho,
            self.phi: phi,
            self.theta: theta,
            self.rho_dot: rates[0],
            self.phi_dot: rates[1],
            self.theta_dot: rates[2],
            self.v1: rates[0],
            self.v2: rates[1],
            **dict(zip(self.start, (rho, phi, theta, k.theta), strict=True)),
        }


class Sliding:
    """Symbols of the first design, (28)-(39)."""

    def __init__(self, system: System, names: Names, t: Shifted) -> None:
        self.law = law_of(system, "sliding")
        p = {q.name: q for q in self.law.parameters}
        self.R = names.free(p["R"], "13/20", "7/10")
        self.R_run = default(self.law, "R")
        self.m = names.free(p["m"], 2, 5)
        self.k_phi = names.free(p["k_phi"], "1/10", 5)
        self.eta = names.free(p["eta_rho"], 0, 2)
        self.theta_star = names.free(p["theta_star"], 4, 6)
        self.s_min = names.free(p["s_min"], "1/100", "1/10")
        self.theta_min = names.free(p["theta_min"], "1/1000", "1/100")
        cut = shifted_cut(system, t)

        def derived(name: str, latex: str, source: str = "", positive: bool = False) -> sp.Symbol:
            return names.derived(name, latex, law_step(system, source or name, cut), positive=positive)

        self.f = derived("f", "f", positive=True)
        self.h = derived("h", "h", positive=True)
        self.g = derived("g", "g")
        self.s = derived("s", "s")
        self.sigma = derived("sigma", r"\sigma", positive=True)
        self.phi_eq = derived("phi_eq", r"\dot{\tilde\varphi}_{eq}", "phi_t_rate")
        rate = law_step(system, "rho_t_rate", cut)
        self.rho_eq = names.derived("rho_eq", r"\dot{\tilde\rho}_{eq}", rate.subs(self.eta, 0))
        self.s_dot = names.derived("s_dot", r"\dot s", time_derivative(names.meaning(self.s), t.motion))
        self.h_dot = names.derived("h_dot", r"\dot h", time_derivative(names.meaning(self.h), t.motion))
        size = sp.Symbol("size", positive=True)
        slope = names.meaning(self.f).subs(sp.Abs(t.theta), size).diff(size).subs(size, sp.Abs(t.theta))
        self.f_slope = names.derived("f_slope", r"|f'|", slope)
        self.driven: Case = {t.rho_dot: rate, t.phi_dot: self.phi_eq}
        solved = -names.meaning(self.s_dot).subs(t.rho_dot, 0)
        self.on_surface: Case = {t.rho_dot: solved}
        self.on_circle: Case = {t.rho: self.h}


class Path:
    """Symbols of the second design, (40)-(51): an arc from the current point (index 1) to the target."""

    def __init__(self, system: System, names: Names, t: Shifted, sliding: Sliding) -> None:
        self.k_phi, self.R = sliding.k_phi, sliding.R
        self.rho = names.free("rho_1", "1/20", "6/5", latex=r"\tilde\rho_1")
        self.phi = names.free("phi_1", -3, 3, latex=r"\tilde\varphi_1")
        self.xi = names.free("xi", -3, 3, latex=r"\xi")
        self.size = names.free("theta_size", "1/100", 3, latex=r"|\tilde\theta|")
        self.alpha = names.family("alpha", r"\alpha")
        self.sides: tuple[Case, ...] = ({self.alpha: sp.S.One}, {self.alpha: -sp.S.One})
        # The arc through the current point and the origin whose direction phi* is xi/2 away, as (40) asks.
        self.phi_star = names.derived("phi_star", r"\varphi^*", self.phi + self.alpha * self.xi / 2)
        diameter, angle, turned = sp.symbols("diameter angle turned")
        arc = diameter * sp.cos(angle - self.phi_star)
        through = sp.solve(self.rho - arc.subs(angle, self.phi), diameter)[0]
        self.A = names.derived("diameter", "A", through, text="A")
        self.phi_end = names.derived("phi_f", r"\tilde\varphi_f", self.phi_star - self.alpha * sp.pi / 2)
        swept = sp.integrate((self.A * sp.cos(turned)) ** 2, turned)
        ends = [swept.subs(turned, end - self.phi_star) for end in (self.phi, self.phi_end)]
        self.theta = names.derived("theta_1", r"\tilde\theta_1", ends[0] - ends[1])
        self.arc_rate = arc.diff(angle).subs({angle: self.phi, diameter: self.A}) * t.v2
        chord = (sp.pi - self.xi) / 2
        self._angle = sp.Symbol("x")
        self._area = arc_area(self._angle)
        self.K = names.derived("K", "K", self._enclosed(chord), positive=True)
        self._drive(system, names, t, chord)
        self._limit(system, names, t)

    def _enclosed(self, chord: Expr) -> Expr:
        """Return K of (42) for an arc that leaves its chord at this angle, as the derivation integrates it."""
        return self._area.subs(self._angle, chord)

    def _drive(self, system: System, names: Names, t: Shifted, chord: Expr) -> None:
        """Take the law's rates, at the current point and at any point of the shifted coordinates.

        The model's law leaves the origin in a way that the paper does not print: escape = 0 takes it out.
        """
        named = {s.name: s for s in system.definitions}

        def rates(rho: Expr, theta: Expr) -> tuple[Expr, Expr]:
            cut = {
                named["x"]: chord,
                named["alpha"]: self.alpha,
                named["rho_t"]: rho,
                named["theta_t"]: theta,
                named["escape"]: sp.S.Zero,
            }
            turn, closing = (
                insert_definitions(named[name], system.definitions, cut) for name in ("turn_rate", "rho_p_rate")
            )
            return closing, turn / rho

        closing, turn = rates(self.rho, self.theta)
        here = {t.v1: closing, t.v2: turn, t.rho_dot: closing, t.phi_dot: turn}
        self.driven: tuple[Case, ...] = tuple({**side, **here} for side in self.sides)
        closing, turn = rates(t.rho, t.theta)
        error = self.alpha * t.rho**2 / 2 * self.K
        anywhere = {t.theta: error, t.phi_dot: turn, t.rho_dot: closing}
        self.anywhere: tuple[Case, ...] = tuple({**side, **anywhere} for side in self.sides)
        self.turn, self.closing = turn, closing
        self.V_dot = names.derived("V_dot", r"\dot V", time_derivative(t.theta**2 / 2, {t.theta: t.theta_dot}))

    def _limit(self, system: System, names: Names, t: Shifted) -> None:
        """Take the arc that touches rho = R from the derivation; the angle x_1 of the arc error is free."""
        named = {s.name: s for s in system.definitions}
        cut = {
            named["rho_t"]: self.rho,
            named["cos_t"]: sp.cos(self.phi),
            named["sin_t"]: sp.sin(self.phi),
            named["alpha"]: self.alpha,
        }
        touching = insert_definitions(named["x_tangent"], system.definitions, cut)
        self.x = names.free("chord_angle", "1/20", 3, latex="x_1")
        self.x_t = names.derived("x_t", "x_t", touching)
        self.theta_max = names.derived("theta_max", r"\tilde\theta_{max}", self.rho**2 / 2 * self._enclosed(self.x_t))
        error = self.alpha * self.rho**2 / 2 * self._enclosed(self.x)
        taken = sp.Min(self.x, self.x_t)
        self.theta_a = names.derived("theta_a", r"\tilde\theta_a", self.rho**2 / 2 * self._enclosed(taken))
        limited = {self.theta: error, self.xi: sp.pi - 2 * taken}
        self.limited: tuple[Case, ...] = tuple({**side, **limited} for side in self.sides)
        self.touching: tuple[Case, ...] = tuple({**side, self.xi: sp.pi - 2 * self.x_t} for side in self.sides)
        self.inside = (self.R**2 - self.rho**2 + 2 * t.a * self.rho * sp.cos(self.phi) - t.a**2,)


def law_of(system: System, name: str) -> Controller:
    """Return one of the system's laws."""
    return next(law for law in system.controllers if law.name == name)


def default(law: Controller, name: str) -> Expr:
    """Return the default of one of a law's parameters, exactly: a number, or a formula in the law's symbols."""
    quantity = next(q for q in law.parameters if q.name == name)
    assert isinstance(quantity, Parameter)
    return sp.sympify(str(quantity.default), locals={q.name: q.symbol for q in law.parameters}, rational=True)


def shifted_cut(system: System, t: Shifted) -> dict[Expr, Expr]:
    """Our shifted coordinates in the paper's."""
    ours = {s.name: s for s in system.definitions}
    theirs = {"rho_t": t.rho, "cos_t": sp.cos(t.phi), "sin_t": sp.sin(t.phi), "theta_t": t.theta}
    return {ours[name]: expr for name, expr in theirs.items()}


def law_step(system: System, name: str, cut: dict[Expr, Expr]) -> Expr:
    """Follow a step of a law down to the shifted coordinates, its smoothed signs made sharp again."""
    symbol = next(s for s in system.definitions if s.name == name)
    return sharp(insert_definitions(symbol, system.definitions, cut))


def sharp(expr: Expr) -> Expr:
    """Undo the smoothing of section 4: sat(x) becomes sgn(x)."""
    wild = sp.Wild("x")
    return expr.replace(sp.Max(-1, sp.Min(1, wild)), lambda x: sp.sign(x))
