# SPDX-License-Identifier: Apache-2.0
"""The overview of the papers: its filters find every claim by its outcome and by its verdict."""

import re
from collections import Counter
from types import SimpleNamespace

from mehvar.report.papers import _overview
from mehvar.reproduction.claims import Check, Claim, ClaimVerdict, TriedReading

GOOD, BAD, NOTED = (Check("x", "1", "1", *how) for how in ((True,), (False,), (False, False)))
CLAIMS = [
    *(Claim(str(k), "holds", (GOOD,)) for k in range(4)),
    Claim("4", "a note", (GOOD, NOTED)),
    Claim("5", "another reading", (BAD,), refuted=True, readings=(TriedReading("r", "read so", (GOOD,)),)),
    Claim("6", "printed", (BAD,), refuted=True, readings=(TriedReading("r", "read so", (GOOD,)),), printed=True),
    Claim("7", "refuted", (BAD,), refuted=True),
    Claim("8", "fails", (BAD,)),
    Claim("9", "our own", (BAD,), own=True),
]


def report(name):
    return SimpleNamespace(
        manifest=SimpleNamespace(model=name, hash="0"), claims=CLAIMS, cover=None, boards=SimpleNamespace(laws=[]),
        paper=SimpleNamespace(captions=SimpleNamespace(citation="")), loops=0, seconds={},
    )  # fmt: skip


def test_each_choice_of_the_filter_has_as_many_rows_as_it_says():
    page = _overview([report("rig"), report("arm")], {}, {}, {"rig": "rig.html", "arm": "arm.html"})
    text = "".join(str(block.html) for section in page.sections for block in section.blocks)
    rows = re.findall(r'data-paper="(\w+)" data-verdict="([^"]*)" data-outcome="([^"]*)"', text)
    assert len(rows) == 2 * len(CLAIMS)
    found = Counter(
        f"{key}:{value}" for _, verdict, outcome in rows for key, value in (("verdict", verdict), ("outcome", outcome))
    )
    offered = {
        value: int(count)
        for value, count in re.findall(r'<option value="((?:verdict|outcome):[^"]*)">[^<]*\((\d+)\)', text)
    }
    assert offered == found
    assert offered["outcome:does not hold"] == 2 * 4
    assert {verdict for _, verdict, _ in rows} == set(ClaimVerdict)
