# SPDX-License-Identifier: Apache-2.0
"""Write the pictures of docs/pictures that show a run or a ledger: `python -m docs.site.pictures`.

What the code or the commands of a page draw is kept by the test that runs the page, `tests/docs/test_docs.py`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import mehvar
from mehvar.codegen.workspace import installed_tree
from mehvar.reproduction.ledgers import paper_ledgers
from papers.triangle.shapes import COLLINEAR, R, vertices

FOLDER = Path(__file__).parents[1] / "pictures"
UNTIL, SECONDS, FRAMES = 24.0, 8, 97
"""Duration of the run, s, duration of the animation, s, and number of positions; half of these show corners."""
SCALE, CENTRE = 330.0, (180.0, 140.0)
"""Pixels per metre, for rods of up to 0.53 m, and the pixel of the centre of mass."""
_GRAPH = (400.0, 650.0, 230.0, 50.0)
"""Left, right, bottom and top of the attitude over time."""
_COLORS = ("#0072b2", "#d55e00", "#009e73")

Frames = NDArray[np.float64]


def turn() -> str:
    """Draw the run of the README: masses and rods that move, and the attitude over time."""
    run = mehvar.simulate("triangle", controller="path", scenario="paper")
    t = np.linspace(0.0, UNTIL, FRAMES)
    at = run.interp(t=t)
    rods = np.column_stack([at[f"l{k}"] for k in (1, 2, 3)])
    places = np.array([vertices(lengths, theta) for lengths, theta in zip(rods, at["theta"].values, strict=True)])
    x, y = list(CENTRE[0] + SCALE * places.real.T), list(CENTRE[1] - SCALE * places.imag.T)
    rods = [_rod(k, x, y) for k in range(3)]
    masses = [f'<circle r="9">{_moved("cx", x[k])}{_moved("cy", y[k])}</circle>' for k in range(3)]
    title = "A triangle of three masses turns by changing the lengths of its rods"
    return _svg((690, 290), title, [*rods, '<g class="mass">', *masses, "</g>", *_graph(t, at["theta"].values)])


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


def printed() -> str:
    """Draw two wrong equations of a paper, from the ledger."""
    ledger = paper_ledgers(installed_tree(), "triangle")[0]
    lines, top = [], 26
    for number in _REFUTED:
        entry = next(entry for entry in ledger["entries"] if entry["number"] == number)
        line = next(line for reading in entry["readings"] for line in reading["lines"] if line["edits"])
        old, new = _pretty(line["printed"]), _pretty(line["corrected"])
        lines += [f'<text x="16" y="{top}" class="strong">{number}  {entry["title"]}</text>']
        for row, (label, text, other, kind) in enumerate(
            (("printed", old, new, "wrong"), ("derived", new, old, "right")), 1
        ):
            lines += [f'<text x="16" y="{top + 28 * row}" class="soft">{label}</text>']
            lines += [f'<text x="84" y="{top + 28 * row}" class="formula">{_marked(text, other, kind)}</text>']
        lines += [f'<text x="84" y="{top + 82}" class="soft">{_pretty(line["edits"][0])}</text>']
        top += 126
    return _svg((480, top - 20), "Two printed equations of a paper and what follows from its physics", lines)


def _marked(text: str, other: str, kind: str) -> str:
    """Mark the part that differs from another text, between their common beginning and end."""
    first = _agreed(text, other)
    last = _agreed(text[first:][::-1], other[first:][::-1])
    own = text[first : len(text) - last]
    marked = f'<tspan class="{kind}">{own}</tspan>' if own else ""
    return f"{text[:first]}{marked}{text[len(text) - last :]}"


def _agreed(one: str, other: str) -> int:
    """Return the length of the common beginning of two texts."""
    return next((k for k, (a, b) in enumerate(zip(one, other, strict=False)) if a != b), min(len(one), len(other)))


def _pretty(text: str) -> str:
    for plain, sign in _SIGNS:
        text = text.replace(plain, sign)
    return text


def sphere() -> str:
    """Draw the upper half of the shape sphere, with triangles at some points."""
    (cx, cy), r = _SPHERE
    turns, spokes = np.radians(np.arange(90, 451, 5)), np.linspace(0.0, COLLINEAR, 30)
    meridians = [[(rho, np.radians(way)) for rho in spokes] for way in range(0, 360, 30)]
    parallels = [[(rho, turn) for turn in turns] for rho in (0.2, 0.4, 0.6)]  # hidden, if at all, at both ends
    lines = [f'<path class="axis" d="{_curve(_on_sphere(line))}"/>' for line in (*meridians, *parallels)]
    equator = [(cx + r * np.cos(turn), cy - r * np.sin(_TILT) * np.sin(turn)) for turn in _ROUND]
    lines += [
        f'<path class="axis dashed" d="{_curve(equator[:37])}"/>',
        f'<path class="line" d="{_curve(equator[36:])}"/>',
    ]
    lines += [f'<path class="line" d="M{cx - r},{cy}A{r},{r} 0 0 1 {cx + r},{cy}"/>']
    for sample in _SAMPLES:
        for place in _on_sphere([sample]):
            lines += _shape(*sample, place)
    lines += [
        '<text x="240" y="24" class="middle">each point is a shape, the pole the equilateral one</text>',
        '<text x="240" y="330" class="middle">on the equator the three masses are collinear</text>',
    ]
    return _svg((480, 345), "Half a sphere whose points are the shapes of a triangle, collinear ones on the rim", lines)


def chart() -> str:
    """Draw the disc of rho and phi, and a loop whose area is a turn."""
    scale, cx, cy = 200.0, 240.0, 180.0

    def place(rho: float, phi: float) -> tuple[float, float]:
        return cx + scale * rho * np.cos(phi), cy - scale * rho * np.sin(phi)

    rim = [place(COLLINEAR, phi) for phi in _ROUND]
    bound = [place(R, phi) for phi in _ROUND]
    loop = [place(0.3 + 0.17 * np.cos(turn), 0.9 + 0.6 * np.sin(turn)) for turn in _ROUND]
    lines = [f'<path class="axis dashed" d="{_curve(rim)}"/>', f'<path class="line" d="{_curve(bound)}"/>']
    lines += [f'<path class="area" d="{_curve(loop)}Z"/>']
    for rho, phi in (*_SAMPLES[:1], *_SAMPLES[2:]):  # the loop takes the place of one sample
        lines += _shape(rho, phi, place(rho, phi))
    at, zero = place(0.47, 0.9), place(0.62, 0.0)
    lines += [
        f'<path class="axis" d="M{cx},{cy}L{zero[0]:.1f},{zero[1]:.1f}"/>',
        f'<path class="pointer" d="M{cx},{cy}L{at[0]:.1f},{at[1]:.1f}"/>',
        f'<circle class="mass" cx="{at[0]:.1f}" cy="{at[1]:.1f}" r="4"/>',
        f'<path class="pointer" d="{_curve([place(0.16, phi) for phi in np.linspace(0.0, 0.9, 20)])}"/>',
        f'<text x="{cx + 46}" y="{cy - 14}">φ</text>',
        f'<text x="{at[0] - 34:.1f}" y="{at[1] + 44:.1f}">ρ</text>',
        '<text x="16" y="24">ρ = R</text>',
        '<path class="axis" d="M58,28L136,76"/>',
        '<text x="16" y="350" class="soft">dashed: collinear masses</text>',
        '<text x="464" y="350" class="soft end">a loop turns by twice its area</text>',
    ]
    return _svg((480, 362), "The disc of shapes with rho, phi and a loop of shapes, whose area is a turn", lines)


def _shape(rho: float, phi: float, at: tuple[float, float]) -> Iterator[str]:
    """Draw a small triangle at a place, with its rods in their colours."""
    lengths = mehvar.load("triangle", backend="python").functions["lengths"](rho, phi, _SIZE)
    points = _SMALL * vertices(lengths)
    corners = [(at[0] + point.real, at[1] - point.imag) for point in points]
    for k in range(3):
        (ax, ay), (bx, by) = corners[(k + 1) % 3], corners[(k + 2) % 3]
        yield f'<path stroke="{_COLORS[k]}" stroke-width="2.5" d="M{ax:.1f},{ay:.1f}L{bx:.1f},{by:.1f}"/>'


def _on_sphere(shapes: Iterable[tuple[float, float]]) -> list[tuple[float, float]]:
    """Project visible shapes (rho, phi); rho is the sine of half the angle from the pole."""
    (cx, cy), r = _SPHERE
    places = []
    for rho, phi in shapes:
        height, across = 1.0 - 2.0 * rho**2, 2.0 * rho * np.sqrt(1.0 - rho**2)
        x, y = across * np.cos(phi), across * np.sin(phi)
        if height * np.sin(_TILT) > y * np.cos(_TILT):
            places.append((cx + r * x, cy - r * (np.cos(_TILT) * height + np.sin(_TILT) * y)))
    return places


def _curve(points: Iterable[tuple[float, float]]) -> str:
    return "M" + "L".join(f"{x:.1f},{y:.1f}" for x, y in points)


def _svg(size: tuple[int, int], title: str, lines: Iterable[str]) -> str:
    width, height = size
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" role="img" aria-label="{title}">'
    return "\n".join([head, f"<title>{title}</title>", _STYLE, *lines, "</svg>", ""])


_REFUTED = ("(27)", "(30)")
_SIGNS = (
    ("theta_t_0", "θ̃₀"), ("rho_t_0", "ρ̃₀"), ("phi_t_0", "φ̃₀"), ("sin(phi_t)**2", "sin²φ̃"), ("cos(phi_t)", "cos φ̃"),
    ("rho_t", "ρ̃"), ("theta_0", "θ₀"), ("theta_f", "θ_f"), ("**2", "²"), ("sqrt", "√"), ("*", " "), (" - ", " − "),
    ("= -", "= −"), ("correct -", "correct −"),
)  # fmt: skip
_ROUND = np.linspace(0.0, 2.0 * np.pi, 73)
_SAMPLES = ((0.0, 0.0), *((rho, np.radians(30 + 60 * k)) for rho in (0.3, 0.56) for k in range(6)))
"""Drawn shapes, without overlaps."""
_SPHERE = ((240.0, 190.0), 145.0)
"""Middle and radius of the sphere, pixels."""
_SIZE, _SMALL, _TILT = 1.0, 46.0, np.radians(50.0)
"""mu of the small triangles, m^2; their pixels per metre; elevation of the eye above the equator."""

_STYLE = """<style>
text { font: 15px system-ui, sans-serif; fill: #58616a; } .soft { font-size: 13px; }
.middle { text-anchor: middle; } .end { text-anchor: end; } .strong { fill: #1d2125; font-weight: 600; }
.formula { font-size: 17px; fill: #1d2125; }
.wrong { fill: #a33f00; font-weight: 700; } .right { fill: #00664a; font-weight: 700; }
.mass { fill: #1d2125; } .line { fill: none; stroke: #1d2125; stroke-width: 2; }
.axis { fill: none; stroke: #98a1aa; } .dashed { stroke-dasharray: 5 4; }
.area { fill: #b0578d; fill-opacity: .22; stroke: #b0578d; stroke-width: 2; }
.pointer { fill: none; stroke: #b0578d; stroke-width: 1.6; }
@media (prefers-color-scheme: dark) {
text { fill: #a6aeb6; } .mass { fill: #e6e8ea; } .line { stroke: #e6e8ea; } .strong, .formula { fill: #e6e8ea; }
.wrong { fill: #ff9f6b; } .right { fill: #6fd6b0; } .axis { stroke: #5d6873; }
.area { fill: #e09ac2; stroke: #e09ac2; } .pointer { stroke: #e09ac2; }
}
</style>"""

PICTURES: dict[str, Callable[[], str]] = {
    "turn.svg": turn,
    "printed.svg": printed,
    "shape-sphere.svg": sphere,
    "chart.svg": chart,
}

if __name__ == "__main__":
    for name, draw in PICTURES.items():
        (FOLDER / name).write_text(draw(), encoding="utf-8")
