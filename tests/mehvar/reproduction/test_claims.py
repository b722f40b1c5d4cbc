# SPDX-License-Identifier: Apache-2.0
import math
from dataclasses import replace

import pytest

from mehvar.reproduction.claims import (
    Check,
    Claim,
    ClaimKind,
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
from tests.papers.shared import HEAVY, paper_claims


def test_a_claim_fails_by_an_essential_check_and_holds_in_part_by_another():
    good, bad = Check("a", "1", "1", True), Check("b", "1", "2", False)
    assert Claim("1", "t", (good,), "why").verdict is ClaimVerdict.HOLDS
    assert Claim("1", "t", (good,), "why").note == ""
    assert Claim("1", "t", (good, not_essential(bad)), "why").verdict is ClaimVerdict.PART
    assert Claim("1", "t", (good, not_essential(bad)), "why").note == "why"
    assert Claim("1", "t", (good, bad, not_essential(bad))).verdict is ClaimVerdict.FAILS
    assert Claim("1", "t", (not_essential(bad),)).verdict is ClaimVerdict.OPEN
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


def test_a_summary_gives_each_failed_check_with_its_value_and_limit():
    good, bad = Check("m", "1 kg", "1 kg", True), Check("T", "< 3 s", "4 s", False)
    assert Claim("1", "", (good,)).summary == "The check holds."
    assert Claim("1", "", (good, good)).summary == "All 2 checks hold."
    assert Claim("1", "", (bad,)).summary == "The check does not hold: T: 4 s, expected < 3 s."
    varied = Claim("1", "", (good,), variant="law b")
    assert (varied.verdict, varied.summary) == (ClaimVerdict.VARIANT, "The check holds. Run with a variant: law b.")
    assert replace(varied, checks=(bad,)).verdict is ClaimVerdict.FAILS
    assert Claim("1", "", (good, bad)).summary == "1 of 2 checks hold: m. Not: T: 4 s, expected < 3 s."
    assert Claim("1", "", (bad,) * 5).summary.endswith("; and 2 more.")


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.soak] if name in HEAVY else []) for name in REPRODUCED]
)
def test_no_failed_check_contradicts_a_verdict(name):
    for claim in paper_claims(name):
        assert (claim.verdict is ClaimVerdict.HOLDS) == all(check.holds for check in claim.checks)
        assert (claim.verdict in (ClaimVerdict.HOLDS, ClaimVerdict.PART)) <= any(check.holds for check in claim.checks)
        assert all(check.failure in claim.summary for check in claim.failed[:3])
        assert all(check.holds for reading in claim.readings if reading.holds for check in reading.checks)


def test_claims_of_papers_findings_and_rows_are_counted_apart():
    good, bad = Check("m", "1", "1", True), Check("m", "1", "2", False)
    own = [Claim(number, "", (good,), kind=kind) for number, kind in (("3", ClaimKind.FINDING), ("R1", ClaimKind.ROW))]
    assert [
        tally_text(kind, of) for kind, of in tally([Claim("1", "", (good,)), Claim("2", "", (bad,)), *own]).items()
    ] == [
        "2 claims of the papers: 1 holds; 1 does not hold",
        "1 finding of our own: 1 holds",
        "1 row of our own against an independent program: 1 holds",
    ]
    assert [claim.title for claim in own] == ["finding 3", "row R1"]


def test_readings_are_run_with_the_numbers_of_the_claim():
    text = ClaimText("1", "t", refuted=True, expected={"m": 3.0}, reading=(ReadingText("r", "other"),))
    checks = {"1": lambda runs, expected: (below("m", expected("m"), 4.0),)}
    readings = {"1": {"r": lambda runs, expected: (below("m", expected("m"), 2.0),)}}
    (claim,) = decide([text], checks, Runs(load("triangle", backend="python")), readings)
    assert claim.verdict is ClaimVerdict.READING
