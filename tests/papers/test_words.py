# SPDX-License-Identifier: Apache-2.0
"""The rules by which the words of claims and captions are checked against their numbers."""

import pytest

from mehvar.reproduction.claims import Check, Claim, ClaimText
from tests.papers.words import numbers, of_claim, without_source


@pytest.mark.parametrize(
    ("text", "written"),
    [
        ("as (31), (32) and (34) print it (claims 8 to 10 and 14, figure 4)", []),
        ("87 000 rpm, 2.5e-5 N m and 62 % of theta_1 in V2", ["87000", "2.5e-5", "62"]),
        ("1 - 2 q^-1 + q^-2, b0 = 0.307.", ["1", "2", "0.307"]),
    ],
)
def test_numbers_are_told_from_names_of_places(text, written):
    assert numbers(text) == written


@pytest.mark.parametrize(
    ("text", "known", "foreign"),
    [
        ("0.27 and 37 %", [0.2701, 0.3718], []),
        ("0.27 and 38 %", [0.2749, 0.3718], ["38"]),
        ("2.4e-5 N m", [2.36e-5], []),
        ("2.3e-5 N m", [2.36e-5], ["2.3e-5"]),
        ("two laws, 2 wheels", [], []),
        ("falls by 46 m/s", [], ["46"]),
        ("87 000 rpm", [8.72e4], []),
        ("86 000 rpm", [8.72e4], ["86000"]),
    ],
)
def test_a_number_in_words_is_a_known_one_as_it_is_rounded(text, known, foreign):
    assert without_source(text, known) == foreign


def test_a_claim_knows_what_it_was_decided_by():
    claim = Claim("1", "t", (Check("error at 35 s", "< 0.1 deg", "0.0532 deg", True),))
    assert set(of_claim(claim, ClaimText("1", "t", expected={"m": 4.0}))) == {35.0, 0.1, 0.0532, 4.0}
