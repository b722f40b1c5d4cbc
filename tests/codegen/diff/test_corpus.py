# SPDX-License-Identifier: Apache-2.0
"""Pairs of documents with the answer that a person would give."""

import re
from collections import Counter
from dataclasses import replace

import pytest
import sympy as sp

from mehvar.codegen.diff import compare
from mehvar.codegen.diff.report import EquationVerdict, Kind
from mehvar.codegen.equal.equality import EqualityTest
from mehvar.codegen.equal.meaning import Meaning
from mehvar.codegen.equal.points import FieldPoints
from mehvar.codegen.equal.pool import Pool
from mehvar.codegen.equal.sampler import PointSampler
from mehvar.codegen.ledger.sides import Sides
from tests.codegen.diff.corpus import EDITED, SAME
from tests.codegen.diff.documents import document
from tests.codegen.diff.measured import answer, answers
from tests.codegen.diff.pairs import SEED, pairs


# six saturations have 729 branches, of which three have 27
@pytest.mark.parametrize(
    "name", [n if n != "six saturations" else pytest.param(n, marks=pytest.mark.soak) for n in SAME]
)
@pytest.mark.share(4)
def test_what_is_only_written_differently_is_the_same(name):
    old, new = (document(text) for text in SAME[name])
    for comparison in (compare(old, new), compare(new, old)):
        assert not comparison.differs, [(e.name, e.verdict, e.how) for e in comparison if e.matters]
        assert not comparison.of(EquationVerdict.UNDECIDED)


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
@pytest.mark.share(4)
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
    assert EqualityTest(pool, lambda _: False, PointSampler({}, frozenset())).decide(*sides).equal is False


@pytest.mark.parametrize("number", range(24))
def test_the_quadrant_of_an_arc_counts(number):
    """In the field an arc has its angle by a root, whose sign is one of chance, too."""
    a, b = sp.symbols(f"a{number} b{number}", real=True)
    pool = Pool()
    meaning = Meaning(pool, lambda _: None)
    sides = [(meaning, Sides(pool).entries(side)[0]) for side in (sp.atan2(b, a), sp.atan(b / a))]
    assert not FieldPoints(pool, lambda _: False).same(*sides)


def test_what_the_field_cannot_tell_says_at_how_many_points_it_was_compared():
    window = "(a > 1) & (a < Rational('1.0001'))"
    old, new = (document(f"f: Piecewise(({part}, {window}), (x, True))") for part in ("acos(cos(a))", "a"))
    comparison = compare(old, new)
    assert not comparison.differs
    how = comparison["f"].how
    assert re.search(r"; compared at (6[4-9]|[7-9]\d) points with 50 digits: acos is not decided exactly", how)
    assert "reached or is excluded" not in how


BUMP = "exp(-10**8*({f} - Rational(12345, 10000))**2)"
WAVE = "Abs(a - 2*pi*floor(a/(2*pi) + Rational(1, 2)))"
NARROW = {
    "a step": ("floor(a)", f"floor(a + {BUMP.format(f='b')}/1000)"),
    "two bumps in a step": ("floor(x*y)", f"floor(x*y + {BUMP.format(f='a')}*{BUMP.format(f='b')}/1000)"),
    "an arc": ("acos(cos(a))", f"{WAVE} + 1/(1 + 10**10*(a - Rational(12345, 10000))**2)**8"),
    "another name": ("acos(cos(a))", f"{WAVE} + 1/(1 + 10**10*(b - Rational(12345, 10000))**2)**8"),
    "a root": ("acos(cos(a))", f"{WAVE} + {BUMP.format(f='sqrt(x**2 + y**2)')}"),
    "a square written out": (
        "log(x**2 + y**2) + 1/(1 + 10**10*x**2 - 2*10**10*x + 10**10)",
        "2*log(sqrt(x**2 + y**2))",
    ),
    "a high power": ("log(x**2 + y**2)*(1 + sin(x)**10000000)", "2*log(sqrt(x**2 + y**2))"),
    "a slope": ("atan(a) + atan(1/a)", "pi/2*sign(a) + tanh(10**7*(a + b - 1)) - tanh(10**7*(a + b) - 10**7 - 1)"),
}
"""Bumps that no ordinary point meets, in expressions that the field does not know."""


@pytest.mark.parametrize("name", NARROW)
@pytest.mark.share(8)
def test_a_bump_that_no_ordinary_point_meets_is_a_change(name):
    old, new = (document(f"f: {text}") for text in NARROW[name])
    for comparison in (compare(old, new), compare(new, old)):
        assert comparison["f"].verdict is EquationVerdict.CHANGED, comparison["f"].how


ANEW = {
    "limits in another order": ("m*Max(-1, Min(1, asin(x/(1 + x**2)) + acos(y/(2 + y**2))))",
                                "Min(1, Max(-1, asin(x/(1 + x**2)) + acos(y/(2 + y**2))))*m"),
    "windows multiplied": (
        "Piecewise((1, (log(1 + x**2) > 1) & (log(1 + x**2) < Rational(11, 10))), (0, True))"
        "*Piecewise((1, Abs(acos(cos(a)) - 1) < Rational(1, 10**5)), (0, True))",
        "Min((sign(2*log(sqrt(1 + x**2)) - 1) - sign(2*log(sqrt(1 + x**2)) - Rational(11, 10)))/2, Piecewise((0, "
        "(acos(cos(a)) <= 1 - Rational(1, 10**5)) | (acos(cos(a)) >= 1 + Rational(1, 10**5))), (1, True)))",
    ),
    "limits that no value meets": ("Max(0, Min(7, pi/2 - asin(tanh(x))))", "Min(7, Max(0, acos(tanh(x))))"),
}  # fmt: skip


@pytest.mark.parametrize("name", ANEW)
def test_limits_and_windows_of_functions_that_are_written_anew_are_the_same(name):
    old, new = (document(f"f: {text}") for text in ANEW[name])
    for comparison in (compare(old, new), compare(new, old)):
        assert not comparison.differs, comparison["f"].how


LIMITED = {
    "by a norm": (
        "x*Min(1, k/sqrt(x**2 + y**2))",
        "x/Max(1, sqrt(x**2 + y**2)/k)",
        "x*k/Max(k, sqrt(x**2 + y**2))",
        "Piecewise((x, x**2 + y**2 <= k**2), (k*x/sqrt(x**2 + y**2), True))",
        "Piecewise((k*x/sqrt(x**2 + y**2), sqrt(x**2 + y**2)/k > 1), (x, True))",
        "x*(1 - Max(0, 1 - k/sqrt(x**2 + y**2)))",
    ),
    "by a ratio": (
        "Piecewise((x, y/z > k), (v, True))",
        "Piecewise((x, y*z > k*z**2), (v, True))",
        "Piecewise((x, ((z > 0) & (y > k*z)) | ((z < 0) & (y < k*z))), (v, True))",
    ),
    "by a root": (
        "Piecewise((x, y/sqrt(1 + z**2) > m), (v, True))",
        "Piecewise((x, y > m*sqrt(1 + z**2)), (v, True))",
        "Piecewise((v, (y <= 0) | (y**2 <= m**2*(1 + z**2))), (x, True))",
    ),
    "by an arc": (
        "Piecewise((x, acos(cos(a)) < 1), (v, True))",
        "Piecewise((v, cos(a) < cos(1)), (x, True))",
    ),
    "by a logarithm": (
        "Piecewise((x, log(1 + y**2) > k), (v, True))",
        "Piecewise((x, sqrt(1 + y**2) > exp(k/2)), (v, True))",
    ),
    "by a case distinction": (
        "Piecewise((v, Piecewise((x, z > 0), (y, True)) > 1), (w, True))",
        "Piecewise((v, ((z > 0) & (x > 1)) | ((z <= 0) & (y > 1))), (w, True))",
    ),
}
"""Limits and conditions, each in several ways."""


@pytest.mark.parametrize(("first", "other"), [
    pytest.param(texts[0], text, id=f"{name}: {text}") for name, texts in LIMITED.items() for text in texts[1:]
])  # fmt: skip
@pytest.mark.share(2)
def test_a_limit_that_is_written_anew_is_the_same_and_another_limit_is_not(first, other):
    assert not compare(document(f"f: {first}"), document(f"f: {other}")).differs
    moved = (
        other.replace("1", "Rational(10001, 10000)", 1) if "1" in other else other.replace("k", "k*(1 + m/10**5)", 1)
    )
    assert compare(document(f"f: {first}"), document(f"f: {moved}"))["f"].verdict is EquationVerdict.CHANGED


@pytest.mark.parametrize(("guard", "what", "values"), [
    ("lift: rising ends failure", "direction", ("falling", "rising")),
    ("lift: falling", "ends", ("failure", "")),
])  # fmt: skip
def test_another_direction_or_end_of_an_event_is_told_of_the_event(guard, what, values):
    plain = document("g: x - y")
    sides = [
        replace(plain, results=tuple(replace(row, name=name, kind="guard") for row in plain.results))
        for name in ("lift: falling ends failure", guard)
    ]
    comparison = compare(*sides)
    (change,) = comparison.parameters
    assert (change.role, change.name, change.what, (change.old, change.new)) == ("event", "lift", what, values)
    assert not comparison.added
    assert not comparison.removed


OPEN = "windows of two functions at once"
"""Windows that a disc of two functions bounds: some are undecided, as the campaign counts."""


@pytest.mark.parametrize("part", range(16))
@pytest.mark.share(16)
def test_every_sixteenth_pair_has_the_answer_of_a_person(part):
    for pair in pairs()[part::256]:
        given, right = answer(compare(pair.old, pair.new)), "different" if pair.differs else "same"
        assert given == right or (given == "undecided" and pair.name.startswith(OPEN)), pair.name


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
