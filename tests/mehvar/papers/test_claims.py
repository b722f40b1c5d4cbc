# SPDX-License-Identifier: Apache-2.0
import math
from dataclasses import replace

from mehvar.papers.claims import Check, Claim, ClaimVerdict, about, below, beside, count


def test_a_claim_fails_by_an_essential_check_and_gets_a_note_by_another():
    good, bad = Check("a", "1", "1", True), Check("b", "1", "2", False)
    assert Claim("1", "t", (good,), "why").verdict is ClaimVerdict.HOLDS
    assert Claim("1", "t", (good,), "why").note == ""
    assert Claim("1", "t", (good, beside(bad)), "why").verdict is ClaimVerdict.NOTE
    assert Claim("1", "t", (good, beside(bad)), "why").note == "why"
    assert Claim("1", "t", (good, bad, beside(bad))).verdict is ClaimVerdict.FAILS
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
