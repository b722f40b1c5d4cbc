# SPDX-License-Identifier: Apache-2.0
import pytest

from mehvar.base.errors import InputError
from mehvar.reproduction.claims import Check, Claim
from mehvar.reproduction.statements import (
    PrintedCounts,
    Statements,
    StatementText,
    StatementVerdict,
    coverage,
    statement_verdicts,
)
from tests.papers.shared import missing

HOLDS = Claim("1", "", (Check("a", "1", "1", True),))
REFUTED = Claim("2", "", (Check("a", "1", "2", False),), refuted=True)
LEDGER = {"(1)": "holds", "(2)": "differs"}


def of(*texts: StatementText, equations: int = 2, tables: int = 1, figures: int = 1) -> Statements:
    return Statements(PrintedCounts(equations, tables, figures), texts)


@pytest.mark.parametrize(
    ("claims", "equations", "verdict"),
    [
        (("1",), (), StatementVerdict.HOLDS),
        (("1", "2"), (), StatementVerdict.REFUTED),
        (("1",), ("(2)",), StatementVerdict.MISPRINT),
        ((), ("(1)",), StatementVerdict.HOLDS),
    ],
)
def test_a_statement_is_as_good_as_the_worst_of_what_it_rests_on(claims, equations, verdict):
    (statement,) = statement_verdicts(of(StatementText("abstract 1", "t", claims, equations)), (HOLDS, REFUTED), LEDGER)
    assert statement.verdict is verdict


def test_a_statement_that_rests_on_nothing_needs_a_remark():
    with pytest.raises(InputError, match="abstract 1: must name a claim or a figure"):
        statement_verdicts(of(StatementText("abstract 1", "t")), (), {})
    (statement,) = statement_verdicts(of(StatementText("abstract 1", "t", remark="history")), (), {})
    assert statement.verdict is StatementVerdict.BACKGROUND


@pytest.mark.parametrize(("claims", "equations"), [(("3",), ()), ((), ("(3)",))])
def test_a_statement_names_only_what_exists(claims, equations):
    with pytest.raises(InputError, match=r"section 2: (claim|equation) .* does not exist"):
        statement_verdicts(of(StatementText("section 2", "t", claims, equations)), (HOLDS,), LEDGER)


def test_everything_printed_that_has_no_entry_is_named():
    lone = of(StatementText("abstract 1", "t", ("1",)), equations=3)
    assert list(missing(lone, ["1", "2"], LEDGER, [])) == [
        "equation (3)", "table 1", "statement of figure 1", "drawing of figure 1",
        "statement for claim 2", "conclusions",
    ]  # fmt: skip


def test_what_is_printed_is_counted_beside_what_is_judged_and_shown():
    texts = of(StatementText("table 1", "t", ("1",)), StatementText("figure 1", "t", remark="lost"))
    rows = coverage(texts, statement_verdicts(texts, (HOLDS,), LEDGER), {"(1)": "holds", "(2)": "undecided"}, [1, 7])
    assert [(r.kind, r.printed, r.judged, r.shown) for r in rows][:3] == [
        ("equations", 2, 1, 2), ("tables", 1, 1, 1), ("figures", 1, 0, 1),
    ]  # fmt: skip


def test_entries_on_the_text_are_counted_and_not_said_to_be_printed():
    texts = of(StatementText("abstract 1", "t", ("1",)), StatementText("abstract 1", "t", remark="background"))
    rows = {
        r.kind: (r.printed, r.judged, r.shown)
        for r in coverage(texts, statement_verdicts(texts, (HOLDS,), LEDGER), {}, [])
    }
    assert rows["entries on the abstract"] == (None, 1, 2)
