# SPDX-License-Identifier: Apache-2.0
import base64
import json
import os
import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from types import SimpleNamespace

import pytest

from mehvar.base.errors import InputError
from mehvar.cli import reproduce as module
from mehvar.cli.reproduce import reproduce
from mehvar.pictures.style import style
from mehvar.report.board import section
from mehvar.report.board.section import Boards, OnBoard
from mehvar.report.page import typeset
from mehvar.report.papers import content
from mehvar.report.papers.backends import Agreement, FunctionAgreement
from mehvar.reproduction.beyond import Beyond, BeyondWords, load_beyond
from mehvar.reproduction.claims import Check, Claim, ClaimKind, ClaimText, ClaimVerdict, tally, tally_text
from mehvar.reproduction.deviations import deviations, table_claims
from mehvar.reproduction.paper import Reproduction, load_reproduction
from mehvar.reproduction.runs import Runs
from mehvar.reproduction.statements import PrintedCounts, Statements
from mehvar.runtime.files import filling
from mehvar.runtime.model.model import load
from tests.derived import REPRODUCED, generated, verdicts
from tests.mehvar.browser import chromium, eventually, prefer, requests, show
from tests.mehvar.pages import (
    contents,
    cut_on_paper,
    misses,
    printed_pages,
    resize,
    settled,
    unlabelled_canvases,
    violations,
)
from tests.papers.shared import LIGHT, paper_agreement, paper_claims, paper_runs, shared_runs

SHOWN = ("slosh", "triangle")
"""Papers of the report in soak; `make run` makes the whole one."""
FEW = ("triangle",)
"""Paper of the report in the suite."""
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


def read(out):
    return {path.stem: Page(path.read_text(encoding="utf-8")) for path in sorted(out.glob("*.html"))}


def written(page):
    page.parent.mkdir(exist_ok=True)
    page.write_text("", encoding="utf-8")


def first_board(runs):
    """Run one law of a model on its board; tests/runtime/board has every law."""
    laws = [*runs.model.manifest.controllers][:1]
    return Boards([section.on_board(runs.board(law)) for law in laws])


def small(monkeypatch, shown):
    """Make batches and runs on the board small, and take what the papers' tests have run: the rest is the command's."""

    def reduced(name):
        paper = load_reproduction(name)
        return replace(paper, study=replace(paper.study, runs=64))

    decided = {name: list(paper_claims(name)) for name in shown}
    monkeypatch.setattr(module, "paper_models", lambda tree: shown)
    monkeypatch.setattr(Reproduction, "claims", lambda paper, runs: decided[runs.model.manifest.model])
    monkeypatch.setattr(content, "load_reproduction", reduced)
    monkeypatch.setattr(content, "Runs", shared_runs)
    monkeypatch.setattr(content, "agreement", lambda runs: paper_agreement(runs.model.manifest.model))
    monkeypatch.setattr(content, "load_beyond", lambda name: load_beyond(name) if name == LIGHT else None)
    monkeypatch.setattr(content, "run_boards", first_board)
    monkeypatch.setattr("mehvar.reproduction.runs._MOST_SAMPLES", 120)
    without_others(monkeypatch, shown)


def without_others(monkeypatch, ledgers):
    """Leave out pages on which models run, which tests/mehvar/web has, and the ledgers of other papers."""
    monkeypatch.setattr(module, "paper_ledgers", lambda tree: [part for name in ledgers for part in verdicts(name)])
    monkeypatch.setattr(module, "export_web", lambda model, out, **_: written(out / f"{model}.html"))


@pytest.fixture(scope="module", params=[FEW, pytest.param(SHOWN, marks=pytest.mark.soak)], ids=" ".join)
def report(request, tmp_path_factory):
    out = tmp_path_factory.mktemp("reproduce") / "new" / "گزارش of today"
    steps = []
    with pytest.MonkeyPatch.context() as patch:
        small(patch, request.param)
        counts, failures = reproduce(out, lambda done, total, what="": steps.append((done, total, what)))
    return SimpleNamespace(shown=request.param, out=out, counts=counts, failures=failures, steps=steps, pages=read(out))


def test_every_claim_holds_and_progress_reaches_the_end(report):
    assert report.failures == []
    done = [step for step, *_ in report.steps]
    assert done == sorted(done)
    assert report.steps[-1][0] == report.steps[-1][1] == len(report.shown)
    said = " ".join(what for *_, what in report.steps)
    assert all(f"{name}: claims" in said for name in report.shown)
    assert "64 runs" in said


def html(report, name):
    return (report.out / f"{name}.html").read_text(encoding="utf-8")


def test_there_is_a_page_for_each_paper_and_an_overview_with_a_picture_of_each(report):
    assert sorted(report.pages) == sorted(["index", *report.shown])
    assert len(report.pages["index"].sources) == len(report.shown)


def test_pages_need_nothing_else(report):
    for name, page in report.pages.items():
        assert not page.elements & {"iframe", "object"}
        assert all(source.startswith("data:image/png;base64,") for source in page.sources)
        for link in page.links:
            if link.startswith("live/"):
                assert (report.out / link).is_file()
                continue
            file, _, anchor = link.partition("#")
            target = report.pages[file.removesuffix(".html")] if file and link != "data:," else page
            assert link == "data:," or not anchor or anchor in target.ids, link
        assert "default-src 'none'" in html(report, name)
        assert len(set(page.ids)) == len(page.ids)
        assert (report.out / f"{name}.html").stat().st_size < 3e6


def test_figures_on_the_pages_are_the_files_beside_them(report):
    files = sorted((report.out / "figures").iterdir())
    wanted = [f"{m}-{figure.number:02d}.png" for m in report.shown for figure in load_reproduction(m).figures]
    wanted += [f"{LIGHT}-beyond-{figure.number}.png" for figure in load_beyond(LIGHT).words.figure]
    assert [file.name for file in files] == sorted(wanted)
    embedded = {base64.b64decode(s.split(",")[1]) for page in report.pages.values() for s in page.sources}
    assert {file.read_bytes() for file in files} <= embedded
    assert all(data.startswith(b"\x89PNG") for data in embedded)


def test_every_series_over_time_and_every_animation_is_in_the_data(report):
    texts = {name: re.search(r'id="data">(.*?)</script>', html(report, name), re.S)[1] for name in report.shown}
    data = {name: json.loads(text) for name, text in texts.items()}
    assert all(list(data[name]["scenes"]) == [name] for name in report.shown)
    for paper, figure in (("slosh", "figure-7"), ("triangle", "figure-9"), ("slosh", "bands"), ("triangle", "bands")):
        assert paper not in report.shown or data[paper]["charts"][f"{paper}-{figure}"]["panels"]
    for name in report.shown:
        scene = data[name]["scenes"][name]
        columns = [set(run["columns"]) for run in scene["runs"].values()]
        assert all(found == columns[0] for found in columns)
        assert {line["column"] for panel in scene["panels"] for line in panel["lines"]} <= columns[0]


def test_batch_board_versions_and_times_are_said(report):
    text = "".join(page.text for page in report.pages.values())
    assert text.count("95 % interval") == len(report.shown)
    assert text.count("0 ulp, bit for bit") == len(report.shown)
    for name in report.shown:
        assert "Our text against CasADi's own C" in report.pages[name].text
    assert "jac_x" in text
    for part in ("numpy", "casadi", "made", "closed loops beside the batches", "MIT License"):
        assert part in text


def test_page_shows_all_claims_captions_and_the_model(report):
    paper, text = load_reproduction("triangle"), "".join(page.text for page in report.pages.values())
    words = " ".join(text.split())
    claims = json.loads((report.out / "claims.json").read_text(encoding="utf-8"))
    ours = [c["number"] for c in claims if c["model"] == "triangle"]
    assert ours == [*(claim.number for claim in paper.texts), "T1", "T2", "T3", "T4", "T5"]
    assert set(claims[0]) == {"model", "number", "kind", "text", "expected", "measured", "outcome", "verdict", "note"}
    for claim in claims:
        assert f"{claim['model']}-claim-{claim['number']}" in report.pages[claim["model"]].ids
        assert typeset(claim["text"]).striptags() in words
        assert typeset(claim["note"]).striptags() in words
    for verdict in ("holds", "holds in part"):
        assert verdict in text
    assert paper.captions.citation in text
    assert all(typeset(figure.caption).striptags() in words for figure in paper.figures)
    assert load("triangle").manifest.hash in text
    assert "does not settle" in text


def test_what_lies_beyond_the_papers_is_shown_and_counted_apart(report):
    beyond = json.loads((report.out / "beyond.json").read_text(encoding="utf-8"))
    page, words = report.pages[LIGHT], load_beyond(LIGHT).words
    assert {claim["model"] for claim in beyond} == {LIGHT}
    assert [claim["number"] for claim in beyond] == [text.number for text in words.claim]
    assert {claim["verdict"] for claim in beyond} == {"holds"}
    assert {f"{LIGHT}-claim-{claim['number']}" for claim in beyond} <= set(page.ids)
    assert {f"{LIGHT}-beyond-{figure.number}" for figure in words.figure} | {f"{LIGHT}-beyond"} <= set(page.ids)
    said = " ".join(page.text.split())
    assert all(typeset(text).striptags() in said for text in words.text)
    assert all(f"--structure {choice}={value}" in page.text for choice, value in words.structure.items())
    assert "operations of the rates" in page.text
    claims = json.loads((report.out / "claims.json").read_text(encoding="utf-8"))
    assert not {claim["number"] for claim in claims} & {claim["number"] for claim in beyond}


def test_the_papers_claims_are_counted_first_and_our_own_apart(report):
    claims = json.loads((report.out / "claims.json").read_text(encoding="utf-8"))
    numbers = {kind: [c for c in claims if c["kind"] == kind] for kind in ClaimKind}
    assert [c["number"] for c in numbers[ClaimKind.FINDING] if c["model"] == "triangle"] == ["9"]
    assert all(claim["number"].isdigit() for claim in numbers[ClaimKind.PAPER])
    assert not any(claim["number"].isdigit() for claim in numbers[ClaimKind.ROW])
    page = "".join(report.pages["index"].text.split())
    for (kind, several), line in zip(numbers.items(), report.counts, strict=True):
        assert line.startswith(f"{kind.of(len(several))}: ")
        assert "".join(f"{kind.of(len(several))}:".split()) in page
        for verdict in {claim["verdict"] for claim in several}:
            count = ClaimVerdict(verdict).of(sum(claim["verdict"] == verdict for claim in several))
            assert count in line
            assert "".join(count.split()) in page
    assert page.index("".join(report.counts[0].split(":")[0].split())) < page.index("".join(ClaimKind.ROW.split()))


@pytest.mark.soak
def test_the_page_of_the_report_says_how_many_claims_hold():
    runs = [paper_runs(name) for name in REPRODUCED]
    tables = [claim for of in runs for claim in table_claims(of.model.manifest, deviations(of))]
    counts = tally([*tables, *(claim for name in REPRODUCED for claim in paper_claims(name))])
    said = Path(__file__).parents[3] / "docs" / "reference" / "report.md"
    assert "\n".join(tally_text(kind, of) for kind, of in counts.items()) in said.read_text(encoding="utf-8")


def test_every_claim_stands_beside_a_figure_or_among_those_without(report):
    claims = json.loads((report.out / "claims.json").read_text(encoding="utf-8"))
    for name in report.shown:
        numbers = {claim["number"] for claim in claims if claim["model"] == name}
        named = [number for figure in load_reproduction(name).figures for number in figure.claims]
        assert set(named) <= numbers
        assert {f"{name}-claim-{number}" for number in numbers} <= set(report.pages[name].ids)


def test_page_names_no_folder_of_this_machine(report):
    for folder in (report.out, Path(module.__file__).parent, Path.home()):
        assert not [name for name in report.pages if str(folder) in html(report, name)]


@pytest.mark.parametrize("number", [2, 6, 10])
@pytest.mark.share(3)
def test_drawing_again_gives_the_same_bytes(report, number):
    runs = Runs(load("triangle"))
    with style():
        figure = load_reproduction("triangle").figures[number - 1].draw(runs)
    again = content.picture("", "", "", figure)
    assert again.png == (report.out / "figures" / f"triangle-{number:02d}.png").read_bytes()


def _only_claims(monkeypatch, claims):
    """Replace what every paper claims, and leave out what takes time."""
    triangle = load_reproduction("triangle")
    captions = replace(triangle.captions, citation="A & B", readings=())
    monkeypatch.setattr(module, "paper_models", lambda tree: SHOWN)
    nothing = Statements(PrintedCounts(0, 0, 0))
    paper = replace(
        triangle,
        captions=captions,
        figures=(),
        texts=(),
        statements=nothing,
        more_claims=claims,
    )
    monkeypatch.setattr(content, "load_reproduction", lambda name: paper)
    monkeypatch.setattr(content, "_animation", lambda *given: {"runs": {}, "panels": []})
    for name in ("run_study", "agreement"):
        monkeypatch.setattr(content, name, lambda *given: None)
    for name in ("deviations", "loop_spectra"):
        monkeypatch.setattr(content, name, lambda *given: [])
    monkeypatch.setattr(content, "run_boards", lambda runs: Boards())
    monkeypatch.setattr(content, "load_beyond", lambda name: None)
    monkeypatch.setattr(module, "load", lambda *given: None)  # CasADi's texts, which are derived
    monkeypatch.setattr(content, "structure_folders", lambda tree, models: {name: generated(name) for name in models})
    without_others(monkeypatch, ())


def test_a_claim_that_does_not_hold_is_shown_and_returned(tmp_path, monkeypatch):
    failing = Claim("1", "masses are <b>heavy</b>", (Check("m", "1e-3 kg", "-2 kg", False),), "they are light")
    _only_claims(monkeypatch, lambda runs: [failing])
    every = ", ".join(f"{name} 1" for name in SHOWN)
    assert reproduce(tmp_path)[1] == [f"claims that do not hold: {every}; see the report"]
    pages = read(tmp_path)
    for page in pages.values():
        assert "b" not in page.elements
        assert "masses are <b>heavy</b>" in page.text
        for part in ("does not hold", "1×10⁻³ kg", "−2 kg"):
            assert part in page.text
    assert "do not hold" in pages["index"].text
    assert "they are light" in pages["triangle"].text
    first = json.loads((tmp_path / "claims.json").read_text(encoding="utf-8"))[0]
    assert (first["verdict"], first["note"]) == ("does not hold", "they are light")


def test_what_fails_is_called_by_its_name(tmp_path, monkeypatch, capsys):
    _only_claims(monkeypatch, lambda runs: [])
    different = Agreement([FunctionAgreement("rhs", 500, 0.0), FunctionAgreement("jac_x", 500, 1e-9)], [])
    monkeypatch.setattr(content, "agreement", lambda runs: different)
    words = BeyondWords("", {}, (), (), (ClaimText("B1", "it is light"),))
    failing = Beyond(words, (), {"B1": lambda *given: [Check("m", "1", "2", False)]})
    monkeypatch.setattr(content, "load_beyond", lambda name: failing)
    board = OnBoard("pd", False, "")
    monkeypatch.setattr(content, "run_boards", lambda runs: Boards([board]))
    assert module.command(tmp_path) == 1
    functions, laws, claims = (", ".join(f"{name} {what}" for name in SHOWN) for what in ("jac_x", "pd", "B1"))
    assert capsys.readouterr().out.splitlines()[4:] == [
        f"claims beyond the papers that do not hold: {claims}; see the report",
        f"laws that differ between board and host: {laws}; see the report",
        f"functions that differ from CasADi's own C: {functions}; see the report",
    ]


def test_an_old_report_stays_when_a_new_one_fails(tmp_path, monkeypatch):
    def broken(runs):
        raise RuntimeError("no claims today")

    with filling(tmp_path, "mehvar reproduce") as folder:
        (folder / "index.html").write_text("old")
    _only_claims(monkeypatch, broken)
    with pytest.raises(RuntimeError, match="no claims today"):
        reproduce(tmp_path)
    assert (tmp_path / "index.html").read_text() == "old"
    assert sorted(path.name for path in tmp_path.iterdir()) == [".mehvar", "index.html"]


def test_refuses_an_output_folder_that_is_a_file(tmp_path):
    (tmp_path / "report").write_text("")
    with pytest.raises(InputError, match=r"report.*must be a folder"):
        reproduce(tmp_path / "report")


def test_refuses_a_folder_that_may_not_be_written_before_it_computes(tmp_path, monkeypatch):
    monkeypatch.setattr(os, "access", lambda path, mode: Path(path) != tmp_path)
    with pytest.raises(InputError, match=f"you may not write into {re.escape(str(tmp_path))}"):
        reproduce(tmp_path / "a" / "b")
    assert list(tmp_path.iterdir()) == []


def test_without_matplotlib_it_says_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda name, *more: None)
    with pytest.raises(InputError, match=r'pip install "mehvar\[plot\]"'):
        reproduce(tmp_path / "report")
    assert list(tmp_path.iterdir()) == []


def test_an_interrupt_leaves_nothing_behind(tmp_path, monkeypatch):
    _only_claims(monkeypatch, lambda runs: [])

    def interrupted(done, total, what=""):
        if "board" in what:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        reproduce(tmp_path / "report", interrupted)
    assert list(tmp_path.iterdir()) == []


OF_SLOSH = pytest.mark.parametrize("report", [pytest.param(SHOWN, marks=pytest.mark.soak)], indirect=True)
EACH = pytest.mark.parametrize(
    ("report", "name"),
    [*((FEW, name) for name in FEW), *(pytest.param(SHOWN, name, marks=pytest.mark.soak) for name in SHOWN)],
    indirect=["report"],
)
EVERY = pytest.mark.parametrize(
    ("report", "name"),
    [
        (FEW, "index"),
        *(pytest.param(SHOWN, name, marks=pytest.mark.soak) for name in ("index", *SHOWN)),
    ],
    indirect=["report"],
)


@pytest.fixture(scope="module")
def browser(report):
    with chromium() as found:
        yield found


@pytest.fixture
def open_page(browser, report):
    def opened(page="index", **preferences):
        prefer(browser, **{"prefers_color_scheme": "light", "prefers_reduced_motion": "no-preference", **preferences})
        browser.get_log("browser")
        requests(browser)
        browser.get((report.out / f"{page}.html").as_uri())
        return browser

    return opened


@EACH
def test_a_page_loads_without_errors_and_asks_the_network_for_nothing(open_page, report, name):
    browser = open_page(name)
    eventually(browser, "document.documentElement.dataset.ready === 'yes'")
    show(browser, f"[data-scene={name}]")
    eventually(browser, "document.querySelectorAll(`[data-scene=${arguments[0]}] .uplot`).length === 3", name)
    assert browser.execute_script(
        "return [...document.images].every((image) => !image.complete || image.naturalWidth > 0)"
    )
    assert requests(browser) == [(report.out / f"{name}.html").as_uri()]
    assert [entry["message"] for entry in browser.get_log("browser")] == []


@pytest.mark.parametrize(
    ("width", "part"),
    [
        (390, slice(0, None, 6)),
        *(pytest.param(width, slice(None), marks=pytest.mark.soak) for width in (1440, 390)),
    ],
)
@EVERY
def test_links_land_after_charts_are_built(browser, report, name, width, part):
    """Every sixth link and the last claim's: a link needs a page of its own, seconds of a processor."""
    resize(browser, width)
    try:
        page = report.out / f"{name}.html"
        browser.get(page.as_uri())
        settled(browser)
        last = (
            [f"{name}-claim-{claim.number}" for claim in load_reproduction(name).texts[-1:]] if name != "index" else []
        )
        assert misses(browser, page, [*contents(browser)[part], *last]) == {}
    finally:
        browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


@EVERY
def test_a_page_can_be_read_aloud_and_printed(open_page, name):
    browser = open_page(name, prefers_reduced_motion="reduce")
    settled(browser)
    assert printed_pages(browser) < 30
    assert cut_on_paper(browser) == []
    browser.execute_script("document.querySelectorAll('details').forEach((part) => { part.open = true })")
    assert violations(browser) == []
    assert unlabelled_canvases(browser)[0] == 0


def test_the_first_screen_of_the_overview_has_a_picture(open_page):
    browser = open_page()
    boxes = browser.execute_script(
        "return [...document.images].map((image) => [image, image.closest('.card')].map((part) => {"
        "const {left, right, top} = part.getBoundingClientRect(); return [left, right, top] }))"
    )
    for (left, right, top), (card_left, card_right, _) in boxes:
        assert card_left <= left < right <= card_right
        assert 0 < top < browser.execute_script("return innerHeight")


@EACH
def test_an_animation_plays_pauses_and_scrubs_with_mouse_and_keys(open_page, name):
    from selenium.webdriver.common.keys import Keys

    browser = open_page(name)
    show(browser, f"[data-scene={name}]")
    part = {p: browser.find_element("css selector", f"[data-scene={name}] [data-part={p}]") for p in ("canvas", "play")}
    time_now = f"Report.players.{name}.time"
    eventually(browser, f"{time_now} > 0")
    part["play"].click()
    stopped = browser.execute_script(f"return {time_now}")
    pixels = f"Report.players.{name}.canvas.toDataURL()"
    before = browser.execute_script(f"return {pixels}")
    assert part["play"].get_attribute("aria-label") == "Play"
    part["canvas"].send_keys(Keys.ARROW_RIGHT)
    moved = browser.execute_script(f"return {time_now}")
    assert moved > stopped
    assert browser.execute_script(f"return {pixels}") != before
    scrub = f"document.querySelector('[data-scene={name}] [data-part=scrub]')"
    browser.execute_script(f"{scrub}.value = 12.5; {scrub}.dispatchEvent(new Event('input'))")
    assert browser.execute_script(f"return {time_now}") == 12.5
    part["canvas"].send_keys(Keys.SPACE)
    eventually(browser, f"{time_now} > 12.5")


@OF_SLOSH
def test_the_animation_shows_both_laws_and_turns(open_page):
    from selenium.webdriver.common.keys import Keys
    from selenium.webdriver.support.select import Select

    browser = open_page("slosh", prefers_reduced_motion="reduce")
    show(browser, "[data-scene=slosh]")
    stage = browser.find_element("css selector", "[data-scene=slosh]")
    canvas = stage.find_element("css selector", "[data-part=canvas]")
    eventually(browser, "document.querySelectorAll('[data-scene=slosh] .uplot').length === 3")
    frames = {browser.execute_script("return Report.players.slosh.canvas.toDataURL()")}
    browser.execute_script("Report.players.slosh.go(5)")
    for part, choice in (("run", "V2, full model"), ("compare", "V1, full model")):
        Select(stage.find_element("css selector", f"[data-part={part}]")).select_by_visible_text(choice)
        frames.add(browser.execute_script("return Report.players.slosh.canvas.toDataURL()"))
    canvas.send_keys(Keys.SHIFT, Keys.ARROW_UP)
    frames.add(browser.execute_script("return Report.players.slosh.canvas.toDataURL()"))
    assert len(frames) == 4
    assert "beside" in stage.find_element("css selector", ".u-legend").text


def test_reduced_motion_waits_for_the_reader(open_page):
    browser = open_page("triangle", prefers_reduced_motion="reduce")
    show(browser, "[data-scene=triangle]")
    eventually(browser, "document.querySelectorAll('[data-scene=triangle] .uplot').length === 3")
    assert browser.execute_script("return [Report.players.triangle.playing, Report.players.triangle.time]") == [
        False,
        0,
    ]


@OF_SLOSH
def test_charts_show_values_zoom_and_hide_laws(open_page):
    from selenium.webdriver.common.action_chains import ActionChains

    browser = open_page("slosh")
    show(browser, "#slosh-figure-7")
    eventually(browser, "document.querySelectorAll('#slosh-figure-7 .uplot').length === 4")
    figure = browser.find_element("css selector", "#slosh-figure-7")
    over, *_ = figure.find_elements("css selector", ".u-over")
    ActionChains(browser).move_to_element(over).perform()
    value = figure.find_elements("css selector", ".u-legend .u-series")[1].text
    assert re.search(r"V1\s*−?\d", value)
    before = figure.find_element("css selector", ".uplot canvas").screenshot_as_base64
    ActionChains(browser).move_to_element(over).click_and_hold().move_by_offset(60, 0).release().perform()
    assert figure.find_element("css selector", ".uplot canvas").screenshot_as_base64 != before
    chip = next(b for b in figure.find_elements("css selector", ".chip") if b.text == "V2")
    chip.click()
    assert chip.get_attribute("aria-pressed") == "false"
    hidden = figure.find_elements("css selector", ".u-legend .u-series.u-off .u-label")
    assert [name.text for name in hidden] == ["V2", "V2"]


@OF_SLOSH
def test_static_pictures_can_be_had_and_claims_filtered(open_page):
    from selenium.webdriver.support.select import Select

    browser = open_page("slosh")
    figure = browser.find_element("css selector", "#slosh-figure-7")
    swap = figure.find_element("css selector", "[data-part=swap]")
    browser.execute_script("arguments[0].scrollIntoView({behavior: 'instant', block: 'center'})", swap)
    swap.click()
    assert figure.find_element("css selector", ".picture").is_displayed()
    open_page()
    rows = "[...document.querySelectorAll('tr[data-paper]')].filter((row) => !row.hidden).length"
    everything = browser.execute_script(f"return {rows}")
    Select(browser.find_element("css selector", "[data-filter]")).select_by_visible_text("slosh")
    assert 0 < browser.execute_script(f"return {rows}") < everything
    assert (
        browser.find_element("id", "shown").text
        == "13 claims of the papers, 1 finding of our own, 8 rows of our own against an independent program"
    )
    assert browser.current_url.endswith("#claims?paper=slosh")
    browser.refresh()
    assert 0 < browser.execute_script(f"return {rows}") < everything


def test_a_narrow_window_needs_no_sideways_scrolling_and_dark_is_dark(open_page):
    browser = open_page("triangle", prefers_color_scheme="dark")
    metrics = {"width": 320, "height": 640, "deviceScaleFactor": 1, "mobile": True}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    try:
        assert eventually(browser, "document.documentElement.scrollWidth") <= 320
        browser.execute_script("document.querySelectorAll('details').forEach((part) => { part.open = true })")
        assert eventually(browser, "document.documentElement.scrollWidth") <= 320
        drawing = "document.querySelector('#triangle-figure-1 img')"
        inches = browser.execute_script(f"return {drawing}.getAttribute('width') / 150")
        assert browser.execute_script(f"return {drawing}.clientWidth <= {drawing}.parentElement.clientWidth")
        browser.find_element("css selector", "#triangle-figure-1 [data-part=enlarge]").click()
        assert browser.execute_script(f"return {drawing}.clientWidth") >= 75 * inches - 1
        assert browser.execute_script(f"return {drawing}.parentElement.clientWidth") < 320
        assert browser.execute_script("return getComputedStyle(document.body).backgroundColor") == "rgb(19, 22, 26)"
    finally:
        browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


@OF_SLOSH
def test_paper_and_browsers_without_scripts_get_the_pictures(open_page, report):
    def shown(browser):
        picture, stage = "#slosh-figure-7 .picture", "[data-scene=slosh]"
        return [browser.find_element("css selector", selector).is_displayed() for selector in (picture, stage)]

    browser = open_page("slosh")
    assert shown(browser) == [False, True]
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
    assert shown(browser) == [True, True]
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})
    browser.execute_cdp_cmd("Emulation.setScriptExecutionDisabled", {"value": True})
    try:
        browser.get((report.out / "slosh.html").as_uri())
        assert shown(browser) == [True, False]
    finally:
        browser.execute_cdp_cmd("Emulation.setScriptExecutionDisabled", {"value": False})
