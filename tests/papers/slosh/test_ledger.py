# SPDX-License-Identifier: Apache-2.0
"""The ledger of the slosh paper: every number once, the misprints where they are, and verdicts with teeth."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

import pytest

from mehvar.codegen.ledger.ledger import EntryVerdict, Ledger
from mehvar.models.system import System
from papers.slosh.ledger import NUMBERS, paper
from tests.papers.ledgers import broken, check_ledger, checked, judged

pytestmark = pytest.mark.soak  # judging takes ten seconds; `make run` does it too

MISPRINTS: Mapping[str, tuple[str, ...]] = {
    "(1)": ("d/dt dL/dV_dot should read d/dt dL/dV",),
    "(2)": ("d/dt dL/dOmega_dot should read d/dt dL/dOmega",),
    "(3)": ("dR/dzeta should read dR/dzeta_dot",),
    "(9)": (
        "term (Omega_2**2 - Omega_3**2)*(h_i - l_i*cos(phi_i)) does not belong there",
        "term -(Omega_2**2 + Omega_3**2)*(h_i - l_i*cos(phi_i)) is missing",
    ),
    "(10)": ("sign of 2*Omega_1*phi_i_dot*cos(phi_i)*cos(theta_i): printed +, correct -",),
    "(11)": ("term 2*Omega_1*theta_i_dot*sin(phi_i)*cos(theta_i) is missing",),
    "(12)": (
        "term -l_i**2*theta_i_ddot is missing",
        "term Omega_3*l_i*vz*cos(phi_i) does not belong there",
        "term I_i*Omega_2*Omega_3 does not belong there",
    ),
    "(13)": (),
    "(14)": (),
    "(15)": (),
    "(16)": (),
    "(25)": ("factor m_i is missing", "sign of eps_i*phi_i_dot/m_i: printed -, correct +"),
    "(26)": ("factor m_i is missing", "sign of eps_i*theta_i_dot/m_i: printed -, correct +"),
    "(27)": (
        "in l_i**2*sin(phi_i)**2: factor m_i is missing",
        "in l_i**2*sin(phi_i)**2: factor sin(phi_i)**2 does not belong there",
    ),
    "text before (29)": (),
    "(31)": ("sign of B*w1: printed +, correct -",),
    "(32)": ("sign of C*w2: printed +, correct -",),
    "(34)": ("sign of B_hat*w1: printed +, correct -",),
    "(35)": ("sign of C_hat*w2: printed +, correct -",),
}
AMBIGUOUS = {
    *("text after (7), omega_i", "text after (28), V_1"),
    *("Table 1, lengths", "Table 1, inertias", "Table 1, dampings", "Table 2, r_3, r_5, r_7", "Table 2, gains"),
}
DEFINITIONS = {
    *("(4)", "(8)", "(17)", "(18)", "(28)", "Table 1, masses", "Table 2, weights", "section 4, initial state"),
}


def test_every_number_is_there_once_and_every_erratum_has_one_kind_and_a_cause(ledger: Ledger) -> None:
    check_ledger(ledger, NUMBERS)


def test_the_verdicts(ledger: Ledger) -> None:
    assert judged(ledger, EntryVerdict.DIFFERS) == set(MISPRINTS)
    assert judged(ledger, EntryVerdict.AMBIGUOUS) == AMBIGUOUS
    assert judged(ledger, EntryVerdict.DEFINITION) == DEFINITIONS


def test_long_equations_are_paired_term_by_term(ledger: Ledger) -> None:
    """Ten changes of (11) and 45 of (25) were listed when each product stood for itself."""
    assert {number: len(ledger[number].edits) for number in ("(11)", "(25)")} == {"(11)": 7, "(25)": 20}


def test_each_misprint_is_at_its_term_with_a_correction_and_a_counterexample(ledger: Ledger) -> None:
    for number, edits in MISPRINTS.items():
        entry = ledger[number]
        assert set(edits) <= set(entry.edits), number
        assert entry.edits, number
        assert entry.corrected_latex, number
        assert "the corrected form is" in entry.how, number
        assert entry.counterexample, number


def test_of_each_table_the_model_follows_one_reading(ledger: Ledger) -> None:
    for entry in ledger.entries:
        if entry.number.startswith(("Table", "section 4", "text after (28)")):
            assert entry.used.verdict in (EntryVerdict.HOLDS, EntryVerdict.DEFINITION), entry.number
            assert all(reading.verdict is EntryVerdict.DIFFERS for reading in entry.readings if not reading.used)


def test_an_inertia_per_unit_mass_repairs_no_printed_formula(ledger: Ledger) -> None:
    for number in ("(25)", "(26)", "(27)"):
        assert [reading.verdict for reading in ledger[number].readings] == [EntryVerdict.DIFFERS] * 2


@pytest.mark.soak
def test_wrong_equations_turn_the_verdicts(system: System) -> None:
    """A wrong mass in the energy, a wrong rate in the reduced model and a wrong gain turn what rests on them."""
    wrong = paper(broken(system, "(20)", "(24)", "(25)", "ax_eq", "V_v2", "u3_v2"))
    turned, unmoved = ("19", "20", "24", "28", "29", "36"), ("21", "22", "17")
    entries = checked(wrong, *turned, *unmoved)
    assert tuple(n for n, entry in entries.items() if entry.verdict is EntryVerdict.DIFFERS) == turned


def test_a_correction_against_a_wrong_derivation_is_not_shown(system: System) -> None:
    residual = (*system.residual[:1], system.residual[1] + system.parameters.m, *system.residual[2:])
    entry = checked(paper(dataclasses.replace(system, residual=residual)), "10")["10"]
    assert entry.verdict is EntryVerdict.DIFFERS
    assert "the corrected form is" not in entry.how
