# SPDX-License-Identifier: Apache-2.0
import math
from dataclasses import replace

import pytest

from mehvar.reproduction.claims import (
    OWN,
    PAPERS,
    Check,
    Claim,
    ClaimText,
    ClaimVerdict,
    ReadingText,
    TriedReading,
    about,
    below,
    count,
    decide,
    not_essential,
    tally,
    tally_text,
)
from mehvar.reproduction.paper import load_reproduction
from mehvar.reproduction.runs import Runs
from mehvar.runtime.model.model import load
from tests.derived import REPRODUCED


def test_a_claim_fails_by_an_essential_check_and_gets_a_note_by_another():
    good, bad = Check("a", "1", "1", True), Check("b", "1", "2", False)
    assert Claim("1", "t", (good,), "why").verdict is ClaimVerdict.HOLDS
    assert Claim("1", "t", (good,), "why").note == ""
    assert Claim("1", "t", (good, not_essential(bad)), "why").verdict is ClaimVerdict.NOTE
    assert Claim("1", "t", (good, not_essential(bad)), "why").note == "why"
    assert Claim("1", "t", (good, bad, not_essential(bad))).verdict is ClaimVerdict.FAILS
    assert not about("a", 1.0, 1.011).holds
    assert not about("a", 1.0, math.nan).holds
    assert not below("a", 1.0, 1.0).holds
    assert count("a", 5, 6).holds
    assert not count("a", 5, 7).holds


def test_a_documented_refutation_does_not_fail_but_its_opposite_does():
    check = Check("m", "1 kg", "2 kg", False)
    assert Claim("1", "", (check,), "", refuted=True).verdict is ClaimVerdict.REFUTED
    assert Claim("1", "", (check,)).verdict is ClaimVerdict.FAILS
    assert Claim("1", "", (replace(check, holds=True),), "", refuted=True).verdict is ClaimVerdict.FAILS


def test_a_refuted_claim_may_hold_under_another_reading():
    bad, good = Check("m", "1", "2", False), Check("m", "1", "1", True)
    fails, holds = TriedReading("grams", "masses in g", (bad,)), TriedReading("pounds", "masses in lb", (good,))
    none = Claim("1", "", (bad,), refuted=True, readings=(fails, fails))
    assert none.verdict is ClaimVerdict.REFUTED
    assert none.outcome == "Does not hold under any of 2 other readings."
    one = replace(none, readings=(fails, holds))
    assert one.verdict is ClaimVerdict.READING
    assert one.outcome == "Holds under 1 of 2 other readings: pounds: masses in lb."
    assert replace(one, refuted=False).verdict is ClaimVerdict.FAILS


def test_a_claim_about_the_print_does_not_hold_under_a_reading_of_something_else():
    bad, good = Check("m", "1", "2", False), Check("m", "1", "1", True)
    readings = (TriedReading("pounds", "masses in lb", (good,)),)
    claim = Claim("1", "", (bad,), refuted=True, readings=readings, printed=True)
    assert claim.verdict is ClaimVerdict.PRINTED
    assert claim.outcome == "Holds under another reading (1 of 1 tried): pounds: masses in lb."
    assert replace(claim, readings=()).verdict is ClaimVerdict.REFUTED
    assert replace(claim, checks=(good,), refuted=False).verdict is ClaimVerdict.HOLDS


@pytest.mark.parametrize("name", REPRODUCED)
def test_what_is_said_of_the_print_and_refuted_is_judged_as_printed(name):
    refuted = [text for text in load_reproduction(name).texts if text.refuted]
    of_the_print = [text.number for text in refuted if "print" in text.text]
    assert [text.number for text in refuted if text.printed] == of_the_print


def test_the_papers_claims_and_our_own_rows_are_counted_apart():
    good, bad = Check("m", "1", "1", True), Check("m", "1", "2", False)
    claims = [Claim("1", "", (good,)), Claim("2", "", (bad,)), Claim("R1", "", (good,), own=True)]
    assert [tally_text(kind, counts) for kind, counts in tally(claims).items()] == [
        f"2 {PAPERS}: 1 holds; 1 does not hold",
        f"1 {OWN}: 1 holds",
    ]


def test_readings_are_run_with_the_numbers_of_the_claim():
    text = ClaimText("1", "t", refuted=True, expected={"m": 3.0}, reading=(ReadingText("r", "other"),))
    checks = {"1": lambda runs, expected: (below("m", expected("m"), 4.0),)}
    readings = {"1": {"r": lambda runs, expected: (below("m", expected("m"), 2.0),)}}
    (claim,) = decide([text], checks, Runs(load("triangle", backend="python")), readings)
    assert claim.verdict is ClaimVerdict.READING
