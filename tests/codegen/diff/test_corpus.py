# SPDX-License-Identifier: Apache-2.0
"""Pairs of documents with the answer that a person would give."""

import re
from collections import Counter

import pytest
import sympy as sp

from mehvar.codegen.diff import compare
from mehvar.codegen.diff.report import Fate, Kind
from mehvar.codegen.equal.judge import Judge
from mehvar.codegen.equal.meaning import Meaning
from mehvar.codegen.equal.pool import Pool
from mehvar.codegen.equal.reals import PointSampler
from mehvar.codegen.ledger.sides import Sides
from tests.codegen.diff.corpus import EDITED, SAME
from tests.codegen.diff.documents import document
from tests.codegen.diff.measured import answer, answers
from tests.codegen.diff.pairs import SEED, pairs


@pytest.mark.parametrize("name", SAME)
def test_what_is_only_written_differently_is_the_same(name):
    old, new = (document(text) for text in SAME[name])
    for comparison in (compare(old, new), compare(new, old)):
        assert not comparison.differs, [(e.name, e.verdict, e.how) for e in comparison if e.matters]
        assert not comparison.of(Fate.UNDECIDED)


@pytest.mark.parametrize("name", EDITED)
def test_an_edit_is_found_named_and_replayed(name):
    before, after, source, kind, word = EDITED[name]
    comparison = compare(document(before), document(after))
    assert [equation.name for equation in comparison.sources] == [source]
    changed = comparison[source]
    assert len(changed.edits) == 1, changed.edits
    (edit,) = changed.edits
    assert kind is None or edit.kind is Kind(kind)
    words = " ".join((edit.says, *edit.path, *(part.text for part in (edit.old, edit.new) if part)))
    assert word in words
    assert changed.replayed
    assert changed.counterexample is not None
    assert changed.counterexample.left != changed.counterexample.right


@pytest.mark.parametrize("name", EDITED)
def test_the_way_back_is_found_too(name):
    before, after, source, *_ = EDITED[name]
    comparison = compare(document(after), document(before))
    assert comparison.differs
    assert [equation.name for equation in comparison.sources] == [source]
    assert comparison[source].replayed


@pytest.mark.parametrize("number", range(24))
def test_the_root_of_a_square_is_not_its_base(number):
    """In the field the sign of a root is one of chance: at all of three points it is right for one name in eight."""
    a, b = sp.symbols(f"a{number} b{number}", real=True)
    pool = Pool()
    meaning = Meaning(pool, lambda _: None)
    sides = [(meaning, Sides(pool).entries(side)[0]) for side in (sp.sqrt(sp.expand((a + b) ** 2)), a + b)]
    assert Judge(pool, lambda _: False, PointSampler({}, frozenset())).decide(*sides).equal is False


@pytest.mark.parametrize("number", range(24))
def test_the_quadrant_of_an_arc_counts(number):
    """In the field an arc has its angle by a root, whose sign is one of chance, too."""
    a, b = sp.symbols(f"a{number} b{number}", real=True)
    pool = Pool()
    meaning = Meaning(pool, lambda _: None)
    sides = [(meaning, Sides(pool).entries(side)[0]) for side in (sp.atan2(b, a), sp.atan(b / a))]
    assert not Judge(pool, lambda _: False, PointSampler({}, frozenset())).same_in_field(*sides)


def test_what_the_field_cannot_tell_says_at_how_many_points_it_was_compared():
    window = "(a > 1) & (a < Rational('1.0001'))"
    old, new = (document(f"f: Piecewise(({part}, {window}), (x, True))") for part in ("acos(cos(a))", "a"))
    comparison = compare(old, new)
    assert not comparison.differs
    assert re.search(r"; 1 of them compared at (6[4-9]|7\d) points with 50 digits or more", comparison["f"].how)


@pytest.mark.parametrize("part", range(4))
def test_every_sixteenth_pair_has_the_answer_of_a_person(part):
    for pair in pairs()[part::64]:
        assert answer(compare(pair.old, pair.new)) == ("different" if pair.differs else "same"), pair.name


@pytest.mark.soak
@pytest.mark.parametrize("seed", [SEED, 1, 2])
def test_the_whole_corpus_has_no_false_same(seed):
    count = sum(answers([seed]).values(), Counter())
    assert count[True, "same"] == 0
    assert count[False, "different"] < 0.03 * sum(n for (differs, _), n in count.items() if not differs)
    assert count[True, "undecided"] + count[False, "undecided"] < 0.08 * count.total()


def test_the_corpus_is_as_large_as_promised():
    assert len(SAME) + len(EDITED) >= 60
    assert len(pairs()) >= 300
