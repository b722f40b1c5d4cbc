# SPDX-License-Identifier: Apache-2.0
"""The ledger of the satellite's paper: every number once, the misprints where they are, and verdicts with teeth."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

import pytest
import sympy as sp

from mehvar.codegen.ledger.ledger import EntryVerdict, Ledger
from mehvar.models.system import System
from papers.satellite.ledger import NUMBERS, paper
from tests.papers.ledgers import broken, check_ledger, checked, judged

pytestmark = pytest.mark.soak  # judging takes ten seconds; `make run` does it too

MISPRINTS: Mapping[str, str] = {
    "(1)": "T_dot should read T",
    "text before (8)": "term Tgg_x is missing",
    "(8)": "in I_x*phi_dot: phi_dot should read phi_ddot",
    "(9)": "in I_y*theta_dot: theta_dot should read theta_ddot",
    "(10)": "in I_z*psi_dot: psi_dot should read psi_ddot",
    "(11)": "phi should read phi_dot",
    "(19)": "1 + alpha_1 q^-1 + alpha_2 q^-2 + ... + alpha_n q^-n should read "
    "1 + alpha_1 q^-1 + alpha_2 q^-2 + ... + alpha_n_C2 q^-n_C2",
    "(23)": "1 + s_1 q^-1 + s_2 q^-2 + ... + s_n q^-n should read 1 + s_1 q^-1 + s_2 q^-2 + ... + s_n_s q^-n_s",
    "(24)": "t_0 + t_1 q^-1 + t_2 q^-2 + ... + t_n q^-n should read t_0 + t_1 q^-1 + t_2 q^-2 + ... + t_n_t q^-n_t",
    "(30)": "[b0*s_1 + b1, b_n_s*s_(d-1) + t_0, t_1] should read [b0*s_1 + b1, b_n_B*s_(d-1), t_0, t_1]",
    "text after (38)": "term -S(1)*d(k)/b0 is missing",
    "(43)": "0.307 should read 0.0586",
    "(44)": "0.305 should read 0.0411",
    "(45)": "0.302 should read 0.0404",
    "text before (49)": "term 1.998*q_inv is missing",
    "text before (49), amount of data": "bit should read byte",
    "text before (49), sampling time": "Max(T_min/10, T_s) should read Min(T_min/10, T_s)",
}
NO_CURE = "text before (12)"
"""The plant is not minimum phase: no other wording of the sentence would be right."""
READINGS: Mapping[str, tuple[EntryVerdict, ...]] = {
    "(1)": (EntryVerdict.DIFFERS, EntryVerdict.DIFFERS),
    "(2)": (EntryVerdict.DIFFERS, EntryVerdict.DEFINITION),
    "(3)": (EntryVerdict.DIFFERS, EntryVerdict.HOLDS, EntryVerdict.DIFFERS),
    "(4)": (EntryVerdict.DEFINITION, EntryVerdict.DIFFERS),
    "text on (3)": (EntryVerdict.HOLDS, EntryVerdict.DIFFERS),
    "text on (4)": (EntryVerdict.HOLDS, EntryVerdict.DIFFERS),
    "(8)": (EntryVerdict.DIFFERS, EntryVerdict.DIFFERS),
    "(10)": (EntryVerdict.DIFFERS, EntryVerdict.DIFFERS),
    "(34)": (EntryVerdict.DIFFERS, EntryVerdict.HOLDS),
    "(36)": (EntryVerdict.DEFINITION, EntryVerdict.DIFFERS),
    "Table 1, I_omega": (EntryVerdict.DEFINITION, EntryVerdict.DIFFERS),
    "text after (45)": (EntryVerdict.HOLDS, EntryVerdict.DIFFERS),
}
HOLD = {5, 6, 7, 13, 22, 25, 26, 27, 32, 40, 41, 42, 46, 47, 48}
DEFINITIONS = {12, 14, 15, 16, 17, 18, 20, 21, 28, 29, 31, 33, 35, 37, 38, 39, 49, 50}


def test_every_number_is_there_once_and_every_erratum_has_one_kind_and_a_cause(ledger: Ledger) -> None:
    check_ledger(ledger, NUMBERS)


def test_the_verdicts(ledger: Ledger) -> None:
    split = {number for number, verdicts in READINGS.items() if len(set(verdicts)) > 1}
    assert judged(ledger, EntryVerdict.DIFFERS) == {*MISPRINTS, NO_CURE}
    assert judged(ledger, EntryVerdict.AMBIGUOUS) == split
    for verdict, numbers in ((EntryVerdict.HOLDS, HOLD), (EntryVerdict.DEFINITION, DEFINITIONS)):
        assert {n for n in judged(ledger, verdict) if n.startswith("(")} == {f"({k})" for k in numbers}


def test_the_readings(ledger: Ledger) -> None:
    readings = {entry.number: tuple(r.verdict for r in entry.readings) for entry in ledger.entries}
    assert {number: verdicts for number, verdicts in readings.items() if len(verdicts) > 1} == READINGS


def test_each_misprint_is_at_its_term_with_a_correction_that_passes(ledger: Ledger) -> None:
    for number, edits in MISPRINTS.items():
        assert edits in ledger[number].edits, number
        wrong = [line for line in ledger[number].used.lines if line.verdict is EntryVerdict.DIFFERS]
        assert all("the corrected form is" in line.how for line in wrong), number
        assert all(line.counterexample or "matrix" in line.how for line in wrong), number


@pytest.mark.parametrize(
    ("number", "reading", "edits"),
    [
        (
            "(1)",
            0,
            {
                "T_ddot should read T",
                "in I*omega_ddot: omega_ddot should read omega_dot",
                "omega_dot should read omega",
            },
        ),
        ("(2)", 0, {"omega_dot should read omega"}),
        ("(3)", 0, {"sign of omega_0: printed +, correct -"}),
        (
            "(8)",
            1,
            {"in I_x*phi_dot: phi_dot should read phi_ddot", "term -omega_0*psi_dot*(I_x - I_y + I_z) is missing"},
        ),
        ("(34)", 0, {"Theta(k) should read Theta(k-1)"}),
    ],
)
def test_what_a_reading_would_have_to_say(ledger: Ledger, number: str, reading: int, edits: set[str]) -> None:
    assert {edit for line in ledger[number].readings[reading].lines for edit in line.edits} == edits


def test_the_corrected_numerators_have_the_sum_that_sampling_keeps(ledger: Ledger, system: System) -> None:
    """B(1) = Ts^2/I is twice the corrected b0, to the printed digits; the printed B(1) is thrice that and more."""
    for number, inertia in (("(43)", 2.13), ("(44)", 3.04), ("(45)", 3.09)):
        *_, (edit,) = (line.edits for line in ledger[number].used.lines if line.edits)
        printed, _, corrected = edit.partition(" should read ")
        assert 2 * float(corrected) == pytest.approx(0.25 / inertia, abs=2e-4)
        assert float(printed) + float(corrected) > 3 * 0.25 / inertia


def test_the_counterexample_of_9(ledger: Ledger) -> None:
    """With pitch at rest at zero, its acceleration alone takes a torque, which the printed (9) does not have."""
    point = ledger["(9)"].counterexample
    assert point is not None
    at = dict(point.at)
    pull = 3 * float(sp.Rational(at["omega_0"])) ** 2 * float(at["theta"]) * (float(at["I_x"]) - float(at["I_z"]))
    assert float(point.left) == pytest.approx(float(at["I_y"]) * float(at["theta_ddot"]) + pull)
    assert float(point.right) == pytest.approx(float(at["I_y"]) * float(at["theta_dot"]) + pull)


@pytest.mark.parametrize(
    ("wrong", "turned", "unmoved"),
    [
        (
            ["C12", "t0_cancel_roll", "u_roll_pd"],
            ["4", "22", "48", "50", "18", "21", "27"],
            ["5", "25", "32", "41", "46"],
        ),
        (["y_hat_roll", r"A_{\mathrm{yaw}}"], ["13", "14", "15", "22", "34"], ["16", "25", "29", "39", "40"]),
        (["w_roll", "alpha5_roll", "f3_roll", "A_{41}"], ["11", "34", "36", "40", "41"], ["7", "12", "22", "27", "39"]),
    ],
)
@pytest.mark.share(3)
def test_wrong_steps_of_the_derivation_turn_the_verdicts(
    system: System, wrong: list[str], turned: list[str], unmoved: list[str]
) -> None:
    entries = checked(paper(broken(system, *wrong)), *turned, *unmoved)
    good = {number: judged.used.verdict is not EntryVerdict.DIFFERS for number, judged in entries.items()}
    assert [number for number in turned if good[number]] == []
    assert [number for number in unmoved if not good[number] and f"({number})" not in MISPRINTS] == []


@pytest.mark.soak
def test_wrong_equations_of_motion_turn_the_verdicts_and_show_no_correction(system: System) -> None:
    steps = broken(system, "wx_rate", "T_y", r"B_{\mathrm{pitch}}").steps
    wrong = dataclasses.replace(system, steps=steps, rhs=(-system.rhs[0], *system.rhs[1:]))
    entries = checked(paper(wrong), "1", "4", "5", "6", "9", "43", "44", "45")
    assert {n for n, judged in entries.items() if judged.used.verdict is not EntryVerdict.DIFFERS} == {"6"}
    assert {n for n, judged in entries.items() if judged.corrected_latex} == {"43", "45"}
