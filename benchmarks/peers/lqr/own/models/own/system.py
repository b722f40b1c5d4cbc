# SPDX-License-Identifier: Apache-2.0
"""The task's craft as a user's own system: equations by hand, one rank-one update of a 6 x 6 system per bob."""

from pathlib import Path

import sympy as sp

from mehvar import (
    Derivation,
    Group,
    Quantity,
    System,
    quaternion_of_turns,
    quaternion_rates,
    read_parameters,
    read_scenarios,
)

HERE = Path(__file__).parent
STRUCTURE: dict[str, tuple[str, ...]] = {}


def group(symbol: str, units: dict[str, str]) -> Group:
    """Return named quantities by their units."""
    return Group(symbol, tuple(Quantity(name, unit, name) for name, unit in units.items()))


def vector(name: str) -> list[str]:
    """Return the names of components."""
    return [f"{name}{axis}" for axis in "xyz"]


UNITS = {"v": "m/s", "w": "rad/s", "s1": "1", "e1": "1/s", "s2": "1", "e2": "1/s"}
QUATERNION = dict.fromkeys(("q0", "q1", "q2", "q3"), "1")
NAMED = [dict.fromkeys(vector(name), unit) for name, unit in UNITS.items()]
X = group("x", NAMED[0] | NAMED[1] | QUATERNION | NAMED[2] | NAMED[3] | NAMED[4] | NAMED[5])
U = group("u", dict.fromkeys(vector("f"), "N") | dict.fromkeys(vector("c"), "N m"))


def solved(a: list[list[sp.Expr]], b: list[sp.Expr], d: Derivation) -> list[sp.Expr]:
    """Solve a symmetric positive definite system by elimination, naming every step."""
    n = len(b)
    for i in range(n):
        for j in range(i + 1, n):
            k = d.define(f"k{i}{j}", a[j][i] / a[i][i], title="factor")
            a[j] = [d.define(f"a{i}{j}{c}", a[j][c] - k * a[i][c], title="entry") if c > i else 0 for c in range(n)]
            b[j] = d.define(f"b{i}{j}", b[j] - k * b[i], title="right side")
    x: list[sp.Expr] = []
    for i in reversed(range(n)):
        later = sum(p * q for p, q in zip(a[i][i + 1 :], x, strict=True))
        x.insert(0, d.define(f"x{i}", (b[i] - later) / a[i][i], title="solution"))
    return x


def equations(p: Group, d: Derivation) -> list[sp.Expr]:
    """Return the rates of the states."""
    x = sp.Matrix(X.symbols)
    v, w, q = x[:3, :], x[3:6, :], x[6:10, :]
    mass, middle = p.mass, sp.Matrix([p.ahead, 0, 0])
    about = sp.diag(p.J_x, p.J_y, p.J_z) + mass * (middle.dot(middle) * sp.eye(3) - middle * middle.T)
    hat = mass * middle.hat()
    a = sp.Matrix(sp.BlockMatrix([[mass * sp.eye(3), -hat], [hat, about]]))
    b = sp.Matrix(U.symbols) - sp.Matrix([*(mass * w.cross(w.cross(middle))), *w.cross(about * w)])
    bobs = []
    for k in (1, 2):
        m, length, pivot, eps = (getattr(p, f"{name}{k}") for name in ("m", "l", "h", "eps"))
        arm, turning = x[4 + 6 * k : 7 + 6 * k, :], x[7 + 6 * k : 10 + 6 * k, :]
        slip = named(f"slip{k}", turning - w.cross(arm), d)
        r = sp.Matrix([pivot, 0, 0]) + length * arm
        rest = named(f"rest{k}", w.cross(w.cross(r)) + 2 * length * w.cross(slip), d)
        drag = eps / length * slip
        onto = named(f"onto{k}", drag - m * (arm.dot(rest) - length * slip.dot(slip)) * arm, d)
        row = named(f"row{k}", sp.Matrix([*arm, *r.cross(arm)]), d)
        a += m * row * row.T
        b += sp.Matrix([*onto, *r.cross(onto)])
        bobs.append((length, arm, slip, r, rest + drag / m))
    both = sp.Matrix(solved(a.tolist(), list(b), d))
    linear, angular = both[:3, :], both[3:, :]
    rates = [*(linear - w.cross(v)), *angular, *quaternion_rates(q, w)]
    for k, (length, arm, slip, r, rest) in enumerate(bobs, 1):
        push = named(f"push{k}", linear + angular.cross(r) + rest, d)
        bend = -(push - arm * arm.dot(push)) / length - slip.dot(slip) * arm
        rates += [*slip, *(bend + angular.cross(arm) + w.cross(slip))]
    return rates


def named(name: str, values: sp.Matrix, d: Derivation) -> sp.Matrix:
    """Name the components of a vector."""
    return sp.Matrix([d.define(f"{name}_{i}", value, title=name) for i, value in enumerate(values, 1)])


def system() -> System:
    """Put the system together."""
    tables = read_parameters(HERE / "parameters.toml")
    scenarios, metrics = read_scenarios(HERE / "scenarios.toml")
    p, s = (Group(letter, tables[name].quantities) for letter, name in (("p", "plant"), ("s", "scenario")))
    d = Derivation()
    d.section("Equations of motion")
    turn = quaternion_of_turns(((2, s.att3_0), (1, s.att2_0), (0, s.att1_0)))
    angles = ((s.phi1_0, s.theta1_0), (s.phi2_0, s.theta2_0))
    arms = [[-sp.cos(f), sp.sin(f) * sp.sin(t), sp.sin(f) * sp.cos(t)] for f, t in angles]
    return System(
        name="own", title="a craft with two pendulums", source="the task", states=X, inputs=U,
        parameters=p, scenario_parameters=s,
        rhs=tuple(equations(p, d)), steps=tuple(d.steps),
        initial=(s.vx_0, s.vy_0, s.vz_0, *[sp.S.Zero] * 3, *turn, *arms[0], *[sp.S.Zero] * 3, *arms[1],
                 *[sp.S.Zero] * 3),
        controllers=(), scenarios=scenarios, metrics=metrics,
    )  # fmt: skip
