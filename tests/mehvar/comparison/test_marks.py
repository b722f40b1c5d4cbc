# SPDX-License-Identifier: Apache-2.0
"""Formulas on the page: valid MathML, and exactly the parts that differ are marked."""

import xml.etree.ElementTree as ET

import pytest

from mehvar.codegen.equations.formula import Printer
from mehvar.codegen.equations.mathml import mathml
from mehvar.codegen.equations.spelling import LATEX, PAGE
from mehvar.comparison.marks import Alignment


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
    text, marked = "", []
    for term, whole in Printer(graph.nodes, spelling=PAGE, marks=marks).parts(root):
        tree = ET.fromstring(mathml(term))
        text += visible(tree)
        marked += (
            [visible(tree)] if whole else [visible(part) for part in tree.iter("mrow") if part.get("class") == "mark"]
        )
    return text, marked


def compare(old: Graph, before: int, new: Graph, after: int, **renamed: str) -> tuple[list[str], list[str]]:
    left, right = Alignment(old.nodes, new.nodes, renamed).marks(before, after)
    return shown(old, before, left)[1], shown(new, after, right)[1]


@pytest.mark.parametrize(
    ("build", "text"),
    [
        (lambda g: g("add", g.sym("a"), g("mul", g.num("-2"), g.sym("b"))), "a−2b"),
        (lambda g: g("mul", g.num("-1/2"), g.sym("m"), g("pow", g.sym("v"), g.num("2"))), "−12mv2"),
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
    assert visible(ET.fromstring(mathml(term))) == "(12x)2"


def test_names_are_escaped_and_latex_is_set():
    assert visible(ET.fromstring(mathml(LATEX.name("a<b", "")))) == "a<b"
    tree = ET.fromstring(mathml(LATEX.name("phi1_dot", r"\dot{\varphi}_1")))
    assert tree.find(".//mover") is not None
    assert "φ" in visible(tree)


def sums(*terms: tuple[int, tuple[str, ...]]) -> tuple[Graph, int]:
    """Return a sum of products of symbols with a coefficient each."""
    g = Graph()
    products = [g("mul", *([g.num(str(k))] if k != 1 else []), *map(g.sym, names)) for k, names in terms]
    return g, g("add", *products)


def test_what_stayed_is_not_marked():
    old, new = sums((1, "ab"), (2, "cd")), sums((2, "dc"), (1, "ba"))
    assert compare(*old, *new) == ([], [])


def test_a_lost_and_a_new_term_are_marked_whole():
    old, new = sums((1, "ab"), (2, "cd"), (1, "ef")), sums((1, "ab"), (1, "ef"))
    assert compare(*old, *new) == (["+2cd"], [])
    assert compare(*new, *old) == ([], ["+2cd"])


def test_a_flipped_sign_marks_the_term_and_another_symbol_only_itself():
    old = sums((1, "ab"), (2, "cd"))
    assert compare(*old, *sums((1, "ab"), (-2, "cd"))) == (["+2cd"], ["−2cd"])
    assert compare(*old, *sums((1, "ab"), (2, "cx"))) == (["d"], ["x"])


def test_a_lost_factor_is_marked_where_it_was():
    assert compare(*sums((1, "ab"), (2, "cde")), *sums((1, "ab"), (2, "cd"))) == (["e"], ["+2cd"])


def test_a_change_deep_inside_is_marked_there():
    def build(name):
        g = Graph()
        inside = g("add", g.sym("a"), g.sin(name))
        return g, g("add", g.sym("b"), g("mul", g.sym("m"), g("pow", inside, g.num("2"))))

    assert compare(*build("x"), *build("y")) == (["x"], ["y"])


def test_renamed_symbols_are_no_difference():
    assert compare(*sums((1, "ab"), (2, "cd")), *sums((1, "ab"), (2, "cz")), d="z") == ([], [])


def test_a_mark_on_a_factor_that_is_not_printed_marks_its_term():
    graph, root = sums((1, "ab"), (-1, "cd"))
    products = [[graph.nodes[factor] for factor in graph.nodes[term][1:]] for term in graph.nodes[root][1:]]
    term = next(k for k, factors in enumerate(products) if ["num", "-1"] in factors)
    assert shown(graph, root, frozenset({(term, 0)}))[1] == ["−cd"]
    assert shown(graph, root, frozenset({(term, 1)}))[1] == ["c"]
