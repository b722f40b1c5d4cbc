# SPDX-License-Identifier: Apache-2.0
"""The pages keep their word: their Python and their commands run, say what the pages show, and links lead somewhere.

What a page may say to this test, in a comment on the line before a block:
`<!-- not run: reason -->`, `<!-- exit: 2 -->` for a block that ends with that status, `<!-- file: NAME -->` for a block
that is written to a file, `<!-- needs: PACKAGE, PACKAGE -->` for one that runs only where these are installed, as
`make peers` does. `<!-- long -->`, or `<!-- long, exit: 2 -->`, for a block that only soak runs: it takes many seconds.
`<!-- in a copy of the checkout -->` gives a page models/, generated/ and docs/examples/ in a git repository.
A `text` block after a Python block, and the lines without `$ ` in a `console` block, are looked for in the output;
`...` stands for anything. The pictures that a page shows and draws are compared with what it draws now.
"""

from __future__ import annotations

import contextlib
import dataclasses
import functools
import importlib.util
import io
import os
import re
import runpy
import shlex
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from matplotlib import pyplot
from PIL import Image

from docs.site import options, pictures
from tests import commands
from tests.mehvar.pages import share_apart
from tests.mutants import page as mutants
from tests.mutants.records import RESULTS, read, sample_file
from tests.validation import __main__ as validation
from tests.validation.table import Row

ROOT = Path(__file__).parents[2]
PAGES = sorted(
    [
        *(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md")),
        *(ROOT / "docs").rglob("*.md"),
        *(ROOT / "benchmarks").glob("*.md"),
    ]
)
SHELLS = ("console", "bash")
LONG = "<!-- long"


@dataclass(frozen=True)
class Block:
    """A fenced block: its language, its lines, the line it starts on, and what the comment before it says."""

    language: str
    lines: tuple[str, ...]
    start: int
    marker: str


def blocks(text: str) -> Iterator[Block]:
    """Find the fenced blocks of a page."""
    found: list[str] | None = None
    fence = language = marker = ""
    start = 0
    for number, line in enumerate(text.splitlines(), 1):
        opening = re.match(r"^(`{3,})(\w*)\s*$", line)
        if found is not None and line.rstrip() == fence:
            yield Block(language, tuple(found), start, marker)
            found, marker = None, ""
        elif found is not None:
            found.append(line)
        elif opening:
            fence, language = opening.groups()
            found, start = [], number
        elif line.strip():
            marker = line.strip()
    assert found is None, f"the block that starts on line {start} has no end"


def said(block: Block, what: str) -> str:
    """Return the value of `what` in the comment before a block, or nothing."""
    match = re.match(rf"^<!-- (?:long, )?{what}: (.+) -->$", block.marker)
    return match.group(1) if match else ""


def test_blocks_are_found_with_their_markers() -> None:
    page = "text\n<!-- exit: 2 -->\n\n```console\n$ false\n```\nmore\n```python\nx = 1\n```\n"
    first, second = blocks(page)
    assert (first.language, first.lines, first.start, said(first, "exit")) == ("console", ("$ false",), 4, "2")
    assert (second.language, second.lines, said(second, "exit")) == ("python", ("x = 1",), "")


def _name(page: Path) -> str:
    return str(page.relative_to(ROOT))


SLOW = (
    *("parts.md", "diff.md", "estimators.md", "own-law.md", "own-system.md", "board.md", "fmi.md", "batch.md"),
    *("generated-c.md", "satellite.md", "slosh.md", "slew.md", "physics-gates.md", "python.md", "fit-and-tune.md"),
    *("numerics.md", "triangle.md"),
)
"""Pages that derive, compile or run for two seconds or more what tests of the same commands have in small."""


def _takes_seconds(page: Path) -> bool:
    """Tell these, and the pages of the systems beyond the papers, whose claims `make run` decides."""
    return page.name.startswith("beyond-") or page.name in SLOW


@pytest.mark.page
@pytest.mark.parametrize(
    "page",
    [pytest.param(page, id=_name(page), marks=pytest.mark.soak if _takes_seconds(page) else ()) for page in PAGES],
)
def test_what_a_page_shows_runs(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run_page(page, tmp_path, monkeypatch)


@pytest.mark.soak
@pytest.mark.parametrize("page", [page for page in PAGES if LONG in page.read_text(encoding="utf-8")], ids=_name)
def test_a_page_with_long_commands_runs_whole(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run_page(page, tmp_path, monkeypatch, whole=True)


def run_page(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, whole: bool = False) -> None:
    """Run the blocks of a page in their order, those that take long only if it is to be whole."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "agg")
    monkeypatch.delenv("PYTEST_ADDOPTS", raising=False)  # it is meant for this run, not for those of a page
    pyplot.close("all")  # a page begins without the figures of the page before it in this process
    monkeypatch.setattr(sys, "path", [*sys.path])
    names: dict[str, Any] = {"__name__": "__main__"}
    output, text = "", page.read_text(encoding="utf-8")
    if "<!-- in a copy of the checkout -->\n" in text:
        copy_checkout(tmp_path)
    for block in blocks(text):
        where = f"{page.relative_to(ROOT)}:{block.start}"
        if said(block, "not run") or missing(block) or (block.marker.startswith(LONG) and not whole):
            output = ""
        elif name := said(block, "file"):
            (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / name).write_text("\n".join(block.lines) + "\n", encoding="utf-8")
        elif block.language == "python":
            output = run_python(block, page, names)
        elif block.language in SHELLS:
            output = run_shell(block, where, tmp_path)
        elif block.language == "text" and output:
            expect(block.lines, output, where)
    check_pictures(page, tmp_path)


def missing(block: Block) -> list[str]:
    """Return the packages that a block needs and that are not there."""
    return [name for name in filter(None, said(block, "needs").split(", ")) if importlib.util.find_spec(name) is None]


@pytest.mark.peers
@pytest.mark.parametrize(
    "page",
    [page for page in PAGES if "<!-- needs: " in page.read_text(encoding="utf-8")],
    ids=_name,
)
def test_what_a_page_shows_of_other_tools_runs(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert not [name for block in blocks(page.read_text(encoding="utf-8")) for name in missing(block)]
    test_what_a_page_shows_runs(page, tmp_path, monkeypatch)


def copy_checkout(folder: Path) -> None:
    """Put the models, what is generated from them, and the examples into a git repository of their own."""
    for name in ("models", "generated", "docs/examples"):
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
    commit = ["-c", "user.name=me", "-c", "user.email=me@example.org", "commit", "-q", "-m", "as it is"]
    (folder / ".gitignore").write_text("__pycache__/\n.bin/\n", encoding="utf-8")
    for arguments in (["init", "-q"], ["add", "."], commit):
        subprocess.run(["git", *arguments], cwd=folder, check=True)


def run_python(block: Block, page: Path, names: dict[str, Any]) -> str:
    """Run a block in the names of its page; a traceback shows the line of the page."""
    text = "\n" * block.start + "\n".join(block.lines)
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(text, str(page), "exec"), names)
    return printed.getvalue()


def run_shell(block: Block, where: str, folder: Path) -> str:
    """Run a block as one script and compare status and output with what the page shows.

    A block begins in the directory in which the block before it ended, as in the terminal of a reader.
    """
    script, shown = script_of(block)
    wanted = int(said(block, "exit") or 0)
    own = environment(folder)
    place = folder / ".bin" / "place"
    done = subprocess.run(
        ["bash", "-euo", "pipefail", "-c", f"trap 'pwd > {place}' EXIT\n{script}"],
        cwd=place.read_text(encoding="utf-8").strip() if place.exists() else folder,
        env=own,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == wanted, f"{where}: exit {done.returncode}, not {wanted}:\n{script}\n{done.stdout}"
    expect(shown, done.stdout, where)
    return done.stdout


def script_of(block: Block) -> tuple[str, list[str]]:
    """Split a console block into a script and the output it shows; a bash block is a script as a whole."""
    if block.language == "bash":
        return "\n".join(block.lines), []
    script, shown, continued = [], [], False
    for line in block.lines:
        if line.startswith("$ ") or continued:
            script.append(line.removeprefix("$ "))
            continued = line.endswith("\\")
        else:
            shown.append(line)
    return "\n".join(script), shown


def environment(folder: Path) -> dict[str, str]:
    """Return an environment in which `mehvar` and `python` are those that run this test."""
    programs = folder / ".bin"
    if not programs.exists():
        programs.mkdir()
        for name, call in (("python", [sys.executable]), ("mehvar", commands.mehvar())):
            program = programs / name
            program.write_text(f'#!/bin/sh\nexec {shlex.join(call)} "$@"\n', encoding="utf-8")
            program.chmod(0o755)
    return {**os.environ, "PATH": f"{programs}{os.pathsep}{os.environ['PATH']}"}


def expect(shown: Sequence[str], output: str, where: str) -> None:
    """Look for the shown lines in the output, in their order; blanks count as one."""
    rest = [squeezed(line) for line in output.splitlines()]
    for line in filter(None, map(squeezed, shown)):
        if line == "...":
            continue
        pattern = ".*".join(map(re.escape, line.split("...")))
        position = next((k for k, real in enumerate(rest) if re.fullmatch(pattern, real)), None)
        assert position is not None, f"{where}: the output lacks the line\n  {line}\nIt is:\n{output}"
        del rest[: position + 1]


def squeezed(line: str) -> str:
    return " ".join(line.split())


def test_expect_refuses_what_is_not_there() -> None:
    expect(["a ... c", "...", "d"], "a  b c\nx\nd\n", "here")
    with pytest.raises(AssertionError, match="lacks the line"):
        expect(["d", "a b c"], "a b c\nd\n", "here")


def test_a_command_that_fails_is_noticed(tmp_path: Path) -> None:
    with pytest.raises(AssertionError, match="exit 2, not 0"):
        run_shell(Block("console", ("$ mehvar show nonsense",), 1, ""), "here", tmp_path)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_somewhere(page: Path) -> None:
    for target in links(page):
        path, _, anchor = target.partition("#")
        place = (page.parent / path).resolve() if path else page
        assert place.exists(), f"{page.relative_to(ROOT)}: no file {target}"
        assert place.is_relative_to(ROOT), f"{page.relative_to(ROOT)}: {target} leads out of the repository"
        if anchor:
            assert anchor in anchors(place), f"{page.relative_to(ROOT)}: no heading for {target}"


def test_every_page_can_be_reached() -> None:
    seen, waiting = set(), [ROOT / "README.md"]
    while waiting:
        page = waiting.pop()
        if page in seen:
            continue
        seen.add(page)
        targets = ((page.parent / target.partition("#")[0]).resolve() for target in links(page))
        waiting += [place for place in targets if place.suffix == ".md" and place.is_file()]
    missing = [str(page.relative_to(ROOT)) for page in PAGES if page not in seen]
    assert not missing, f"no link leads to {', '.join(missing)}"


def links(page: Path) -> Iterator[str]:
    """Return the relative links of a page, code excepted."""
    text = re.sub(r"^(`{3,}).*?^\1\s*$", "", page.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)
    for target in re.findall(r"\]\(([^)\s]+)\)", re.sub(r"`[^`\n]*`", "", text)):
        if not re.match(r"^[a-z]+:", target):
            yield target


def anchors(page: Path) -> set[str]:
    """Return the anchors that a forge gives the headings of a page."""
    text = re.sub(r"^(`{3,}).*?^\1\s*$", "", page.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)
    headings = re.findall(r"^#+\s+(.+?)\s*$", text, flags=re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def test_the_page_of_numbers_is_what_the_benchmarks_say() -> None:
    program = runpy.run_path(str(ROOT / "docs" / "site" / "numbers.py"))
    assert program["PAGE"].read_text(encoding="utf-8") == program["page"](), "run: python docs/site/numbers.py"


def test_the_page_of_options_is_what_the_commands_say() -> None:
    assert options.PAGE.read_text(encoding="utf-8") == options.page(), "run: python -m docs.site.options"


@pytest.mark.parametrize("name", pictures.PICTURES)
def test_a_picture_is_what_its_run_draws(name: str) -> None:
    text = (pictures.FOLDER / name).read_text(encoding="utf-8")
    assert text == pictures.PICTURES[name](), "run: python -m docs.site.pictures"


def test_every_picture_has_an_origin_a_size_and_a_reader() -> None:
    """An SVG is made by a run or written by hand; a PNG is drawn by the page that shows it."""
    shown = {name: page for page in PAGES for name in linked(page)}
    for picture in pictures.FOLDER.iterdir():
        assert picture.name in shown, f"no page shows {picture.name}"
        assert picture.stat().st_size < LARGEST, picture.name
        if picture.suffix == ".png":
            assert any(name == picture.name and draws(page, name) for page in PAGES for name in linked(page)), picture
        else:
            assert 'role="img" aria-label="' in picture.read_text(encoding="utf-8"), f"{picture.name} has no name"


def linked(page: Path) -> list[str]:
    """Return the pictures of docs/pictures that a page shows."""
    return re.findall(r"!\[[^\]]+\]\((?:\.\./|docs/)?pictures/([\w.-]+)\)", page.read_text(encoding="utf-8"))


def draws(page: Path, name: str) -> bool:
    """Return whether code or a command of a page writes a picture, before it is shown."""
    text = page.read_text(encoding="utf-8")
    shown = text.index(f"pictures/{name})")
    lines = [line for block in blocks(text[:shown]) for line in block.lines]
    return any(re.search(rf"(?<![\w-]){re.escape(name)}\b", line) for line in lines)


def check_pictures(page: Path, folder: Path) -> None:
    """Compare what a page has drawn with the pictures that it shows; with MEHVAR_APPROVE=yes they become those."""
    for name in linked(page):
        place = next(iter(folder.rglob(name)), None)
        if place is None or not name.endswith(".png"):
            continue  # another page draws it, or a block that needs a package
        kept = pictures.FOLDER / name
        with Image.open(place) as figure:
            drawn = figure.convert("RGB").quantize(HUES)
        if os.environ.get("MEHVAR_APPROVE") == "yes":
            drawn.save(kept, optimize=True)
        with Image.open(kept) as old:
            apart = share_apart(old, drawn)
        assert apart < ALIKE, f"{name} is {apart:.2%} from what {page.name} draws: MEHVAR_APPROVE=yes, and look at it"


LARGEST = 150_000
"""Bytes of a picture: a page with three is there at once on a telephone."""
HUES = 64
"""Colours of a figure. Of more there are only shades at the edges of lines."""
ALIKE = 0.01
"""Share of a thumbnail's pixels: fonts and the last digits of ticks differ between machines."""


def test_the_citation_names_this_version() -> None:
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    version = runpy.run_path(str(ROOT / "version.py"))["version"]()
    assert f"version: {version.partition('.post')[0]}\n" in citation


def test_every_page_is_in_an_index_and_in_the_site() -> None:
    """The home page leads to the index of each room, which leads to the pages of the room; decisions need no menu."""
    indices = [ROOT / "docs" / "index.md", ROOT / "docs" / "developers.md", *(ROOT / "docs").glob("*/index.md")]
    listed = {(page.parent / target.partition("#")[0]).resolve() for page in indices for target in links(page)}
    site = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    pages = [page for page in (ROOT / "docs").rglob("*.md") if page != ROOT / "docs" / "index.md"]
    assert not [page for page in pages if page not in listed]
    assert not [page for page in pages if f" {page.relative_to(ROOT / 'docs')}" not in site]


def test_the_home_page_leads_to_few_places() -> None:
    """People choose among forty links, not a hundred; each of at least sixteen pictures leads to what made it."""
    home = ROOT / "docs" / "index.md"
    targets = [target for target in links(home) if not target.startswith("pictures/")]
    panels = re.findall(
        r"\[!\[[^\]]+\]\(pictures/([\w.-]+)\)\]\(([\w./-]+)(?:#[\w-]+)?\)", home.read_text(encoding="utf-8")
    )
    assert len(targets) <= 40
    assert len(panels) >= 16
    for picture, page in panels:
        assert picture in linked(home.parent / page), f"{page} does not show {picture}"


def test_every_number_names_the_command_that_made_it() -> None:
    page = (ROOT / "docs" / "numbers.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| \[.+\]\(\.\./benchmarks/results/(\w+\.md)\) \| (.+) \|$", page, flags=re.MULTILINE)
    assert [name for name, _ in rows] == sorted(path.name for path in (ROOT / "benchmarks" / "results").glob("*.md"))
    for name, origin in rows:
        assert programs(origin), f"{name} is followed by {origin!r}"
        assert "a user's default" in origin, f"{name}: {origin!r} does not say at which settings"


def test_every_figure_of_the_readme_names_its_page_and_command() -> None:
    text = re.sub(
        r"^(`{3,}).*?^\1\s*$", "", (ROOT / "README.md").read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE
    )
    claims = [paragraph for paragraph in text.split("\n\n") if FIGURE.search(prose(paragraph))]
    assert len(claims) >= 2
    for claim in claims:
        assert programs(claim), f"no command made: {claim}"
        assert re.search(r"\]\((docs|benchmarks)/[^)]+\.md", claim), f"no page has: {claim}"


FIGURE = re.compile(
    r"(?<![\w.-])\d+(\.\d+)?(e-?\d+)?(?![\w.-]*\d)|\b(two|three|four|five|six|seven|eight|nine|ten) "
    r"(times|quarters|to \w+|runs|points|%)"
)
"""A number that somebody measured: what an interpreter or a release is called has a name before it, see `prose`."""


def prose(paragraph: str) -> str:
    """Return a paragraph without code, targets of links and names with a number in them."""
    return re.sub(r"`[^`]*`|\]\([^)]*\)|(?:Python|Version|C|Apache)[ -]?\d[\d.]*", "", paragraph)


def programs(text: str) -> list[str]:
    """Return the commands that a text names, each of which must be there."""
    targets = re.findall(
        r"^(?:campaign-)?([a-z]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), flags=re.MULTILINE
    )
    there = {
        "python": lambda place: (ROOT / place).is_file(),
        "python -m": lambda name: any(
            (ROOT / f"{name.replace('.', '/')}{end}").is_file() for end in (".py", "/__main__.py")
        ),
        "make": targets.__contains__,
        "mehvar": lambda name: (
            (ROOT / "mehvar" / "cli" / name).is_dir() or (ROOT / "mehvar" / "cli" / f"{name}.py").is_file()
        ),
    }
    pairs = re.findall(r"`(python -m|python|make|mehvar) ([^` ]+)", " ".join(text.split()))
    for program, place in pairs:
        assert there[program](place), f"there is no {program} {place}"
    return [" ".join(pair) for pair in pairs]


def test_a_figure_without_its_origin_is_seen() -> None:
    for text in (
        "It is 12 times as fast.",
        "The error is 2e-14.",
        "It saves 30 % of it.",
        "Up to three quarters fail.",
    ):
        assert FIGURE.search(prose(text)), text
    for text in ("With Python 3.11 or newer.", "Version 0.1.0 is not released.", "C99 and Apache-2.0, `t = 35`."):
        assert not FIGURE.search(prose(text)), text
    with pytest.raises(AssertionError, match="there is no make nonsense"):
        programs("It is 3 (`make nonsense`).")


def test_the_first_screen_leads_to_the_validation_and_its_tables_are_filled() -> None:
    """A table without rows or a case without a date does not reach a reader."""
    assert "(docs/validation.md)" in "".join((ROOT / "README.md").read_text(encoding="utf-8").splitlines(True)[:25])
    page = validation.PAGE.read_text(encoding="utf-8")
    cases = [line for line in page.splitlines() if re.search(r"\| (yes|\*\*no\*\*) \|$", line)]
    references = {line.split(" | ")[1] for line in cases}
    assert {"MuJoCo", "Basilisk", "JEOD", "SALib", "python-control", "SciPy DOP853", "SciPy Radau"} <= references
    assert all(re.search(r"\| \d{4}-\d\d-\d\d \|", line) for line in cases)
    shown = validation.SUMMARY.read_text(encoding="utf-8").partition(validation.SUMMARY_BEGIN)[2]
    assert shown.partition(validation.SUMMARY_END)[0].splitlines() == validation.summary(cases)


def test_the_page_has_every_mutant_that_was_recorded() -> None:
    """An open survivor is called open there: it is a task for tests, which the page does not hide."""
    page = mutants.PAGE.read_text(encoding="utf-8")
    seed = int(re.search(r"--sample 100 --seed (\d+)", page)[1])  # type: ignore[index]
    for begin, end, lines in (
        (mutants.BEGIN, mutants.END, functools.partial(mutants.whole, read(RESULTS))),
        (mutants.SAMPLE, mutants.SAMPLE_END, functools.partial(mutants.drawn, read(sample_file(seed)), 100, seed)),
    ):
        shown = page.partition(begin)[2].partition(end)[0]
        day = re.search(r"\d{4}-\d\d-\d\d", shown)
        assert day, begin
        assert shown.splitlines() == lines(day=day[0])


def test_a_case_that_ends_without_a_result_does_not_keep_its_old_row(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    page, row = tmp_path / "page.md", Row("one", "engine", "1", 1, 0.0, 1.0, "m", "digits")
    page.write_text(f"above\n{validation.BEGIN}{validation.END}below\n", encoding="utf-8")
    monkeypatch.setattr(validation, "PAGE", page)
    monkeypatch.setattr(validation, "SUMMARY", tmp_path / "summary.md")
    validation.SUMMARY.write_text(validation.SUMMARY_BEGIN + validation.SUMMARY_END, encoding="utf-8")
    validation.write([row, dataclasses.replace(row, case="two")])
    assert "2 cases: 2 hold, 0 fail." in page.read_text(encoding="utf-8")
    validation.write([row], without_result={"test_two": "InputError: no"}, complete=True)
    text = page.read_text(encoding="utf-8")
    assert "2 cases: 1 hold, 1 fail." in text
    assert "InputError: no" in text
    assert "| two |" not in text
    validation.write([dataclasses.replace(row, case="two", error=2.0)], passed={"test_two"})
    assert "2 cases: 1 hold, 1 fail." in page.read_text(encoding="utf-8")


def test_what_is_mutated_and_which_tests_concern_it_are_there() -> None:
    """A module that moves must not leave the campaign without a word."""
    subjects = tomllib.loads((ROOT / "tests" / "mutants" / "subjects.toml").read_text(encoding="utf-8"))["subject"]
    for subject in subjects:
        tests = [test for test in subject["tests"] if not test.startswith("-k ")]  # which of a file's tests run
        assert tests, subject
        for path in (*subject["modules"], *tests, *subject.get("without", ())):
            assert (ROOT / path.partition("::")[0]).is_file(), path


def test_the_page_that_compares_shows_what_was_measured() -> None:
    shown, measured = (
        re.findall(r"^\|.*\|$", (ROOT / place).read_text(encoding="utf-8"), flags=re.MULTILINE)
        for place in ("docs/compare.md", "benchmarks/results/compare.md")
    )
    assert shown == measured
    for tool in ("mehvar", "heyoka", "Drake", "PyDy", "Basilisk", "python-control"):
        assert any(line.startswith(f"| {tool}") for line in shown), f"no row of {tool}"
