# SPDX-License-Identifier: Apache-2.0
"""Every kind of page looks as approved, at three widths, light and dark, and shows no code of a failed text.

A sheet of six small grey pictures is approved for each kind: `MEHVAR_APPROVE=yes pytest tests/mehvar/test_looks.py -m
"soak or not soak"` writes them; look at them before you commit. Pages are in a font that Matplotlib brings, so that a
sheet is the same on every machine.
"""

from __future__ import annotations

import io
import itertools
import os
import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests import commands
from tests.mehvar import looks
from tests.mehvar.browser import chromium, prefer
from tests.mehvar.pages import in_approved_font, resize, settled

APPROVED = Path(__file__).parent / "approved"
SCALE, HEIGHT, LEVELS = 6, 2400, 16
"""A page's first 2400 pixels at a sixth of the size in 16 greys: 20 kB a sheet; a line of text is a grey row."""
TOLERANCE = 0.0015
"""Largest share of a picture's pixels that may differ by a fifth of the range. Two renderings differ by 0.0000; of
planted faults a hidden heading differs by 0.002 to 0.004, hidden contents by 0.003, hidden legends by 0.001 to 0.003,
letters that are a sixteenth larger by 0.02 to 0.08."""
QUICK = ("a model", "a batch", "requirements")
"""Kinds of the suite; a run looks as that of a model does. The others belong to soak."""
FAILED = re.compile(r"\\[a-z]{2,}|\bundefined\b|\bNaN\b|\[object \w+\]|\bNone\b")
"""LaTeX, and what a script or a template writes in place of a missing value."""


@pytest.fixture(scope="module")
def browser():
    with chromium() as driver:
        yield driver


@pytest.fixture(scope="module", autouse=True)
def pages(tmp_path_factory):
    """Make the pages of this checkout, not those of an earlier one, by commands that share their imports."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(looks, "BUILD", tmp_path_factory.mktemp("looks"))
        patch.setattr(looks, "PROGRAM", commands.mehvar())
        yield


def picture(browser, page: Path, width: int, color: str) -> Image.Image:
    """Return the first screens of a page, small and grey."""
    resize(browser, width, HEIGHT)
    prefer(browser, prefers_color_scheme=color, prefers_reduced_motion="reduce")
    browser.execute_cdp_cmd("Emulation.setScrollbarsHidden", {"hidden": True})  # they fade
    browser.get("about:blank")
    browser.get(page.as_uri())
    settled(browser, ready=False)
    with Image.open(io.BytesIO(browser.get_screenshot_as_png())) as image:
        small = image.convert("L").resize((width // SCALE, HEIGHT // SCALE), Image.Resampling.BOX)
    return small.point(lambda grey: round(grey * (LEVELS - 1) / 255) * 255 // (LEVELS - 1))


def sheet(pictures: list[Image.Image]) -> Image.Image:
    """Return pictures side by side."""
    whole = Image.new("L", (sum(image.width for image in pictures), HEIGHT // SCALE))
    left = 0
    for image in pictures:
        whole.paste(image, (left, 0))
        left += image.width
    return whole


def parts(approved: Path) -> list[Image.Image]:
    """Return the pictures of a sheet."""
    with Image.open(approved) as image:
        whole = image.convert("L")
    ends = np.cumsum([0, *(width // SCALE for width, _ in LOOKS)])
    return [whole.crop((left, 0, right, whole.height)) for left, right in itertools.pairwise(ends.tolist())]


def apart(one: Image.Image, other: Image.Image) -> float:
    """Return the share of pixels that differ by a fifth of the range."""
    return float(np.mean(np.abs(np.asarray(one, dtype=float) - np.asarray(other, dtype=float)) > 51))


LOOKS = [(width, color) for width in looks.WIDTHS for color in looks.COLORS]
SOME, OTHERS = LOOKS[::5], LOOKS[1:5]
CASES = [
    *(pytest.param(kind, SOME, id=kind) for kind in QUICK),
    *(pytest.param(kind, OTHERS, id=f"{kind}, the other four", marks=pytest.mark.soak) for kind in QUICK),
    *(pytest.param(kind, LOOKS, id=kind, marks=pytest.mark.soak) for kind in looks.kinds() if kind not in QUICK),
]


@pytest.mark.parametrize(("kind", "wanted"), CASES)
def test_a_page_looks_as_approved(kind, wanted, browser):
    approving = os.environ.get("MEHVAR_APPROVE") == "yes"
    page, approved = looks.kinds()[kind](), APPROVED / (re.sub(r"\W+", "-", kind) + ".png")
    shown = in_approved_font(page, page.with_name(f"{page.stem}-look.html"))
    try:
        found = {look: picture(browser, shown, *look) for look in (LOOKS if approving else wanted)}
        words = browser.execute_script("return document.body.innerText")
    finally:
        shown.unlink()
    if approving:
        sheet([*found.values()]).quantize(LEVELS).save(approved, optimize=True)
    assert kind.startswith("site") or not FAILED.findall(words)  # the site shows Python, and its None
    there = dict(zip(LOOKS, parts(approved), strict=True))
    unlike = {look: apart(image, there[look]) for look, image in found.items()}
    assert max(unlike.values()) < TOLERANCE, f"look at {approved}, then approve what you see with MEHVAR_APPROVE=yes"
