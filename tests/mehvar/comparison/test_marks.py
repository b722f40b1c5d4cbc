# SPDX-License-Identifier: Apache-2.0
"""Formulas on the page: valid MathML, and exactly the parts that differ are marked."""

import xml.etree.ElementTree as ET
from collections.abc import Iterable

import pytest

from mehvar.codegen.equations.formula import Printer
from mehvar.codegen.equations.mathml import mathml
from mehvar.codegen.equations.spelling import LATEX, PAGE
from mehvar.comparison.compare import compare_documents
from mehvar.comparison.html import _Sheet
from tests.codegen.diff.documents import document


class Graph:
    """An expression graph as equations.json holds it, written by hand."""

    def __init__(self) -> None:
        self.nodes: list[list[object]] = []

    def __call__(self, operation: str, *operands: object) -> int:
        self.nodes.append([operation, *operands])
        return len(self.nodes) - 1

    def sym(self, name: str) -> int:
        return self("sym", name)

    def num(self, value: str) -> int:
        return self("num", value)

    def sin(self, name: str) -> int:
        return self("sin", self.sym(name))


def visible(node: ET.Element) -> str:
    """Return the visible text of a formula."""
    return "".join(node.itertext())


def shown(graph: Graph, root: int, marks: frozenset[tuple[int, ...]] = frozenset()) -> tuple[str, list[str]]:
    """Return a formula's text, and the text of its marked parts."""
    return read((mathml(term), whole) for term, whole in Printer(graph.nodes, spelling=PAGE, marks=marks).parts(root))


def read(terms: Iterable[tuple[str, bool]]) -> tuple[str, list[str]]:
    text, marked = "", []
    for term, whole in terms:
        tree = ET.fromstring(term)
        text += visible(tree)
        marked += (
            [visible(tree)] if whole else [visible(part) for part in tree.iter("mrow") if part.get("class") == "mark"]
        )
    return text, marked


@pytest.mark.parametrize(
    ("build", "text"),
    [
        (lambda g: g("add", g.sym("a"), g("mul", g.num("-2"), g.sym("b"))), "a−2b"),
        (lambda g: g("mul", g.num("-1/2"), g.sym("m"), g("pow", g.sym("v"), g.num("2"))), "−mv22"),
        (lambda g: g("pow", g("add", g.sym("a"), g.sym("b")), g.num("2")), "(a+b)2"),
        (lambda g: g("mul", g.sym("c"), g("add", g.sym("a"), g.sym("b"))), "c(a+b)"),
        (lambda g: g("pow", g.sin("x"), g.num("2")), "sin2x"),
        (lambda g: g("pow", g.sym("x"), g.sym("n")), "xn"),
        (lambda g: g("mul", g.num("-1"), g("add", g.sym("a"), g.sym("b"))), "−(a+b)"),
        (lambda g: g("abs", g("add", g.sym("a"), g.num("-1"))), "|a−1|"),
        (lambda g: g("max", g.num("1/1000000000"), g.sym("x")), "max(10−9,x)"),
        (lambda g: g("min", g.num("4/25"), g.num("1/3")), "min(0.16,13)"),
        (lambda g: g("mul", g("const", "pi"), g("exp", g.sym("t"))), "πet"),
        (
            lambda g: g(
                "piecewise",
                g("exprcondpair", g.sym("a"), g("strictgreaterthan", g.sym("x"), g.num("0"))),
                g("exprcondpair", g.num("0"), g("const", "True")),
            ),
            "{aif\xa0x>00otherwise",
        ),
    ],
)
def test_a_formula_says_what_the_graph_says(build, text):
    graph = Graph()
    assert shown(graph, build(graph))[0] == text


def test_a_sum_looks_the_same_whatever_the_order_of_its_operands():
    one, two = Graph(), Graph()
    assert shown(one, one("add", one.sym("a"), one.sym("b"))) == shown(two, two("add", two.sym("b"), two.sym("a")))


def test_a_power_of_a_product_keeps_its_brackets():
    graph = Graph()
    half = graph("pow", graph("mul", graph.num("1/2"), graph.sym("x")), graph.num("2"))
    (term,) = Printer(graph.nodes, spelling=PAGE).terms(half)
    assert visible(ET.fromstring(mathml(term))) == "(x2)2"


def test_names_are_escaped_and_latex_is_set():
    assert visible(ET.fromstring(mathml(LATEX.name("a<b", "")))) == "a<b"
    tree = ET.fromstring(mathml(LATEX.name("phi1_dot", r"\dot{\varphi}_1")))
    assert tree.find(".//mover") is not None
    assert "φ" in visible(tree)


@pytest.mark.parametrize("tex", [r"\dot{v}", r"\ddot{v}_1", r"\hat{x}", r"\tilde{x}", r"\vec{r}", r"\dot{\hat{x}}"])
def test_signs_above_letters_have_their_whole_size(tex):
    """Browsers draw them like exponents otherwise, and the dot of a rate is smaller than a pixel."""
    signs = list(ET.fromstring(mathml(tex)).iter("mover"))
    assert signs
    assert all(sign.get("accent") == "true" for sign in signs)


@pytest.mark.parametrize(
    ("tex", "text"),
    [
        (r"-d \mathrm{atan2}\left(v, x\right)", "−d atan2(v,x)"),
        (r"k \sin^{2} x", "k sin2 x"),
        (r"-\mathrm{gain} k x", "−gain kx"),
        (r"\mathrm{hub}_{a} \mathrm{hub}_{b}", "huba hubb"),
        (r"2 \, \sin \, x", "2 sin x"),
        (r"2 \mathrm{x2max}", "2 x2max"),
        (r"x_{\mathrm{ref}} y", "xrefy"),
        (r"\left(a\right) \cos b - \ln c", "(a) cos b−ln c"),
    ],
)
def test_names_of_several_letters_stand_apart(tex, text):
    tree = ET.fromstring(mathml(tex))
    for space in tree.iter("mspace"):
        space.text = " "
    assert visible(tree) == text


@pytest.mark.parametrize(
    ("old", "new", "marked"),
    [
        ("f: x*(y + z) + v", "f: x*y + x*z + v", [["+x(y+z)"], ["+xy", "+xz"]]),  # what stayed is not marked
        ("f: x*y + 2*z*w + m*v", "f: x*y + m*v", [["+2wz"], []]),
        ("f: x*y + m*v", "f: x*y + 2*z*w + m*v", [[], ["+2wz"]]),
        ("f: x*y + 2*z*w", "f: x*y - 2*z*w", [["2wz"], ["−2wz"]]),
        ("f: x*y + 2*z*w", "f: x*y + 2*z*v", [["w"], ["v"]]),
        ("f: x*y + m*sin(z)", "f: x*y + m*sin(y)", [["z"], ["y"]]),  # not in the term that stayed
        ("f: x*(y/3 + z)/2", "f: x*(y/3 + z)/3", [["2"], ["x(y3+z)3"]]),  # the other 1/3 stayed
        ("f: x*y + 2*z*w*v", "f: x*y + 2*z*w", [["2vwz"], ["2wz"]]),
        ("f: v + 3*x/4", "f: v + 3*x/8", [["3", "4"], ["3", "8"]]),
        ("f: v - x/2", "f: v - x/3", [["2"], ["3"]]),
        ("f: v - 3*x/4", "f: v + 5*x/8", [["−3x4"], ["+5x8"]]),  # the sign changed too
        ("s = x + z\nf: s*w + s*v", "sigma = x + z\nf: sigma*w + 2*sigma*v", [["sv"], ["2sigmav"]]),
    ],
)
def test_the_edited_parts_of_terms_that_differ_are_marked(old, new, marked):
    sheet = _Sheet(compare_documents(document(old), document(new)))
    blocks = [inner for block in sheet.blocks for inner in getattr(block, "blocks", [block])]
    card = next(block for block in blocks if block.equation.name == "f")
    assert [read(side.terms)[1] for side in sheet.sides(card)] == marked


def sums(*terms: tuple[int, tuple[str, ...]]) -> tuple[Graph, int]:
    """Return a sum of products of symbols with a coefficient each."""
    g = Graph()
    products = [g("mul", *([g.num(str(k))] if k != 1 else []), *map(g.sym, names)) for k, names in terms]
    return g, g("add", *products)


def test_a_mark_on_a_factor_that_is_not_printed_marks_its_term():
    graph, root = sums((1, "ab"), (-1, "cd"))
    products = [[graph.nodes[factor] for factor in graph.nodes[term][1:]] for term in graph.nodes[root][1:]]
    term = next(k for k, factors in enumerate(products) if ["num", "-1"] in factors)
    assert shown(graph, root, frozenset({(term, 0)}))[1] == ["−cd"]
    assert shown(graph, root, frozenset({(term, 1)}))[1] == ["c"]
