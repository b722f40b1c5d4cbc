# SPDX-License-Identifier: Apache-2.0
"""Random expressions with functions that the field cannot decide, rewritten or with a small difference.

Each part is drawn together with another text of the same function. A pair that differs has one thing more on its new
side: a bump that no ordinary point meets, a moved limit, another number, or a term in names that the old side lacks.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator

import sympy as sp

from tests.codegen.diff.documents import Version, version
from tests.codegen.diff.windows import inside

Row = tuple[str, bool, Version, Version]
Texts = tuple[str, str]
"""A function in two forms."""
_COUNT = 20
"""Pairs of either kind in one drawing."""

INNER = ("{a}", "{x}", "{a} + {b}", "{a} - {b}", "{x}*{y}", "{x} + 2*{y}", "m*{x}", "{x} - k*{y}", "{x}**2 - {y}")
"""Arguments of the inexact functions."""

WRITTEN: tuple[tuple[str, ...], ...] = (
    ("acos(cos({u}))", "acos(1 - 2*sin(({u})/2)**2)", "Abs(atan2(sin({u}), cos({u})))"),
    ("acos(cos({u}))", "Abs({u} - 2*pi*floor(({u})/(2*pi) + Rational(1, 2)))"),
    ("asin(sin({u}))", "pi/2 - acos(sin({u}))"),
    ("atan({u})", "asin(({u})/sqrt(1 + ({u})**2))", "atan2({u}, 1)"),
    ("atan({u}) + atan(1/({u}))", "pi/2*sign({u})"),
    ("atan2({u}, {v})", "-atan2(-({u}), {v})"),
    ("log(1 + ({u})**2)", "2*log(sqrt(1 + ({u})**2))", "-log(1/(1 + ({u})**2))"),
    ("log(2) + log(({u})**2 + 1)", "log(2*({u})**2 + 2)"),
    ("log(exp({u}) + exp({v}))", "({u}) + log(1 + exp(({v}) - ({u})))"),
    ("sqrt(1 + ({u})**2)", "Abs({u})*sqrt(1 + 1/({u})**2)"),
    ("sqrt(({u})**2)", "Abs({u})", "Max({u}, -({u}))", "({u})*sign({u})"),
    ("sign({u})*sqrt(Abs({u}))", "({u})/sqrt(Abs({u}))"),
    ("floor({u})", "-ceiling(-({u}))", "({u}) - Mod({u}, 1)"),
    ("floor(2*({u}))", "floor({u}) + floor({u} + Rational(1, 2))"),
    ("Mod({u}, 3)", "3*Mod(({u})/3, 1)", "({u}) - 3*floor(({u})/3)"),
    ("acosh(1 + ({u})**2)", "2*asinh(Abs({u})/sqrt(2))"),
    ("asinh({u})", "log({u} + sqrt(1 + ({u})**2))"),
    ("atanh(tanh({u}))", "log(exp({u}))"),
    ("asin(({u})/(1 + ({u})**2)) + acos(({v})/(2 + ({v})**2))",
     "pi/2 + asin(({u})/(1 + ({u})**2)) - asin(({v})/(2 + ({v})**2))"),
    ("exp(-({u})**2)", "1/exp(({u})**2)"),
    ("tanh({u})", "1 - 2/(exp(2*({u})) + 1)"),
    ("sign({u})", "2*Piecewise((1, {u} > 0), (0, True)) - 1", "Piecewise((-1, {u} < 0), (1, True))"),
    ("Max({u}, {v})", "({u} + {v} + Abs(({u}) - ({v})))/2", "-Min(-({u}), -({v}))"),
)  # fmt: skip
"""Texts of one function each."""

WIDE = tuple(texts for texts in WRITTEN if texts[0] in ("acos(cos({u}))", "atan({u})", "asinh({u})", "tanh({u})"))
"""Pairs of expressions with values between zero and one."""

CLAMPS = (
    "Min({h}, Max({l}, {f}))",
    "Max({l}, Min({h}, {f}))",
    "Piecewise(({l}, {f} < {l}), ({h}, {f} > {h}), ({f}, True))",
    "(Abs({f} - ({l})) - Abs({f} - ({h})) + ({l}) + ({h}))/2",
)
BOTH = (
    "{p}*{q}",
    "Min({p}, {q})",
    "(Max(0, {p} + {q} - 1))",
)
"""Expressions equal to one where two indicators are."""
BUMPS = (
    "(tanh({s}*({f} - {c})) - tanh({s}*({f} - {d})))",
    "exp(-{s}**2*({f} - {c})**2)",
    "exp(-{s}*Abs({f} - {c}))",
    "1/(1 + {s}**2*({f} - {c})**2)**{n}",
    "1/cosh({s}*({f} - {c}))",
    "exp(-(({f} - {c})*{s})**4)",
)
"""Expressions that are zero outside a place of width 1/s."""


class Writer:
    """Generator of random expressions in some names."""

    def __init__(self, draw: random.Random) -> None:
        self.draw = draw
        names = [*draw.sample(("a", "b", "phi", "theta"), 2), *draw.sample(("x", "y", "v", "w"), 3)]
        self.names = dict(zip("abxyz", names, strict=True))

    def inner(self) -> str:
        """Return a random argument of a function."""
        return self.draw.choice(INNER).format(**self.names)

    def function(self) -> Texts:
        """Return an inexact function of the names or of another inexact function."""
        u, v = self.inner(), self.inner()
        if self.draw.random() < 0.2:
            u = f"{self.draw.choice(WRITTEN)[0].format(u=u, v=v)} + {self.names['z']}"
        first, second = self.draw.sample(self.draw.choice(WRITTEN), 2)
        return f"({first.format(u=u, v=v)})", f"({second.format(u=u, v=v)})"

    def window(self, of: Texts) -> Texts:
        """Return an expression that is one in a narrow range of a function's values."""
        low = sp.Rational(f"{self.draw.uniform(0.1, 1.2):.4f}")
        high = low + sp.Rational(1, 10 ** self.draw.randrange(3, 8))
        number = self.draw.randrange(len(inside("f", low, high)))
        other = self.draw.randrange(len(inside("f", low, high)))
        return f"({inside(of[0], low, high)[number]})", f"({inside(of[0], low, high)[other]})"

    def clamp(self, of: Texts) -> Texts:
        """Write a saturation."""
        low, high = sorted(sp.Rational(n, 4) for n in self.draw.sample(range(-8, 9), 2))
        first, second = (
            text.format(f=f, l=f"({low})", h=f"({high})")
            for text, f in zip(self.draw.sample(CLAMPS, 2), of, strict=True)
        )
        return first, second

    def both(self, one: Texts, two: Texts) -> Texts:
        """Return an expression that is one where two windows overlap."""
        first, second = self.draw.sample(BOTH, 2)
        return first.format(p=one[0], q=two[0]), second.format(p=one[1], q=two[1])

    def part(self) -> Texts:
        """Return a function or a combination of two functions."""
        kind = self.draw.randrange(6)
        f = self.function()
        if kind == 1:
            return self.clamp(f)
        if kind == 2:
            return self.window(f)
        if kind == 3:
            return self.both(self.window(f), self.window(self.function()))
        if kind == 4:
            g = self.function()
            return f"({f[0]} + {g[0]})", f"({g[1]} + {f[1]})"
        return f

    def whole(self) -> Texts:
        """Return a product in two orders."""
        f, g = self.part(), self.draw.choice(("{z}", "m", "({x} + m)", "cos({a})", "sqrt(1 + {y}**2)*{x}"))
        g = g.format(**self.names)
        return f"{g}*{f[0]} + {self.names['z']}", f"{self.names['z']} + {f[1]}*{g}"

    def bump(self, names: str) -> str:
        """Return an expression that is zero except in a narrow range."""
        centre = sp.Rational(f"{self.draw.uniform(-2, 2):.4f}")
        steep = 10 ** self.draw.randrange(4, 8)
        return self.draw.choice(BUMPS).format(
            s=steep, f=names, c=f"({centre})", d=f"({centre + sp.Rational(1, steep)})", n=self.draw.randrange(2, 9)
        )


def _row(differs: bool, texts: Texts) -> Row:
    old, new = texts
    return f"{old} | {new}", differs, version(f"f: {old}"), version(f"f: {new}")


def equal(draw: random.Random) -> Iterator[Row]:
    """Yield functions in two forms, with zero terms in names that one side lacks."""
    for number in range(_COUNT):
        writer = Writer(draw)
        old, new = writer.whole()
        if number % 5 == 0:
            left, right = draw.choice(WRITTEN[:5]), "q1"
            first, second = (text.format(u=right, v=right) for text in draw.sample(left, 2))
            new = f"{new} + {draw.choice(('m', 'y'))}*(({first}) - ({second}))"
        yield _row(False, (old, new))


def _bumped(writer: Writer, old: str, new: str) -> Texts:
    """Add a bump in one or two names, in a function's argument, or in a name that the old side lacks."""
    draw = writer.draw
    f = draw.choice((*writer.names.values(), writer.inner(), writer.inner(), "q1", "q1*x"))
    bump = f"{sp.Rational(1, draw.choice((1, 1000)))}*{writer.bump(f)}"
    if draw.random() < 0.3:
        bump = f"{writer.bump('J + q1')}*{bump}"
    return old, f"{new} + {bump}"


def _bumped_inside(writer: Writer, old: str, new: str) -> Texts:
    """Add a bump inside a function or a step."""
    draw, u = writer.draw, writer.inner()
    f = draw.choice((*writer.names.values(), writer.inner(), "q1"))
    texts = draw.choice(WRITTEN)
    v, more = writer.inner(), f"{u} + {writer.bump(f)}/{draw.choice((10, 1000))}"
    first, second = draw.choice(texts), draw.choice(texts)
    return f"{old} + {first.format(u=u, v=v)}", f"{new} + {second.format(u=more, v=v)}"


def _shifted(writer: Writer, old: str, new: str) -> Texts:
    """Add a saturation with a moved limit, or a moved step."""
    draw = writer.draw
    f = tuple(text.format(u=writer.names["a"], v=writer.names["x"]) for text in draw.sample(draw.choice(WIDE), 2))
    limit = sp.Rational(f"{draw.uniform(0.1, 0.9):.4f}")
    moved = limit + sp.Rational(1, 10 ** draw.randrange(3, 9))
    text = draw.choice(("Max(-2, Min({f}, {c}))", "Piecewise((1, {f} > {c}), (0, True))", "sign({f} - {c})"))
    z = writer.names["z"]
    return f"{old} + {z}*{text.format(f=f[0], c=limit)}", f"{new} + {text.format(f=f[1], c=moved)}*{z}"


def _one_sided(writer: Writer, old: str, new: str) -> Texts:
    """Add a term that acts in a window or beyond a limit of names that the old side lacks."""
    u = writer.draw.choice(("q1", "J*q1", "q1 + J", "r - J"))
    f = writer.draw.choice(WRITTEN)[0].format(u=u, v="q1 - 2*J")
    if writer.draw.random() < 0.5:
        return old, f"{new} + {writer.window((u, u))[0]}"
    return old, f"{new} + Max(0, {f} - {writer.draw.choice(('1', 'Rational(1, 2)'))})/100"


def _numbered(writer: Writer, old: str, new: str) -> Texts:
    """Add a function with another constant."""
    f, part = writer.function(), sp.Rational(1, 10 ** writer.draw.randrange(3, 10))
    return f"{old} + {f[0]}", f"{new} + {1 + part}*{f[1]}"


EDITS: tuple[Callable[[Writer, str, str], Texts], ...] = (
    _bumped, _bumped, _bumped_inside, _shifted, _one_sided, _numbered
)  # fmt: skip


def different(draw: random.Random) -> Iterator[Row]:
    """Yield functions in two forms with a small difference."""
    for number in range(_COUNT):
        writer = Writer(draw)
        yield _row(True, EDITS[number % len(EDITS)](writer, *writer.whole()))


GROUPS: dict[str, Callable[[random.Random], Iterator[Row]]] = {
    "inexact, written anew": equal,
    "inexact, small difference": different,
}
