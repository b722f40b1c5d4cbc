# SPDX-License-Identifier: Apache-2.0
"""The overview of the papers: filters by outcome and by verdict, and a count of each kind of claims."""

import re
from types import SimpleNamespace

from mehvar.report.papers.pages import _overview
from mehvar.reproduction.claims import Check, Claim, ClaimKind, ClaimVerdict, TriedReading

GOOD, BAD, NOTED = (Check("x", "1", "1", *how) for how in ((True,), (False,), (False, False)))
CLAIMS = [
    *(Claim(str(k), "holds", (GOOD,)) for k in range(4)),
    Claim("4", "in part", (GOOD, NOTED)),
    Claim("5", "another reading", (BAD,), refuted=True, readings=(TriedReading("r", "read so", (GOOD,)),)),
    Claim("6", "printed", (BAD,), refuted=True, readings=(TriedReading("r", "read so", (GOOD,)),), printed=True),
    Claim("7", "refuted", (BAD,), refuted=True),
    Claim("8", "fails", (BAD,)),
    Claim("9", "undecided", (NOTED,)),
    Claim("10", "our own", (BAD,), kind=ClaimKind.FINDING),
    Claim("11", "of our law", (GOOD,), variant="law b"),
    Claim("R1", "our own too", (GOOD,), kind=ClaimKind.ROW),
]


def report(name):
    return SimpleNamespace(
        manifest=SimpleNamespace(model=name, hash="0"), claims=CLAIMS, cover=None, boards=SimpleNamespace(laws=[]),
        paper=SimpleNamespace(captions=SimpleNamespace(citation="")), loops=0, seconds={},
    )  # fmt: skip


def test_each_choice_of_the_filter_has_rows_and_kinds_are_counted_apart():
    page = _overview([report("rig"), report("arm")], {}, {}, {"rig": "rig.html", "arm": "arm.html"})
    text = "".join(str(block.html) for section in page.sections for block in section.blocks)
    rows = re.findall(r'data-paper="(\w+)" data-verdict="([^"]*)" data-outcome="([^"]*)"', text)
    assert len(rows) == 2 * len(CLAIMS)
    found = {f"verdict:{verdict}" for _, verdict, _ in rows} | {f"outcome:{outcome}" for *_, outcome in rows}
    assert set(re.findall(r'<option value="((?:verdict|outcome):[^"]*)">', text)) == found
    assert {verdict for _, verdict, _ in rows} == set(ClaimVerdict)
    assert "✓ holds; ✗ does not hold and decides its claim; ! does not hold and decides no claim" in text
    assert "22 claims of the papers, 2 findings of our own, 2 rows of our own" in text
