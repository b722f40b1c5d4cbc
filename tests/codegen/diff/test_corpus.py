# SPDX-License-Identifier: Apache-2.0
"""Pairs of documents with the answer that a person would give."""

import pytest

from mehvar.codegen.diff import compare
from mehvar.codegen.diff.report import Fate, Kind
from tests.codegen.diff.corpus import EDITED, SAME
from tests.codegen.diff.documents import document


@pytest.mark.parametrize("name", SAME)
def test_what_is_only_written_differently_is_the_same(name):
    old, new = (document(text) for text in SAME[name])
    for found in (compare(old, new), compare(new, old)):
        assert not found.differs, [(e.name, e.verdict, e.how) for e in found if e.matters]
        assert not found.of(Fate.UNDECIDED)


@pytest.mark.parametrize("name", EDITED)
def test_an_edit_is_found_named_and_replayed(name):
    before, after, source, kind, word = EDITED[name]
    found = compare(document(before), document(after))
    assert [equation.name for equation in found.sources] == [source]
    changed = found[source]
    assert len(changed.edits) == 1, changed.edits
    (edit,) = changed.edits
    assert kind is None or edit.kind is Kind(kind)
    told = " ".join((edit.says, *edit.path, *(part.text for part in (edit.old, edit.new) if part)))
    assert word in told
    assert changed.replayed
    assert changed.counterexample is not None
    assert changed.counterexample.left != changed.counterexample.right


@pytest.mark.parametrize("name", EDITED)
def test_the_way_back_is_found_too(name):
    before, after, source, *_ = EDITED[name]
    found = compare(document(after), document(before))
    assert found.differs
    assert [equation.name for equation in found.sources] == [source]
    assert found[source].replayed


def test_the_corpus_is_as_large_as_promised():
    assert len(SAME) + len(EDITED) >= 60
