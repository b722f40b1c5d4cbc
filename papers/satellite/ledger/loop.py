# SPDX-License-Identifier: Apache-2.0
"""The symbols of the satellite's sampled loop, (12)-(33): polynomials in q^-1, signals, the law; from the derivation.

A signal is its z-transform, so that q^-1 is a factor: y(k - 1) is q^-1 y(k). Where the past matters, as in (18), past
values are names of their own.
"""

from __future__ import annotations

import sympy as sp
from sympy import Expr

from mehvar import Controller, System
from mehvar.ledger import Case, Equation, Names, insert_definitions
from mehvar.models.satellite.controllers import REFERENCES, model_memory
from mehvar.models.satellite.dynamics import angles
from mehvar.models.satellite.estimator import symbols as estimator_memory
from mehvar.models.satellite.polynomials import cancelling

DELAYS = (1, 2)
"""d: one sample of the held torque, and another on the link between computer and board."""
_PAST = sp.symbols("Y0 Y1 U1 U2 W0 W1 W2")


class SampledLoop:
    """Symbols of the design. Families take their meaning for d = 1 or 2 from `at`, `along` or `closed`."""

    def __init__(self, system: System, names: Names) -> None:
        self._definitions = system.definitions
        self._named = {symbol.name: symbol for symbol in self._definitions}
        self._shown = {step.left: step.expr for step in system.steps if isinstance(step, Equation)}
        self._law = controller(system, "mrac-literal")
        self._memory = estimator_memory("roll")
        self.q = names.free("q_inv", "1/10", "9/10", latex="q^{-1}")
        self.d = names.family("d", "d", positive=True)
        self.a1, self.a2, self.b0, self.b1 = (
            names.free(n, -2, 2, latex=f"{n[0]}_{n[1]}") for n in ("a1", "a2", "b0", "b1")
        )
        self._signals(names)
        self._polynomials(names)
        self._orders(names)
        self._plant(names)
        self._vectors(names)

    def _signals(self, names: Names) -> None:
        def signal(name: str, latex: str, text: str) -> sp.Symbol:
            return names.free(name, -2, 2, latex=latex, text=text)

        self.y, self.u = signal("y_k", "y_p(k)", "y_p(k)"), signal("u_k", "u(k)", "u(k)")
        self.y_m, self.r_k = signal("ym_k", "y_m(k)", "y_m(k)"), signal("r_k", "r(k)", "r(k)")
        self.y_1 = signal("y_k1", "y_p(k-1)", "y_p(k-1)")
        self.u_1, self.u_2 = (signal(f"u_k{i}", f"u(k-{i})", f"u(k-{i})") for i in (1, 2))
        ahead = self.q**-self.d
        self.y_m_ahead = names.derived("ym_kd", "y_m(k+d)", self.y_m * ahead, text="y_m(k+d)")
        self.model_ahead = tuple(
            signal(f"ym_ahead{i}", f"y_m(k+d{last})", f"y_m(k+d{last})") for i, last in enumerate(("", "-1", "-2"))
        )
        self.e = signal("e_k", "e(k)", "e(k)")
        self.e_ahead = names.derived("e_kd", "e(k+d)", (self.y - self.y_m) * ahead, text="e(k+d)")
        self.u_now = names.family("u_now", "u(k)", text="u(k)")
        self.u_offset = names.family("u_offset", "u(k)", text="u(k)")
        self.offset = signal("offset", "d(k)", "d(k)")
        self.C2_y_ahead, self.C2_e_ahead, self.C2_e_offset = (
            names.family(f"C2_{n}_kd", rf"C_2(q^{{-1}})\,{shown}(k+d)", text=f"C2(q^-1) {shown}(k+d)")
            for n, shown in (("y", "y_p"), ("e", "e"), ("offset", "e"))
        )
        self.S_1 = names.family("S_1", "S(1)", text="S(1)")

    def _polynomials(self, names: Names) -> None:
        """Take A and B from what the estimator identifies, C1 and D from the reference model, the rest from the law."""
        q = self.q
        self.pole, self._model_pole = names.free("c_2", -1, 1), names.free("p_m", -1, 1, latex="p")
        A = 1 - self._predicted(q, q**2, 0, 0)
        B = self._predicted(0, 0, 1, q)
        model = insert_definitions(
            self._named["w_roll"],
            self._definitions,
            dict(zip(self._past_model(), (q, q**2), strict=True)) | {self._named["model_pole"]: self._model_pole},
        )
        reference = REFERENCES.symbols[0]
        weights = {d: self._weights(d) for d in DELAYS}
        Y0, Y1, U1, U2, W0, W1, W2 = range(7)
        C2 = sp.expand(weights[1][W0] + q * weights[1][W1] + q**2 * weights[1][W2])
        self.A, self.B, self.C1, self.D, self.C2 = (
            names.derived(f"{n}_q", f"{n[0]}_{n[1:]}(q^{{-1}})" if n[1:] else f"{n}(q^{{-1}})", e, text=f"{n}(q^-1)")
            for n, e in (
                ("A", A),
                ("B", B),
                ("C1", 1 - model.subs(reference, 0)),
                ("D", model.diff(reference)),
                ("C2", C2),
            )
        )
        self.S, self.T, self.BS = (
            names.family(f"{n}_q", rf"{latex}(q^{{-1}})", text=f"{latex}(q^-1)")
            for n, latex in (("S", "S"), ("T", "T"), ("BS", "B_S"))
        )
        self.alpha = (
            *(names.derived(f"alpha_{i}", rf"\alpha_{i}", weights[1][4 + i]) for i in (1, 2)),
            names.free("alpha_3"),
        )
        self.s_1, self.t_0, self.t_1 = (names.family(n, n) for n in ("s_1", "t_0", "t_1"))
        self.s = (self.s_1, names.free("s_2"), names.free("s_3"))
        unsaid = names.free("s_unsaid", latex="s_1", text="s_1")
        self.t = (self.t_0, self.t_1, names.free("t_2"), names.free("t_3"))
        self.weights = weights
        self.at: dict[int, Case] = {}
        for d in DELAYS:
            w, solution = weights[d], cancelling((self.pole, self.pole), d)
            S = sp.Add(*(s * q**i for i, s in enumerate(solution.S)))
            self.at[d] = {
                self.d: sp.Integer(d),
                self.S: S,
                self.S_1: S.subs(q, 1),
                self.s_1: solution.S[1] if d > 1 else unsaid,
                self.T: -(w[Y0] + q * w[Y1]),
                self.t_0: -w[Y0],
                self.t_1: -w[Y1],
                self.BS: -(q * w[U1] + q**2 * w[U2]),
            }

    def _predicted(self, y1: Expr, y2: Expr, v: Expr, v1: Expr, offset: Expr = sp.S.Zero) -> Expr:
        """Take the next angle from the derived prediction (34), for past angles and torques."""
        z = self._memory
        cut = {
            self._named["y1_used_roll"]: y1,
            z["y2"]: y2,
            self._named["v_roll"]: v,
            z["v1"]: v1,
            z["d"]: offset,
            **{z[n]: getattr(self, n) for n in ("a1", "a2", "b0", "b1")},
        }
        return sp.expand(
            insert_definitions(self._named["y_hat_roll"], self._definitions, {k: sp.sympify(v) for k, v in cut.items()})
        )

    @staticmethod
    def _past_model() -> tuple[sp.Symbol, sp.Symbol]:
        _, one, two, *_ = (q.symbol for q in model_memory("roll", True))
        return one, two

    def _command(self, d: int, offset: Expr = sp.S.Zero) -> Expr:
        """Take the derived command as a function of past values, for exact estimates."""
        Y0, Y1, U1, U2, W0, W1, W2 = _PAST
        named, p = self._named, {q.name: q.symbol for q in self._law.parameters}
        w1, w2 = self._past_model()
        estimates = {named[f"{n}_now_roll"]: getattr(self, n) for n in ("a1", "a2", "b0", "b1")}
        cut = estimates | {
            named["d_used_roll"]: offset,
            named["b0_used_roll"]: self.b0,
            angles[0]: Y0,
            named["y1_used_roll"]: Y1,
            named["v_roll"]: U1 if d == 1 else U2,
            self._memory["u1"]: U1,
            named["w_roll"]: W0,
            w1: W1,
            w2: W2,
            p["design_delay"]: sp.Integer(d - 1),
            p["C2_pole"]: self.pole,
        }
        return insert_definitions(named["u_roll_mrac_literal"], self._definitions, cut)

    def _weights(self, d: int) -> tuple[Expr, ...]:
        """Return b0 times the weight of each past value in the law."""
        command = self._command(d)
        return tuple(sp.expand(self.b0 * command.diff(past)) for past in _PAST)

    def _orders(self, names: Names) -> None:
        """Degrees; and n, which the paper prints for three of them and never says."""
        degree = {n: int(sp.degree(names.meaning(getattr(self, n)), self.q)) for n in ("A", "B", "C2")}
        self.n_A, self.n_B, self.n_C2 = (
            names.derived(f"n_{n}", f"n_{{{n}}}", sp.Integer(degree[n])) for n in ("A", "B", "C2")
        )
        self.n_s, self.n_t = names.family("n_s", "n_s"), names.family("n_t", "n_t")
        self.b_ns, self.b_nB, self.s_last = (
            names.family(n, latex) for n, latex in (("b_n_s", "b_{n_s}"), ("b_n_B", "b_{n_B}"), ("s_(d-1)", "s_{d-1}"))
        )
        self.n = names.free("n", 1, 3, integer=True)
        for d in DELAYS:
            case = self.at[d]
            orders = {n: sp.Integer(sp.degree(case[of], self.q)) for n, of in ((self.n_s, self.S), (self.n_t, self.T))}
            named = {
                self.b_ns: (self.b0, self.b1)[d - 1],
                self.b_nB: (self.b0, self.b1)[degree["B"]],
                self.s_last: case[self.s_1] if d > 1 else sp.S.One,
            }
            self.at[d] = {**case, **orders, **named}
        self.C2_to = {n: self._series(names, "alpha", r"\alpha", n, self.alpha, sp.S.One) for n in (self.n, self.n_C2)}
        self.S_to = {n: self._series(names, "s", "s", n, self.s, sp.S.One) for n in (self.n, self.n_s)}
        self.T_to = {n: self._series(names, "t", "t", n, self.t[1:], self.t_0) for n in (self.n, self.n_t)}

    def _series(
        self, names: Names, name: str, latex: str, last: sp.Symbol, coefficients: tuple[Expr, ...], first: Expr
    ) -> sp.Symbol:
        """Name a sum whose last index is open, as the paper writes it; the name keeps the dots."""
        terms = (sp.Piecewise((c * self.q**i, sp.Le(i, last)), (0, True)) for i, c in enumerate(coefficients, 1))
        start, n = ("t_0" if name == "t" else "1"), names.table[last].latex
        shown = rf"{start} + {latex}_1 q^{{-1}} + {latex}_2 q^{{-2}} + \dots + {latex}_{{{n}}} q^{{-{n}}}"
        text = f"{start} + {name}_1 q^-1 + {name}_2 q^-2 + ... + {name}_{last} q^-{last}"
        return names.derived(f"{name}_to_{last}", shown, first + sp.Add(*terms), text=text)

    def _plant(self, names: Names) -> None:
        """Take the exact sampled model of an axis with stiffness from the derivation, and its transfer function."""
        inertia, frequency, period = (
            names.free(n, lo, hi) for n, lo, hi in (("I_1", 1, 4), ("w_1", "1/10", 1), ("T_s1", "1/10", 2))
        )
        cut = {sp.Symbol("I", positive=True): inertia, sp.Symbol("w", positive=True): frequency}
        by_name = {s.name: s for s in self._shown["B"].free_symbols}
        cut |= {by_name["Ts"]: period}
        one, two = sp.symbols("q^{-1} q^{-2}", real=True)
        A, B = (sp.expand(self._shown[n].subs(cut)) for n in "AB")
        held = sp.Matrix([[0, 1], [-(frequency**2), 0]])
        step = sp.Matrix([[sp.cos(frequency * period), sp.sin(frequency * period) / frequency]] * 2)
        step[1, :] = step[0, :].diff(period)
        assert sp.simplify(step.diff(period) - held * step) == sp.zeros(2)
        time = sp.Symbol("time", positive=True)
        push = (step[:, 1] / inertia).subs(period, time).applyfunc(lambda e: sp.integrate(e, (time, 0, period)))
        resolvent = (sp.eye(2) - self.q * step).adjugate() / (sp.eye(2) - self.q * step).det()
        transfer = (resolvent * push * self.q)[0]
        numbers = {self.a1: A.coeff(one), self.a2: A.coeff(two), self.b0: B.coeff(one, 0), self.b1: B.coeff(one)}
        self.H = names.free("H_q", -2, 2, latex="H(q^{-1})", text="H(q^-1)")
        self.sampled: tuple[Case, ...] = tuple(
            {**numbers, self.d: sp.Integer(d), self.y: self.q ** (d - 1) * transfer * self.u} for d in DELAYS
        )

    def _vectors(self, names: Names) -> None:
        """Regressors and parameters (28)-(31): the past values that the law weighs, and their weights."""
        past = (self.y, self.y_1, self.u_1, self.u_2)
        self.Phi0: dict[int, sp.MatrixSymbol] = {}
        self.p0: dict[int, sp.MatrixSymbol] = {}
        self.Phi: dict[int, sp.MatrixSymbol] = {}
        self.p: dict[int, sp.MatrixSymbol] = {}
        self.p0_Phi0: dict[int, sp.Symbol] = {}
        self.p_Phi: dict[int, sp.Symbol] = {}
        self.along: dict[int, Case] = {}
        for d in DELAYS:
            weighed = [(s, -w) for s, w in zip(past, self.weights[d], strict=False) if w]
            weighed = [*weighed[2:], *weighed[:2]]
            everything = [(self.u, self.b0), *weighed]
            for vectors, weights, products, symbol, latex, pairs in (
                (self.Phi0, self.p0, self.p0_Phi0, "Phi0", r"\bar\Phi_0", weighed),
                (self.Phi, self.p, self.p_Phi, "Phi", r"\bar\Phi", everything),
            ):
                low = symbol.replace("Phi", "p")
                index = "_0" if pairs is weighed else ""
                signals, parameters = (sp.Matrix([list(column)]) for column in zip(*pairs, strict=True))
                vectors[d] = names.matrix(f"{symbol}_{d}", rf"{latex}^T(k)", signals, text=f"Phi{index}^T(k)")
                weights[d] = names.matrix(f"{low}_{d}", f"p{index}^T", parameters, text=f"p{index}^T")
                products[d] = names.derived(
                    f"{low}_{symbol}_{d}", rf"p{index}^T {latex}(k)", (parameters * signals.T)[0],
                    text=f"p{index}^T Phi{index}(k)",
                )  # fmt: skip
            self.along[d] = self._along(d)

    def _along(self, d: int) -> Case:
        """Signals along the plant (13), by the torque and the reference model."""
        q, ahead = self.q, self.y_m / self.q**d
        now = dict(
            zip(_PAST, (self.y, q * self.y, q * self.u, q**2 * self.u, ahead, q * ahead, q**2 * ahead), strict=True)
        )
        return {
            **self.at[d],
            self.y: q**d * self.B * self.u / self.A,
            self.y_1: q * self.y,
            self.u_1: q * self.u,
            self.u_2: q**2 * self.u,
            self.u_now: self._command(d).subs(now, simultaneous=True),
            self.u_offset: self._command(d, self.offset).subs(now, simultaneous=True),
        }

    def modelled(self, d: int) -> Case:
        """Give y_m(k) by the reference, from the memory of the law's reference model."""
        law, w = self._law, sp.Symbol("w_now")
        assert law.memory is not None
        update = dict(zip(law.memory.symbols, law.update, strict=True))
        (next_model,) = (expr for symbol, expr in update.items() if symbol.name == "ym_roll")
        p = {q.name: q.symbol for q in law.parameters}
        one, _ = self._past_model()
        cut = {self._named["healthy_mrac_literal"]: sp.S.One, p["design_delay"]: sp.Integer(d - 1)}
        next_one = next_model.subs({**cut, self._named["w_roll"]: w, one: self.q * w}, simultaneous=True)
        return {self.d: sp.Integer(d), self.y_m: self.q * next_one.subs(w, self.D * self.r_k / self.C1)}

    def closed(self, d: int) -> Case:
        """Close the loop: the plant (13) under the derived law, which wants w = q^d y_m."""
        at, model = self.at[d], self.modelled(d)
        whole = self.A * (self.b0 + at[self.BS]) + self.q**d * self.B * at[self.T]
        return {**at, **model, self.y: self.B * self.C2 * self.y_m / whole}

    def settling(self, d: int) -> Case:
        """C2 y and C2 e d samples ahead under the derived law, from any past, without and with an offset."""
        Y0, Y1, U1, U2, *W = _PAST
        past = dict(zip((Y0, Y1, U1, U2, *W), (self.y, self.y_1, self.u_1, self.u_2, *self.model_ahead), strict=True))
        one, two = self.alpha[:2]
        model = W[0] + one * W[1] + two * W[2]
        plain, driven = self._ahead(d, sp.S.Zero), self._ahead(d, self.offset)
        ahead = {
            self.C2_y_ahead: plain.subs(dict.fromkeys(W, 0)),
            self.C2_e_ahead: plain - model,
            self.C2_e_offset: driven - model,
        }
        return {self.d: sp.Integer(d), **{name: e.subs(past, simultaneous=True) for name, e in ahead.items()}}

    def _ahead(self, d: int, offset: Expr) -> Expr:
        """Return C2 y(k+d): the plant moves as the estimator's model says, d samples on."""
        Y0, Y1, U1, U2, *_ = _PAST
        command, (one, two) = self._command(d, offset), self.alpha[:2]
        if d == 1:
            return self._predicted(Y0, Y1, command, U1, offset) + one * Y0 + two * Y1
        following = self._predicted(Y0, Y1, U1, U2, offset)
        return self._predicted(following, Y0, command, U1, offset) + one * following + two * Y0


def controller(system: System, name: str) -> Controller:
    """Return one of the system's laws."""
    return next(law for law in system.controllers if law.name == name)
