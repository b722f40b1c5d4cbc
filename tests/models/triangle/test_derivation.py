# SPDX-License-Identifier: Apache-2.0
"""The triangle's derived equations against the published forms and their properties."""

import itertools

import pytest
import sympy as sp

from mehvar.models.mechanics import planar_cross
from mehvar.models.system import Definition, Derivation, System
from mehvar.models.triangle import dynamics
from mehvar.models.triangle.controllers import arc_area
from mehvar.models.triangle.dynamics import base_triangle, shifted_attitude
from tests import derived

RHO, PHI, MU = (q.symbol for q in (dynamics.RHO, dynamics.PHI, dynamics.MU))
W1, W2, W3 = (q.symbol for q in (dynamics.W1, dynamics.W2, dynamics.W3))
POINT = {
    RHO: sp.Rational(2, 5),
    PHI: sp.Rational(7, 10),
    MU: sp.Rational(1, 3),
    W1: sp.Rational(1, 7),
    W2: -sp.Rational(3, 5),
    W3: sp.Rational(1, 9),
}


def in_paper_chart(system: System, expr: sp.Expr) -> sp.Expr:
    """Follow definitions and the chart down to rho, phi, mu and their rates."""
    coordinates = system.coordinates
    chart = dict(zip(coordinates.states.symbols[:2], coordinates.from_state, strict=False))
    chart |= dict(zip(coordinates.inputs.symbols[:2], coordinates.from_input, strict=False))
    known = system.definitions
    for _ in range(4):
        expr = expr.xreplace(known)
    return expr.xreplace(chart)


@pytest.mark.parametrize(("k", "shift"), [(1, -2 * sp.pi / 3), (2, 2 * sp.pi / 3), (3, sp.S.Zero)])
def test_rod_lengths_are_20_and_rates_are_22(system, k, shift):
    length = sp.sqrt(MU / 3 * (1 + 2 * RHO * sp.sqrt(1 - RHO**2) * sp.cos(PHI + shift)))
    result = in_paper_chart(system, sp.Symbol(f"length{k}", positive=True))
    assert sp.N((result - length).subs(POINT), 40) == pytest.approx(0, abs=1e-35)
    rate = (
        length / (2 * MU) * W3
        + MU / (3 * length) * (1 - 2 * RHO**2) / sp.sqrt(1 - RHO**2) * sp.cos(PHI + shift) * W1
        - MU / (3 * length) * RHO * sp.sqrt(1 - RHO**2) * sp.sin(PHI + shift) * W2
    )
    result = in_paper_chart(system, sp.Symbol(f"rod_rate{k}", real=True))
    assert sp.N((result - rate).subs(POINT), 40) == pytest.approx(0, abs=1e-35)


def test_momentum_balance_is_12_and_18(system):
    equations = {step.left: step.expr for step in system.steps if not isinstance(step, Definition)}
    momentum, disturbance, mass = system.parameters.symbols
    assert sp.simplify(equations[r"\bar I"] - MU / 3) == 0
    assert sp.simplify(system.rhs[3] - (RHO**2 * W2 + 3 * momentum / (mass * MU) + disturbance)) == 0


@pytest.mark.parametrize("masses", [(1, 1, 1), (1, 2, sp.Rational(7, 2)), (5, 1, 1)])
def test_base_triangle_meets_its_conditions(masses):
    """The base edges, placed from their lengths and directions, have the moments that (2) and (13) ask for."""
    d = Derivation()
    base = base_triangle(tuple(map(sp.Rational, masses)), d)
    mean = sum(map(sp.Rational, masses)) / 3
    edges = []
    for squared, cosine, sine in zip(base.length_squared, base.cosine, base.sine, strict=True):
        squared, cosine, sine = (
            sp.N(sp.sympify(e).subs(d.definitions).subs(d.definitions), 40) for e in (squared, cosine, sine)
        )
        length, double = sp.sqrt(squared), sp.atan2(sine, cosine)
        edges.append((length, double / 2))
    options = itertools.product((0, sp.pi), repeat=2)
    best = min(
        (_moment_error(masses, mean, edges, turns) for turns in options),
        key=lambda pair: pair[0],
    )
    assert best[0] < 1e-30
    assert best[1] > 0


def _moment_error(masses, mean, edges, turns):
    """Close the triangle with edge 3 along +x and compare its second moments; the second value is its area."""
    d1, d2, d3 = (
        sp.Matrix([length * sp.cos(angle + turn), length * sp.sin(angle + turn)]).evalf(40)
        for (length, angle), turn in zip(edges, (*turns, 0), strict=True)
    )
    corners = [sp.zeros(2, 1), d3, d3 + d1]
    centre = sum((m * c for m, c in zip(masses, corners, strict=True)), sp.zeros(2, 1)) / (3 * mean)
    moment = sum((m * (c - centre) * (c - centre).T for m, c in zip(masses, corners, strict=True)), sp.zeros(2, 2))
    gap = sum((abs(v) for v in (d1 + d2 + d3)), 0)
    return gap + sum(abs(v) for v in moment - mean / 2 * sp.eye(2)), planar_cross(d3, d1)


def test_shape_of_27_obeys_26():
    """d(theta~)/dt = rho~^2 phi~' holds identically for the derived factor and fails for the printed half."""
    t, a, target = sp.symbols("t a phi_f", real=True)
    w = [sp.Function(f"w{k}")(t) for k in (1, 2)]
    position = sp.Matrix(
        [
            (a - w[0]) * sp.cos(target) + w[1] * sp.sin(target),
            (a - w[0]) * sp.sin(target) - w[1] * sp.cos(target),
        ]
    )
    theta_rate = planar_cross(position, position.diff(t))
    for factor, holds in ((1, True), (sp.Rational(1, 2), False)):
        shift = shifted_attitude(sp.S.Zero, a, tuple(w), factor)
        left = sp.simplify(theta_rate + shift.diff(t) - planar_cross(sp.Matrix(w), sp.Matrix(w).diff(t)))
        assert (left == 0) is holds


def test_arc_area_is_42():
    xi = sp.Symbol("xi", real=True)
    printed = (sp.pi - xi - sp.sin(xi)) / (1 + sp.cos(xi))
    derived = arc_area((sp.pi - xi) / 2)
    for value in (-2, -sp.Rational(1, 2), 1, 3):
        assert sp.N((printed - derived).subs(xi, value), 30) == pytest.approx(0, abs=1e-25)


def test_equal_masses_are_a_case_of_the_general_ones(system):
    general = derived.system("triangle", masses="general")
    masses = {q.symbol: sp.S.One for q in general.parameters.quantities[2:]}
    expr = sp.Symbol("length1", positive=True)
    for _ in range(4):
        expr = expr.xreplace(general.definitions)
    equal = sp.Symbol("length1", positive=True)
    for _ in range(4):
        equal = equal.xreplace(system.definitions)
    assert sp.simplify(expr.xreplace(masses) - equal) == 0


def test_every_number_the_derivation_carries_is_of_the_paper(system):
    numbers = {n for step in system.steps for n in step.number.replace(" ", "").split(",") if n}
    assert {
        "(19)",
        "(20)",
        "(22)",
        "(25)",
        "(27)",
        "(28)",
        "(30)",
        "(31)",
        "(36)",
        "(37)",
        "(42)",
        "(46)",
    } <= numbers
    assert all(1 <= int(n.strip("()")) <= 53 for n in numbers)
