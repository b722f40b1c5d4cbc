# SPDX-License-Identifier: Apache-2.0
"""equations.json is canonical and complete; equations.md is well formed, short-lined and explains its names."""

import dataclasses
import importlib
import json
import re

import pytest
import sympy as sp

from mehvar.codegen.diff import Document
from mehvar.codegen.equations.formula import Printer, width
from mehvar.codegen.equations.graph import EquationsError, Graph, equations_json, exact, outcomes
from mehvar.codegen.generate import installed_tree
from mehvar.models.derivation import Derivation, Equation
from mehvar.models.slosh.system import system as slosh_system

GENERATED = installed_tree().root / "generated"
MODELS = installed_tree().models
x, y, z = sp.symbols("x y z", real=True)


@pytest.fixture(scope="module")
def triangle():
    return importlib.import_module("mehvar.models.triangle").system()


def nodes(expr):
    graph = Graph()
    graph.add(expr)
    return {json.dumps(_written(graph.nodes, k)) for k in range(len(graph.nodes))}


def _written(graph, k):
    return [_written(graph, o) if isinstance(o, int) else o for o in graph[k]]


@pytest.mark.parametrize(
    ("first", "second"),
    [
        (x + y * z, sp.Add(sp.Mul(z, y, evaluate=False), x, evaluate=False)),
        (x + y + z, sp.Add(x, sp.Add(y, z, evaluate=False), evaluate=False)),
        (6 * x * y, sp.Mul(2, sp.Mul(3, x, evaluate=False), y, evaluate=False)),
        (sp.Max(x, y, z), sp.Max(z, y, x)),
        (sp.Rational(4, 25) * x, sp.Float("0.16") * x),
        (x + 3, sp.Add(1, x, 2, evaluate=False)),
    ],
)
def test_order_and_nesting_do_not_show(first, second):
    assert nodes(first) == nodes(second)


def test_a_float_is_the_shortest_decimal_of_its_double():
    assert exact(sp.Float(0.1 + 0.2)) == sp.Rational("0.30000000000000004")
    assert exact(sp.Float(0.1)) == sp.Rational(1, 10)
    assert exact(sp.Float(0.1 + 0.2)) != exact(sp.Float(0.3))


@pytest.mark.parametrize("number", [sp.Float("0.1", 30), sp.Float("inf"), sp.Float("nan")])
def test_what_is_no_double_is_refused(number):
    with pytest.raises(EquationsError, match=r"write sympy\.Rational"):
        exact(number)


def test_the_text_does_not_depend_on_the_order_of_construction(triangle):
    """The same expressions with their operands built the other way round."""

    def turned(expr):
        return expr.replace(
            lambda e: isinstance(e, sp.Add | sp.Mul), lambda e: e.func(*reversed(e.args), evaluate=False)
        )

    steps = tuple(dataclasses.replace(step, expr=turned(step.expr)) for step in triangle.steps)
    assert equations_json(dataclasses.replace(triangle, steps=steps)) == equations_json(triangle)


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.share(3)
def test_everything_that_is_evaluated_is_there(model):
    system = importlib.import_module(f"mehvar.models.{model}").system()
    document = Document.read(GENERATED / model)
    assert [(row.kind, row.name) for row in document.results] == [(o.kind, o.name) for o in outcomes(system)]
    count = {kind: sum(row.kind == kind for row in document.results) for kind in {r.kind for r in document.results}}
    memory = sum(len(law.memory) for law in system.controllers)
    assert count["rhs"] == len(system.states)
    assert count.get("memory update", 0) == count.get("memory at start", 0) == memory
    assert count.get("function", 0) == sum(len(f.results) for f in system.functions)
    assert count.get("motion", 0) == len(system.residual)
    names = [(row.kind, row.name) for row in document.results]
    assert len(names) == len(set(names))


@pytest.mark.parametrize("model", MODELS)
def test_every_symbol_of_a_document_can_be_printed(model):
    document = Document.read(GENERATED / model)
    used = {node[1] for node in document.nodes if node[0] == "sym"}
    assert used <= document.latex.keys()
    printed = [Printer(document.nodes).text(row.node) for row in document.rows]
    assert all(printed)


def test_members_of_a_family_know_their_number():
    document = Document.parse(equations_json(slosh_system(pendulums="3")))
    families = {(s.family, s.index) for s in document.symbols if s.family}
    assert {("m", k) for k in (1, 2, 3)} | {("phi_dot", k) for k in (1, 2, 3)} <= families
    members = {(row.family, row.index) for row in document.definitions if row.family}
    assert {("k_phi", k) for k in (1, 2, 3)} <= members


def test_a_symbol_that_nobody_declared_is_refused(triangle):
    stray = dataclasses.replace(triangle, rhs=(sp.Symbol("stray"), *triangle.rhs[1:]))
    with pytest.raises(EquationsError, match="'stray' is neither"):
        equations_json(stray)


def test_a_shown_equation_may_introduce_names(triangle):
    d = Derivation()
    d.show("E", sp.Symbol(r"\dot v", real=True) * x, "(1)")
    (step,) = d.steps
    assert isinstance(step, Equation)
    shown = dataclasses.replace(triangle, steps=(*triangle.steps, step))
    assert Document.parse(equations_json(shown)).declared[r"\dot v"].role == "shown"


@pytest.mark.parametrize("model", MODELS)
def test_the_page_is_well_formed(model):
    text = (GENERATED / model / "equations.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```math\n(.*?)\n```", text, flags=re.DOTALL)
    inline = re.findall(r"\$`(.*?)`\$", text)
    assert blocks
    assert inline
    for formula in (*blocks, *inline):
        assert formula.count("{") == formula.count("}")
        assert formula.count(r"\left") == formula.count(r"\right")
        assert formula.count(r"\begin{") == formula.count(r"\end{")
        assert r"\operatorname" not in formula
    for formula in inline:
        assert "|" not in formula


@pytest.mark.parametrize("model", MODELS)
def test_links_of_the_contents_lead_somewhere(model):
    text = (GENERATED / model / "equations.md").read_text(encoding="utf-8")
    headings = re.findall(r"^#+ (.*)$", text, flags=re.MULTILINE)
    anchors = {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}
    links = re.findall(r"\]\(#(.*?)\)", text)
    assert links
    assert set(links) <= anchors


def test_lines_of_the_slosh_page_fit_a_screen():
    """A few products of long factors stay longer than the rest."""
    text = (GENERATED / "slosh" / "equations.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```math\n(.*?)\n```", text, flags=re.DOTALL)
    widths = sorted(width(line) for block in blocks for line in block.splitlines())
    assert widths[int(0.98 * len(widths))] <= 110
    assert widths[-1] <= 180


def test_equations_of_the_paper_are_numbered_on_the_page():
    text = (GENERATED / "slosh" / "equations.md").read_text(encoding="utf-8")
    for number in ("(7)", "(9)", "(12)", "(16)", "(25)", "(26)", "(33)"):
        assert f"**{number}" in text or f", {number}" in text
