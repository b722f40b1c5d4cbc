# SPDX-License-Identifier: Apache-2.0
import base64
import json
import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from types import SimpleNamespace

import pytest

from mehvar import reproduce as module
from mehvar.papers import Check, Claim, Runs, Verdict, load_paper, paper_models
from mehvar.plots import save, style
from mehvar.reproduce import reproduce
from runtime.errors import InputError
from runtime.model import load

VOID = {"meta", "link", "img", "br", "hr", "input", "col"}


class Page(HTMLParser):
    """Collects text, links and images, and fails on elements that are not nested."""

    def __init__(self, text):
        super().__init__()
        self.open, self.sources, self.links, self.elements, self.ids = [], [], [], set(), []
        self.text = ""
        self.feed(text)
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        found = dict(attrs)
        self.elements.add(tag)
        if tag not in VOID:
            self.open.append(tag)
        if "src" in found:
            self.sources.append(found["src"])
        if "href" in found:
            self.links.append(found["href"])
        if "id" in found:
            self.ids.append(found["id"])

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text += data


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    out = tmp_path_factory.mktemp("reproduce") / "new" / "report"
    steps = []
    holds = reproduce(out, lambda done, total: steps.append((done, total)))
    html = (out / "index.html").read_text(encoding="utf-8")
    return SimpleNamespace(out=out, holds=holds, steps=steps, html=html, page=Page(html))


def test_every_claim_holds_and_progress_reaches_the_end(report):
    assert report.holds is True
    done = [step for step, _ in report.steps]
    assert done == sorted(done)
    assert report.steps[-1][0] == report.steps[-1][1] == len(paper_models())


def test_page_needs_nothing_else(report):
    page = report.page
    assert not page.elements & {"script", "link", "iframe", "object"}
    assert all(source.startswith("data:image/png;base64,") for source in page.sources)
    assert all(link.startswith("#") and link[1:] in page.ids for link in page.links)
    assert not re.search(r"@import|url\(|https?:", report.html)
    assert len(set(page.ids)) == len(page.ids)
    assert "prefers-color-scheme: dark" in report.html


def test_figures_on_the_page_are_the_files_beside_it(report):
    files = sorted((report.out / "figures").iterdir())
    wanted = [f"{m}-{figure.number:02d}.png" for m in paper_models() for figure in load_paper(m).figures()]
    assert [file.name for file in files] == sorted(wanted)
    embedded = [base64.b64decode(source.split(",")[1]) for source in report.page.sources]
    assert sorted(embedded) == sorted(file.read_bytes() for file in files)
    assert all(data.startswith(b"\x89PNG") for data in embedded)


def test_page_shows_all_claims_captions_and_the_model(report):
    paper, text = load_paper("triangle"), report.page.text
    claims = json.loads((report.out / "claims.json").read_text(encoding="utf-8"))
    ours = [c["number"] for c in claims if c["model"] == "triangle"]
    assert ours == [*map(str, range(1, 10)), "T1", "T2", "T3", "T4", "T5"]
    assert set(claims[0]) == {"model", "number", "text", "expected", "measured", "verdict", "note"}
    for claim in claims:
        assert f"{claim['model']}-claim-{claim['number']}" in report.page.ids
        assert claim["text"] in text
        assert module._typeset(claim["note"]) in text
    for verdict in ("holds", "holds with a note"):
        assert verdict in text
    assert paper.CITATION in text
    assert all(figure.caption in text for figure in paper.figures())
    assert load("triangle").manifest.hash in text
    assert "does not settle" in text


def test_page_names_no_folder_of_this_machine(report):
    for folder in (report.out, Path(module.__file__).parent, Path.home()):
        assert str(folder) not in report.html


@pytest.mark.parametrize("number", [2, 6, 10])
def test_drawing_again_gives_the_same_bytes(report, tmp_path, number):
    runs = Runs(load("triangle"))
    with style():
        save(load_paper("triangle").figures()[number - 1].draw(runs), tmp_path / "again.png")
    assert (tmp_path / "again.png").read_bytes() == (report.out / "figures" / f"triangle-{number:02d}.png").read_bytes()


def _paper(claims):
    return SimpleNamespace(CITATION="A & B", READINGS=(), figures=list, claims=claims)


def test_a_claim_that_does_not_hold_is_shown_and_returned(tmp_path, monkeypatch):
    failing = Claim("1", "masses are <b>heavy</b>", (Check("m", "1e-3 kg", "-2 kg", False),), "they are light")
    monkeypatch.setattr(module, "load_paper", lambda name: _paper(lambda runs: [failing]))
    assert reproduce(tmp_path) is False
    page = Page((tmp_path / "index.html").read_text(encoding="utf-8"))
    assert "b" not in page.elements
    assert "masses are <b>heavy</b>" in page.text
    for part in ("does not hold", "they are light", "1×10⁻³ kg", "−2 kg", "do not hold"):
        assert part in page.text
    first = json.loads((tmp_path / "claims.json").read_text(encoding="utf-8"))[0]
    assert (first["verdict"], first["note"]) == ("does not hold", "they are light")


def test_a_documented_refutation_does_not_fail_but_its_opposite_does():
    check = Check("m", "1 kg", "2 kg", False)
    assert Claim("1", "", (check,), "", refuted=True).verdict is Verdict.REFUTED
    assert Claim("1", "", (check,)).verdict is Verdict.FAILS
    assert Claim("1", "", (replace(check, holds=True),), "", refuted=True).verdict is Verdict.FAILS


def test_an_old_report_stays_when_a_new_one_fails(tmp_path, monkeypatch):
    def broken(runs):
        raise RuntimeError("no claims today")

    (tmp_path / "index.html").write_text("old")
    monkeypatch.setattr(module, "load_paper", lambda name: _paper(broken))
    with pytest.raises(RuntimeError, match="no claims today"):
        reproduce(tmp_path)
    assert (tmp_path / "index.html").read_text() == "old"


def test_refuses_an_output_folder_that_is_a_file(tmp_path):
    (tmp_path / "report").write_text("")
    with pytest.raises(InputError, match=r"report.*must be a folder"):
        reproduce(tmp_path / "report")


@pytest.mark.parametrize(
    ("plain", "pretty"),
    [
        ("2.7e-10 rad", "2.7×10⁻¹⁰ rad"),
        ("from -1 to -0.5", "from −1 to −0.5"),
        ("paper-b, 5-6, l-1", "paper-b, 5-6, l-1"),
        ("R + 9e-11", "R + 9×10⁻¹¹"),
    ],
)
def test_numbers_are_set_with_minus_signs_and_powers(plain, pretty):
    assert module._typeset(plain) == pretty
