# SPDX-License-Identifier: Apache-2.0
"""The ledger of the triangle's paper: every number once, the misprints where they are, and verdicts with teeth."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

import pytest
import sympy as sp

from mehvar.codegen.ledger.ledger import EntryVerdict, Ledger
from mehvar.models.paper import Names, Paper, Relation, printed
from mehvar.models.quantities import ModelError
from mehvar.models.system import System
from papers.triangle.ledger import NUMBERS, paper
from tests.papers.ledgers import broken, check_ledger, checked, judged

MISPRINTS: Mapping[str, str] = {
    "text after (9)": "sign of X_i.T*J*X_dot_i: printed +, correct -",
    "text before (11)": "factor I is missing",
    "(11)": "m should read m_bar",
    "(13)": "in m_1*x_1.T: m_1 should read x_1",
    "text after (18)": "theta_dot should read S_dot",
    "Table 1, row 3": "factor sqrt(3/(2*mu)) is missing",
    "(19)": "in -sqrt(3)*eta/mu: exponent of eta: printed 1, correct 1/2",
    "(22)": "sign of mu*rho*w2*sqrt(1 - rho**2)*sin(Delta_phi_i + phi)/(3*l_i): printed +, correct -",
    "(27)": "number before a*rho_t_0*sin(phi_t_0): printed 1/2, correct 1",
    "(30)": "sign of a**2*sin(phi_t)**2: printed +, correct -",
    "(32)": "h should read g",
    "(35)": "term rho_t_dot is missing",
    "text before (36), rate of the attitude": "phi_t_dot should read theta_t_dot",
    "text before (36), slope of f": "exponent of f: printed m - 1, correct 1 - m",
    "text after (36)": "in -rho_t*sigma**2/(m*theta_star): exponent of rho_t: printed 1, correct 2",
    "text before (37)": "h should read f",
    "(38)": "theta should read theta_t",
    "(41)": "in a*xi: a should read alpha",
    "text after (41)": "sign of phi_f - phi_star: printed -, correct +",
    "text after (42)": "xi and pi are exchanged",
    "(44)": "factor v_2 is missing",
    "text before (47)": "theta_max > Abs(theta_1) should read theta_max < Abs(theta_1)",
    "(48)": "factor cos(xi/2) is missing",
    "section 4, R": "factor metre does not belong there",
    "section 4, sliding mode": "pi/45 should read 4",
    "(52)": "mu should read mu_dot",
    "text after (52)": "theta_t should read sign(s)",
    "(53)": "term -t_s/I_bar is missing",
}
AMBIGUOUS = {"text before (28)", "(36)", "text before (41)", "section 4, k_phi", "section 4, rod lengths"}
DEFINITIONS = {3, 4, 6, 7, 14, 25, 29, 31, 34, 37, 40, 45, 47}


def test_every_number_is_there_once_and_every_erratum_has_one_kind_and_a_cause(ledger: Ledger) -> None:
    check_ledger(ledger, NUMBERS)


def test_the_verdicts(ledger: Ledger) -> None:
    assert judged(ledger, EntryVerdict.DIFFERS) == set(MISPRINTS)
    assert judged(ledger, EntryVerdict.AMBIGUOUS) == AMBIGUOUS
    assert judged(ledger, EntryVerdict.DEFINITION) == {f"({k})" for k in DEFINITIONS}


def test_each_misprint_is_at_its_term(ledger: Ledger) -> None:
    for number, edits in MISPRINTS.items():
        assert edits in ledger[number].edits, number


def test_each_misprint_has_a_correction_that_passes_and_a_counterexample(ledger: Ledger) -> None:
    for number in MISPRINTS:
        wrong = [line for line in ledger[number].used.lines if line.verdict is EntryVerdict.DIFFERS]
        assert all(line.corrected_latex for line in wrong), number
        assert all("the corrected form is" in line.how for line in wrong), number
        assert all(line.counterexample or "matrix" in line.how for line in wrong), number


def test_the_reading_that_the_model_follows_holds(ledger: Ledger) -> None:
    for number in AMBIGUOUS:
        assert ledger[number].used.verdict in (EntryVerdict.HOLDS, EntryVerdict.DEFINITION), number


def test_the_counterexample_of_22(ledger: Ledger) -> None:
    """At rho = 1/2, phi = 0, mu = 1 and w2 = 1 alone, rod 1 grows: +(1/3 l_1)(1/2)(sqrt 3/2) sin(2 pi/3)."""
    point = ledger["(22)"].counterexample
    assert point is not None
    at = {name: value for name, value in point.at if name in ("rho", "phi", "mu", "w1", "w2", "w3")}
    assert at == {"rho": "1/2", "phi": "0", "mu": "1", "w1": "0", "w2": "1", "w3": "0"}
    length = sp.sqrt(sp.Rational(1, 3) * (1 - sp.sqrt(3) / 4))
    rate = sp.Rational(1, 3) / length * sp.Rational(1, 2) * sp.sqrt(3) / 2 * sp.sqrt(3) / 2
    assert float(point.left) == pytest.approx(float(rate), rel=1e-5)
    assert float(point.right) == pytest.approx(-float(rate), rel=1e-5)


def verdicts(system: System, *numbers: str) -> list[EntryVerdict]:
    """Judge a few entries of the paper against another system."""
    return [entry.verdict for entry in checked(paper(system), *numbers).values()]


@pytest.mark.soak
def test_a_wrong_law_of_motion_turns_the_verdicts(system: System) -> None:
    rhs = (*system.rhs[:3], -system.rhs[3])
    wrong = dataclasses.replace(system, rhs=rhs)
    forms = [f"section 3, {form}" for form in ("nonholonomic integrator", "chained form", "Brockett")]
    assert verdicts(wrong, "12", "21", "23", "24", "53", *forms[:2]) == [EntryVerdict.DIFFERS] * 7
    assert verdicts(wrong, "20", forms[2]) == [EntryVerdict.HOLDS] * 2
    drifting = dataclasses.replace(system, rhs=(*system.rhs[:3], system.rhs[3] + sp.Rational(1, 1000)))
    assert verdicts(drifting, forms[2]) == [EntryVerdict.DIFFERS]


@pytest.mark.parametrize(
    ("wrong", "turned", "unmoved"),
    [
        (["length2", "theta_exact", "h"], ["5", "16", "20", "26", "28", "29"], ["19", "25", "31", "42", "45"]),
        (["rod_rate1", "g", "turn_rate"], ["6", "32", "33", "45", "46"], ["20", "28", "31", "37", "42"]),
        (["f", "sigma", "x_tangent"], ["29", "31", "34", "37", "text before (47), tangency"], ["28", "33", "47"]),
    ],
)
@pytest.mark.soak
def test_wrong_steps_of_the_derivation_turn_the_verdicts(
    system: System, wrong: list[str], turned: list[str], unmoved: list[str]
) -> None:
    standings = dict(zip((*turned, *unmoved), verdicts(broken(system, *wrong), *turned, *unmoved), strict=True))
    assert [number for number in turned if standings[number] is not EntryVerdict.DIFFERS] == []
    assert [
        number for number in unmoved if standings[number] is EntryVerdict.DIFFERS and f"({number})" not in MISPRINTS
    ] == []


def test_a_correction_against_a_wrong_derivation_is_not_shown(system: System) -> None:
    entry = checked(paper(broken(system, "rod_rate1")), "22")["22"]
    assert entry.verdict is EntryVerdict.DIFFERS
    assert entry.corrected_latex == ()


def test_a_paper_refuses_what_is_missing_or_unknown() -> None:
    names = Names()
    x, member = names.free("x"), names.family("member", "x_i")
    one = printed("1", "", "equation", Relation(x, x))
    with pytest.raises(ModelError, match=r"missing \[2\]"):
        Paper("", 2, names, (one,))
    with pytest.raises(ModelError, match=r"entered twice \['1'\]"):
        Paper("", 1, names, (one, one))
    with pytest.raises(ModelError, match=r"not in the paper \['7'\]"):
        Paper("", 1, names, (one, printed("7", "", "equation")))
    with pytest.raises(ModelError, match=r"entry 1 uses 'z', which the table of names lacks"):
        Paper("", 1, names, (printed("1", "", "equation", Relation(x, sp.Symbol("z"))),))
    with pytest.raises(ModelError, match=r"entry 1 uses 'member', an indexed name"):
        Paper("", 1, names, (printed("1", "", "equation", Relation(x, member)),))
    with pytest.raises(ModelError, match="occurs twice in the table of names"):
        names.derived("x", "x", sp.S.One)
    with pytest.raises(ModelError, match="must use exactly one reading"):
        Paper("", 1, names, (one.reading("another", Relation(x, x)),))
    with pytest.raises(ModelError, match="must use exactly one reading"):
        Paper("", 1, names, (printed("1", "", "equation").reading("read", Relation(x, x), used=False),))
