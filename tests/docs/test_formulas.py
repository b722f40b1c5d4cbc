# SPDX-License-Identifier: Apache-2.0
"""Every formula of every page and of every derived equation, drawn: well-formed, whole, and no LaTeX that shows."""

from __future__ import annotations

from pathlib import Path

import pytest

from docs.site.hooks import FENCED, INLINE
from mehvar.codegen.equations.document import Document
from mehvar.codegen.equations.formula import Printer, SymbolNames
from mehvar.codegen.equations.mathml import element, mathml
from mehvar.codegen.equations.spelling import LATEX, PAGE
from tests.docs.formulas import faults

ROOT = Path(__file__).parents[2]
FOLDERS = ("docs", "generated", "benchmarks")
PAGES = sorted((*ROOT.glob("*.md"), *(path for folder in FOLDERS for path in (ROOT / folder).rglob("*.md"))))
MODELS = sorted(path.parent for path in (ROOT / "generated").glob("*/equations.json"))


def formulas(text: str) -> list[str]:
    """Return the TeX of a page."""
    blocks = [match[3] for match in FENCED.finditer(text) if match[2] == "math"]
    return blocks + [match[1] for match in INLINE.finditer(FENCED.sub("", text))]


@pytest.mark.parametrize("page", PAGES, ids=lambda path: str(path.relative_to(ROOT)))
def test_every_formula_of_a_page_is_drawn(page: Path) -> None:
    for tex in formulas(page.read_text(encoding="utf-8")):
        assert not list(faults(mathml(tex))), tex


def test_there_are_formulas_of_every_kind() -> None:
    texts = [tex for page in PAGES for tex in formulas(page.read_text(encoding="utf-8"))]
    assert len(texts) > 2000
    for kind in (r"\begin{aligned}", r"\begin{cases}", r"\begin{pmatrix}", r"\frac", r"\hat"):
        assert any(kind in tex for tex in texts), kind


@pytest.mark.parametrize("folder", MODELS, ids=lambda path: path.name)
@pytest.mark.share(3)
def test_every_derived_equation_is_drawn(folder: Path) -> None:
    """On one line, term by term, and in broken lines."""
    document = Document.read(folder)
    names = SymbolNames(document.latex)
    page, lines = Printer(document.nodes, names, PAGE), Printer(document.nodes, names, LATEX, line=88)
    for row in document.rows:
        for tex in (page.text(row.node), *page.terms(row.node), lines.text(row.node)):
            assert not list(faults(mathml(tex))), row.name


@pytest.mark.parametrize(
    ("math", "fault"),
    [
        ("<mi>&amp;</mi>", "LaTeX shows: '&'"),
        ("<mi>&</mi>", "not well-formed"),
        ("<mi>\\alpha</mi>", "LaTeX shows"),
        ('<mi>a</mi><mspace linebreak="newline" />', "a line that ends outside of a table"),
        ("<mo>(</mo><mi>a</mi>", "1 ( and 0 )"),
        ("<mfrac><mi>a</mi></mfrac>", "<mfrac> of 1 parts"),
        ("<mrow>a</mrow>", "text outside of tokens"),
        ("<mtable><mtr><mtd/></mtr><mtr><mtd/><mtd/></mtr></mtable>", "rows of different length"),
    ],
)
def test_what_is_wrong_is_seen(math: str, fault: str) -> None:
    assert any(text.startswith(fault) for text in faults(element(math)))


def test_aligned_lines_become_a_table() -> None:
    inner = r"\left(\begin{aligned} c& \\ & d\end{aligned}\right)"
    table = mathml(rf"\begin{{aligned}} a& = b \\ & \quad + {inner} \end{{aligned}}")
    assert table.count("<mtable") == 2
    assert table.count("<mtr") == 4
    assert not list(faults(table))
