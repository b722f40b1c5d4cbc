# SPDX-License-Identifier: Apache-2.0
"""Text, page, comment and JSON say the same of a comparison; and a long one is told shortly."""

import dataclasses
import html
import json
import re

import pytest

from mehvar.base.manifest import read_manifest
from mehvar.codegen.diff.report import EquationVerdict, label
from mehvar.comparison.compare import compare_documents
from mehvar.comparison.consequences import Consequences, Rate
from mehvar.comparison.document import Group, Table, Words
from mehvar.comparison.effects import moved, number, relative, unit
from mehvar.comparison.equations import example
from mehvar.comparison.html import html_page
from mehvar.comparison.markdown import _paragraphs, markdown
from mehvar.comparison.result import Diff, ModelDiff
from mehvar.comparison.runs import MarginChange, MetricChange, RunChange, Runs
from mehvar.comparison.spectra import Loop
from mehvar.estimation.margins import Margin
from mehvar.html import quantities
from tests.codegen.diff.documents import document
from tests.codegen.diff.pairs import PENDULUM

EDITS = {
    "sign": ("s = x + m*y\nf: s*z", "s = x - m*y\nf: s*z"),
    "two edits": ("f: m*x*y + k*z*w + J*v", "f: -m*x*y + k*z*w + 2*J*v"),
    "term added": ("f: x", "f: x + m*y"),
    "term lost": ("f: x + m*y", "f: x"),
    "definition": ("f: x*y + z", "s = x*y\nf: s + z"),
    "result added": ("f: x", "f: x\ng: y*m"),
    "result removed": ("f: x\ng: y*m", "f: x"),
    "renamed": ("s = x*y + z\nf: s*w", "sigma = x*y + z\nf: sigma*w"),
    "renamed and changed": ("s = x*y/2 + z\nf: s*w", "sigma = x*y + z\nf: sigma*w"),
    "rearranged": ("f: x*(y + z)", "f: x*y + x*z"),
    "scaled": ("0: x + y", "0: 2*x + 2*y"),
    "convention": ("s = x - y\nf: s*z + w\ng: s**2", "s = y - x\nf: w - s*z\ng: s**2"),
    "family": ("s1 = m1*q1\ns2 = m2*q2\nf: s1 + s2", "s1 = 2*m1*q1\ns2 = 2*m2*q2\nf: s1 + s2"),
    "follows": ("s = m*cos(theta)\nf: k - m*w*sin(theta)", "s = m*sin(theta)\nf: k + m*w*cos(theta)"),
    "undecided": ("f: Piecewise((y, erf(x) > 2), (z, True))", "f: Piecewise((w, erf(x) > 2), (z, True))"),
    "lost": ("s = m*x + k*y\nf: s*z\ng: 2*s - v", "f: (m*x - k*y)*z\ng: 2*m*x - 2*k*y - v"),
}


def consequences(count):
    """Return consequences of every kind, each with numbers of its own."""
    metrics = tuple(MetricChange(f"metric {k}", "rad", 1.25 + k, 2.5 + 2 * k) for k in range(count))
    changed = tuple(RunChange(f"law{k}", "swing", "", "ended early: fell", metrics, 40) for k in range(count))
    margins = (MarginChange("pd", "swing", (Margin("T", 3.25, 0.5),), (Margin("T", 4.75, 0.625),)),)
    runs = Runs(
        changed, (("pd", "calm"),), margins, (("pd", "stiff", "angle_0 must be less"),), "laws were not all run"
    )
    return Consequences(
        rates=tuple(Rate(f"state{k}", "rad/s^2", 0.111 + k, 0.222 + k) for k in range(count)),
        samples=512,
        point=(("angle", 0.375),),
        residual=0.0625,
        eigenvalues=tuple((complex(-0.5 - k, 2), complex(-0.75 - k, 3)) for k in range(count)),
        loops=tuple(Loop(f"law{k}", 0.05, (("angle", 0.5),), ((0.9 + 0j, 0.8 + 0j),)) for k in range(count)),
        operations=tuple((f"function{k}", 100 + k, 200 + 3 * k) for k in range(count)),
        runs=runs,
        note="loops not compared",
    )


def facts(model: ModelDiff) -> list[str]:
    """Return the facts, as texts that have to stand in every format."""
    comparison, follows = model.comparison, model.consequences
    said = [model.name, *model.notes, *(text for choice in comparison.structure for text in choice)]
    said += [text for p in comparison.parameters for text in (p.name, p.role, p.what, p.old, p.new)]
    said += [group.says for group in comparison.groups if group.kind not in ("family", "symmetric")]
    for equation in comparison:
        if equation.verdict is not EquationVerdict.SAME:
            said += [label(equation), equation.verdict.value]
        if equation.verdict is EquationVerdict.RENAMED:
            said.append(equation.old_name)
        if equation.verdict in (
            EquationVerdict.REARRANGED,
            EquationVerdict.RENAMED,
            EquationVerdict.SCALED,
            EquationVerdict.UNDECIDED,
        ):
            said.append(equation.how)
        if equation.verdict in (EquationVerdict.CHANGED, EquationVerdict.UNDECIDED) and not equation.cause:
            said += [*(edit.says for edit in equation.edits), example(equation), *equation.users]
    if follows:
        said += [text for rate in follows.rates for text in (rate.name, f"{rate.largest:.3g}", f"{rate.typical:.3g}")]
        spectra = (follows, *follows.loops)
        said += [number(value) for spectrum in spectra for pair in spectrum.eigenvalues for value in pair]
        said += [str(part) for row in follows.operations for part in row]
        said += [text for run in follows.runs.changed for text in (run.law, run.scenario, run.new)]
        for m in (m for run in follows.runs.changed for m in run.metrics):
            said += [m.name, f"{m.old:.5g}", f"{m.new:.5g}"]
        for change in follows.runs.margins:
            said += [change.law, *(margin.text for margin in (*change.old, *change.new))]
        said += [reason for _, _, reason in follows.runs.refused]
        said += [follows.note, follows.runs.note, f"{follows.residual:.2g}", "angle = 0.375"]
    return [fact for fact in said if fact]


def test_values_at_a_point_name_the_definitions_that_keep_their_old_values():
    old, new = "s = x\nr = y\nf: s*m + r*k", "s = x + 1\nr = y\nf: s**2*m + r*k"
    model = compare_documents(document(old), document(new))
    changed = model.comparison["f"]
    assert changed.held == ("s",)
    told = [str(model), html_page(Diff("", "", (model,))), markdown(Diff("", "", (model,))), str(model.to_json())]
    assert all("with s as before" in plain(form) for form in told[:3])
    assert "'held': ('s',)" in told[3]
    assert model.comparison["s"].held == ()


def plain(text: str) -> str:
    """Return a text as it is read: without tags, escapes and line breaks, numbers as pages set them."""
    text = html.unescape(re.sub(r"<style>.*?</style>|</?[a-z!][^>]*>", " ", text, flags=re.DOTALL))
    text = html.unescape(str(quantities(text)))
    return " ".join(re.sub(r"\\(.)", r"\1", text).split()).casefold()


def missing(model: ModelDiff) -> list[tuple[str, str]]:
    """Return the facts that a format leaves out."""
    diff = Diff("old", "new", (model,))
    forms = {"text": str(model), "page": html_page(diff), "comment": markdown(diff), "notebook": model._repr_html_()}
    return [(form, fact) for form, text in forms.items() for fact in facts(model) if plain(fact) not in plain(text)]


@pytest.mark.parametrize("name", EDITS)
@pytest.mark.share(8)
def test_every_fact_is_in_every_format(name):
    model = compare_documents(*map(document, EDITS[name]))
    comparison = dataclasses.replace(model.comparison, structure=(("rods", "default", "light"),))
    model = dataclasses.replace(model, comparison=comparison, notes=("generated/made is stale: x.py changed",))
    assert missing(model) == []
    told = dataclasses.replace(model, consequences=consequences(2))
    other = dataclasses.replace(told, variant="rods=uniform", notes=("of its own",))
    assert missing(told) == []
    assert missing(other) == []


@pytest.mark.parametrize("what", ["unit", "bounds", "source", "name", "added"])
def test_names_and_numbers_are_in_every_format(what):
    values = {"unit": ("kg", "g"), "bounds": ("(0, inf)", "[0, 1]"), "source": ("paper", "guess")}
    if what in values:
        pair = [document("f: m*x", m={what: value}) for value in values[what]]
    else:
        new = {"stiff": {"role": "parameter", "description": "the spring" if what == "name" else "another"}}
        old = {"spring": {"role": "parameter", "description": "the spring"}} if what == "name" else {}
        pair = [document("f: x" + "*spring" * bool(old), **old), document("f: x*stiff", **new)]
    assert missing(compare_documents(*pair)) == []


def test_numbers_of_manifests_are_in_every_format():
    manifest, plain_document = read_manifest(PENDULUM), document("f: m*x")
    scenario = manifest.scenarios["swing"]
    changed = dataclasses.replace(scenario, duration=123.5, step=0.375)
    after = dataclasses.replace(manifest, scenarios=dict(manifest.scenarios) | {"swing": changed})
    pair = (dataclasses.replace(plain_document, manifest=each) for each in (manifest, after))
    model = compare_documents(*pair)
    assert len(model.parameters) == 2
    assert missing(model) == []


def test_json_has_every_field():
    """As plain data; the graphs that the nodes refer to stand in equations.json, the runs' series nowhere."""
    model = compare_documents(*map(document, EDITS["two edits"]))
    model = dataclasses.replace(model, consequences=consequences(2), notes=("a note",), structures=(model,))
    data = json.loads(Diff("old", "new", (model,)).json_text())["models"][0]
    graphs = {"old_nodes", "new_nodes", "old_latex", "new_latex"}
    fields = {field.name for kind in (model, model.comparison) for field in dataclasses.fields(kind)}
    assert fields - graphs - {"comparison", "overlay"} <= data.keys()
    assert data["notes"] == ["a note"]
    assert data["structures"][0]["equations"] == data["equations"]


def test_many_edits_are_told_shortly_and_in_order():
    names = [first + second for first in "bcd" for second in "aeio"]
    edits = [(f"m**{k + 2}*x + k*y", f"m**{k + 2}*x - {k + 1}*k*y") for k in range(12)]
    old, new = (
        "\n".join(f"{name} = {edit[side]}\nf{name}: {name}*J" for name, edit in zip(names, edits, strict=True))
        for side in (0, 1)
    )
    new += "\ng: x"
    model = compare_documents(document(old), document(new))
    model = dataclasses.replace(model, consequences=consequences(30))
    text = str(model)
    assert len(text.splitlines()) < 170
    places = [text.find(f"changed {name}\n") for name in names[:8]]
    places += [
        text.find(f"4 more of definition, changed: {', '.join(names[8:])}"),
        text.find("1 more of rhs, added: g"),
    ]
    assert -1 not in places
    assert places == sorted(places)
    assert text.count("3 points of a 154-bit field") < 12
    assert "and 22 more" in text
    page = html_page(Diff("old", "new", (model,)))
    assert all(f"metric {k}" in page for k in range(30))


def test_a_heading_counts_every_equation_that_it_names():
    names = ("xa", "ya", "za", "va", "wa", "xb", "yb", "zb")
    others = "".join(f"{name} = {name[0]}*J\nr{name}: {name}\n" for name in names)
    members = "".join(f"s{k} = m{k}*q{k}\n" for k in (1, 2, 3)) + "f: s1 + s2 + s3"
    edited = members.replace("\n", " + x\n")
    model = compare_documents(document(others + members), document(others.replace("J", "k") + edited))
    assert "3 more of definition, changed: s1, s2, s3" in str(model)


def test_markdown_reads_like_the_text():
    """Of a summary Markdown reads no escapes, as it stands within HTML."""
    MarkdownIt = pytest.importorskip("markdown_it").MarkdownIt
    words = "x_1 < y_1 & *[a]* ~~b~~ $c$ #1 \\ `d` | e &lt; <b>"
    group = Group(words, [Words(words), Words(words, strong=True), Table(words, ["old"], [[words]])], True)
    read = MarkdownIt("gfm-like", {"linkify": False}).render("\n\n".join(_paragraphs([group])))
    text = html.unescape(re.sub(r"</?(p|strong|table|thead|tbody|tr|th|td|details|summary)( [^>]*)?>", "\n", read))
    assert [line for line in map(str.strip, text.splitlines()) if line] == [words] * 4 + ["old", words]


def test_a_page_begins_with_what_changed_and_has_no_section_without_content():
    same, changed = (
        dataclasses.replace(compare_documents(document("f: m*x"), document(new)), model=name)
        for name, new in (("same", "f: m*x"), ("turned", "f: -m*x"))
    )
    page = html_page(Diff("old", "new", (same, changed)))
    assert re.findall(r'<section id="(\w+)"', page) == ["turned"]
    assert page.index("#turned") < page.index("<li>same")


def test_a_change_without_effect_is_told_with_its_reason():
    """A factor of the changed term is zero in every run: equal metrics, and why."""
    runs = Runs(same=(("pd", "calm"), ("pd", "swing")), largest=2.5e-9, zero=("m", "v"))
    model = compare_documents(*map(document, EDITS["sign"]))
    model = dataclasses.replace(model, consequences=Consequences(runs=runs))
    for told in (str(model), html_page(Diff("old", "new", (model,))), markdown(Diff("old", "new", (model,)))):
        text = plain(told)
        assert "all metrics equal in 2 runs, largest relative difference 2.5×10⁻⁹: calm, swing under pd" in text
        assert "the changed terms have m = 0 in all of these runs" in text


def test_the_run_that_moved_farthest_is_shown_and_the_others_are_folded():
    model = compare_documents(document("f: m*x"), document("f: -m*x"))
    runs = [
        RunChange("pd", f"start{k}", "", "", (MetricChange("T", "s", 1.0, 1.0 + k),), 1) for k in (1, 3, 2, 6, 5, 4)
    ]
    model = dataclasses.replace(model, consequences=Consequences(runs=Runs(changed=tuple(runs))))
    page = html_page(Diff("old", "new", (model,)))
    folded = page[page.index("2 more under other laws or scenarios") :]
    assert "start6" in page.removesuffix(folded)
    assert 0 < folded.index("start2") < folded.index("start1")


def test_a_notebook_shows_a_comparison_once(monkeypatch):
    """In Jupyter, rich showed each line of the form in HTML beside the form itself."""
    shown = []
    monkeypatch.setattr("rich.console._is_jupyter", lambda: True)
    monkeypatch.setattr("rich.jupyter.display", lambda *parts: shown.append(parts))
    model = compare_documents(*map(document, next(iter(EDITS.values()))))
    assert "<pre" in model._repr_html_()
    assert not shown


def test_what_differs_is_shown_different_and_a_value_that_became_zero_has_no_percentage():
    """Such lines read "-0.8333 -> -0.8333" and "(-100 %)"."""
    assert moved(complex(-5 / 6), complex(-5 / 6 - 2e-6)) == ("-0.83333", "-0.83334")
    assert moved(complex(-0.5), complex(-0.5, 1e-11)) == ("-0.5", "-0.5 ± 1e-11i")
    edge = complex(-0.12475 - 1e-15, 7.993), complex(-0.12475 + 1e-15, 7.994)
    assert len({part.split(" ")[0] for part in moved(*edge)}) == 1
    assert moved(complex(-0.5), complex(-0.25, 1)) == ("-0.5", "-0.25 ± 1i")
    pairs = ((2.0, 3.0), (2.0, 0.0), (0.0, 2.0))
    assert [relative(MetricChange("m", "s", *pair)) for pair in pairs] == ["+50 %", "", ""]


def test_eigenvalues_of_two_periods_name_both():
    loop = Loop("law", 0.2, (), ((0.98 + 0j, 0.96 + 0j),), 0.1)
    assert unit(loop) == "per period of 0.1 s -> 0.2 s"
    assert unit(dataclasses.replace(loop, old_period=0.2)) == "per period of 0.2 s"
