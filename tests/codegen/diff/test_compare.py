# SPDX-License-Identifier: Apache-2.0
"""Sources and what inherits from them, names, families, conventions, implicit equations, parameters, refusals."""

import dataclasses
import json
import re
from pathlib import Path

import pytest

from mehvar.base.manifest import read_manifest
from mehvar.codegen.diff import Document, DocumentError, compare
from mehvar.codegen.diff.report import EquationVerdict, Kind, handle, label
from tests.codegen.diff.documents import document

PENDULUM = Path(__file__).parents[2] / "runtime" / "pendulum"


def verdicts(comparison):
    return {equation.name: equation.verdict for equation in comparison}


def test_a_definition_used_in_ten_equations_is_reported_once():
    uses = "\n".join(f"f{k}: s*x**{k}" for k in range(1, 11))
    comparison = compare(document(f"s = m*x + k*y\n{uses}"), document(f"s = m*x - k*y\n{uses}"))
    assert verdicts(comparison) == {"s": EquationVerdict.CHANGED} | {
        f"f{k}": EquationVerdict.INHERITED for k in range(1, 11)
    }
    assert comparison["s"].users == tuple(f"f{k}" for k in range(1, 11))
    assert all(comparison[f"f{k}"].via == ("s",) for k in range(1, 11))
    assert len(comparison.changed) == 11


def test_two_sources_are_told_apart():
    comparison = compare(document("s = x + y\nf: s*z\ng: m*w"), document("s = x - y\nf: s*z\ng: l*w"))
    assert {equation.name for equation in comparison.sources} == {"s", "g"}
    assert comparison["f"].verdict is EquationVerdict.INHERITED
    assert comparison["f"].via == ("s",)


def test_a_user_may_change_beside_what_it_inherits():
    comparison = compare(document("s = x + y\nf: s*z + w"), document("s = x - y\nf: s*z - w"))
    assert verdicts(comparison) == {"s": EquationVerdict.CHANGED, "f": EquationVerdict.CHANGED}
    assert [edit.says for edit in comparison["f"].edits] == ["sign flipped: + became -"]


def test_a_renamed_definition_is_found_by_its_value():
    comparison = compare(document("s = x*y + z\nf: s*w"), document("sigma = x*y + z\nf: sigma*w"))
    assert comparison["sigma"].verdict is EquationVerdict.RENAMED
    assert comparison["sigma"].old_name == "s"
    assert not comparison.differs


def test_a_renamed_definition_that_inherits_is_found_by_its_text():
    comparison = compare(document("s = x - y\nt = s*z\nf: t*w"), document("s = x + y\nu = s*z\nf: u*w"))
    assert comparison["u"].old_name == "t"
    assert comparison["u"].verdict is EquationVerdict.INHERITED
    assert [equation.name for equation in comparison.sources] == ["s"]


def test_a_definition_that_changed_and_was_written_out_is_reported_once():
    old = "s = m*x + k*y\nf: s*z + w\ng: 2*s - v\nh: x*s + s*y"
    new = "f: (m*x - k*y)*z + w\ng: 2*m*x - 2*k*y - v\nh: (x + y)*(m*x - k*y)"
    comparison = compare(document(old), document(new))
    assert verdicts(comparison) == {"s": EquationVerdict.CHANGED} | dict.fromkeys("fgh", EquationVerdict.INHERITED)
    assert comparison["s"].users == ("f", "g", "h")
    assert [edit.says for edit in comparison["s"].edits] == ["sign flipped: + became -"]


def test_what_one_user_alone_lost_is_not_blamed_on_a_definition():
    old = "s = m*x + k*y\nf: s*z + w\ng: 2*s - v"
    new = "f: (m*x - k*y)*z + w\ng: 2*m*x + 2*k*y - v"
    comparison = compare(document(old), document(new))
    assert [equation.name for equation in comparison.sources] == ["f"]


def test_naming_an_intermediate_result_is_no_difference():
    comparison = compare(document("f: (x + y)*z"), document("s = x + y\nf: s*z"))
    assert [equation.name for equation in comparison.added] == ["s"]
    assert not comparison.differs


def test_a_new_result_is_a_difference():
    comparison = compare(document("f: x"), document("f: x\ng: y"))
    assert [equation.name for equation in comparison.added] == ["g"]
    assert comparison.differs


def test_a_convention_that_its_users_compensate_is_no_physics():
    comparison = compare(document("s = x - y\nf: s*z + w\ng: s**2"), document("s = y - x\nf: w - s*z\ng: s**2"))
    assert comparison["s"].verdict is EquationVerdict.CHANGED
    assert not comparison.differs
    (group,) = comparison.groups
    assert group.kind == "convention"
    assert group.names == ("s", "f")
    assert group.says == "the sign of s changed; f compensate"


def test_a_convention_that_one_user_forgot_is_physics():
    comparison = compare(document("s = x - y\nf: s*z + w\ng: s*v"), document("s = y - x\nf: w - s*z\ng: s*v"))
    assert comparison.differs
    assert comparison["f"].verdict is EquationVerdict.REARRANGED
    assert comparison["g"].via == ("s",)


def test_a_term_added_for_every_member_is_one_story():
    members = "\n".join(f"s{k} = m{k}*q{k}" for k in (1, 2, 3))
    edited = "\n".join(f"s{k} = m{k}*q{k} + l{k}*w{k}**2" for k in (1, 2, 3))
    total = "\nf: s1 + s2 + s3"
    comparison = compare(document(members + total), document(edited + total))
    (group,) = [group for group in comparison.groups if group.kind == "family"]
    assert group.names == ("s1", "s2", "s3")
    assert "for every i" in group.says
    assert all(equation.edits[0].kind is Kind.TERM_ADDED for equation in comparison.sources)


def test_definitions_that_exchange_their_values_have_changed_both():
    """Each keeps its name, so that a user of one has another value without an edit of its own."""
    comparison = compare(document("p = x\nq = y\nf: p*z\ng: q*z"), document("p = y\nq = x\nf: p*z\ng: q*z"))
    assert {e.name: e.verdict.value for e in comparison} == {
        "p": "changed", "q": "changed", "f": "inherited", "g": "inherited",
    }  # fmt: skip


def test_a_new_definition_with_the_former_name_of_another_is_told_apart():
    """The old p is now q; an edit in old and new names would read p became p."""
    comparison = compare(document("p = x\nf: p*z"), document("p = y\nq = x\nf: p*z\ng: q"))
    (edit,) = comparison["f"].edits
    assert comparison["q"].verdict is EquationVerdict.RENAMED
    assert edit.says == "q z became p z"
    assert (edit.old.text, edit.new.text) == ("q z", "p z")


def test_a_renamed_array_is_told_by_its_elements():
    """Each element keeps its description; the whole array's name stands first."""

    def row(array):
        words = ("the first", "the second")
        declared = {f"{array}_{k}": {"description": text, "array": array} for k, text in enumerate(words, 1)}
        return document(f"f: {array}_1*x + {array}_2", **declared)

    (change,) = compare(row("old"), row("new")).parameters
    assert (change.name, change.old, change.new) == ("new", "old_1, old_2", "new_1, new_2")


def test_a_symbol_that_is_renamed_is_a_change_of_names_only():
    gone, come = {"description": "stiffness", "latex": "k"}, {"description": "stiffness", "latex": "k"}
    old = document("f: spring*x", spring={"role": "parameter", **gone})
    new = document("f: stiffness*x", stiffness={"role": "parameter", **come})
    comparison = compare(old, new)
    assert [(p.what, p.old, p.new) for p in comparison.parameters] == [("renamed", "spring", "stiffness")]
    assert comparison["f"].verdict in (EquationVerdict.SAME, EquationVerdict.REARRANGED)
    assert comparison.differs


@pytest.mark.parametrize("what", ["unit", "bounds", "source", "sign"])
def test_a_declaration_that_changes_is_reported(what):
    values = {"unit": ("kg", "g"), "bounds": ("(0, inf)", "[0, 1]"), "source": ("paper", "guess")}
    old, new = values.get(what, ("positive", "real"))
    comparison = compare(document("f: m*x", m={what: old}), document("f: m*x", m={what: new}))
    assert [(p.name, p.what, p.old, p.new) for p in comparison.parameters] == [("m", what, old, new)]
    assert comparison.differs


def test_numbers_of_the_manifest_are_compared():
    manifest, plain = read_manifest(PENDULUM), document("f: m*x")
    mass, paper = manifest.parameters[0], manifest.scenarios["swing"]

    def numbers(default, value):
        parameters = (dataclasses.replace(mass, default=default), *manifest.parameters[1:])
        scenarios = {"paper": dataclasses.replace(paper, values={"m": value})}
        return dataclasses.replace(manifest, parameters=parameters, scenarios=scenarios)

    old, new = (dataclasses.replace(plain, manifest=numbers(*n)) for n in ((1.0, 2.0), (1.5, 3.0)))
    comparison = compare(old, new)
    changes = [(p.role, p.name, p.what, p.old, p.new) for p in comparison.parameters]
    assert changes == [("parameter", "m", "value", "1.0", "1.5"), ("scenario paper", "m", "value", "2.0", "3.0")]


@pytest.mark.parametrize("what", ["duration", "step"])
def test_when_a_scenario_ends_and_what_it_samples_are_compared(what):
    manifest, plain = read_manifest(PENDULUM), document("f: m*x")
    paper = manifest.scenarios["swing"]
    changed = dataclasses.replace(paper, **{what: 2 * getattr(paper, what)})
    after = dataclasses.replace(manifest, scenarios=dict(manifest.scenarios) | {"swing": changed})
    comparison = compare(*(dataclasses.replace(plain, manifest=each) for each in (manifest, after)))
    assert [(p.role, p.name) for p in comparison.parameters] == [("scenario swing", what)]


@pytest.mark.parametrize(("field", "name"), [("expect", "p-sum.n expected"), ("controllers", "p-sum.n")])
def test_a_number_of_a_scenario_is_named_by_its_law_and_said_to_be_expected_where_it_is(field, name):
    manifest, plain = read_manifest(PENDULUM), document("f: m*x")
    swing = dataclasses.replace(manifest.scenarios["swing"], **{field: {"p-sum": {"n": 1.0}}})
    after = dataclasses.replace(manifest, scenarios=dict(manifest.scenarios) | {"swing": swing})
    comparison = compare(*(dataclasses.replace(plain, manifest=each) for each in (manifest, after)))
    assert [(change.role, change.name, change.new) for change in comparison.parameters] == [
        ("scenario swing", name, "1.0")
    ]


def test_what_an_older_manifest_does_not_say_has_not_changed():
    manifest, plain = read_manifest(PENDULUM), document("f: m*x")
    before = dataclasses.replace(manifest, text=re.sub("tolerates_loss|delay", "not_yet", manifest.text))
    law = dataclasses.replace(manifest.controllers["p-sum"], delay="k_p")
    after = dataclasses.replace(manifest, controllers=dict(manifest.controllers) | {"p-sum": law})
    assert not compare(*(dataclasses.replace(plain, manifest=each) for each in (before, after))).differs


@pytest.mark.parametrize(
    ("operand", "where"),
    [
        ("x", r"\{y if erf\(x\)[^.]*"),
        ("x*y + x**2*z + y**2*w + z**3*w + x**3*y**3*z**3*w**3 + x**4*y**5", r".{60}\.\.\."),
    ],
)
def test_a_saturation_that_no_point_reaches_is_undecided(operand, where):
    """Said with the condition, or the beginning of a long one."""
    old, new = (document(f"f: Piecewise(({value}, erf({operand}) > 2), (z, True))") for value in ("y", "w"))
    comparison = compare(old, new)
    assert comparison["f"].verdict is EquationVerdict.UNDECIDED
    assert comparison["f"].matters
    assert comparison.differs
    assert re.search(f"a branch of {where} was neither reached nor excluded", comparison["f"].how)


def test_what_has_a_value_where_an_undecided_definition_has_one_is_undecided_too():
    root = "sqrt(2 - erf(x))"
    comparison = compare(
        document(f"s = ({root} + y)*({root} - y) + z\nf: s*w"), document("s = 2 - erf(x) - y**2 + z\nf: s*w")
    )
    assert verdicts(comparison) == {"s": EquationVerdict.UNDECIDED, "f": EquationVerdict.UNDECIDED}


@pytest.mark.parametrize("user", ["s*w", "w*s + s*z - z*s"])
def test_what_an_undecided_definition_is_used_for_is_undecided(user):
    """And changed where another definition is."""
    old, new = (f"s = Piecewise(({value}, erf(x) > 2), (z, True))\nq = s + 1\n" for value in ("y", "w"))
    comparison = compare(document(f"{old}f: q*w + s"), document(f"{new}f: q*w + {user} - s*w + s"))
    assert set(verdicts(comparison).values()) == {EquationVerdict.UNDECIDED}
    changed = compare(document(f"{old}r = y*z\nf: q*w + r"), document(f"{new}r = 2*y*z\nf: q*w + r"))
    assert verdicts(changed)["f"] is EquationVerdict.INHERITED


@pytest.mark.parametrize(
    ("kind", "number", "title", "latex", "short", "apart"),
    [
        ("equation", "(3)", "energy", "0", "(3)", "(3)"), ("equation", "", "energy", "0", "energy", "energy"),
        ("equation", "", "", "0", "e1", "e1"), ("equation", "(3)", "energy", "E", "(3)", "e1"),
        ("rhs", "(3)", "energy", "0", "e1", "e1"),
    ],
)  # fmt: skip
def test_an_equation_goes_by_its_number_or_its_title_and_all_else_by_its_name(kind, number, title, latex, short, apart):
    row = dataclasses.replace(
        document("f: m*x").results[0], name="e1", kind=kind, number=number, title=title, latex=latex
    )
    assert (label(row), handle(row)) == (short, apart)


def test_a_branch_behind_many_conditions_is_not_called_the_same():
    """Fourteen signs at once: no point of the field has them, and a point in that cell is found by its conditions."""
    names = [f"a{k}" for k in range(14)]
    seldom = " & ".join(f"({name} > 0)" for name in names)
    old, new = (
        document(f"f: Piecewise((x + {shift}, {seldom}), (x, True))", **{name: {} for name in names})
        for shift in (1, 2)
    )
    comparison = compare(old, new)
    assert comparison["f"].verdict is EquationVerdict.CHANGED
    assert comparison.differs


def test_strict_and_other_comparisons_are_not_mixed_up():
    comparison = compare(
        document("f: Piecewise((x, x > 0), (0, True))"), document("f: Piecewise((x, x >= 0), (0, True))")
    )
    assert not comparison.of(EquationVerdict.CHANGED)


def motion(first, second):
    text = document("", qa={"role": "rate"}, qb={"role": "rate"})
    made = document(f"one: {first}\ntwo: {second}", qa={"role": "rate"}, qb={"role": "rate"})
    rows = tuple(dataclasses.replace(row, kind="motion") for row in made.results)
    return dataclasses.replace(made, results=rows, rates={"v": "qa", "w": "qb"}, structure=text.structure)


def test_recombined_equations_of_motion_are_the_same_motion():
    old = motion("m*qa + k*qb - x", "k*qa + J*qb - y")
    new = motion("m*qa + k*qb - x + 2*(k*qa + J*qb - y)", "k*qa + J*qb - y - l*(m*qa + k*qb - x)")
    comparison = compare(old, new)
    assert not comparison.differs
    assert [group.kind for group in comparison.groups] == ["recombined"]


def test_recombining_does_not_hide_a_change():
    old = motion("m*qa + k*qb - x", "k*qa + J*qb - y")
    new = motion("m*qa + k*qb - x + 2*(k*qa + J*qb + y)", "k*qa + J*qb - y")
    assert compare(old, new).differs


def test_several_edits_are_all_told_and_replayed():
    old = document("f: m*x*y + k*z*w + J*v + l*x**2")
    new = document("f: -m*x*y + k*z*w + 2*J*v + l*x**3")
    changed = compare(old, new)["f"]
    assert sorted(edit.kind.value for edit in changed.edits) == ["coefficient", "exponent", "sign"]
    assert changed.replayed


def test_places_lead_to_the_edited_part():
    old, new = document("f: m*x*y + k*z*w + v"), document("f: m*x*y - k*z*w + v")
    comparison = compare(old, new)
    (edit,) = comparison["f"].edits
    for graph, root, part in (
        (old.nodes, comparison["f"].old_node, edit.old),
        (new.nodes, comparison["f"].new_node, edit.new),
    ):
        (place,) = part.places
        node = root
        for k in place:
            node = graph[node][1 + k]
        factors = {graph[o][1] for o in graph[node][1:] if graph[o][0] == "sym"}
        assert factors == {"k", "z", "w"}


def test_it_is_plain_data():
    comparison = compare(document("s = x + y\nf: s*z"), document("s = x - y\nf: s*z"))
    plain = json.loads(json.dumps(comparison.to_json()))
    assert plain["counts"]["changed"] == 1
    assert plain["equations"][0]["edits"][0]["kind"] == "sign"


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda d: d.update(schema=1), "has schema 1"),
        (lambda d: d["nodes"].update(b=["sin", "c"], c=["sym", "x"]), "refers to a later node"),
        (lambda d: d["symbols"].clear(), "not declared"),
        (lambda d: d.pop("results"), "damaged"),
        (lambda d: d["results"][0].update(node="z"), "does not exist"),
    ],
)
def test_what_is_no_document_is_refused(damage, message):
    data = {
        "schema": 3, "model": "made", "structure": {}, "rates": {}, "definitions": [], "nodes": {"a": ["sym", "x"]},
        "symbols": [{"name": "x", "role": "state"}], "results": [{"name": "f", "kind": "rhs", "node": "a"}],
    }  # fmt: skip
    Document.parse(json.dumps(data))
    damage(data)
    with pytest.raises(DocumentError, match=message):
        Document.parse(json.dumps(data))


def test_a_definition_cannot_use_itself():
    data = {
        "schema": 3, "model": "made", "structure": {}, "rates": {}, "nodes": {"a": ["sym", "s"]}, "symbols": [],
        "definitions": [{"name": "s", "kind": "definition", "node": "a"}], "results": [],
    }  # fmt: skip
    with pytest.raises(DocumentError, match="before it is defined"):
        Document.parse(json.dumps(data))


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("x*sqrt((1 + cos(a))/2)", "-x*cos(a/2)"),
        ("y + m*sqrt(1 - sin(a)**2)", "y - m*cos(a)"),
        ("y + Abs(x)", "y - x"),
        ("y + asin(sin(a))", "y - a"),
        ("y + sqrt(x**2 + 2*x*z + z**2)", "y - x - z"),
    ],
)
def test_a_flip_on_half_of_the_space_is_not_called_a_flipped_sign(old, new):
    changed = compare(document(f"f: {old}"), document(f"f: {new}"))["f"]
    assert changed.edits
    assert changed.replayed
    assert Kind.SIGN not in {edit.kind for edit in changed.edits}


@pytest.mark.parametrize(("old", "new"), [("x*sqrt(y**2 + z**2) + m", "m - x*sqrt(y**2 + z**2)"),
                                      ("y + sqrt(m*x + l)*z", "y - sqrt(m*x + l)*z")])  # fmt: skip
def test_a_flip_before_a_root_is_called_a_flipped_sign(old, new):
    changed = compare(document(f"f: {old}"), document(f"f: {new}"))["f"]
    assert [edit.kind for edit in changed.edits] == [Kind.SIGN]


def test_values_that_differ_are_shown_with_digits_that_differ():
    changed = compare(document("f: x + 7*y/2"), document("f: x + 7*y/2 + y/10**30"))["f"]
    assert changed.counterexample is not None
    assert changed.counterexample.left != changed.counterexample.right


def test_a_branch_that_was_not_met_is_named_by_its_expression():
    smaller = "1 - x*y/(x**2 + y**2)"
    undecided = compare(document(f"f: m*Abs({smaller})"), document(f"f: m*({smaller})"))["f"]
    assert undecided.verdict is EquationVerdict.UNDECIDED
    assert "abs(1 - x y/(x^2 + y^2))" in undecided.how or "abs(x y/(x^2 + y^2) - 1)" in undecided.how


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("asin(x/sqrt(x**2 + y**2 + z**2))", "atan2(x, sqrt(y**2 + z**2))"),
        ("m*Abs(1 - x**2/(x**2 + y**2 + z**2))", "m*(y**2 + z**2)/(x**2 + y**2 + z**2)"),
        ("n = sqrt(x**2 + y**2)\nf: acos(x/n)", "f: acos(x/sqrt(x**2 + y**2))"),
    ],
)
def test_a_component_of_a_unit_vector_is_known_to_be_within_one(old, new):
    old, new = (text if ":" in text else f"f: {text}" for text in (old, new))
    assert compare(document(old), document(new))["f"].verdict is EquationVerdict.REARRANGED


WIDENED = {
    "bounds": ({"bounds": "[0, inf)"}, {"bounds": "(-inf, inf)"}),
    "sign": ({"bounds": "(0, inf)", "sign": "positive"}, {"bounds": "(-inf, inf)"}),
    "upper": ({"bounds": "[0, 1]"}, {"bounds": "[-2, 1]"}),
}


def declaring(text, *declarations):
    """Return a document whose k, which SymPy takes for any number, is declared so."""
    plain = document(text, k={"sign": "real"})
    rows = tuple(dataclasses.replace(plain.declared["k"], **row) for row in declarations)
    return dataclasses.replace(plain, symbols=(*(s for s in plain.symbols if s.name != "k"), *rows))


@pytest.mark.parametrize("what", WIDENED)
@pytest.mark.parametrize("narrow_is", ["old", "new"])
def test_a_guard_counts_where_either_side_allows_what_it_guards_from(what, narrow_is):
    narrow, wide = WIDENED[what]
    guarded, bare = declaring("f: x*Abs(k)", narrow), declaring("f: x*k", wide)
    comparison = compare(guarded, bare) if narrow_is == "old" else compare(bare, guarded)
    assert comparison["f"].verdict is EquationVerdict.CHANGED
    assert compare(guarded, declaring("f: x*k", narrow))["f"].verdict is EquationVerdict.REARRANGED


def test_a_guard_counts_where_a_widened_parameter_got_another_name():
    narrow, wide = ({"bounds": bounds, "sign": "real", "latex": "s"} for bounds in ("[0, inf)", "(-inf, inf)"))
    comparison = compare(document("f: x*Abs(spring)", spring=narrow), document("f: x*stiff", stiff=wide))
    assert comparison["f"].verdict is EquationVerdict.CHANGED


def test_a_guard_counts_where_one_of_two_laws_has_a_wider_parameter_of_the_name():
    laws = {"role": "law a", "bounds": "(-inf, inf)"}, {"role": "law b", "bounds": "[0, inf)"}
    comparison = compare(declaring("f: x*Abs(k)", *laws), declaring("f: x*k", *laws))
    assert comparison["f"].verdict is EquationVerdict.CHANGED


def test_an_angle_that_became_a_number_is_drawn_beyond_a_turn():
    old = document("f: atan2(sin(a), cos(a))", a={"unit": "rad"})
    assert compare(old, document("f: a", a={"unit": "1"}))["f"].verdict is EquationVerdict.CHANGED


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("s = x*y/2 + z\nf: s*w", "sigma = x*y + z\nf: sigma*w", "coefficient 1/2 became 1"),
        ("b = x*y/2 + z\nf: a*b*w", "zeta = x*y + z\nf: a*w*zeta", "coefficient 1/2 became 1"),
        ("s = x*y + z\nf: s*w\ng: s - v", "sigma = x*y - z\nf: sigma*w\ng: sigma - v", "sign flipped: + became -"),
        ("s = x + z\nt = s*y\nf: t*w", "q = x - z\nr = q*y\nf: r*w", "sign flipped: + became -"),
        ("s = m*x\nf: w/s", "sigma = m*x**2\nf: w/sigma", "exponent of x: 1 became 2"),
    ],
)
def test_a_definition_that_got_another_name_and_another_value_is_told_by_its_edit(old, new, says):
    comparison = compare(document(old), document(new, q={}, r={"role": "state"}))
    (source,) = comparison.sources
    assert [edit.says for edit in source.edits] == [says]
    assert source.old_name != source.name
    assert not comparison.added
    assert not comparison.removed


def test_another_definition_in_the_place_of_one_that_stays_is_not_called_renamed():
    comparison = compare(document("s = x*y\nf: s*w\ng: s"), document("s = x*y\nt = x + z\nf: t*w\ng: s"))
    assert comparison["s"].verdict is EquationVerdict.SAME
    assert "t" in {equation.name for equation in comparison.added}
    assert comparison["f"].verdict is EquationVerdict.CHANGED
