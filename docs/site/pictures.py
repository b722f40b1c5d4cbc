# SPDX-License-Identifier: Apache-2.0
"""Write docs/pictures: the README's moving picture, those that the code of a page draws, and those of its commands.

python -m docs.site.pictures
"""

from __future__ import annotations

import hashlib
import os
import re
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Iterable
from contextlib import chdir
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

import mehvar
from mehvar.papers.recorded import recorded_scene

DOCS = Path(__file__).parents[1]
FILE = DOCS / "pictures" / "turn.svg"
DRAWN = {"slew.svg": "tutorials/slew.md"}
"""Pictures that the code of a page writes, and the page."""
FIGURES = {
    "triangle": ("path.png", "mehvar simulate triangle --controller path --plot path.png"),
    "slosh": ("v1.png", "mehvar simulate slosh --controller lyapunov-v1 --out v1.nc --plot v1.png"),
    "satellite": ("mrac.png", "mehvar simulate satellite --controller mrac --out mrac.nc --plot mrac.png"),
}
"""By tutorial: the figure, and the command of the page that draws it."""
HUES = 64
"""Colours of a figure. Of more there are only shades at the edges of lines."""
UNTIL, SECONDS, FRAMES = 24.0, 8, 97
"""Seconds of the run until it is at rest, seconds of the picture, and places on the way: half as many show corners."""
SCALE, CENTRE = 330.0, (180.0, 140.0)
"""Pixels for a metre, of a triangle with rods of up to 0.53 m; where its centre of mass is."""
_GRAPH = (400.0, 650.0, 230.0, 50.0)
"""Left, right, bottom and top of the attitude over time."""
_COLORS = ("#0072b2", "#d55e00", "#009e73")

Frames = NDArray[np.float64]


def picture() -> str:
    """Return the text of the picture: the run of the README, its masses, rods and attitude."""
    run = mehvar.simulate("triangle", controller="path", scenario="paper")
    animated = recorded_scene(run, mehvar.load("triangle").manifest)
    assert animated is not None
    (series,) = animated[1].runs.values()
    t = np.linspace(0.0, UNTIL, FRAMES)
    at = {name: np.interp(t, series["t"], values) for name, values in series.items()}
    x = [CENTRE[0] + SCALE * at[f"x{k}"] for k in (1, 2, 3)]
    y = [CENTRE[1] - SCALE * at[f"y{k}"] for k in (1, 2, 3)]
    rods = [_rod(k, x, y) for k in range(3)]
    masses = [f'<circle r="9">{_moved("cx", x[k])}{_moved("cy", y[k])}</circle>' for k in range(3)]
    return "\n".join([_HEAD, *rods, '<g class="mass">', *masses, "</g>", *_graph(t, at["theta"]), "</svg>", ""])


def _rod(k: int, x: list[Frames], y: list[Frames]) -> str:
    """Return the rod across from mass k + 1."""
    one, other = (k + 1) % 3, (k + 2) % 3
    ends = zip(("x1", "y1", "x2", "y2"), (x[one], y[one], x[other], y[other]), strict=True)
    return f'<line stroke="{_COLORS[k]}" stroke-width="5">{"".join(_moved(*end) for end in ends)}</line>'


def _graph(t: Frames, theta: Frames) -> Iterable[str]:
    left, right, bottom, top = _GRAPH
    across = left + (right - left) * t / UNTIL
    up = bottom - (bottom - top) * theta / theta.max()
    points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(across, up, strict=True))
    yield f'<path class="axis" d="M{left},{top}V{bottom}H{right}"/>'
    yield f'<polyline class="line" points="{points}"/>'
    yield f'<circle class="mass" r="5">{_moved("cx", across)}{_moved("cy", up)}</circle>'
    yield f'<text x="{left + 8}" y="{top - 8}">attitude, from {theta[0]:.0f} rad to {abs(theta[-1]):.0f}</text>'
    yield f'<text x="{right - 60}" y="{bottom + 20}">{UNTIL:.0f} s</text>'
    yield '<text x="40" y="275">no torque: it turns by the lengths of its rods</text>'


def _moved(attribute: str, values: Frames) -> str:
    texts = ";".join(f"{value:.1f}" for value in values)
    return f'<animate attributeName="{attribute}" dur="{SECONDS}s" repeatCount="indefinite" values="{texts}"/>'


_HEAD = """<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 690 290" role="img"
 aria-label="A triangle of three masses turns by changing the lengths of its rods">
<style>
text { font: 15px system-ui, sans-serif; fill: #58616a; }
.mass { fill: #1d2125; } .line { fill: none; stroke: #1d2125; stroke-width: 2; }
.axis { fill: none; stroke: #98a1aa; }
@media (prefers-color-scheme: dark) {
text { fill: #a6aeb6; } .mass { fill: #e6e8ea; } .line { stroke: #e6e8ea; }
}
</style>"""


def origin(page: str) -> str:
    """Return the last line of a picture, by the page's code: numbers differ between machines, this does not."""
    return f"<!-- drawn by {page}, whose code is {hashlib.sha256(_code(page).encode()).hexdigest()} -->\n"


def drawn(name: str, page: str) -> str:
    """Return the text of a picture that the code of a page writes."""
    import matplotlib

    os.environ["SOURCE_DATE_EPOCH"] = "0"
    style = {"backend": "agg", "svg.hashsalt": name, "svg.fonttype": "none", "axes.grid": True}
    with tempfile.TemporaryDirectory() as folder, chdir(folder), matplotlib.rc_context(style):
        exec(compile(_code(page), page, "exec"), {"__name__": "__main__"})
        return re.sub(r" +$", "", Path(name).read_text(encoding="utf-8"), flags=re.MULTILINE) + origin(page)


def _code(page: str) -> str:
    text = (DOCS / page).read_text(encoding="utf-8")
    return "\n".join(re.findall(r"^```python\n(.*?)^```$", text, flags=re.DOTALL | re.MULTILINE))


def draw(name: str, command: str) -> None:
    """Run the command of a page in a folder of its own and keep its figure."""
    with tempfile.TemporaryDirectory() as folder:
        words = [sys.executable, "-m", *shlex.split(command)]
        subprocess.run(words, cwd=folder, check=True, stdout=subprocess.DEVNULL)
        with Image.open(Path(folder) / name) as figure:
            figure.convert("RGB").quantize(HUES).save(FILE.parent / name, optimize=True)


if __name__ == "__main__":
    FILE.parent.mkdir(exist_ok=True)
    FILE.write_text(picture(), encoding="utf-8")
    for name, page in DRAWN.items():
        (FILE.parent / name).write_text(drawn(name, page), encoding="utf-8")
    for file, line in FIGURES.values():
        draw(file, line)
