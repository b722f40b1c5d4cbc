# SPDX-License-Identifier: Apache-2.0
"""Formulas of pages in a font of their own, in a browser."""

import base64
import builtins
import io
import re
from pathlib import Path

import jinja2
import pytest
from fontTools.ttLib import TTFont

from mehvar import html
from mehvar.html import page, quantities, typeset
from tests.mehvar.browser import chromium

ROOT = Path(__file__).parents[2]
MODELS = ("triangle", "slosh", "satellite")
WHOLE = '@font-face { font-family: Formulas; src: url(data:font/woff;base64,%s) format("woff"); }'
WIDTHS = """
return [...document.querySelectorAll("math, math *")].map((part) => {
  return [`${part.tagName} ${part.children.length ? "" : part.textContent}`, part.getBoundingClientRect().width];
});
"""
FORMULA = r"\Omega_3 + \left(\frac{h}{\sqrt{x^2}}\right)"


def styled(body):
    """Return a page as the templates make it: the style's place is filled."""
    return f"<!doctype html><style>{html._formula_font(body)} math {{ font-family: Formulas }}</style>{body}"


def test_a_page_embeds_the_signs_of_its_formulas_and_no_others():
    font = html._formula_font(f"<p>words</p>{typeset(FORMULA)}")
    data = base64.b64decode(re.search(r"base64,([^)]+)\)", font)[1])
    signs = set(map(chr, TTFont(io.BytesIO(data)).getBestCmap()))
    assert {"Ω", "𝛺", "3", "+", "(", "ℎ", "𝑥", "√"} <= signs
    assert not {"w", "∑"} & signs
    assert html._formula_font("<p>words</p>") == ""


def test_without_font_tools_the_whole_font_is_embedded(monkeypatch):
    imported = builtins.__import__

    def missing(name, *rest):
        if name.startswith("fontTools"):
            raise ImportError(name)
        return imported(name, *rest)

    monkeypatch.setattr(builtins, "__import__", missing)
    assert html._font.__wrapped__(frozenset("x")) == html._FONT.read_bytes()


def test_a_template_is_compiled_once_for_the_filters_of_a_page(tmp_path, monkeypatch):
    (tmp_path / "page.j2").write_text("{{ 'x' | mark }}", encoding="utf-8")
    monkeypatch.setattr(html, "_TEMPLATES", tmp_path)
    plain, compiled = jinja2.Environment.compile, []
    monkeypatch.setattr(jinja2.Environment, "compile", lambda *given: compiled.append(given[2]) or plain(*given))
    assert [html.page("page.j2", {"mark": mark}) for mark in (str.upper, len, len)] == ["X", "1", "1"]
    assert compiled == ["page.j2", "page.j2"]


@pytest.mark.parametrize("latex", [r"\Omega_3", "h_i"])
@pytest.mark.share(2)
@pytest.mark.soak
def test_a_subscript_is_lowered(latex, tmp_path):
    (tmp_path / "page.html").write_text(styled(str(typeset(latex))), encoding="utf-8")
    with chromium() as browser:
        browser.get((tmp_path / "page.html").as_uri())
        browser.execute_async_script("document.fonts.ready.then(arguments[0])")
        base, below = (
            browser.execute_script(
                f"const box = document.querySelector('msub').children[{k}].getBoundingClientRect();"
                "return (box.top + box.bottom) / 2"
            )
            for k in (0, 1)
        )
    assert below > base + 2


SIGNS = (
    FORMULA,
    r"\sqrt[3]{x} + \sqrt{3} \left|\frac{a}{b}\right| \ge -1",
    r"\begin{bmatrix} \mathbf{R} & \dot{q} \\ \tilde\rho & \zeta_1' \end{bmatrix} \boldsymbol{\omega} \times \vec r",
    r"\begin{cases} \sum_i m_i & x < 0 \\ \lfloor \hat y \rfloor & \text{otherwise} \end{cases}",
    r"\max\left(-1, \bar{\vartheta}\right) \to \infty \pm \mathrm{atan2}\left(\ddot u, \mathcal{L}\right)",
)


@pytest.mark.soak
@pytest.mark.parametrize("formulas", [SIGNS, *MODELS])
def test_the_reduced_font_draws_formulas_as_the_whole_font_does(formulas, tmp_path):
    """Every element of every formula has the same width; a reduced font rounds heights otherwise."""
    if isinstance(formulas, str):
        text = (ROOT / "generated" / formulas / "equations.md").read_text(encoding="utf-8")
        formulas = re.findall(r"```math\n(.*?)\n```", text, re.DOTALL)
    body = "".join(f"<p>{typeset(latex)}</p>" for latex in formulas)
    whole = base64.b64encode(html._FONT.read_bytes()).decode()
    styles = {"reduced": html._formula_font(body), "whole": WHOLE % whole}
    widths = {}
    with chromium() as browser:
        for name, style in styles.items():
            page = f"<!doctype html><style>{style} math {{ font-family: Formulas }}</style>{body}"
            (tmp_path / f"{name}.html").write_text(page, encoding="utf-8")
            browser.get((tmp_path / f"{name}.html").as_uri())
            browser.execute_async_script("document.fonts.ready.then(arguments[0])")
            widths[name] = browser.execute_script(WIDTHS)
    assert len(widths["whole"]) > 50
    assert {one[0] for one, other in zip(widths["reduced"], widths["whole"], strict=True) if one != other} == set()


@pytest.mark.parametrize(
    ("plain", "pretty"),
    [
        ("5.23e-08 at most", "5.23×10⁻⁸ at most"),
        ("run 7, final(theta) = -7.96028e-06", "run 7, final(theta) = −7.96028×10⁻⁶"),
        ("0x12e45678 after 40960 samples", "0x12e45678 after 40\u202f960 samples"),
        ("40960 of 40960 runs, > 1e6", "40\u202f960 of 40\u202f960 runs, &gt; 1×10⁶"),
        (1e-05, "1×10⁻⁵"),
        ("0.0e+00 and -0.00e+00 of 1.0e+00", "0 and 0 of 1.0×10⁰"),
    ],
)
def test_quantities_are_set_and_names_and_checksums_are_not(plain, pretty):
    assert quantities(plain) == pretty


def test_the_page_of_requirements_has_one_style_of_numbers():
    requirement = {"name": "small", "text": "peak < 1e-5", "units": "peak in m", "number": "peak"}
    worst = [("run 1, peak = 3e-06", "")]
    row = (requirement, "holds", "holds", "between 2e-06 and 1", worst)
    text = page("requirements.html.j2", title="runs", wrong="1e-06", rows=[row])
    assert all(f"{figure}×10⁻⁶" in text for figure in (1, 2, 3))
    assert "<code>peak &lt; 1e-5</code>" in text  # what is typed stays


@pytest.mark.parametrize(("number", "heading"), [("peak", "Worst runs"), (None, "First runs that fail")])
def test_runs_are_the_worst_only_where_a_number_orders_them(number, heading):
    requirement = {"name": "small", "text": "", "units": "", "number": number}
    row = (requirement, "holds", "holds", "", [("run 1", "")])
    assert re.findall("<h3>(.*)</h3>", page("requirements.html.j2", title="", wrong="1", rows=[row])) == [heading]
