# SPDX-License-Identifier: Apache-2.0
"""The symbols of the slosh paper and what the derivation says they mean."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import sympy as sp
from sympy import Expr

from mehvar import Quantity, System
from mehvar.ledger import Case, Equation, Names, frozen, insert_definitions
from mehvar.mechanics import matrix_rate, time_derivative
from mehvar.models.slosh.plant import pendulum
from mehvar.models.slosh.plant.equations import velocity_accelerations
from mehvar.models.slosh.states import angle_quantities, angle_rate_quantities, rate, velocity

_SIZES: Mapping[str, tuple[str | int, int]] = {
    "m": ("1/10", 4),
    "l": ("1/10", 2),
    "h": (-2, 2),
    "I": ("1/10", 4),
    "eps": (0, 2),
}
"""A pendulum's parameters and where they are tried."""
_LATEX = {
    "eps": r"\epsilon",
    "phi": r"\varphi",
    "theta": r"\theta",
    "phi_dot": r"\dot\varphi",
    "theta_dot": r"\dot\theta",
    "phi_ddot": r"\ddot\varphi",
    "theta_ddot": r"\ddot\theta",
}


class Total(sp.UnevaluatedExpr):  # type: ignore[misc]
    """The sum of a term over the pendulums, written once with the index i as the paper prints it."""

    def __new__(cls, term: Expr, member: sp.Tuple, members: sp.Tuple) -> Total:
        """Sum `term`, in the names of `member`, over the `members`."""
        total: Total = sp.Expr.__new__(cls, sp.sympify(term), member, members)
        return total

    @property
    def free_symbols(self) -> set[sp.Basic]:
        """Names with index i, which the sum binds."""
        return set(self.doit().free_symbols)

    def doit(self, **hints: bool) -> Expr:
        """Write the sum out."""
        term, member, members = self.args
        written = (term.xreplace(dict(zip(member, each, strict=True))) for each in members)
        return sp.Add(*(each.doit(**hints) for each in written))

    def _latex(self, printer: Any) -> str:
        term = printer.parenthesize(self.args[0], sp.printing.precedence.PRECEDENCE["Mul"])
        return rf"\sum_{{i=1}}^{{{len(self.args[2])}}} {term}"

    def _sympystr(self, printer: Any) -> str:
        return f"sum_i({printer._print(self.args[0])})"


class Index:
    """The names of one pendulum: parameters, angles, their rates and accelerations, by our names without a number."""

    def __init__(self, symbols: Mapping[str, sp.Symbol]) -> None:
        self.symbols = dict(symbols)

    def __getattr__(self, name: str) -> sp.Symbol:
        return self.symbols[name]


class Spacecraft:
    """Symbols of sections 2 and 3, free as the model's states, rates and parameters, or derived from its energy."""

    def __init__(self, system: System, names: Names) -> None:
        self.names, self.system = names, system
        self._hull(system, names)
        self.bobs = tuple(self._bob(system, names, k) for k in (1, 2))
        self.i = Index(
            {
                name: names.family(
                    f"{name.partition('_')[0]}_i" + "".join(name.partition("_")[1:]),
                    f"{_LATEX.get(name, name)}_i",
                    positive=name in ("m", "l", "I"),
                )
                for name in self.bobs[0].symbols
            }
        )
        self.moving = {phi: bob.symbols[f"{name}_dot"] for bob in self.bobs for name, phi in _angles(bob).items()}
        self._motion(names)
        self._energy(system, names)
        self._wrench(system, names)

    def _hull(self, system: System, names: Names) -> None:
        p = {q.name: q for q in system.parameters}
        states = {q.name: q for q in (*system.states, *system.inputs)}

        def free(name: str, low: str | int, high: str | int, latex: str = "", text: str = "") -> sp.Symbol:
            return names.free({**p, **states}[name], low, high, latex=latex, text=text)

        self.m, self.m0 = free("m", "1/10", 4), free("m0", "1/10", 4)
        self.I0, self.b, self.d, self.h0 = free("I0", 0, 4), free("b", -2, 2), free("d", -2, 2), free("h0", -2, 2)
        self.J = tuple(free(f"J_{axis}", "1/10", 4) for axis in "xyz")
        self.F = free("F", "1/10", 4)
        self.v = tuple(free(f"v{axis}", -2, 2) for axis in "xyz")
        self.w = tuple(free(f"w{axis}", -2, 2, text=f"Omega_{k}") for k, axis in enumerate("xyz", 1))
        self.att = tuple(free(f"att{k}", -1, 1, latex=rf"\vartheta_{k}", text=f"vartheta_{k}") for k in (1, 2, 3))
        self.M = tuple(free(f"M{axis}", -2, 2, text=f"M_{axis}") for axis in "xyz")
        self.delta = tuple(free(f"delta{k}", "-3/2", "3/2", text=f"delta_{k}") for k in (1, 2))
        self.v_dot = tuple(
            names.free(f"v{axis}_rate", -2, 2, latex=rf"\dot v_{axis}", text=f"v{axis}_dot") for axis in "xyz"
        )
        self.w_dot = tuple(
            names.free(f"w{axis}_rate", -2, 2, latex=rf"\dot\Omega_{k}", text=f"Omega_{k}_dot")
            for k, axis in enumerate("xyz", 1)
        )

    def _bob(self, system: System, names: Names, k: int) -> Index:
        p = {q.name: q for q in system.parameters}
        symbols = {name: names.free(p[f"{name}{k}"], *bounds) for name, bounds in _SIZES.items()}
        quantities: Sequence[Quantity] = (*angle_quantities(k), *angle_rate_quantities(k))
        for q in quantities:
            symbols[str(q.family)] = names.free(q, -2, 2)
        for angle in ("phi", "theta"):
            latex = f"{_LATEX[f'{angle}_ddot']}_{k}"
            symbols[f"{angle}_ddot"] = names.free(f"{angle}{k}_ddot", -2, 2, latex=latex)
        return Index(symbols)

    def total(self, term: Expr) -> Total:
        """Sum a term in the names with index i over the pendulums."""
        member = sp.Tuple(*self.i.symbols.values(), self.V_i, self.omega_i)
        vectors = ((self.V_at[str(k)], self.omega[k - 1]) for k in range(1, len(self.bobs) + 1))
        members = (sp.Tuple(*bob.symbols.values(), *own) for bob, own in zip(self.bobs, vectors, strict=True))
        return Total(term, member, sp.Tuple(*members))

    def each(self) -> tuple[dict[Expr, Expr], ...]:
        """Return the meanings of the names with index i, pendulum by pendulum."""
        return tuple({self.i.symbols[n]: s for n, s in bob.symbols.items()} for bob in self.bobs)

    def _motion(self, names: Names) -> None:
        """Vectors of V, Omega and a (17), the rates of everything along a motion, and the rate of O's position."""
        rates = dict(zip((*velocity, *rate), (*self.v_dot, *self.w_dot), strict=True))
        self.rates: dict[Expr, Expr] = rates | self.moving
        for bob in self.bobs:
            self.rates |= {bob.phi_dot: bob.phi_ddot, bob.theta_dot: bob.theta_ddot}
        linear = list(velocity_accelerations(rates).values())[:3]
        self.a_spelled = tuple(linear)
        self.a = tuple(names.derived(f"a_{axis}", f"a_{axis}", e) for axis, e in zip("xyz", linear, strict=True))
        self.a_column = names.matrix("a", "a", sp.Matrix(linear))
        self.V = names.matrix("V", "V", velocity)
        self.V_dot = names.matrix("V_dot", r"\dot V", sp.Matrix(self.v_dot))
        self.Omega = names.matrix("Omega", r"\Omega", rate)
        self.place = tuple(names.free(axis, -2, 2) for axis in "xyz")
        still = velocity - rate.cross(sp.Matrix(self.place))
        self.place_dot = tuple(
            names.derived(f"{axis}_dot", rf"\dot {axis}", e) for axis, e in zip("xyz", still, strict=True)
        )

    def _energy(self, system: System, names: Names) -> None:
        """Read the terms of T: d/dm of T is |V_c|^2/2, d/dI_i of it |omega_i + Omega|^2/2, and so on."""
        energy = next(f for f in system.functions if f.name == "energy").results[0][1]
        energy = insert_definitions(energy, system.definitions)
        self.T = names.derived("T", "T", energy)
        self.U = names.derived("U", "U", sp.S.Zero)
        self.L = names.derived("L", "L", energy)
        self.I3 = names.matrix("I_3", "I", sp.eye(3), text="I")
        self.J_matrix = names.matrix("J", "J", sp.diag(*self.J))
        at = sp.Matrix(self.place)
        self.V_at: dict[str, sp.MatrixSymbol] = {}
        self.r: dict[str, sp.MatrixSymbol] = {}
        self.r_dot: dict[str, sp.MatrixSymbol] = {}
        masses = {"c": self.m, "0": self.m0} | {f"{k}": bob.m for k, bob in enumerate(self.bobs, 1)}
        for name, mass in masses.items():
            speed = sp.Matrix([energy.diff(mass, v) for v in velocity])
            arm = sp.Matrix([speed[1].diff(rate[2]), speed[2].diff(rate[0]), speed[0].diff(rate[1])])
            moved = velocity - rate.cross(at) + matrix_rate(arm, self.moving)
            self.V_at[name] = names.matrix(f"V_at_{name}", f"V_{name}", speed, text=f"V_{name}")
            self.r[name] = names.matrix(f"r_{name}", f"r_{name}", at + arm)
            self.r_dot[name] = names.matrix(f"r_dot_{name}", rf"\dot r_{name}", moved)
        self.V_i, self.r_i, self.r_dot_i, self.omega_i = (
            names.matrix_family(name, latex, 3)
            for name, latex in (("V_i", "V_i"), ("r_i", "r_i"), ("r_dot_i", r"\dot r_i"), ("omega_i", r"\omega_i"))
        )
        self.own = tuple(frozen(sp.Matrix([energy.diff(bob.I, w) for w in rate]) - rate) for bob in self.bobs)
        self.omega = tuple(names.matrix(f"omega_{k}", rf"\omega_{k}", own) for k, own in enumerate(self.own, 1))
        self._derivatives(energy, names)

    def _derivatives(self, energy: Expr, names: Names) -> None:
        """Take the derivatives of L that (1)-(3) name; L has no V-dot and no Omega-dot, so those are zero."""

        def column(text: str, latex: str, by: Sequence[Expr], of: Expr = energy) -> tuple[sp.MatrixSymbol, sp.Matrix]:
            value = sp.Matrix([of.diff(symbol) for symbol in by])
            return names.matrix(text, latex, value, text=text), value

        def moving(text: str, latex: str, value: sp.Matrix) -> sp.MatrixSymbol:
            written = names.matrix(f"d/dt {text}", rf"\frac{{d}}{{dt}}{latex}", matrix_rate(value, self.rates))
            return written

        self.by: dict[str, sp.MatrixSymbol] = {}
        self.rate_of: dict[str, sp.MatrixSymbol] = {}
        for text, spelled, symbols in (
            ("V", "V", tuple(velocity)),
            ("Omega", r"\Omega", tuple(rate)),
            ("V_dot", r"\dot V", self.v_dot),
            ("Omega_dot", r"\dot\Omega", self.w_dot),
        ):
            latex = rf"\frac{{\partial L}}{{\partial {spelled}}}"
            self.by[text], value = column(f"dL/d{text}", latex, symbols)
            self.rate_of[text] = moving(f"dL/d{text}", latex, value)
        shown = equations(self.system)
        generic = shown["(8)", "R_i"]
        loss = sp.Add(*(generic.xreplace(generic_names(bob)) for bob in self.bobs))
        self.R = names.derived("R", "R", loss)
        parts = {
            "d/dt dL/dzeta_dot": r"\frac{d}{dt}\frac{\partial L}{\partial \dot\zeta}",
            "dL/dzeta": r"\frac{\partial L}{\partial \zeta}",
            "dR/dzeta": r"\frac{\partial R}{\partial \zeta}",
            "dR/dzeta_dot": r"\frac{\partial R}{\partial \dot\zeta}",
        }
        self.zeta = {text: names.matrix_family(text, latex, 2) for text, latex in parts.items()}
        self.zeta_cases: tuple[Case, ...] = tuple(
            {
                self.zeta["d/dt dL/dzeta_dot"]: sp.Matrix(
                    [time_derivative(energy.diff(speed), self.rates) for speed in (bob.phi_dot, bob.theta_dot)]
                ),
                self.zeta["dL/dzeta"]: sp.Matrix([energy.diff(bob.phi), energy.diff(bob.theta)]),
                self.zeta["dR/dzeta"]: sp.Matrix([loss.diff(bob.phi), loss.diff(bob.theta)]),
                self.zeta["dR/dzeta_dot"]: sp.Matrix([loss.diff(bob.phi_dot), loss.diff(bob.theta_dot)]),
            }
            for bob in self.bobs
        )

    def _wrench(self, system: System, names: Names) -> None:
        """tau_t and tau_r: what the inputs change in the derived residuals, with the sign of a right side."""
        residual = system.residual
        off = dict.fromkeys((self.F, *self.M), sp.S.Zero)
        applied = sp.Matrix([side.xreplace(off) - side for side in residual[:6]]).applyfunc(sp.expand)
        self.tau_t = names.matrix("tau_t", r"\tau_t", applied[:3, :])
        self.tau_r = names.matrix("tau_r", r"\tau_r", applied[3:, :])
        self.balance = residual[:6]
        self.rows = (residual[6:8], residual[8:10])
        self.row = tuple(names.family(f"row_{angle}_i", rf"\mathrm{{row}}_{{{angle},i}}") for angle in ("phi", "theta"))
        self.row_column = names.matrix_family("rows_i", r"\mathrm{rows}_i", 2)


def _angles(bob: Index) -> dict[str, sp.Symbol]:
    return {"phi": bob.phi, "theta": bob.theta}


def equations(system: System) -> dict[tuple[str, str], Expr]:
    """Return the derivation's steps by number and left side."""
    return {(step.number, step.left): step.expr for step in system.steps if isinstance(step, Equation)}


def generic_names(bob: Index) -> dict[Expr, Expr]:
    """Return the meanings of the symbols of the derivation's pendulum i in a pendulum."""
    g = pendulum.GENERIC
    values = {g.mass: bob.m, g.length: bob.l, g.pivot: bob.h, g.inertia: bob.I, g.damping: bob.eps}
    moving = {pendulum.phi: bob.phi, pendulum.theta: bob.theta}
    rates = {pendulum.phi_rate: bob.phi_dot, pendulum.theta_rate: bob.theta_dot}
    return {**values, **moving, **rates}
