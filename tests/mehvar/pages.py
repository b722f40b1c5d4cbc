# SPDX-License-Identifier: Apache-2.0
"""Checks of every page: links, accessibility, print, appearance."""

import base64
import io
import os
import re
from pathlib import Path

import matplotlib
import numpy as np
from PIL import Image

from tests.mehvar.browser import prefer

WIDTHS = (1440, 768, 390)
"""Widths of a laptop, a tablet and a phone, in CSS pixels."""
TOLERANCE = 0.0015
"""Share of the pixels of a thumbnail. Two renderings of one page differ by 0.0000; of planted faults a rod that is not
drawn differs by 0.0017, contents that are not shown by 0.006, another font by 0.007."""
_HEIGHT = 900
_AXE = (Path(__file__).parent / "axe" / "axe.min.js").read_text(encoding="utf-8")
_PATIENCE = 240
"""Seconds for axe-core on a large page with everything unfolded: on a machine that ten others use it took over 60."""
_STILL = """
const [ready, done] = arguments, page = document.documentElement;
const near = (image) => image.getClientRects().length && image.getBoundingClientRect().top < innerHeight;
let before = "", frames = 0;
const look = () => {
  const drawn = [...document.images].every((image) => image.complete || !near(image));
  const whole = drawn && document.fonts.status === "loaded" && (!ready || page.dataset.ready === "yes");
  const seen = [whole, scrollY, page.scrollHeight, document.images.length, page.dataset.done].join();
  frames = whole && seen === before ? frames + 1 : 0;
  before = seen;
  if (frames < 15) requestAnimationFrame(look); else done();
};
look();
"""
"""Script that ends when nothing has moved for a quarter of a second and charts, pictures and fonts are there. It counts
frames, which come late where the machine is busy."""
_LANDING = """(() => {
  const target = document.getElementById(arguments[0]), page = document.documentElement;
  const wanted = parseFloat(getComputedStyle(page).scrollPaddingTop) || 0;
  return {off: target.getBoundingClientRect().top - wanted, end: scrollY + innerHeight >= page.scrollHeight - 1};
})()"""


def resize(browser, width, height=_HEIGHT):
    """Give the page a width in CSS pixels."""
    metrics = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 600}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)


def settled(browser, ready=True):
    """Wait until the page is drawn and nothing moves any more; a page of the site does not say when it is `ready`."""
    browser.set_script_timeout(_PATIENCE)
    browser.execute_async_script(_STILL, ready)


def misses(browser, page, anchors):
    """Return the anchors that a fresh page misses, with the distance in pixels."""
    off = {}
    for anchor in anchors:
        browser.get("about:blank")
        browser.get(f"{page.as_uri()}#{anchor}")
        settled(browser)
        landing = browser.execute_script(f"return {_LANDING}", anchor)
        if abs(landing["off"]) > 8 and not (landing["end"] and landing["off"] > 0):
            off[anchor] = landing["off"]
    return off


def contents(browser):
    """Return the anchors that the contents of the page lead to."""
    links = browser.find_elements("css selector", "nav.contents a[href^='#']")
    return [link.get_attribute("href").split("#")[1] for link in links]


def violations(browser):
    """Return the findings of axe-core: rule, help and the first places.

    Within formulas it is not asked: they are thousands of elements of which it has no rules.
    """
    browser.execute_script(_AXE)
    browser.set_script_timeout(_PATIENCE)
    rows = browser.execute_async_script(
        "const done = arguments[0]; axe.run({exclude: ['math']}, {resultTypes: ['violations']})"
        ".then((result) => done(result.violations), (e) => done([{impact: 'critical', id: String(e), nodes: []}]))"
    )
    return [(row["id"], row.get("help"), [node["html"][:120] for node in row["nodes"][:3]]) for row in rows]


SHIFT = """
const done = arguments[0];
let shift = 0;
new PerformanceObserver((list) => {
  for (const entry of list.getEntries()) shift += entry.hadRecentInput ? 0 : entry.value;
}).observe({ type: "layout-shift", buffered: true });
(async () => {
  for (let at = 0; at < document.documentElement.scrollHeight; at += 0.7 * innerHeight) {
    scrollTo({ top: at, behavior: "instant" });
    await new Promise((then) => setTimeout(then, 60));
  }
  setTimeout(() => done(shift), 300);
})();
"""


def shift(browser):
    """Scroll to the end, and return the layout shift; readers notice 0.1."""
    return browser.execute_async_script(SHIFT)


def unlabelled_canvases(browser):
    """Return the number of canvases without a text alternative, and of all canvases."""
    return browser.execute_script(
        "const all = [...document.querySelectorAll('canvas')], told = (c) => c.getAttribute('aria-label');"
        "return [all.filter((c) => c.getAttribute('role') !== 'img' || !told(c)).length, all.length]"
    )


def printed_pages(browser):
    """Return the number of A4 sheets of the printed page."""
    options = {"paperWidth": 8.27, "paperHeight": 11.69}
    pdf = base64.b64decode(browser.execute_cdp_cmd("Page.printToPDF", options)["data"])
    return len(re.findall(rb"/Type\s*/Page\b", pdf))


_BEYOND = """
const beyond = (part) => part.getClientRects().length && part.getBoundingClientRect().right > innerWidth + 1;
const leaves = [...document.querySelectorAll("main *")].filter((part) => !part.children.length && !part.closest("svg"));
return leaves.filter(beyond).map((part) => part.outerHTML.slice(0, 90));
"""


def cut_on_paper(browser):
    """Return the elements beyond the right edge of an A4 sheet."""
    browser.execute_script("dispatchEvent(new Event('beforeprint'))")
    resize(browser, 718)
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
    try:
        return browser.execute_script(_BEYOND)
    finally:
        browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})
        browser.execute_script("dispatchEvent(new Event('afterprint'))")


def opened(browser, page, width=1440, color="light"):
    """Show a page without animation and wait until nothing moves."""
    resize(browser, width)
    prefer(browser, prefers_color_scheme=color, prefers_reduced_motion="reduce")
    browser.get("about:blank")
    browser.get(page.as_uri())
    settled(browser)


def in_approved_font(page, file):
    """Write a page in Matplotlib's font, which is the same on every machine; return the file."""
    fonts = Path(matplotlib.get_data_path()) / "fonts" / "ttf"
    faces = [
        f"@font-face {{ font-family: Approved; font-weight: {weight};"
        f" src: url(data:font/ttf;base64,{base64.b64encode((fonts / name).read_bytes()).decode()}) }}"
        for weight, name in (("normal", "DejaVuSans.ttf"), ("bold", "DejaVuSans-Bold.ttf"))
    ]
    text = page.read_text(encoding="utf-8")
    style = f"<style>{' '.join(faces)} * {{ font-family: Approved !important }}</style></head>"
    file.write_text(text.replace("</head>", style, 1), encoding="utf-8")
    return file


def thumbnail(image):
    """Return a picture at a quarter of its size, in grey, which hides differences at the edges of letters."""
    grey = image.convert("L")
    return grey.resize((grey.width // 4, grey.height // 4), Image.Resampling.BOX)


def share_apart(one, other):
    """Return the share of two pictures' pixels, as thumbnails, that differ by a tenth of the range."""
    here, there = (np.asarray(thumbnail(image), dtype=float) for image in (one, other))
    return float(np.mean(np.abs(here - there) > 25.5)) if here.shape == there.shape else 1.0


def unlike(png, approved):
    """Return the difference of a picture from the approved one; MEHVAR_APPROVE=yes approves it: look at it first."""
    if os.environ.get("MEHVAR_APPROVE") == "yes":
        with Image.open(io.BytesIO(png)) as image:
            thumbnail(image).save(approved, optimize=True)
    return difference(png, approved)


def difference(png, approved):
    """Return the share of a picture's pixels that differ from an approved thumbnail by a tenth of the range."""
    with Image.open(approved) as image:
        there = np.asarray(image, dtype=float)
    with Image.open(io.BytesIO(png)) as image:
        here = np.asarray(thumbnail(image), dtype=float)
    if here.shape != there.shape:
        return 1.0
    return float(np.mean(np.abs(here - there) > 25.5))
