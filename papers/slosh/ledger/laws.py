# SPDX-License-Identifier: Apache-2.0
"""Lyapunov functions and control of the slosh paper: equations (27)-(36), as printed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import sympy as sp
from sympy import Expr

from mehvar import System
from mehvar.ledger import Case, Names, Printed, Relation, printed
from mehvar.mechanics import time_derivative
from mehvar.models.slosh.states import DEMAND

from .symbols import Spacecraft, equations, generic_names
from .terms import Shorthand

HALF = sp.Rational(1, 2)


@dataclass(frozen=True)
class Symbols:
    """Symbols of one law: V, its derivative, A, B, C, f and g of (29) or (30); and what its inputs are."""

    V: sp.Symbol
    V_dot: sp.Symbol
    ABC: tuple[sp.Symbol, ...]
    f: sp.ImmutableMatrix
    g: sp.ImmutableMatrix
    demand: Case


class Laws:
    """Symbols of section 3: inputs of the reduced model, its rates, V_1 and V_2, and their derivatives."""

    def __init__(self, system: System, names: Names, s: Spacecraft) -> None:
        self._definitions = system.definitions
        self._written: dict[sp.Symbol, Expr] = {}
        self.u = tuple(names.free(q, -2, 2, text=f"u_{k}") for k, q in enumerate(DEMAND, 1))
        gains = {q.name: q for law in system.controllers for q in law.parameters}
        self.r = {k: names.free(gains[f"r{k}"], "1/10", 4) for k in range(1, 11)}
        self.w = {k: names.free(gains[f"w{k}"], "1/10", 4) for k in range(1, 6)}
        self.axial = self._defined("ax_eq")
        self.motion = self._motion(system, s)
        self.rates = {rate: e.xreplace(self.motion) for rate, e in s.rates.items()}
        self.rates |= dict(zip(s.att, s.w, strict=True))
        self.law = {name: self._law(name, names, s) for name in ("v1", "v2")}

    def _defined(self, name: str) -> Expr:
        """Follow a definition of the derivation; an entry of f that is zero has none."""
        return next((self._followed(symbol) for symbol in self._definitions if symbol.name == name), sp.S.Zero)

    def _followed(self, symbol: sp.Symbol) -> Expr:
        """Write a definition out, and those it is made of, each once."""
        if symbol not in self._written:
            expr = self._definitions[symbol]
            parts = {part: self._followed(part) for part in expr.free_symbols if part in self._definitions}
            self._written[symbol] = expr.xreplace(parts)
        return self._written[symbol]

    def _motion(self, system: System, s: Spacecraft) -> dict[Expr, Expr]:
        """Rates along the reduced model, as derived, for its inputs u_1 to u_5."""
        shown = equations(system)
        axial = {sp.Symbol("a_x", real=True): self.axial}
        numbers = {"x": "", "y": "(20)", "z": "(21)"}
        linear = [shown[number, rf"\dot v_{axis}"].xreplace(axial) for axis, number in numbers.items()]
        angular = [shown[f"({22 + k})", rf"\dot\Omega_{k + 1}"] for k in range(3)]
        motion = dict(zip((*s.v_dot, *s.w_dot), (*linear, *angular), strict=True))
        for bob in s.bobs:
            member = generic_names(bob) | axial
            motion[bob.phi_ddot] = shown["(25)", r"\ddot\varphi_i"].xreplace(member)
            motion[bob.theta_ddot] = shown["(26)", r"\ddot\theta_i"].xreplace(member)
        return motion

    def _law(self, name: str, names: Names, s: Spacecraft) -> Symbols:
        """V and its derivative along the reduced model; the coefficients of (29), (30) and the inputs as derived."""
        k, hat, accent = ("1", "", "") if name == "v1" else ("2", r"\hat ", "_hat")
        value = self._defined(f"V_{name}")

        def coefficient(letter: str, index: str = "") -> sp.Symbol:
            place = f"_{{{index}}}" if index else ""
            low = "".join(sorted(index, reverse=True))
            return names.derived(
                f"{letter}{accent}{'_' if index else ''}{index}",
                rf"{hat}{letter}{place}",
                self._defined(f"{letter}{low}_{name}"),
            )

        return Symbols(
            names.derived(f"V_{k}", f"V_{k}", value),
            names.derived(f"V_{k}_dot", rf"\dot V_{k}", time_derivative(value, self.rates)),
            tuple(coefficient(letter) for letter in "ABC"),
            sp.ImmutableMatrix(3, 3, [coefficient("f", f"{i}{j}") for i in "123" for j in "123"]),
            sp.ImmutableMatrix([coefficient("g", i) for i in "123"]),
            {u: self._defined(f"u{j}_{name}") for j, u in enumerate(self.u, 1)},
        )


def candidates(s: Spacecraft, law: Laws) -> Iterator[Printed]:
    """(27)-(30): the Lyapunov functions and the form of their derivatives."""
    first, corrected = _first(s, law, True), _first(s, law, False)
    names, v1, v2 = s.names, law.law["v1"], law.law["v2"]
    yield (
        printed(
            "27",
            "Lyapunov function with the pendulums",
            "definition",
            note="V_1 is the authors' choice, but they state (29), which does not follow from it.",
        )
        .reading(
            "I_i moments of inertia",
            Relation(v1.V, first, corrected=corrected),
            why="As in the energy (5).",
        )
        .reading(
            "I_i per unit of the pendulum's mass",
            Relation(v1.V, _first(s, law, True, {s.i.I: s.i.I / s.i.m})),
            used=False,
            why="Then no factor m_i is missing, but the terms with l_i^2 are.",
        )
    )
    yield printed("28", "Lyapunov function without the pendulums", "definition", Relation(v2.V, _second(s, law)))
    yield from _positivity(s, law)
    pull = [
        names.matrix(
            f"d(dV_1/dt)/du with V_1 as {text}",
            rf"\left.\partial\dot V_1/\partial(u_3,u_4,u_5)\right|_{{\Omega=0}}^\mathrm{{{text}}}",
            _pull(law, s, value),
        )
        for text, value in (("printed", first), ("corrected", corrected))
    ]
    yield printed(
        "text before (29)",
        "form of the derivative of V_1",
        "statement",
        Relation(
            pull[0],
            sp.zeros(3, 1),
            corrected_left=pull[1],
            says="along (20)-(26), u_3 to u_5 appear only multiplied by a body rate",
        ),
        note="The left side is the part of dV_1/dt that u_3 to u_5 multiply where Omega = 0, with V_1 as "
        "(27) prints it and as it is corrected.",
    )
    yield _form("29", "derivative of V_1", s, law, v1)
    yield _form("30", "derivative of V_2", s, law, v2)


def _second(s: Spacecraft, law: Laws) -> Expr:
    r, squares = law.r, (s.v[1], s.v[2], s.att[0], s.w[0], s.att[1], s.w[1], s.att[2], s.w[2])
    return sp.Mul(HALF, sp.Add(*(r[k] * x**2 for k, x in enumerate(squares, 1))), evaluate=False)


def _first(s: Spacecraft, law: Laws, as_printed: bool, meaning: Mapping[Expr, Expr] | None = None) -> Expr:
    i = s.i
    lean, swing, inertias = _products(s, as_printed)
    bob = law.r[9] * (i.phi_dot**2 - lean / inertias[0]) + law.r[10] * (i.theta_dot**2 - swing / inertias[1])
    return _second(s, law) + HALF * s.total(i.m * bob.xreplace(dict(meaning or {})))


def _products(s: Spacecraft, as_printed: bool) -> tuple[Expr, Expr, tuple[Expr, Expr]]:
    """Return the products of (27) of a pendulum's rates with the body rates, and what they are divided by."""
    i, t, (W1, W2, W3) = s.i, Shorthand(s.i), s.w
    q, turn = i.phi_dot, i.theta_dot
    reach, square = i.h * i.l, i.l**2
    if as_printed:
        lean = -2 * q * W3 * reach * t.cS + 2 * q * W2 * reach * t.cC - 2 * q * W1 * i.I
        swing = -2 * turn * W3 * i.I - 2 * turn * W3 * reach * t.sC - 2 * turn * W2 * reach * t.sS
        return lean, swing, (square * t.s**2 + i.I, i.I)
    lean = (
        -2 * q * W3 * i.m * reach * t.cS
        + 2 * q * W2 * i.m * reach * t.cC
        - 2 * q * W1 * i.I
        + 2 * q * W3 * i.m * square * t.S
        - 2 * q * W2 * i.m * square * t.C
    )
    swing = (
        -2 * turn * W3 * i.I
        - 2 * turn * W3 * i.m * reach * t.sC
        - 2 * turn * W2 * i.m * reach * t.sS
        + 2 * turn * W3 * i.m * square * t.s * t.cC
        + 2 * turn * W2 * i.m * square * t.s * t.cS
        + 2 * turn * W1 * i.m * square * t.s**2
    )
    return lean, swing, (i.m * square + i.I, i.m * square * t.s**2 + i.I)


def _positivity(s: Spacecraft, law: Laws) -> Iterator[Printed]:
    """Yield the sentences between (28) and (29): both functions are positive."""
    v1, v2 = law.law["v1"], law.law["v2"]
    yield printed(
        "text after (28), V_2",
        "V_2 is positive as a sum of squares",
        "statement",
        Relation(v2.V, sp.S.Zero, ">"),
    )
    large = s.names.free("large", 10**3, 10**4, latex=r"r_{\gg 1}")
    small = s.names.free("small", "1/1000000", "1/100000", latex=r"r_{\ll 1}")

    def ordered(of_hull: Expr, of_bobs: Expr) -> Relation:
        weights = dict.fromkeys((law.r[k] for k in range(3, 9)), of_hull) | dict.fromkeys(
            (law.r[9], law.r[10]), of_bobs
        )
        return Relation(v1.V, sp.S.Zero, ">", cases=(weights,))

    yield (
        printed(
            "text after (28), V_1",
            "V_1 is positive for the order of its weights",
            "statement",
            note="Completing the squares of the pendulums' rates leaves the f of (29) in place of r_4, r_6 and r_8: "
            "V_1 is positive where f is, however the weights are ordered. The angles of the pendulums are in neither.",
        )
        .reading(
            "r_3 to r_8 >> 1 >> r_9, r_10",
            Relation(v1.V, _completed(s, law), says="V_1 in squares, and f"),
            ordered(large, small),
            why="As Table 2 has r_4, r_6, r_8, r_9 and r_10.",
        )
        .reading(
            "r_9, r_10 >> 1 >> r_3 to r_8",
            ordered(small, large),
            used=False,
            why="So the text at hand prints it; the products with the body rates then outweigh their squares.",
        )
    )


def _completed(s: Spacecraft, law: Laws) -> Expr:
    """Write V_1 with the squares of the pendulums' rates completed."""
    i, f, W = s.i, law.law["v1"].f, s.w
    lean, swing, inertias = _products(s, False)
    moved = [
        rate - product.diff(rate) / (2 * inertia)
        for rate, product, inertia in zip((i.phi_dot, i.theta_dot), (lean, swing), inertias, strict=True)
    ]
    turning = sp.Add(*(f[j, k] * W[j] * W[k] for j in range(3) for k in range(3)))
    r = law.r
    hull = sp.Add(*(r[k] * x**2 for k, x in zip((1, 2, 3, 5, 7), (s.v[1], s.v[2], *s.att), strict=True)))
    return HALF * (hull + turning) + HALF * s.total(i.m * (r[9] * moved[0] ** 2 + r[10] * moved[1] ** 2))


def _pull(law: Laws, s: Spacecraft, value: Expr) -> sp.Matrix:
    """Differentiate a V along the reduced model and take the rest of u_3 to u_5 without body rates."""
    still, value = dict.fromkeys(s.w, sp.S.Zero), value.doit()
    slopes = {x: value.diff(x).xreplace(still) for x in law.rates}
    return sp.Matrix([sp.Add(*(slopes[x] * law.rates[x].diff(u).xreplace(still) for x in slopes)) for u in law.u[2:]])


def _form(number: str, title: str, s: Spacecraft, law: Laws, v: Symbols) -> Printed:
    (a, b, c), u = v.ABC, law.u
    turning = (sp.Add(*(v.f[i, j] * u[2 + j] for j in range(3)), v.g[i]) * s.w[i] for i in range(3))
    return printed(
        number,
        title,
        "equation",
        Relation(v.V_dot, sp.Add(a, b * u[0], c * u[1], *turning)),
        note="The sum is written out.",
    )


def control(s: Spacecraft, law: Laws) -> Iterator[Printed]:
    """(31)-(36): the inputs."""
    yield from _inputs(31, "V_1", s, law, law.law["v1"])
    yield from _inputs(34, "V_2", s, law, law.law["v2"])


def _inputs(number: int, name: str, s: Spacecraft, law: Laws, v: Symbols) -> Iterator[Printed]:
    w, u, cases = law.w, law.u, (v.demand,)
    _, b, c = v.ABC
    yield printed(
        str(number),
        f"input u_1 from {name}",
        "equation",
        Relation(u[0], w[1] * b, corrected=-w[1] * b, cases=cases),
    )
    yield printed(
        str(number + 1),
        f"input u_2 from {name}",
        "equation",
        Relation(u[1], w[2] * c, corrected=-w[2] * c, cases=cases),
    )
    gained = sp.ImmutableMatrix([v.g[k] + w[3 + k] * s.w[k] for k in range(3)])
    yield printed(
        str(number + 2),
        f"inputs u_3 to u_5 from {name}",
        "equation",
        Relation(sp.ImmutableMatrix(u[2:]), sp.MatMul(-1, sp.Inverse(v.f), gained), cases=cases),
    )
