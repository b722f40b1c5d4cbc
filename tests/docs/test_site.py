# SPDX-License-Identifier: Apache-2.0
"""The site: built without a warning, whole, and read without a network."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import mehvar
from tests.docs.formulas import MATH, faults
from tests.mehvar.browser import chromium

pytestmark = pytest.mark.soak  # .ci/run builds the site too

ROOT = Path(__file__).parents[2]
LOADS = re.compile(r'<(?:script|link|img|iframe|source)\b[^>]*?\b(?:src|href)="([^"]+)"')
CUT = """
const scrolls = (element) => {
  for (; element !== document.body; element = element.parentElement) {
    if (/auto|scroll/.test(getComputedStyle(element).overflowX)) return true;
  }
  return false;
};
document.querySelectorAll("details").forEach((details) => { details.open = true; });
const faults = document.documentElement.scrollWidth > innerWidth ? ["the page is wider than the screen"] : [];
document.querySelectorAll("main math, article math").forEach((math, number) => {
  const box = math.getBoundingClientRect(), host = math.closest(".formula");
  if (!box.width || !box.height) faults.push([number, "is not drawn"]);
  if (host && host.scrollHeight > host.clientHeight + 1) faults.push([number, "is cut", math.textContent]);
  if ((box.right > innerWidth || box.left < 0) && !scrolls(math)) faults.push([number, "is beyond", math.textContent]);
});
return faults.slice(0, 5);
"""


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("site")
    build = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--quiet", "--strict", "--site-dir", str(folder)],
        cwd=ROOT,
        env={**os.environ, "NO_MKDOCS_2_WARNING": "1", "PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    assert build.returncode == 0, build.stdout
    return folder


def test_the_search_finds_pages_before_source_files(site: Path) -> None:
    entries = json.loads((site / "search" / "search_index.json").read_text(encoding="utf-8"))["docs"]
    weights = {entry["location"]: entry.get("boost", 1) for entry in entries}
    assert {weight for place, weight in weights.items() if place.startswith("repo/")} == {0.1}
    assert {weight for place, weight in weights.items() if not place.startswith("repo/")} == {1}
    about = [entry["location"] for entry in entries if "monte carlo" in entry["text"].lower()]
    assert any(place.startswith("tutorials/batch") for place in about)
    titled = [entry["location"] for entry in entries if "monte carlo" in entry["title"].lower()]
    assert titled == ["tutorials/batch.html"]  # the search weighs titles most


def test_no_page_loads_anything_from_elsewhere(site: Path) -> None:
    pages = list(site.rglob("*.html"))
    assert len(pages) > 40
    for path in pages:
        for target in LOADS.findall(path.read_text(encoding="utf-8")):
            assert not re.match(r"([a-z]+:)?//", target), f"{path.relative_to(site)} loads {target}"
            if not target.startswith("data:"):
                assert (path.parent / target.partition("#")[0].partition("?")[0]).exists() or path.name == "404.html"
    for style in site.rglob("*.css"):
        assert not re.search(r"url\(\s*['\"]?(https?:)?//", style.read_text(encoding="utf-8")), style


def test_formulas_are_drawn_without_a_script(site: Path) -> None:
    sphere = (site / "explanation" / "shape-sphere.html").read_text(encoding="utf-8")
    assert sphere.count("<math") == (ROOT / "docs" / "explanation" / "shape-sphere.md").read_text().count("```math")
    triangle = (site / "repo" / "generated" / "triangle" / "equations.html").read_text(encoding="utf-8")
    assert triangle.count("<math") > 150
    for path in site.rglob("*.html"):
        text = path.read_text(encoding="utf-8")
        assert "\ue000" not in text, f"{path} lost a formula"
        assert "$<code>" not in text, f"{path} shows TeX"


def test_every_formula_is_whole(site: Path) -> None:
    pages = {path: MATH.findall(path.read_text(encoding="utf-8")) for path in site.rglob("*.html")}
    assert sum(map(len, pages.values())) > 2000
    for path, formulas in pages.items():
        for formula in formulas:
            assert not list(faults(formula)), f"{path.relative_to(site)}: {formula[:500]}"


def test_no_formula_is_cut_on_a_phone(site: Path, tmp_path: Path) -> None:
    """At 390 px: each is drawn, none leaves its box upright, none leaves the page unless it scrolls."""
    pages = [path for path in site.rglob("*.html") if "<math" in path.read_text(encoding="utf-8")]
    assert len(pages) > 5
    with chromium() as browser:
        screen = {"width": 390, "height": 844, "deviceScaleFactor": 1, "mobile": False}
        browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", screen)
        for path in pages:
            browser.get(path.as_uri())
            assert browser.execute_script("return innerWidth") == 390
            assert browser.execute_script(CUT) == [], path.relative_to(site)


def test_the_reference_has_every_public_name(site: Path) -> None:
    page = (site / "reference" / "python.html").read_text(encoding="utf-8")
    missing = [name for name in mehvar.__all__ if f'id="mehvar.{name}"' not in page]
    assert not missing
