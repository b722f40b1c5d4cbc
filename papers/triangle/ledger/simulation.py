# SPDX-License-Identifier: Apache-2.0
"""The simulation section of the triangle's paper: equations (52), (53), the smoothing and the numbers, as printed."""

from __future__ import annotations

from collections.abc import Iterator

import sympy as sp
from sympy import Expr

from mehvar import System
from mehvar.ledger import Case, Names, Printed, Relation, printed

from .laws import Shifted, Sliding, default, law_of
from .symbols import Kinematics


def runs(system: System, names: Names, k: Kinematics, t: Shifted, s: Sliding) -> Iterator[Printed]:
    """(52), (53), the smoothing, and the numbers of section 4."""
    metre = names.free("metre", "1/10", 4, latex=r"\mathrm{m}")
    sliding, path = law_of(system, "sliding"), law_of(system, "path")
    chosen = {q.symbol: default(sliding, q.name) for q in sliding.parameters if q.name != "eta_rho"}
    yield printed(
        "section 4, R",
        "radius of the largest circle",
        "data",
        Relation(s.R, sp.Rational(65, 100) * metre, corrected=sp.Rational(65, 100), cases=({s.R: chosen[s.R]},)),
    )
    k_path = names.derived("k_path", r"k_\varphi", default(path, "k_phi"), text="k_phi")
    yield (
        printed("section 4, k_phi", "gains of the two designs", "data")
        .reading(
            "3, and 0.5 with the decimal sign lost",
            Relation(s.k_phi, sp.Integer(3), cases=(chosen,)),
            Relation(k_path, sp.Rational(1, 2)),
            why="The paper says that the gains make both designs take the same time and that the second needs "
            "the smaller inputs. That holds with 0.5 and fails with 5, which the scenario `printed` keeps.",
        )
        .reading(
            "3 and 5, as printed",
            Relation(s.k_phi, sp.Integer(3), cases=(chosen,)),
            Relation(k_path, sp.Integer(5), corrected=sp.Rational(1, 2)),
            used=False,
            why="Ten times too fast for the comparison.",
        )
    )
    star = {s.theta_star: chosen[s.theta_star]}
    yield printed(
        "section 4, sliding mode",
        "m, theta* and eta_rho",
        "data",
        Relation(s.m, sp.Integer(3), cases=(chosen,)),
        Relation(s.theta_star, 4 * sp.pi / 180, corrected=sp.Integer(4), cases=(star,)),
        Relation(s.eta, s.k_phi * s.R / s.m, cases=({s.eta: default(sliding, "eta_rho")},)),
        note="The initial error of 1 rad would exceed 4 degrees.",
    )
    margin = names.family("l_a + l_b - l_c", r"l_a + l_b - l_c")
    yield (
        printed(
            "section 4, rod lengths",
            "initial and final rods",
            "data",
            note="The lengths are scenario parameters.",
        )
        .reading(
            "0.2, 0.2, 0.3 m and 0.3, 0.3, 0.5 m",
            _triangles(margin, ("0.2", "0.2", "0.3"), ("0.3", "0.3", "0.5")),
            why="Both are triangles, the initial theta~ is 1 as the text says, the limit of (52) acts, and both "
            "designs take the same time.",
        )
        .reading(
            "0.2, 0.2, 0.3 m and 0.3, 0.4, 0.5 m",
            _triangles(margin, ("0.2", "0.2", "0.3"), ("0.3", "0.4", "0.5")),
            used=False,
            why="Possible too: the scenario `paper-b`.",
        )
        .reading(
            "0.12, 0.12, 0.32 m and 0.32, 0.32, 0.52 m",
            _triangles(margin, ("0.12", "0.12", "0.32"), ("0.32", "0.32", "0.52")),
            used=False,
            why="As the digits stand; the initial rods do not form a triangle.",
        )
    )
    rate, limit, size = _law_of_size(system, names, k)
    yield printed(
        "52",
        "law of the size",
        "definition",
        Relation(rate, sp.Rational(1, 2) * (t.mu_f - k.mu)),
        Relation(limit, sp.Rational(5, 100)),
        Relation(k.mu, k.w3, corrected_left=k.mu_dot, cases=(size,)),
        Relation(k.w3, sp.Min(sp.Abs(rate), limit) * sp.sign(rate), cases=(size,)),
        note="The number is printed twice.",
    )
    yield printed(
        "text after (52)",
        "smoothed signs",
        "definition",
        Relation(
            t.theta,
            sp.Max(-1, sp.Min(1, s.s / s.s_min)),
            corrected_left=sp.sign(s.s),
            domain=(sp.Abs(s.s) - s.s_min,),
            says="sat(s/s_min) stands for sgn(s): equal outside |s| < s_min",
        ),
        Relation(
            sp.sign(t.theta),
            sp.Max(-1, sp.Min(1, t.theta / s.theta_min)),
            domain=(sp.Abs(t.theta) - s.theta_min,),
            says="equal outside |theta~| < theta~_min",
        ),
        Relation(s.s_min, sp.Rational(2, 100), cases=(chosen,)),
        Relation(s.theta_min, sp.Rational(1, 1000), cases=(chosen,)),
        note="Not said: whether sgn(theta~) is smoothed in rho~'_eq too. The model smooths it in phi~' only.",
    )
    disturbed = system.rhs[3].subs(system.parameters.H, 0)
    drift = names.free(next(q for q in system.parameters if q.name == "disturbance"), -1, 1, latex="d", text="d")
    yield printed(
        "53",
        "disturbance",
        "equation",
        Relation(
            k.theta_dot,
            -k.t_read / k.I_read + drift,
            corrected=-k.t_s / k.I_bar + drift,
            cases=({k.theta_dot: disturbed},),
        ),
        note="The text says that d is added to (12); it is added to theta' that (12) gives. d = 0.001 rad/s.",
    )


def _law_of_size(system: System, names: Names, k: Kinematics) -> tuple[sp.Symbol, sp.Symbol, Case]:
    """Return the rate that the size is to have, its limit, and what the law makes of both."""
    sliding = law_of(system, "sliding")
    p = {q.name: q.symbol for q in sliding.parameters}
    numbers = {p[name]: default(sliding, name) for name in ("mu_gain", "mu_rate_max")}
    command: Expr = sliding.command[-1]
    rate = names.derived("mu_d_dot", r"\dot\mu_d", command.subs(p["mu_rate_max"], sp.oo).subs(numbers))
    limit = names.derived("mu_max_dot", r"\dot\mu_{max}", numbers[p["mu_rate_max"]])
    return rate, limit, {k.w3: command.subs(numbers)}


def _triangles(margin: sp.Symbol, *lengths: tuple[str, str, str]) -> Relation:
    """Return the triangle inequality for the rods at the start and at the end."""
    rods = [[sp.Rational(length) for length in triangle] for triangle in lengths]
    cases = tuple({margin: sp.Add(*triangle) - 2 * max(triangle)} for triangle in rods)
    return Relation(margin, sp.S.Zero, ">", cases=cases, says="the triangle inequality, initial and final")
