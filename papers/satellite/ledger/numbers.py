# SPDX-License-Identifier: Apache-2.0
"""The numbers of the satellite's paper: Table 1, (43)-(50) and the sentences around them, as printed."""

from __future__ import annotations

from collections.abc import Iterator

import sympy as sp
from sympy import Expr

from mehvar import Group, Parameter, System
from mehvar.ledger import Case, Equation, Names, Printed, Relation, printed

from .loop import SampledLoop, controller
from .symbols import Motion

_AXES = ("roll", "pitch", "yaw")
_LETTERS = (r"\varphi", r"\theta", r"\psi")
_UNIT = sp.Rational(1, 10**4)
"""One unit of the last digit of (43)-(45)."""


class Numbers:
    """The model's numbers, and what the derivation makes of them."""

    def __init__(self, system: System, names: Names, c: SampledLoop) -> None:
        law, pd = controller(system, "mrac-literal"), controller(system, "pd")
        self.plant, self.law = _defaults(system.parameters), _defaults(law.parameters)
        self._shown = {step.left: step.expr for step in system.steps if isinstance(step, Equation)}
        values = self.plant
        self.axis = tuple(self._double_integrator(axis, c, values) for axis in _AXES)
        self.stiff = tuple(self._stiff(k, c, values) for k in range(3))
        named = {symbol.name: symbol for symbol in self.law}
        self.design: Case = {**self.axis[0], c.pole: self.law[named["C2_pole"]]}
        self.forgetting = names.derived("forgetting_run", r"\lambda", self.law[named["forgetting"]], text="lambda")
        self.d = 1 + self.law[named["delay"]]
        self._runs(system, names)
        self._gains(system, names, _defaults(pd.parameters))
        self._link(names, c)
        self._digits: dict[str, sp.Symbol] = {}
        self._names = names

    def printed(self, digits: str) -> sp.Symbol:
        """Return a number that is shown with its printed digits, "0.307" or "1.47e-5"."""
        if digits not in self._digits:
            front, _, power = digits.partition("e")
            latex = f"10^{{{power}}}" if front == "1" else rf"{front} \times 10^{{{power}}}"
            latex = latex if power else front
            self._digits[digits] = self._names.derived(digits, latex, sp.Rational(digits))
        return self._digits[digits]

    def _double_integrator(self, axis: str, c: SampledLoop, values: Case) -> Case:
        """Take A and B of an axis without stiffness from the derived sampled model."""
        A, B = (sp.expand(self._shown[rf"{n}_{{\mathrm{{{axis}}}}}"].subs(values)) for n in "AB")
        return _coefficients(A, B, c)

    def _stiff(self, k: int, c: SampledLoop, values: Case) -> Case:
        """Take A and B of an axis with the stiffness that the gravity gradient gives it."""
        square = -self._shown[f"A_{{{k + 4}{k + 1}}}"].subs(values)
        inertia = 1 / self._shown[f"B_{{{k + 4}{k + 1}}}"].subs(values)
        cut = {sp.Symbol("w", positive=True): sp.sqrt(square), sp.Symbol("I", positive=True): inertia, **values}
        A, B = (sp.expand(self._shown[n].subs(cut)) for n in "AB")
        return _coefficients(A, B, c)

    def _runs(self, system: System, names: Names) -> None:
        """Take the start of a run and its references."""
        scenario = _defaults(system.scenario_parameters)
        self.degree = names.derived("degree", r"{}^\circ", sp.pi / 180, positive=True)
        self.start = tuple(
            names.derived(f"{name}_0", f"{latex}_0", expr.subs(scenario))
            for name, latex, expr in zip(("phi", "theta", "psi"), _LETTERS, system.initial[:3], strict=True)
        )
        time = {symbol: sp.S.Zero for expr in system.reference for symbol in expr.free_symbols if symbol.name == "t"}
        self.reference = tuple(
            names.derived(f"r_{name}", f"r_{latex}", expr.subs({**scenario, **time}))
            for name, latex, expr in zip(("phi", "theta", "psi"), _LETTERS, system.reference, strict=True)
        )
        period = next(value for symbol, value in self.plant.items() if symbol.name == "Ts")
        self.Ts = names.derived("T_s_run", "T_s", period, positive=True, text="T_s")
        self.any_Ts = names.free("T_s", "1/10", 2)
        self.period = names.free("T_min", "1/10", 20, latex=r"T_{min}")
        self.hertz = names.derived("hertz", r"\mathrm{Hz}", sp.S.One, positive=True, text="Hz")
        self.kilometre = names.derived("kilometre", r"\mathrm{km}", sp.Integer(1000), positive=True, text="km")
        attraction, radius = sp.Rational("3.986004418e14"), sp.Integer(6378137)
        rate = next(value for symbol, value in self.plant.items() if symbol.name == "omega0")
        self.height = names.derived("h_orbit", "h", sp.cbrt(attraction / rate**2) - radius, text="h")
        self.mass = names.free("mass", 1, 100, latex="m", text="m")
        wheels = [value for symbol, value in self.plant.items() if symbol.name.startswith("Iw_")]
        self.I_w = names.matrix("I_w", r"I_\omega", sp.diag(*wheels), text="I_omega")

    def _gains(self, system: System, names: Names, values: Case) -> None:
        """Take the gains from the derived PD law: its factors of the reference and of the rates."""
        named = {symbol.name: symbol for symbol in system.definitions}
        self.K_P, self.K_D = [], []
        for i, axis, reference in zip("xyz", _AXES, system.references.symbols, strict=True):
            command = system.definitions[named[f"u_{axis}_pd"]]
            command = sp.sympify(command).subs({s: v for s, v in values.items() if s.name == "follow_model"})
            proportional, damping = command.diff(reference), -command.diff(named[f"rate_{i}"])
            self.K_P.append(names.derived(f"K_P{i}", f"K_{{P{i}}}", proportional.subs(values)))
            self.K_D.append(names.derived(f"K_D{i}", f"K_{{D{i}}}", damping.subs(values)))

    def _link(self, names: Names, c: SampledLoop) -> None:
        """Count what the law (32) needs of a sample, in numbers of single precision."""
        self.bit = names.derived("bit", r"\mathrm{bit}", sp.S.One, positive=True)
        self.byte = names.derived("byte", r"\mathrm{byte}", sp.Integer(8), positive=True)
        needed = sum(weight != 0 for weight in c.weights[1])
        self.sent = names.derived("sent", r"n_{\downarrow}", sp.Integer(3 * needed * 32), text="sent to the board")
        self.received = names.derived("received", r"n_{\uparrow}", sp.Integer(3 * 32), text="received from the board")


def _defaults(group: Group) -> dict[sp.Symbol, sp.Rational]:
    """Return a group's numbers exactly; formulas are left out."""
    return {
        q.symbol: sp.Rational(str(q.default))
        for q in group
        if isinstance(q, Parameter) and not isinstance(q.default, str)
    }


def _coefficients(A: Expr, B: Expr, c: SampledLoop) -> Case:
    one, two = sp.symbols("q^{-1} q^{-2}", real=True)
    return {c.a1: A.coeff(one), c.a2: A.coeff(two), c.b0: B.coeff(one, 0), c.b1: B.coeff(one)}


def table(m: Motion, v: Numbers) -> Iterator[Printed]:
    """Table 1: the satellite."""
    yield printed(
        "Table 1",
        "the satellite",
        "data",
        *(
            Relation(inertia, v.printed(number), cases=(v.plant,))
            for inertia, number in zip(m.moments, ("2.13", "3.04", "3.09"), strict=True)
        ),
        Relation(v.height, 600 * v.kilometre, within=sp.S.One, says="from the model's orbital rate, in metres"),
        Relation(v.mass, sp.Integer(50), given=True),
        note="I_y > I_x > I_z does not hold: roll and pitch are unstable under the gravity gradient.",
    )
    wheels = sp.diag(*(v.printed(x) for x in ("1.47e-5", "1.26e-5", "1.26e-5")))
    yield (
        printed(
            "Table 1, I_omega",
            "inertia of the wheels",
            "data",
            note="Infeasible in either reading: the manoeuvre asks for 0.12 N m s, which is 87000 rpm.",
        )
        .reading(
            "the spin inertias of the wheels along x, y and z",
            Relation(v.I_w, wheels),
            why="One number for each of three wheels along the axes.",
        )
        .reading(
            "the principal inertias of one wheel: each has the spin inertia 1.47e-5",
            Relation(v.I_w, v.printed("1.47e-5") * sp.eye(3)),
            used=False,
            why="The paper does not say which.",
        )
    )


def sampled(c: SampledLoop, v: Numbers) -> Iterator[Printed]:
    """(43)-(45): the sampled axes."""
    digits = (("0.307", "0.0586"), ("0.305", "0.0411"), ("0.302", "0.0404"))
    for k, (first, second) in enumerate(digits):
        yield printed(
            str(43 + k),
            f"sampled model of {_AXES[k]}",
            "equation",
            Relation(c.A, 1 - 2 * c.q + c.q**2, cases=(v.axis[k],)),
            Relation(
                c.A,
                1 - 2 * c.q + c.q**2,
                cases=(v.stiff[k],),
                within=sp.Rational(1, 10**6),
                says="with the stiffness of the gravity gradient, within 1e-6",
            ),
            Relation(
                c.B,
                v.printed(first) + v.printed(second) * c.q,
                corrected=v.printed(second) + v.printed(second) * c.q,
                cases=(v.axis[k],),
                within=2 * _UNIT,
                says="within one unit of the last digit of each coefficient",
            ),
            note="b_0 = b_1 = T_s^2/(2 I), of which the printed b_1 are the first digits; the printed b_0 are 5.2 to "
            "7.5 times too large, and not in proportion to 1/I.",
        )


def design(c: SampledLoop, v: Numbers) -> Iterator[Printed]:
    """(46)-(48), and the delay that they are designed for."""
    after_link = "with the delay of a sample between computer and board"
    yield (
        printed("text after (45)", "d is 1", "statement")
        .reading(
            "the delay of the held torque alone",
            Relation(c.d, sp.S.One, cases=({c.d: v.d},)),
            why="As in figures 4 and 5; scenarios with the link's delay have a design for d = 2.",
        )
        .reading(
            after_link,
            Relation(c.d, sp.S.One, corrected=sp.Integer(2), cases=({c.d: v.d + 1},)),
            used=False,
            why="The text before (49) says that it is to be designed for; then d is 2.",
        )
    )
    small = v.printed("1e-6")
    one, two = ({**c.at[d], **v.design} for d in (1, 2))
    q = c.q
    yield printed(
        "46",
        "C2",
        "equation",
        Relation(c.C2, 1 - v.printed("0.002") * q + small * q**2, cases=(one,)),
        note="Both poles are 0.001, as the text after (49) says.",
    )
    S, T = sp.S.One, v.printed("1.998") - (1 - small) * q
    yield printed("47", "S", "equation", Relation(c.S, S, cases=(one,)), note="For d = 1.")
    yield printed("48", "T", "equation", Relation(c.T, T, cases=(one,)), note="For d = 1.")
    yield printed(
        "text before (49)",
        "the law is designed for the delay of the link",
        "statement",
        Relation(c.S, S, corrected=1 + v.printed("1.998") * q, cases=(two,), says="(47) with d = 2"),
        Relation(
            c.T,
            T,
            corrected=v.printed("2.996001") - v.printed("1.998000") * q,
            cases=(two,),
            says="(48) with d = 2",
        ),
        note="S for d = 2 has its root at -1.998: the law is unstable by itself.",
    )


def runs(c: SampledLoop, v: Numbers) -> Iterator[Printed]:
    """(49), (50), and the numbers of the runs and of the link."""
    yield printed(
        "text before (49), amount of data",
        "72 bits to the board and 12 bits back",
        "statement",
        Relation(v.sent, 72 * v.bit, corrected=72 * v.byte, says="to the board, in bits"),
        Relation(v.received, 12 * v.bit, corrected=12 * v.byte, says="back, in bits"),
        note="12 bytes are three numbers of single precision; 72 bytes are "
        "18, and the law (32) with d = 1 needs six for an axis: y_m(k+1), y_m(k), y_m(k-1), y(k), y(k-1), u(k-1). "
        "The paper does not say what is sent: this is likely, no more.",
    )
    wish, most = v.any_Ts, v.period / 10
    r = v.printed
    yield printed(
        "text before (49), sampling time",
        "the least sampling time is a tenth of the shortest period",
        "statement",
        Relation(
            v.period / sp.Max(wish, most),
            sp.Integer(10),
            ">=",
            corrected_left=v.period / sp.Min(wish, most),
            says="ten samples in the shortest period, whatever sampling time T_s is wished for: as the least, "
            "Max(T_s, T_min/10) is taken, as the greatest, Min",
        ),
        Relation(v.Ts, 1 / (10 * r("0.2") * v.hertz), says="shortest period: that of 0.2 Hz"),
        Relation(v.Ts, r("0.5")),
        note="That the fastest oscillation has 0.2 Hz is not explained.",
    )
    degree = v.degree
    yield printed(
        "49",
        "initial angles",
        "data",
        *(Relation(angle, number * degree) for angle, number in zip(v.start, (10, 10, 5), strict=True)),
    )
    yield printed(
        "text after (49), manoeuvre",
        "roll between -25 and 25, pitch between -30 and 30 degrees, yaw zero",
        "data",
        *(Relation(angle, number * degree) for angle, number in zip(v.reference, (25, 30, 0), strict=True)),
        note="The model's square waves begin positive; their period is not given.",
    )
    yield printed(
        "text after (49), poles",
        "poles of the error dynamics (21)",
        "data",
        Relation(c.C2, (1 - r("0.001") * c.q) * (1 - r("0.001") * c.q), cases=(v.design,)),
    )
    yield printed(
        "text after (49), forgetting factor",
        "forgetting factor",
        "data",
        Relation(v.forgetting, r("0.998")),
        note="Beyond the range that the text after (42) calls usual, 0.98 to 0.995.",
    )
    K_D = ("0.3621e-1", "0.5168e-1", "0.5253e-1")
    K_P = ("2.1087e-3", "3.0096e-3", "3.0591e-3")
    yield printed(
        "50",
        "gains of the PD law",
        "data",
        *(Relation(gain, r(number)) for gain, number in zip(v.K_D, K_D, strict=True)),
        *(Relation(gain, r(number)) for gain, number in zip(v.K_P, K_P, strict=True)),
        note="The law itself is not printed. K_P = 9.9e-4 I and K_D = 0.017 I on all axes: damping ratio 0.27, so "
        "that slow tracking is a matter of these gains.",
    )
