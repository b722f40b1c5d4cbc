# SPDX-License-Identifier: Apache-2.0
"""Section 4 of the slosh paper: Tables 1 and 2, the initial state, and what follows from the laws, as printed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import sympy as sp
from sympy import Expr

from mehvar import Group, Parameter, System
from mehvar.ledger import Case, Names, Printed, Relation, printed

from .laws import Laws
from .symbols import Spacecraft

_EXACT = sp.Rational(1, 10**15)
"""Tolerance of an angle in radians: the model's numbers are doubles."""


class Numbers:
    """The model's numbers, by the names that they have in the tables."""

    def __init__(self, system: System, names: Names) -> None:
        self._names = names
        self.plant = _defaults(system.parameters)
        self.laws = {symbol: value for law in system.controllers for symbol, value in _defaults(law.parameters).items()}
        start = _defaults(system.scenario_parameters)
        self.degree = names.derived("degree", r"{}^\circ", sp.pi / 180, positive=True)
        self.second = names.derived("second", r"\mathrm{s}", sp.S.One, positive=True, text="s")
        self.start = {
            state.name: names.derived(f"{state.name}_0", f"{state.latex}(0)", sp.sympify(expr).subs(start))
            for state, expr in zip(system.states, system.initial, strict=True)
        }
        self._digits: dict[str, sp.Symbol] = {}

    def printed(self, digits: str) -> sp.Symbol:
        """Return a number that is shown with its printed digits, "0.16" or "8e-7"."""
        if digits not in self._digits:
            front, _, power = digits.partition("e")
            latex = rf"{front} \times 10^{{{power}}}" if power else front
            self._digits[digits] = self._names.derived(digits, latex, sp.Rational(digits))
        return self._digits[digits]

    def equal(self, values: Mapping[Expr, str]) -> tuple[Relation, ...]:
        """Return for each symbol that the model's number is the printed one."""
        return tuple(
            Relation(left, self.printed(digits), cases=(self.those_in(left),)) for left, digits in values.items()
        )

    def those_in(self, *expressions: Expr) -> Case:
        """Return the model's numbers for the symbols of some expressions."""
        symbols = set().union(*(expr.free_symbols for expr in expressions))
        return {symbol: value for symbol, value in {**self.plant, **self.laws}.items() if symbol in symbols}


def _defaults(group: Group) -> dict[sp.Symbol, sp.Rational]:
    """Return a group's numbers exactly; formulas are left out."""
    return {
        q.symbol: sp.Rational(str(q.default))
        for q in group
        if isinstance(q, Parameter) and not isinstance(q.default, str)
    }


def tables(s: Spacecraft, law: Laws, v: Numbers) -> Iterator[Printed]:
    """Yield Tables 1 and 2."""
    first, second = s.bobs
    yield printed(
        "Table 1, masses",
        "masses, thrust and the place of the fuel that does not slosh",
        "data",
        *v.equal({s.m: "975", s.m0: "480", first.m: "50", second.m: "5", s.F: "2450", s.h0: "0.05", second.l: "0.1"}),
        note="J and I_0 are not in the table. The reduced model and the laws do not have them, the moments do.",
    )
    yield _lengths(s, v)
    yield (
        printed("Table 1, inertias", "inertias of the pendulums", "data")
        .reading(
            "moments of inertia, as printed in kg m^2",
            *v.equal({first.I: "10", second.I: "1"}),
            why="(5) has them so, and a bob of 50 kg cannot have 500 kg m^2 on an arm of 0.2 m.",
        )
        .reading(
            "per unit of the pendulum's mass",
            *v.equal({first.I / first.m: "10", second.I / second.m: "1"}),
            used=False,
            why="(26) and (27) print I_i where I_i/m_i belongs. With this reading, and with the dampings 3.7 and 0.5, "
            "the runs do what the text says of diagrams 4, 7 and 8: the paper's simulation very likely had it.",
        )
    )
    yield (
        printed("Table 1, dampings", "dampings of the pendulums, printed 3/7 and 0.15", "data")
        .reading(
            "3.57 and 0.15",
            *v.equal({first.eps: "3.57", second.eps: "0.15"}),
            why="A digit of 3/7 is taken as lost: 3.57 stands in papers on like craft. No settling time depends on it.",
        )
        .reading(
            "3.7 and 0.5, strokes read as in the lengths",
            *v.equal({first.eps: "3.7", second.eps: "0.5"}),
            used=False,
            why="3/7 is 3.7, and 0.15 is 0/5, as 0.16 is 0/6. Needed, beside I_i per unit mass, for what the text says "
            "of diagram 4.",
        )
    )
    yield from _weights(law, v)


def _lengths(s: Spacecraft, v: Numbers) -> Printed:
    first, second = s.bobs
    return (
        printed("Table 1, lengths", "lengths whose strokes were lost", "data")
        .reading(
            "0.6, 0.9, -0.6, 1.2 and 0.2 m: a stroke for the decimal sign was read as 1, or stayed",
            *v.equal({first.h: "0.6", second.h: "0.9", s.b: "-0.6", s.d: "1.2", first.l: "0.2"}),
            why="d is printed 1/2 and eps1 3/7, so strokes there are. No settling time depends on it.",
        )
        .reading(
            "0.16, 0.19, -0.16, 0.5 and 0.12 m, as printed",
            *v.equal({first.h: "0.16", second.h: "0.19", s.b: "-0.16", s.d: "0.5", first.l: "0.12"}),
            used=False,
            why="Possible; the second pendulum then hangs inside of the tank.",
        )
    )


def _weights(law: Laws, v: Numbers) -> Iterator[Printed]:
    r, w = law.r, law.w
    yield printed(
        "Table 2, weights",
        "weights of the velocities, the body rates and the pendulums",
        "data",
        *v.equal({r[1]: "8e-7", r[2]: "8e-7", r[4]: "500", r[6]: "500", r[8]: "500", r[9]: "1e-5", r[10]: "1e-5"}),
    )
    of_attitude = (r[3], r[5], r[7])
    yield (
        printed("Table 2, r_3, r_5, r_7", "weights of the attitude, printed 1 x 10^-5", "data")
        .reading(
            "10^3",
            *v.equal(dict.fromkeys(of_attitude, "1000")),
            why="The text wants them far above 1; 10^3 is the least thrust sideways by which 200 s hold.",
        )
        .reading(
            "10^-5, as printed",
            *v.equal(dict.fromkeys(of_attitude, "1e-5")),
            used=False,
            why="No gain brings the attitude to zero within 11 hours: see the text on diagram 2.",
        )
        .reading(
            "10^5, a minus sign too many",
            *v.equal(dict.fromkeys(of_attitude, "1e5")),
            used=False,
            why="Possible with w_3 to w_5 = 4e5; the thrust then goes all sideways at first.",
        )
    )
    gains = dict.fromkeys((w[1], w[2]), "10000") | dict.fromkeys((w[3], w[4], w[5]), "40000")
    as_printed = dict.fromkeys((w[1], w[2]), "10") | dict.fromkeys((w[3], w[4], w[5]), "40")
    yield (
        printed("Table 2, gains", "gains, printed 1 x 10 and 4 x 10", "data")
        .reading("10^4 and 4 x 10^4", *v.equal(gains), why="The exponents are lost; these fit 500 s and 200 s.")
        .reading("10 and 40", *v.equal(as_printed), used=False, why="v_y would need 35 hours.")
    )


def simulation(s: Spacecraft, law: Laws, v: Numbers) -> Iterator[Printed]:
    """Yield the initial state, and sentences on the diagrams."""
    at, number = v.start, v.printed
    angles = {"att1": 5, "att2": 2, "att3": -5, "phi1": 30, "phi2": 40, "theta1": 20, "theta2": 10}
    rates = (state for state in at if state.endswith("_dot") or state in ("wx", "wy", "wz"))
    yield printed(
        "section 4, initial state",
        "what the run starts from",
        "data",
        *(Relation(at[name], number(digits)) for name, digits in (("vx", "3000"), ("vy", "75"), ("vz", "25"))),
        *(Relation(at[name], degrees * v.degree, within=_EXACT) for name, degrees in angles.items()),
        *(Relation(at[name], sp.S.Zero) for name in rates),
        note="theta_1 and theta_2 are printed twice, for the attitude and for the azimuths; the body rates are printed "
        "as rates of the attitude.",
    )
    yield from _diagrams(s, law, v)


def _diagrams(s: Spacecraft, law: Laws, v: Numbers) -> Iterator[Printed]:
    """Yield the laws' accelerations of the reduced model, without body rates or without lateral velocity."""
    still = dict.fromkeys(s.w, sp.S.Zero)
    demand = law.law["v2"].demand
    r, w, (_, vy, vz) = law.r, law.w, s.v
    along, across = (
        s.names.derived(name, latex, law.motion[rate].xreplace(demand).xreplace(still))
        for name, latex, rate in (
            ("vx_rate_V2", r"\dot v_x", s.v_dot[0]),
            ("vy_rate_V2", r"\dot v_y", s.v_dot[1]),
        )
    )
    decay = sp.exp(-w[1] * r[1] * 500 * v.second)
    yield printed(
        "section 4, diagram 1",
        "v_x grows with a_x; v_y and v_z go to zero asymptotically by 500 s",
        "statement",
        Relation(along, s.F / (s.m + s.m0 + s.total(s.i.m)), says="once the body does not turn"),
        Relation(across, -w[1] * r[1] * vy, says="once the body does not turn, under V_2"),
        Relation(decay, v.printed("0.02"), "<", cases=(v.those_in(decay),), says="four time constants of 125 s"),
    )
    turn = s.names.derived("u_3_V2", "u_3", demand[law.u[2]].xreplace({vy: sp.S.Zero, vz: sp.S.Zero}), text="u_3")
    slow = (w[3] - sp.sqrt(w[3] ** 2 - 4 * r[3] * r[4])) / (2 * r[4])
    left = sp.exp(-slow * 200 * v.second)
    yield printed(
        "section 4, diagram 2",
        "the attitude goes to zero by 200 s",
        "statement",
        Relation(r[4] * turn, -(r[3] * s.att[0] + w[3] * s.w[0]), says="without lateral velocity, under V_2"),
        Relation(left, v.printed("0.01"), "<", cases=(v.those_in(left),), says="the slower of the two poles"),
        Relation(
            slow,
            sp.sqrt(r[3] / r[4]),
            "<=",
            domain=(w[3] ** 2 - 4 * r[3] * r[4],),
            says="no gain makes it faster than this: with r_3 = 10^-5, as printed, 1.4e-4 1/s",
        ),
    )
    yield printed(
        "section 4, diagrams 5 and 6",
        "(10)-(14) with (20)-(26) put in give the five inputs",
        "statement",
        Relation(
            s.names.derived("D", "D", _inputs_by_balances(s)),
            -(s.F**2) * sp.cos(s.delta[0]) * sp.cos(s.delta[1]) ** 2,
            says="the determinant of (10)-(14) by the inputs is not zero below 90 degrees",
        ),
        note="(9) is not among them: with the a_x of (19) it is met without lateral thrust only. The model takes the "
        "a_x that is left of the thrust.",
    )


def _inputs_by_balances(s: Spacecraft) -> Expr:
    return sp.Matrix(s.balance[1:]).jacobian([*s.delta, *s.M]).det()
