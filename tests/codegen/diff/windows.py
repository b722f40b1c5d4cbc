# SPDX-License-Identifier: Apache-2.0
"""Pairs that are equal or differ only in a narrow window of inverse functions, steps, roots and logarithms.

Each pair is equal, or different, by construction: a window inside the range of what it looks at is open, one outside it
is empty, and an arc undoes its function on its principal range only.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator
from math import pi

import sympy as sp

from tests.codegen.diff.documents import Version, version

Row = tuple[str, bool, Version, Version]
_INSIDE = 0.9
"""Part of a range within which windows lie, so that none reaches over its end."""

RANGES: tuple[tuple[str, float, float], ...] = (
    ("acos(cos({a}))", 0, pi),
    ("asin(sin({a}))", -pi / 2, pi / 2),
    ("atan(tan({a}))", -pi / 2, pi / 2),
    ("atan2(sin({a}), cos({a}))", -pi, pi),
    ("Abs(atan2(sin({a} - {b}), cos({a} - {b})))", 0, pi),
    ("acos(cos({a} - {b}))", 0, pi),
    ("acos(sin({a})*cos({b}))", 0, pi),
    ("atan2({x}, {y})", -pi, pi),
    ("atan({x}/{y})", -pi / 2, pi / 2),
    ("asin({x}/sqrt({x}**2 + {y}**2))", -pi / 2, pi / 2),
    ("acos({z}/sqrt({x}**2 + {y}**2 + {z}**2))", 0, pi),
    ("acos(tanh({x}))", 0, pi),
    ("{a} - 2*floor({a}/2)", 0, 2),
    ("Mod({a}, 2*pi)", 0, 2 * pi),
    ("Mod({x} + {y}, 3) - 1", -1, 2),
    ("sqrt({a}**2)", 0, 40),
    ("sqrt({x}**2 + {y}**2)", 0, 40),
    ("log(exp({x}))", -30, 30),
    ("log(1 + {x}**2)", 0, 9),
    ("exp(-{x}**2)", 0, 1),
    ("tanh({x}*{y})", -1, 1),
    ("1/(1 + exp(-{x}))", 0, 1),
    ("acosh(1 + {x}**2)", 0, 9),
    ("asinh({x})", -9, 9),
    ("cosh({x}) - sinh({x})", 0, 9),
)
"""Arguments of windows, each with its range or a part of it."""

NESTED: tuple[tuple[str, float, float], ...] = (
    ("sqrt(acos(cos({a})))", 0, 1.77),
    ("log(1 + acos(cos({a})))", 0, 1.42),
    ("acos(cos(acos(cos({a})) + {b}))", 0, pi),
    ("acos(cos({a}*acos(cos({b}))))", 0, pi),
    ("atan2(sin(2*{a}), 2 + cos({b}))", -0.7, 0.7),
    ("asin(sin({a})*sin({b}))", -pi / 2, pi / 2),
    ("acos(cos({a}))*asin(sin({b}))", -4.5, 4.5),
    ("sqrt(Abs(atan2(sin({a}), cos({a})) - {b}))", 0, 3),
    ("acos(cos({a})) - acos(cos({b}))", -pi, pi),
    ("Max(acos(cos({a})), Abs(atan2({x}, {y})))", 0, pi),
    ("Min(sqrt({x}**2), sqrt({y}**2))", 0, 30),
    ("atan2(Max(0, {x}), {y})", 0, pi),
    ("log(1 + sqrt({x}**2 + {y}**2))", 0, 5),
    ("acos(cos({a})) + Mod({x}, 2)", 0, 5),
    ("{x} - floor({x}) + {y} - floor({y})", 0, 2),
    ("sqrt({x} - floor({x}))", 0, 1),
    ("atan2(sin({a} + floor({x})), cos({a} + floor({x})))", -pi, pi),
    ("exp(-acos(cos({a})))", 0.05, 1),
    ("sign({x})*acos(cos({a}))", -pi, pi),
)

UNDONE: tuple[tuple[str, str, str, float, float], ...] = (
    ("acos(cos({a}))", "{a}", "{a}", 0, pi),
    ("acos(cos({a}))", "-{a}", "{a}", -pi, 0),
    ("acos(cos({a}))", "2*pi - {a}", "{a}", pi, 2 * pi),
    ("asin(sin({a}))", "{a}", "{a}", -pi / 2, pi / 2),
    ("asin(sin({a}))", "pi - {a}", "{a}", pi / 2, 3 * pi / 2),
    ("atan(tan({a}))", "{a}", "{a}", -pi / 2, pi / 2),
    ("atan2(sin({a}), cos({a}))", "{a}", "{a}", -pi, pi),
    ("atan2(sin(2*{a}), cos(2*{a}))", "2*{a}", "{a}", -pi / 2, pi / 2),
    ("sqrt({a}**2)", "{a}", "{a}", 0, 50),
    ("sqrt(1 - sin({a})**2)", "cos({a})", "{a}", -pi / 2, pi / 2),
    ("atan2({y}, {x})", "atan({y}/{x})", "{x}", 0, 50),
    ("atan({x}) + atan(1/{x})", "pi/2", "{x}", 0, 50),
    ("acosh(cosh({x}))", "{x}", "{x}", 0, 50),
    ("sqrt({x}**2 - 2*{x} + 1)", "{x} - 1", "{x}", 1, 50),
    ("Mod({a}, 2*pi)", "{a}", "{a}", 0, 2 * pi),
    ("{x} - floor({x})", "{x}", "{x}", 0, 1),
    ("acos(cos({a} - {b}))", "{a} - {b}", "({a} - {b})", 0, pi),
)
"""Two expressions that are equal where a third one lies within a range, and different beyond its lower end."""

ALWAYS: tuple[tuple[str, str], ...] = (
    ("log(exp({a}))", "{a}"),
    ("acos(cos({a}))", "Abs(atan2(sin({a}), cos({a})))"),
    ("acos(cos({a}))", "acos(1 - 2*sin({a}/2)**2)"),
    ("acos(sin({a}))", "pi/2 - asin(sin({a}))"),
    ("asin(tanh({x}))", "atan(sinh({x}))"),
    ("sqrt({x}**2)", "Abs({x})"),
    ("floor({x}/3)", "({x} - Mod({x}, 3))/3"),
    ("atan2({x}, {y})", "2*atan({x}/(sqrt({x}**2 + {y}**2) + {y}))"),
    ("asin({x}/sqrt({x}**2 + {y}**2))", "atan({x}/Abs({y}))"),
    ("log(1 + {x}**2)", "2*log(sqrt(1 + {x}**2))"),
    ("acos(-cos({a}))", "pi - acos(cos({a}))"),
)

EMPTY: tuple[tuple[str, float, float], ...] = (
    ("acos(cos({a}))", 3.15, 3.2),
    ("asin(sin({a} + {b}))", -1.7, -1.6),
    ("atan2({x}, {y})", 3.15, 4),
    ("atan({x}*{y})", 1.58, 2),
    ("sqrt({x}**2 + {y}**2)", -1, -0.001),
    ("exp(-{x}**2)", 1.001, 2),
    ("log(1 + {x}**2)", -1, -0.001),
    ("tanh({x})", 1.001, 3),
    ("floor({x}/{n})", 2.25, 2.5),
    ("sqrt(acos(cos({a})))", 1.8, 2),
    ("acos(cos({a})) - atan2({x}, {y})", 6.3, 7),
    ("Mod({x}, 2)", 2.001, 3),
    ("{x} - floor({x})", 1.001, 1.01),
    ("acosh(1 + {x}**2)", -0.1, -0.01),
)
"""Arguments of windows, each with a range outside its own."""


def _write(draw: random.Random, *texts: str) -> list[str]:
    angles, states = draw.sample(("a", "b", "phi", "theta"), 2), draw.sample(("x", "y", "v", "w"), 3)
    names = dict(zip("abxyz", (*angles, *states), strict=True)) | {"n": str(draw.randrange(2, 9))}
    return [text.format(**names) for text in texts]


def _row(differs: bool, old: str, new: str) -> Row:
    return f"{old} | {new}", differs, version(f"f: {old}"), version(f"f: {new}")


def _window(draw: random.Random, low: float, high: float) -> tuple[sp.Rational, sp.Rational]:
    """Draw a window of a width of 1e-9 to 1e-4 inside a range."""
    middle, reach = (low + high) / 2, (high - low) / 2 * _INSIDE
    start = sp.Rational(f"{middle + draw.uniform(-reach, reach):.4f}")
    return start, start + sp.Rational(1, 10 ** draw.randrange(4, 10))


def inside(f: str, low: sp.Rational, high: sp.Rational) -> list[str]:
    """Return expressions that are one inside a window and zero outside."""
    middle, half = (low + high) / 2, (high - low) / 2
    return [
        f"Piecewise((1, ({f} > {low}) & ({f} < {high})), (0, True))",
        f"Piecewise((0, ({f} <= {low}) | ({f} >= {high})), (1, True))",
        f"Piecewise((Piecewise((1, {f} < {high}), (0, True)), {f} > {low}), (0, True))",
        f"Piecewise((1, Abs({f} - ({middle})) < {half}), (0, True))",
        f"Piecewise((1, ({f} - ({middle}))**2 < {half**2}), (0, True))",
        f"Piecewise((1, ({f} - ({low}))*({high} - ({f})) > 0), (0, True))",
        f"Piecewise((1, Min({f} - ({low}), {high} - ({f})) > 0), (0, True))",
        f"(sign({f} - ({low})) + 1)*(sign({high} - ({f})) + 1)/4",
        f"(sign({f} - ({low})) - sign({f} - ({high})))/2",
    ]


def ramps(f: str, low: sp.Rational, high: sp.Rational) -> list[str]:
    """Return expressions that rise and fall inside a window and are zero outside."""
    return [
        f"Max(0, {f} - ({low}))*Max(0, {high} - ({f}))",
        f"Max(0, ({f} - ({low}))*({high} - ({f})))",
        f"Piecewise((({f} - ({low}))*({high} - ({f})), ({f} > {low}) & ({f} < {high})), (0, True))",
    ]


def tents(f: str, low: sp.Rational, high: sp.Rational) -> list[str]:
    """Return expressions of a triangular function over a window."""
    middle = (low + high) / 2
    return [
        f"Max(0, Min({f} - ({low}), {high} - ({f})))",
        f"(Max(0, {f} - ({low})) - 2*Max(0, {f} - ({middle})) + Max(0, {f} - ({high})))",
    ]


SHAPES: tuple[Callable[[str, sp.Rational, sp.Rational], list[str]], ...] = (inside, inside, inside, ramps, tents)


def windows(draw: random.Random) -> Iterator[Row]:
    """Yield terms that act only inside a window, and windows in two forms."""
    yield from _windows(draw, RANGES)


def nested(draw: random.Random) -> Iterator[Row]:
    """Yield the same for compositions of compositions."""
    yield from _windows(draw, NESTED)


def _windows(draw: random.Random, ranges: tuple[tuple[str, float, float], ...]) -> Iterator[Row]:
    for text, low, high in ranges:
        f, rest, factor = _write(draw, text, "{z}", draw.choice(("1", "{x}", "k", "cos({a})")))
        shapes = draw.choice(SHAPES)(f, *_window(draw, low, high))
        yield _row(True, f"{rest} + {factor}*{draw.choice(shapes)}", rest)
        first, second = draw.sample(draw.choice(SHAPES)(f, *_window(draw, low, high)), 2)
        yield _row(False, f"{rest} + {factor}*{first}", f"{rest} + {factor}*{second}")


def undone(draw: random.Random) -> Iterator[Row]:
    """Yield inverse functions of functions, inside windows of the same or another state."""
    for left, right, of, low, high in UNDONE:
        middle, reach = (low + high) / 2, (high - low) / 2
        width = sp.Rational(1, 10 ** draw.randrange(4, 10))
        edge = sp.Rational(f"{low:.9f}")
        one, two, it, other = _write(draw, left, right, of, "{z}")
        start = sp.Rational(f"{middle + draw.uniform(-reach, reach) * _INSIDE:.4f}")
        own = draw.choice(inside(it, start, start + width))
        over = draw.choice(inside(it, edge - sp.Rational(1, 10), edge + sp.Rational(1, 10)))
        elsewhere = draw.choice(inside(other, *_window(draw, -40, 40)))
        pair = f"({one})", f"({two})"
        yield _row(False, f"{other} + {own}*{pair[0]}", f"{other} + {own}*{pair[1]}")
        yield _row(True, f"{other} + {elsewhere}*{pair[0]}", f"{other} + {elsewhere}*{pair[1]}")
        yield _row(True, f"{other} + {over}*{pair[0]}", f"{other} + {over}*{pair[1]}")
    for left, right in ALWAYS:
        one, two, other = _write(draw, left, right, "{z}")
        elsewhere = draw.choice(inside(other, *_window(draw, -40, 40)))
        yield _row(False, f"{elsewhere}*({one})", f"{elsewhere}*({two})")


def together(draw: random.Random) -> Iterator[Row]:
    """Yield products of windows of several compositions, and windows between two states."""
    for _ in range(12):
        chosen = draw.sample(RANGES, draw.choice((2, 2, 3)))
        names = _write(draw, *(text for text, _, _ in chosen), "{z}")
        *looks, rest = names
        spans = [_window(draw, low, high) for _, low, high in chosen]
        if not _are_apart(looks):
            continue
        parts = [draw.choice(inside(f, *span)) for f, span in zip(looks, spans, strict=True)]
        turned = [draw.choice(inside(f, *span)) for f, span in zip(looks, spans, strict=True)]
        yield _row(True, f"{rest} + {'*'.join(parts)}", rest)
        yield _row(False, f"{rest} + {'*'.join(parts)}", f"{rest} + {'*'.join(turned)}")
    for _ in range(8):
        between, rest = _write(draw, draw.choice(BETWEEN), "{z}")
        shapes = draw.choice(SHAPES)(between, *_window(draw, -1, 1))
        yield _row(True, f"{rest} + {draw.choice(shapes)}", rest)
        yield _row(False, *(f"{rest} + {shape}" for shape in draw.sample(shapes, 2)))


BETWEEN = (
    "({a} - {b})",
    "(acos(cos({a})) - {y})",
    "(sqrt({x}**2) - sqrt({y}**2))",
    "(atan2(sin({a}), cos({a})) + {b})",
    "(log(1 + {x}**2) - {y})",
    "(asin(sin({a})) - acos(cos({b})))",
    "({x} - floor({y}))",
)


def _are_apart(looks: list[str]) -> bool:
    """Return True if expressions share no name, so that their windows can overlap."""
    names = [{str(name) for name in sp.sympify(text).free_symbols} for text in looks]
    return sum(map(len, names)) == len(set().union(*names))


def empty(draw: random.Random) -> Iterator[Row]:
    """Yield empty windows."""
    for text, low, high in EMPTY:
        f, rest = _write(draw, text, "{z}")
        span = sp.Rational(str(low)), sp.Rational(str(high))
        yield _row(False, f"{rest} + {draw.choice(draw.choice(SHAPES)(f, *span))}", rest)
    for text, low, high in draw.sample(RANGES, 6):
        f, rest = _write(draw, text, "{z}")
        start, stop = _window(draw, low, high)
        yield _row(False, f"{rest} + Piecewise((1, ({f} > {stop}) & ({f} < {start})), (0, True))", rest)


GROUPS: dict[str, Callable[[random.Random], Iterator[Row]]] = {
    "windows": windows,
    "windows of nested functions": nested,
    "functions undone in a window": undone,
    "windows together": together,
    "empty windows": empty,
}
