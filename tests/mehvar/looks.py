# SPDX-License-Identifier: Apache-2.0
"""Weight, time and faults of every kind of page, measured in a browser: `python -m tests.mehvar.looks [PAGE...]`.

It makes the pages below build/looks, the report and the site where `make run docs` has not, and opens each at three
widths, in light and in dark. The table of docs/reference/report.md has the worst of the six.
"""

from __future__ import annotations

import datetime
import json
import shutil
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from tests.mehvar.browser import chromium, prefer
from tests.mehvar.pages import resize, violations

ROOT = Path(__file__).parents[2]
BUILD = ROOT / "build" / "looks"
PAGE = ROOT / "docs" / "reference" / "report.md"
BEGIN = "<!-- table: written by python -m tests.mehvar.looks -->\n"
END = "<!-- end of the table -->\n"
PROGRAM = [sys.executable, "-m", "mehvar"]
SITE = ("index", "tutorials/triangle", "explanation/shape-sphere", "validation", "reference/python", "live", "404")
WIDTHS, COLORS = (1440, 1024, 390), ("light", "dark")
WATCH = """
window.shifts = [];
const named = (node) => node && node.nodeType === 1 ? node.outerHTML.slice(0, 90) : "text";
new PerformanceObserver((list) => {
  for (const entry of list.getEntries()) if (!entry.hadRecentInput) {
    window.shifts.push([entry.value, entry.sources.slice(0, 3).map(({ node }) => named(node))]);
  }
}).observe({ type: "layout-shift", buffered: true });
const inked = (canvas) => {
  if (!canvas.width || !canvas.height) return false;
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  return new Uint32Array(data.buffer).some(Boolean);
};
const drawn = (part) => part.tagName === "IMG" ? part.complete && part.naturalWidth > 20
  : part.tagName !== "CANVAS" || inked(part);
const look = () => {
  const parts = [...document.querySelectorAll(":is(main, article) :is(img, canvas, math)")].slice(0, 8);
  if (parts.some((part) => part.getClientRects().length && drawn(part))) window.figure ??= performance.now();
  else requestAnimationFrame(look);
};
requestAnimationFrame(look);
"""
"""Script that sums layout shifts and records the time of the first picture or formula."""
WALK = """
const done = arguments[0], wait = (ms) => new Promise((then) => setTimeout(then, ms));
(async () => {
  await wait(700);
  for (let at = 0, end = 0; at <= document.documentElement.scrollHeight && end < 150; at += 0.7 * innerHeight, end++) {
    scrollTo({ top: at, behavior: "instant" });
    await wait(60);
  }
  await wait(300);
  const page = document.documentElement, shift = window.shifts.reduce((sum, [value]) => sum + value, 0);
  done({ shift, shifts: window.shifts, figure: window.figure ?? null, over: page.scrollWidth - innerWidth });
})();
"""
"""Script that scrolls to the end, so that all charts are built."""
_LARGE = 900_000
"""Size above which axe-core checks a page as it opens; with every fold open the check takes minutes."""


@dataclass(frozen=True)
class Look:
    """A page at one width in one scheme of colours."""

    width: int
    color: str
    shift: float
    figure: float | None
    over: int
    findings: Sequence[Any]
    shifts: Sequence[Any]


def kinds() -> dict[str, Callable[[], Path]]:
    """Return the kinds of pages, each with a function that returns a page and makes it if it is not there."""
    papers = {f"report: {name}": partial(report, name) for name in ("triangle", "slosh", "satellite")}
    return {
        "report: overview": partial(report, "index"),
        **papers,
        "live page": live,
        "a model": partial(made, "model", "report", "triangle"),
        "a run": lambda: made("run", "report", run()),
        "a batch": lambda: made("batch", "report", batch()),
        "requirements": requirements,
        "a diff": lambda: diff("diff", "--model", "triangle", folder=edited()),
        "a diff of three models that are the same": partial(
            diff, "same", str(ROOT / "generated"), str(ROOT / "generated")
        ),
        "the equations of the papers": partial(diff, "paper", "--paper"),
        "a run on a board": board,
        **{f"site: {name}": partial(site, name) for name in SITE},
    }


def report(name: str) -> Path:
    """Return a page of the papers' report."""
    folder = ROOT / "build" / "report"
    if not folder.is_dir():
        mehvar("reproduce", "--out", str(folder))
    return folder / f"{name}.html"


def site(name: str) -> Path:
    """Return a page of the site."""
    folder = ROOT / "build" / "site"
    if not folder.is_dir():
        subprocess.run([sys.executable, "-m", "mkdocs", "build", "--quiet"], cwd=ROOT, check=True)
    return folder / f"{name}.html"


def live() -> Path:
    """Return a page on which a model runs, judged by the paper's condition."""
    if not (BUILD / "live").is_dir():
        mehvar("export", "web", "triangle", "--success", "T_theta < 20 and T_rho < 25", "--out", "live")
    return BUILD / "live" / "triangle.html"


def mehvar(*words: str, folder: Path | None = None) -> None:
    """Run a command in a folder, or in the folder of the pages; `diff` ends with 1 where something changed."""
    folder = folder or BUILD
    folder.mkdir(parents=True, exist_ok=True)
    subprocess.run([*PROGRAM, *words], cwd=folder, check=False, stdout=subprocess.DEVNULL)


def made(name: str, *words: str) -> Path:
    """Return the page that a command writes into a folder."""
    folder = BUILD / name
    if not folder.is_dir():
        mehvar(*words, "--out", str(folder))
    return folder / "index.html"


def run() -> str:
    """Return the file of a run."""
    if not (BUILD / "run.nc").exists():
        mehvar("simulate", "triangle", "--controller", "path", "--scenario", "paper", "--out", "run.nc")
    return "run.nc"


def batch() -> str:
    """Return the store of a batch."""
    if not (BUILD / "runs.zarr").exists():
        vary = ("--vary", "theta_0=uniform(0.8, 1.2)", "--vary", "mass=normal(1, 0.05)")
        mehvar(
            "batch",
            "triangle",
            "--controller",
            "path",
            "-n",
            "200",
            *vary,
            "--success",
            "T_theta < 19",
            "--out",
            "runs.zarr",
        )
    return "runs.zarr"


def requirements() -> Path:
    """Return the page of a requirement."""
    page = BUILD / "require.html"
    if not page.exists():
        mehvar("require", batch(), "--that", "attitude=quantile(0.95, final(theta)) < 0.1", "--page", page.name)
    return page


def edited() -> Path:
    """Return a checkout in which one sign of the triangle is turned since the last commit."""
    folder = BUILD / "edited"
    if not folder.exists():
        for room in ("models", "generated"):
            shutil.copytree(ROOT / room, folder / room, ignore=shutil.ignore_patterns("__pycache__"))
        me = ["-c", "user.name=me", "-c", "user.email=me@example.org"]
        for words in (["init", "-q"], ["add", "."], [*me, "commit", "-q", "-m", "as it is"]):
            subprocess.run(["git", *words], cwd=folder, check=True)
        source = folder / "models" / "triangle" / "system.py"
        text = source.read_text(encoding="utf-8")
        source.write_text(text.replace("plant.H, d) + drift", "plant.H, d) - drift"), encoding="utf-8")
    return folder


def diff(name: str, *words: str, folder: Path | None = None) -> Path:
    """Return the page of a comparison."""
    page = BUILD / f"{name}.html"
    if not page.exists():
        mehvar("diff", *words, "--out", str(page), folder=folder)
    return page


def board() -> Path:
    """Return the page of a run on an emulated board."""
    if not (BUILD / "board").exists():
        mehvar("board", "report", "triangle", "--controller", "path", "--samples", "40", "--out", "board")
    return next((BUILD / "board").glob("*.html"))


def measured(browser: Any, page: Path, width: int, color: str) -> Look:
    """Open a page and walk through it."""
    resize(browser, width)
    prefer(browser, prefers_color_scheme=color, prefers_reduced_motion="no-preference")
    browser.get("about:blank")
    browser.get(page.as_uri())
    browser.set_script_timeout(240)
    seen = browser.execute_async_script(WALK)
    if page.stat().st_size < _LARGE:
        browser.execute_script("document.querySelectorAll('details').forEach((part) => { part.open = true })")
    asked = (width, color) in (
        (WIDTHS[0], COLORS[0]),
        (WIDTHS[-1], COLORS[-1]),
    )  # seconds each, minutes on a large page
    return Look(width, color, findings=violations(browser) if asked else (), **seen)


def row(kind: str, size: int, looks: Sequence[Look]) -> str:
    """Return a page's row of the table: the worst of its looks."""
    figures = [look.figure for look in looks if look.figure is not None]
    figure = f"{max(figures):.0f}" if figures else "none"
    shift, over = max(look.shift for look in looks), max(0, *(look.over for look in looks))
    findings = max(len(look.findings) for look in looks)
    return f"| {kind} | {size / 1000:.0f} | {figure} | {shift:.3f} | {findings} | {over} |"


def write(rows: Sequence[str]) -> None:
    """Write the table into its page."""
    head, rest = PAGE.read_text(encoding="utf-8").split(BEGIN)
    columns = f"measured {datetime.date.today()} | kB | first figure, ms | layout shift | axe findings | sideways, px"
    table = [f"| {columns} |", "|---|---|---|---|---|---|", *rows, "", ""]
    PAGE.write_text(head + BEGIN + "\n".join(["", *table]) + END + rest.partition(END)[2], encoding="utf-8")


def main(*wanted: str) -> None:
    """Measure all pages, or pages whose name contains a word; print faults, and write the table."""
    rows = []
    with chromium() as browser:
        browser.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": WATCH})
        for kind, page_of in kinds().items():
            if wanted and not any(word in kind for word in wanted):
                continue
            page = page_of()
            looks = [measured(browser, page, width, color) for width in WIDTHS for color in COLORS]
            rows.append(row(kind, page.stat().st_size, looks))
            print(rows[-1], flush=True)
            for look in looks:
                print(f"  {look.width} {look.color}: {json.dumps([look.findings, look.shifts[:3]])}", flush=True)
    if not wanted:
        write(rows)


if __name__ == "__main__":
    main(*sys.argv[1:])
