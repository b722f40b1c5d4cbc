# SPDX-License-Identifier: Apache-2.0
"""Pairs that are equal or differ only near one drawn state, in a window around a function's value there.

A window is thus never empty by mistake, whatever is composed, and a pair that differs does so at a known point. Beside
each such pair stands an equal one, in which the same window is written in another way.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator, Mapping

import sympy as sp

from tests.codegen.diff.documents import Version, version
from tests.codegen.diff.windows import inside, ramps, tents

Row = tuple[str, bool, Version, Version]
_COUNT, _FEW = 25, 4
"""Pairs of either kind in one drawing, and those in windows that few lines meet."""
_DIGITS = 40
_NAMES = ("a", "phi", "x", "y", "v", "w")

LEAVES = (
    "{n}", "{n}", "{n} + {m}", "{n} - {m}", "{n}*{m}", "2*{n} - {m}/3", "{n}**2 - {m}", "{n}*(1 + {m}**2)/5",
    "k*{n} + {m}",
)  # fmt: skip
UNARY = (
    "acos(cos({u}))", "asin(sin({u}))", "atan({u})", "sqrt(1 + ({u})**2)", "sqrt(Abs({u}))", "log(1 + ({u})**2)",
    "log(Abs({u}) + 1)", "exp(-({u})**2/9)", "tanh({u})", "Abs({u})", "acosh(2 + ({u})**2)", "asinh({u})", "cos({u})",
    "({u}) - floor({u})", "Mod({u}, 3)", "atan2(sin({u}), cos({u}) + 2)", "Max({u}, 0)", "acos(tanh({u}))",
    "floor({u})/7 + {n}", "sign({u})*log(2 + Abs({u}))", "asin(({u})/sqrt(4 + ({u})**2))",
)  # fmt: skip
BINARY = (
    "atan2({u}, {v})", "sqrt(({u})**2 + ({v})**2)", "({u})*({v})", "({u}) + {v}", "Max({u}, {v})",
    "({u})/(1 + ({v})**2)", "acos(cos(({u}) - ({v})))", "log(exp({u}) + exp({v}))",
    "Piecewise(({u}, {n} > 0), ({v}, True))",
)  # fmt: skip
BASES = ("z", "z*{n}", "{n}", "z - cos({n})")
TERMS = ("1", "{n}", "cos({n})", "k", "{n}*{m}/100", "Rational(1, 10**6)", "1/(1 + {n}**2)")


class Place:
    """Functions of one draw, and the state around which their windows lie."""

    def __init__(self, draw: random.Random) -> None:
        self.draw = draw
        spans = {"a": 6.0, "phi": 1.5}
        self.at = {n: sp.Rational(f"{draw.uniform(-1, 1) * spans.get(n, 3.0):.3f}") for n in _NAMES}
        self.at |= {"k": sp.Rational(draw.randrange(1, 9), 2), "z": sp.Integer(1)}

    def names(self) -> Mapping[str, str]:
        """Draw two states."""
        return dict(zip("nm", self.draw.sample(_NAMES, 2), strict=True))

    def fill(self, text: str, **parts: str) -> str:
        """Write a drawn text over two drawn states."""
        return text.format(**self.names(), **parts)

    def function(self, depth: int) -> str:
        """Return a function of the states with its value at the state, smooth nearby."""
        while True:
            text = self._function(depth)
            if self.is_smooth(text):
                return text

    def _function(self, depth: int) -> str:
        if depth == 0:
            return self.fill(self.draw.choice(LEAVES))
        if self.draw.random() < 0.6:
            return self.fill(self.draw.choice(UNARY), u=self._function(depth - 1))
        return self.fill(self.draw.choice(BINARY), u=self._function(depth - 1), v=self._function(depth - 1))

    def value(self, text: str, **moved: sp.Expr) -> sp.Expr | None:
        """Return the value of a text at the place, None without a real value."""
        point = {**self.at, **moved}
        value = sp.sympify(text, locals={n: sp.Symbol(n, real=True) for n in point})
        value = value.subs({sp.Symbol(n, real=True): x for n, x in point.items()}).evalf(_DIGITS)
        return value if value.is_Float or value.is_Rational else None

    def is_smooth(self, text: str) -> bool:
        """Return True if values near the state are close to each other but not all equal."""
        here, step = self.value(text), sp.Rational(1, 10**12)
        if here is None:
            return False
        beside = [self.value(text, **{n: self.at[n] + s * step}) for n in _NAMES for s in (1, -1)]
        if any(value is None for value in beside):
            return False
        moves = [abs(value - here) for value in beside if value is not None]
        return max(moves) < 10**-8 and max(moves) > 10**-15

    def range(self, text: str) -> tuple[sp.Rational, sp.Rational]:
        """Draw a narrow range around the value at the place."""
        digits = self.draw.randrange(3, 9)
        width = sp.Rational(1, 10**digits)
        value = self.value(text)
        assert value is not None
        middle = sp.Rational(str(sp.N(value, _DIGITS))).limit_denominator(10 ** (digits + 3))
        low = middle - width * sp.Rational(self.draw.randrange(2, 9), 10)
        return low, low + width

    def shapes(self) -> list[str]:
        """Return expressions that are nonzero only near the state."""
        f = self.function(self.draw.choice((1, 1, 2, 2, 3)))
        kind = self.draw.choice((inside, inside, inside, ramps, tents))
        return kind(f, *self.range(f))

    def discs(self) -> list[str]:
        """Return an expression that is nonzero only where two functions are both near their values at the state."""
        f, g = self.function(1), self.function(self.draw.choice((0, 1)))
        (low, high), (below, above) = self.range(f), self.range(g)
        c, d, r = (low + high) / 2, (below + above) / 2, (high - low) / 2
        s = (above - below) / 2
        return [
            f"Piecewise((1, (({f}) - ({c}))**2/({r**2}) + (({g}) - ({d}))**2/({s**2}) < 1), (0, True))",
            f"(sign(1 - (({f}) - ({c}))**2/({r**2}) - (({g}) - ({d}))**2/({s**2})) + 1)/2",
        ]

    def pairs(self, shapes: list[str]) -> Iterator[Row]:
        """Yield a pair that differs near the state only, and an equal pair."""
        term, base = (self.fill(self.draw.choice(texts)) for texts in (TERMS, BASES))
        other = self.function(1)
        one, two = self.draw.sample(shapes, 2)
        kind = self.draw.randrange(3)
        if kind == 0:
            yield _row(True, base, f"{base} + ({term})*{one}")
        elif kind == 1:
            yield _row(True, f"{base} + {other}", f"({other})*(1 + {one}) + {base}")
        else:
            yield _row(True, f"{base} + {one}*({term})", f"{base} + {two}*({term})*Rational(1000001, 1000000)")
        yield _row(False, f"{base} + ({term})*{one}", f"{two}*({term}) + {base}")


def _row(differs: bool, old: str, new: str) -> Row:
    return f"{old} | {new}", differs, version(f"f: {old}"), version(f"f: {new}")


def near_a_place(draw: random.Random) -> Iterator[Row]:
    """Yield pairs of both kinds."""
    for _ in range(_COUNT):
        place = Place(draw)
        yield from place.pairs(place.shapes())


def in_a_disc(draw: random.Random) -> Iterator[Row]:
    """Yield pairs with windows that two functions bound together."""
    for _ in range(_FEW):
        place = Place(draw)
        yield from place.pairs(place.discs())


GROUPS: dict[str, Callable[[random.Random], Iterator[Row]]] = {
    "windows near a drawn state": near_a_place,
    "windows of two functions at once": in_a_disc,
}
