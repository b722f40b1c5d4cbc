# SPDX-License-Identifier: Apache-2.0
"""Verdicts on relations whose truth is known."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET

import pytest
import sympy as sp

from mehvar.codegen.equal.pool import Pool
from mehvar.codegen.ledger.ledger import Entry, EntryVerdict, check_entry, check_paper
from mehvar.codegen.ledger.misprints import edits
from mehvar.codegen.ledger.sides import Sides, UnknownFunctionError
from mehvar.html import typeset_within
from mehvar.models.paper import Cross, Erratum, ErratumKind, Names, Paper, Printed, Reading, Relation, printed
from mehvar.models.quantities import ModelError

names = Names()
x = names.free("x", -2, 2)
y = names.free("y", -2, 2)
r = names.free("r", 0, 2, latex=r"\rho")
double = names.derived("double", "D", 2 * x)
member = names.family("member", "x_i")
turned = names.derived("turned", "T", sp.sin(x + y))
swing = names.derived("swing", "W", member**2)
A = names.matrix("A", "A", sp.Matrix([[x, y], [0, 1]]))
v, w = (names.matrix(name, name, sp.Matrix(entries)) for name, entries in (("v", [x, y, 1]), ("w", [1, x, r])))
count = names.free("n", 1, 9, integer=True)


def entry(*relations: Relation) -> Entry:
    return check_entry(printed("1", "a relation", "equation", *relations), names)


@pytest.mark.parametrize(
    ("relation", "how"),
    [
        (Relation(double, x + x), "proved: both sides are the same expression"),
        (
            Relation(turned, sp.sin(x) * sp.cos(y) + sp.cos(x) * sp.sin(y)),
            "proved: the difference vanishes in normal form",
        ),
        (Relation(sp.Abs(x * y), sp.Abs(x) * sp.Abs(y)), "tested at 64"),
        (Relation(sp.Max(x, y), (x + y + sp.Abs(x - y)) / 2), "tested at 64 random points with 50 digits"),
        (Relation(x**2 + y**2, 2 * x * y, ">="), "tested at 128 random points"),
        (Relation(sp.Limit(sp.sin(x) / x, x, 0), sp.S.One), "proved"),
        (Relation(sp.Limit(1 / r, r, 0), sp.oo), "proved"),
        (Relation(sp.Derivative(double**2, x), 8 * x), "proved"),
        (Relation(sp.Integral(double, (x, 0, y)), y**2), "proved"),
        (Relation(A * A - A, (A - sp.Identity(2)) * A), "proved"),
        (Relation(sp.Trace(A), x + 1), "proved"),
        (Relation(Cross(v, w), -Cross(w, v)), "proved"),
        (Relation(sp.cos(sp.pi * count) ** 2, sp.S.One), "proved"),
        (Relation(sp.pi, sp.Rational("3.14"), within=sp.Rational("0.01")), "compared as numbers, within 1/100"),
        (Relation(swing, x**2, cases=({member: x}, {member: -x})), "proved"),
        (Relation(x, sp.S.Zero, ">", domain=(x,)), "tested at 128 random points"),
        (Relation(sp.sqrt(x), sp.sqrt(x) * sp.sign(x)), "tested"),
    ],
    ids=lambda value: value if isinstance(value, str) else f"{value.left} {value.op} {value.right}",
)
def test_what_is_true_holds(relation: Relation, how: str) -> None:
    judged = entry(relation)
    assert judged.verdict is EntryVerdict.HOLDS
    assert judged.how.startswith(how)


@pytest.mark.parametrize(
    "relation",
    [
        Relation(turned, sp.sin(x) * sp.cos(y) - sp.cos(x) * sp.sin(y)),
        Relation(x, x + sp.Rational(1, 10**35)),
        Relation(sp.Max(x, y), (x + y + sp.Abs(x + y)) / 2),
        Relation(sp.Abs(x), x),
        Relation(x, y, "<="),
        Relation(A * A, A),
        Relation(Cross(v, w), Cross(w, v)),
        Relation(sp.Limit(1 / r, r, 0), sp.S.Zero),
        Relation(sp.pi, sp.Rational("3.15"), within=sp.Rational("0.001")),
        Relation(swing, x * y, cases=({member: x}, {member: y})),
        Relation(swing, x**2, cases=({member: x}, {member: y})),
    ],
    ids=lambda value: f"{value.left} {value.op} {value.right}",
)
def test_what_is_false_differs(relation: Relation) -> None:
    assert entry(relation).verdict is EntryVerdict.DIFFERS


def test_a_counterexample_is_simple_and_fails_there() -> None:
    point = entry(Relation(x**2 + y * r, x**2 - y * r)).counterexample
    assert point is not None
    values = {sp.Symbol(name): sp.Rational(value) for name, value in point.at}
    assert values == {sp.Symbol("r"): 1, sp.Symbol("x"): 0, sp.Symbol("y"): 1}
    assert (float(point.left), float(point.right)) == (1.0, -1.0)


def test_a_counterexample_says_which_member_it_is_about() -> None:
    point = entry(Relation(member**3, x**3, cases=({member: x}, {member: -x}))).counterexample
    assert point is not None
    assert dict(point.at)["x"] == "1"
    assert (point.left, point.right) == ("-1.0", "1.0")


def test_sides_of_different_shape_differ() -> None:
    judged = entry(Relation(x, A, corrected_left=A))
    assert judged.verdict is EntryVerdict.DIFFERS
    assert "a number cannot equal a 2 x 2 matrix" in judged.how
    assert judged.corrected_latex == ("A = A",)


def test_nothing_is_said_without_points() -> None:
    judged = entry(Relation(x, x + 1, domain=(-(x**2),)))
    assert judged.verdict is EntryVerdict.UNDECIDED
    assert "0 of 16 points" in judged.how
    assert entry(Relation(sp.log(-(r**2)), x)).verdict is EntryVerdict.UNDECIDED


def test_a_correction_is_shown_only_if_it_passes() -> None:
    right = entry(Relation(turned, sp.sin(x - y), corrected=sp.sin(x + y)))
    assert right.corrected_latex == (r"T = \sin{\left(x + y \right)}",)
    assert right.edits == ("sign of y: printed -, correct +",)
    wrong = entry(Relation(turned, sp.sin(x - y), corrected=sp.cos(x + y)))
    assert wrong.corrected_latex == ()
    assert wrong.edits == ()


def test_an_equation_of_motion_is_compared_with_its_residual() -> None:
    acceleration, force = sp.cos(x) * y, r**2
    residual = 2 * y * sp.cos(x) - r**2
    assert entry(Relation(2 * acceleration, force, against=residual)).verdict is EntryVerdict.HOLDS
    judged = entry(Relation(acceleration + x, force, against=residual))
    assert judged.verdict is EntryVerdict.DIFFERS
    assert judged.edits == ("number before y*cos(x): printed 1, correct 2", "term x does not belong there")
    corrected = entry(Relation(acceleration, force, corrected_left=2 * acceleration, against=residual))
    assert corrected.edits == ("number before y*cos(x): printed 1, correct 2",)


@pytest.mark.parametrize(
    ("before", "after", "edit"),
    [
        (x + y * r, x - y * r, "sign of r*y: printed +, correct -"),
        (x, x + y, "term y is missing"),
        (x + y, x, "term y does not belong there"),
        (x * y, x, "factor y does not belong there"),
        (sp.sin(x) * y, sp.cos(x) * y, "sin(x) should read cos(x)"),
        (x**2 * y, x * y, "exponent of x: printed 2, correct 1"),
        (x / 2, x, "number before x: printed 1/2, correct 1"),
        (sp.sqrt(r + x**2), sp.sqrt(r - x**2), "sign of x**2: printed +, correct -"),
        (-x * sp.sin(x + r), x * sp.sin(x + r), "sign of x*sin(r + x): printed -, correct +"),
        (sp.Integer(5), sp.Rational(1, 2), "5 should read 1/2"),
    ],
)
def test_a_misprint_is_named_at_its_place(before: sp.Expr, after: sp.Expr, edit: str) -> None:
    assert [change.spelled(sp.sstr) for change in edits(before, after)] == [edit]
    assert edits(after, after) == ()


@pytest.mark.parametrize(
    ("before", "after", "changes"),
    [
        # two terms run into one product: the factor that is too many, and the term that is lost
        (x**2 * y * r * sp.sin(x), y * r * sp.sin(x) + x**2 * sp.cos(x), [
            "in r*x**2*y*sin(x): factor x**2 does not belong there", "term x**2*cos(x) is missing",
        ]),
        # which of two terms has lost its partner is told by the fewest changes
        (x * y + r * y, r * x * y + x * y, ["in r*y: factor x is missing"]),
        (x * sp.sin(y) + r**2, y * sp.cos(y) * r + r**2, [
            "term x*sin(y) does not belong there", "term r*y*cos(y) is missing",
        ]),
        (y - x, x - y, ["sign of x - y: printed -, correct +"]),
        # a long product of sums is compared as it stands, not multiplied out
        ((x + y) * (r + 1) * x, (x + y) * (r - 1) * x, ["1 should read -1"]),
    ],
)  # fmt: skip
def test_changes_are_as_few_and_small_as_can_be(before: sp.Expr, after: sp.Expr, changes: list[str]) -> None:
    assert [change.spelled(sp.sstr) for change in edits(before, after)] == changes


def test_a_chain_that_was_read_backwards_is_one_change() -> None:
    judged = entry(Relation(y, r, "<", corrected_left=r, corrected=y, domain=(y - r,)))
    assert judged.edits == ("r and y are exchanged",)


def test_changes_are_typeset() -> None:
    judged = entry(Relation(double, 3 * x * r, corrected_left=double, corrected=2 * x))
    (line,) = judged.used.lines
    assert line.edits_latex == (
        "number before $\\rho x$: printed $3$, correct $2$",
        "factor $\\rho$ does not belong there",
    )
    for edit in line.edits_latex:
        assert len(ET.fromstring(f"<p>{typeset_within(edit)}</p>").findall("math")) == edit.count("$") / 2


def test_an_erratum_is_of_an_entry_and_has_one_sentence() -> None:
    row = printed("1", "twice", "equation", Relation(double, 3 * x, corrected=2 * x))
    ledger = check_paper(
        Paper("", 1, names, (row,), errata={"1": Erratum(ErratumKind.MISPRINT, "A 3 is printed.")}), "model"
    )
    assert ledger["(1)"].erratum == Erratum(ErratumKind.MISPRINT, "A 3 is printed.")
    assert ledger.slips() == {**dict.fromkeys(ErratumKind, 0), ErratumKind.MISPRINT: 1}
    with pytest.raises(ModelError, match=r"errata refer to entries that do not exist: \['2'\]"):
        Paper("", 1, names, (row,), errata={"2": Erratum(ErratumKind.SCAN, "A dot is lost.")})
    for cause in ("", ".", "no full stop", "One. Two."):
        with pytest.raises(ModelError, match="one sentence"):
            Erratum(ErratumKind.SCAN, cause)


def readings(first: Relation, second: Relation) -> Printed:
    return Printed("1", "", "equation", (Reading((first,), "one"), Reading((second,), "other", used=False)))


def test_readings_that_disagree_are_ambiguous() -> None:
    holds, differs = Relation(double, 2 * x), Relation(double, 3 * x)
    judged = check_entry(readings(holds, differs), names)
    assert judged.verdict is EntryVerdict.AMBIGUOUS
    assert [reading.verdict for reading in judged.readings] == [EntryVerdict.HOLDS, EntryVerdict.DIFFERS]
    assert judged.used.text == "one"
    assert check_entry(readings(holds, holds), names).verdict is EntryVerdict.HOLDS
    assert check_entry(readings(differs, differs), names).verdict is EntryVerdict.DIFFERS


def test_a_definition_that_contradicts_the_derivation_differs() -> None:
    agreed, introduced = Relation(double, 2 * x), Relation(double, y, given=True)
    for relations, verdict in (((agreed,), EntryVerdict.DEFINITION), ((introduced,), EntryVerdict.DEFINITION)):
        assert check_entry(printed("1", "", "definition", *relations), names).verdict is verdict
    assert check_entry(printed("1", "", "definition", Relation(double, y)), names).verdict is EntryVerdict.DIFFERS
    assert entry(introduced).verdict is EntryVerdict.DEFINITION


def test_a_ledger_is_plain_data() -> None:
    paper = Paper("a paper", 1, names, (printed("1", "twice", "equation", Relation(double, 3 * x, corrected=2 * x)),))
    document = json.loads(json.dumps(check_paper(paper, "model").to_json()))
    assert document["counts"]["differs"] == 1
    (row,) = document["entries"]
    assert (row["number"], row["verdict"]) == ("(1)", "differs")
    (line,) = row["readings"][0]["lines"]
    assert (line["printed"], line["corrected"]) == ("double = 3*x", "double = 2*x")
    assert (line["printed_latex"], line["corrected_latex"]) == ("D = 3 x", "D = 2 x")
    assert line["edits"] == ["number before x: printed 3, correct 2"]


def test_a_function_without_a_value_is_named():
    x = sp.Symbol("x")
    with pytest.raises(
        UnknownFunctionError, match=r"no 50-digit value for besselj in besselj\(0, x\); functions known: .*acos, "
    ):
        Sides(Pool()).entries(sp.besselj(0, x))


def test_an_inverse_is_printed_and_not_computed(monkeypatch):
    def computed(self, **hints):
        raise AssertionError("computed")

    monkeypatch.setattr(sp.ImmutableDenseMatrix, "_eval_inverse", computed)
    product = sp.MatMul(sp.Inverse(sp.ImmutableMatrix([[x, y], [0, 1]])), sp.ImmutableMatrix([x, r]))
    assert names.as_text(product) == "[x, y; 0, 1]**(-1)*[x; r]"
    assert names.as_latex(product) == (
        r"\left[\begin{matrix}x & y\\0 & 1\end{matrix}\right]^{-1} \left[\begin{matrix}x\\\rho\end{matrix}\right]"
    )
