# SPDX-License-Identifier: Apache-2.0
"""Hundreds of pairs of different or equal versions, by class, drawn with fixed seeds.

Each class is one that a comparison by random points gets wrong when it is careless: what lies beyond the range that is
drawn, between two points, in a joint state of several branches, or in a field that nobody compares.
"""

from __future__ import annotations

import functools
import itertools
import random
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import sympy as sp

from mehvar.base.manifest import Advice, Choice, Manifest, Output, Quantity, manifest_text, read_manifest
from mehvar.codegen.diff import Document
from tests.codegen.diff import mixed, places, windows
from tests.codegen.diff.documents import Version, version

PENDULUM = Path(__file__).parents[2] / "runtime" / "pendulum"
ANGLES = ("a", "b", "phi", "theta", "q1")
STATES = ("x", "y", "z", "v", "w")
PARAMETERS = ("m", "l", "k", "J", "r")
SEED = 1702
"""Seed; fixed, so that a pair keeps its name and answer."""


@dataclass(frozen=True)
class Pair:
    """Two versions of a model, read at use, and the known answer."""

    group: str
    name: str
    differs: bool
    versions: tuple[Version, Version]

    @functools.cached_property
    def old(self) -> Document:
        return self.versions[0]()

    @functools.cached_property
    def new(self) -> Document:
        return self.versions[1]()


@functools.cache
def pairs(seed: int = SEED) -> tuple[Pair, ...]:
    """Return the corpus of a seed, cached."""
    return tuple(
        Pair(group, f"{group} {number}: {label}", differs, (old, new))
        for group, write in GROUPS.items()
        for number, (label, differs, old, new) in enumerate(write(random.Random(f"{seed} {group}")), start=1)
    )


Row = tuple[str, bool, Version, Version]


def _text(differs: bool, old: str, new: str) -> Row:
    old, new = (f"f: {text}" if ":" not in text else text for text in (old, new))
    return f"{old} | {new}", differs, version(old), version(new)


def _angles(draw: random.Random) -> Iterator[Row]:
    for angle in ANGLES:
        s, p = draw.choice(STATES), draw.choice(PARAMETERS)
        wrapped = f"atan2(sin({angle}), cos({angle}))"
        yield _text(True, f"{p}*{wrapped}", f"{p}*{angle}")
        yield _text(True, f"Max(-{p}, Min({wrapped} + {s}, {p}))", f"Max(-{p}, Min({angle} + {s}, {p}))")
        yield _text(False, wrapped, f"atan2(2*sin({angle}/2)*cos({angle}/2), 1 - 2*sin({angle}/2)**2)")
    for first, second in itertools.pairwise(ANGLES):
        error = f"({first} - {second})"
        s = draw.choice(STATES)
        yield _text(True, f"{s}*atan2(sin{error}, cos{error})", f"{s}*{error}")
        yield _text(True, f"e = atan2(sin{error}, cos{error})\nf: {s} - e", f"e = {error}\nf: {s} - e")
        yield _text(False, f"{s}*sin(atan2(sin{error}, cos{error}))", f"{s}*(sin({first})*cos({second})"
                    f" - cos({first})*sin({second}))")  # fmt: skip
        yield _text(False, f"atan2({s}*sin{error}, {s}*cos{error})", f"atan2({s}*(sin({first})*cos({second}) - "
                    f"cos({first})*sin({second})), {s}*cos{error})")  # fmt: skip
    yield _text(True, "acos(cos(a))", "Abs(a)")
    yield _text(True, "asin(sin(phi))*x", "phi*x")
    yield _text(True, "atan(tan(theta))", "theta")
    yield _text(True, "Mod(a + pi, 2*pi) - pi", "a")
    yield _text(True, "x*atan2(sin(2*a), cos(2*a))", "2*x*atan2(sin(a), cos(a))")
    yield _text(True, "atan2(y, x)", "atan(y/x)")
    yield _text(True, "atan2(sin(m*x), cos(m*x))", "m*x")
    yield _text(False, "acos(cos(a))", "acos(1 - 2*sin(a/2)**2)")
    yield _text(True, "x*cos(2*acos(y))", "x*(2*y**2 - 1)")
    yield _text(False, "sin(phi + 2*pi)*x + Abs(y)", "sin(phi)*x + Max(y, -y)")


def _roots(draw: random.Random) -> Iterator[Row]:
    arguments = [*ANGLES, "2*a", "a + b", "phi - theta", "q1/3", "a + 2*b"]
    for argument in arguments:
        s = draw.choice(STATES)
        half = f"({argument})/2"
        yield _text(True, f"{s}*sqrt((1 + cos({argument}))/2)", f"{s}*cos({half})")
        yield _text(True, f"{s} + sqrt((1 - cos({argument}))/2)", f"{s} + sin({half})")
        yield _text(False, f"{s}*sqrt((1 + cos({argument}))/2)", f"{s}*Abs(cos({half}))")
    for first, second in zip(STATES, STATES[1:] + STATES[:1], strict=True):
        n = draw.randrange(2, 9)
        square = f"{first}**2 + {2 * n}*{first}*{second} + {n * n}*{second}**2"
        yield _text(True, f"sqrt({square})", f"{first} + {n}*{second}")
        yield _text(False, f"sqrt({square})", f"Abs({first} + {n}*{second})")
        far = 10 ** draw.randrange(3, 10)
        yield _text(True, f"sqrt({first}**2 + {2 * far}*{first} + {far}**2)*{second}", f"({first} + {far})*{second}")
    for first, second in itertools.pairwise(PARAMETERS):
        square = f"{first}**2 + 2*{first}*{second} + {second}**2"
        yield _text(False, f"x*sqrt({square})", f"x*{first} + x*{second}")
        yield _text(True, f"x*sqrt({first}**2 - 2*{first}*{second} + {second}**2)", f"x*{first} - x*{second}")
    yield _text(True, "sqrt(1 - sin(a)**2)", "cos(a)")
    yield _text(False, "sqrt(1 - sin(a)**2)", "Abs(cos(a))")
    yield _text(False, "sqrt(x**2 + y**2)*sqrt(x**2 + y**2)", "x**2 + y**2")


def _regions(draw: random.Random) -> Iterator[Row]:
    for number in range(12):
        x, y, z = draw.sample(STATES, 3)
        a, b = draw.randrange(1, 60), draw.randrange(1, 60)
        narrow = sp.Rational(1, draw.choice((1, 10, 1000, 10**6)))
        window = f"({x} > {a}) & ({x} < {a + narrow}) & ({y} > {b}) & ({y} < {b + narrow})"
        product = f"Max(0, {x} - {a})*Max(0, {y} - {b})"
        saturated = f"Max(-{a}, Min({x}, {a}))*Max(-{b}, Min({y}, {b}))"
        yield _text(True, f"{z} + {product}", z)
        yield _text(True, f"{z} + Piecewise((1, {window}), (0, True))", z)
        yield _text(True, saturated, f"{saturated} + Max(0, {x} - {a + 1})*Max(0, {y} - {b + 1})*{z}")
        yield _text(False, f"{saturated}*({z} + 1)", f"Min({b}, Max({y}, -{b}))*{z}*Min({a}, Max({x}, -{a}))"
                    f" + Min({b}, Max({y}, -{b}))*Min({a}, Max({x}, -{a}))")  # fmt: skip
        if number % 3 == 0:
            yield _text(True, f"{z} + {product}*Max(0, -{z} - {b})", z)
            tent = f"Max(0, {x} - {a}) - 2*Max(0, {x} - {a + narrow / 2}) + Max(0, {x} - {a + narrow})"
            yield _text(True, f"{z} + {tent}", z)
            yield _text(True, f"Piecewise(({x}, (Abs({y}) < 10**10) & (Abs({z}) < {b})), (0, True))",
                        f"Piecewise(({x}, (Abs({y}) < 10**11) & (Abs({z}) < {b})), (0, True))")  # fmt: skip
            yield _text(False, f"Max(0, {x} - {a})*Max(0, {a} - {x}) + {z}", z)
            yield _text(False, f"Max({x}, {y}) + Min({x}, {y})", f"{x} + {y}")
            yield _text(False, f"Piecewise(({z}, ({x} > {a}) & ({y} > {b})), (0, True))",
                        f"Piecewise((0, ({x} <= {a}) | ({y} <= {b})), ({z}, True))")  # fmt: skip
            yield _text(False, f"Piecewise((Piecewise(({z}, {y} > {b}), (0, True)), {x} > {a}), (0, True))",
                        f"Piecewise(({z}, ({x} > {a}) & ({y} > {b})), (0, True))")  # fmt: skip
    yield _text(False, "Max(x, y, z)", "Max(Max(x, y), Max(y, z))")
    yield _text(False, "Piecewise((sin(x)/x, Ne(x, 0)), (1, True))", "Piecewise((1, Eq(x, 0)), (sin(x)/x, True))")
    yield _text(True, "Piecewise((y, Eq(x, 1)), (z, True))", "Piecewise((2*y, Eq(x, 1)), (z, True))")
    yield _text(False, "Abs(x**2 + m)*Abs(y)", "(x**2 + m)*Max(y, -y)")


def _table(x: str, knots: list[sp.Rational], values: list[sp.Rational], slope: bool = True) -> str:
    """Interpolate linearly between knots, constant outside."""
    pieces = [f"({values[0]}, {x} < {knots[0]})"]
    for k in range(len(knots) - 1):
        a, b, p, q = knots[k], knots[k + 1], values[k], values[k + 1]
        steep = f"{p} + ({x} - ({a}))*({(q - p) / (b - a)})"
        weighted = f"(({b} - {x})*({p}) + ({x} - ({a}))*({q}))/({b - a})"
        line = steep if slope else weighted
        pieces.append(f"({line}, {x} < {b})")
    return f"Piecewise({', '.join(pieces)}, ({values[-1]}, True))"


def _tables(draw: random.Random) -> Iterator[Row]:
    for relative in ("1e-9", "1e-6", "1e-3", "1e-2", "0.1", "0.5"):
        s, t = draw.sample(STATES, 2)
        place = sp.Rational(str(round(draw.uniform(0.2, 50), 3)))
        moved = place * (1 + sp.Rational(relative))
        p = draw.choice(PARAMETERS)
        yield _text(True, f"Piecewise((1, {s} > {place}), (2, True))", f"Piecewise((1, {s} > {moved}), (2, True))")
        yield _text(True, f"Piecewise(({t}, {s}**2 < {place}*{p}), (0, True))",
                    f"Piecewise(({t}, {s}**2 < {moved}*{p}), (0, True))")  # fmt: skip
        yield _text(True, f"{t}*floor({s})", f"{t}*floor({s} + {relative})")
        yield _text(True, f"{t}*ceiling({p}*{s})", f"{t}*ceiling({p}*{s} - {relative})")
        yield _text(True, f"{t}*sign({s} - {place})", f"{t}*sign({s} - {moved})")
        yield _text(True, f"Piecewise(({t}, ({s} > {place}) & ({p} > {place})), (0, True))",
                    f"Piecewise(({t}, ({s} > {place}) & ({p} > {moved})), (0, True))")  # fmt: skip
        yield _text(False, f"Piecewise(({t}, 3*{s} > {3 * place}), (0, True))",
                    f"Piecewise((0, {s} <= {place}), ({t}, True))")  # fmt: skip
    for first in (1, 1, 5, 20, 300):
        s, t = draw.sample(STATES, 2)
        knots = [sp.Rational(first)]
        for _ in range(draw.randrange(2, 7)):
            knots.append(knots[-1] + sp.Rational(draw.randrange(1, 40), 20))
        values = [sp.Rational(draw.randrange(1, 500), 100) for _ in knots]
        edited = draw.randrange(1, len(knots))
        other = [v * sp.Rational(101, 100) if k == edited else v for k, v in enumerate(values)]
        shifted = [v + sp.Rational(1, 100) if k == edited else v for k, v in enumerate(knots)]
        plain = _table(s, knots, values)
        yield _text(True, f"{t}*{plain}", f"{t}*{_table(s, knots, other)}")
        yield _text(True, f"{t} + {plain}", f"{t} + {_table(s, shifted, values)}")
        yield _text(False, f"{t}*{plain}", f"{t}*{_table(s, knots, values, slope=False)}")


def _limits(draw: random.Random) -> Iterator[Row]:
    for _ in range(5):
        s, t = draw.sample(STATES, 2)
        p, far = draw.choice(PARAMETERS), 10 ** draw.randrange(7, 40)
        tiny = sp.Rational(1, 10 ** draw.randrange(20, 90))
        yield _text(True, f"Max({s}, -{far})", f"Max({s}, -{10 * far})")
        yield _text(True, f"{t}*Min({s}*{p}, {far})", f"{t}*{s}*{p}")
        yield _text(True, f"Abs({s} + {tiny})", f"Abs({s})")
        yield _text(True, f"{t} + {tiny}*Max({s}, 0)", t)
        yield _text(False, f"Max(-{far}, Min({s}, {far}))*({t} + {p})",
                    f"Max(-{far}, Min({s}, {far}))*{t} + {p}*Max(-{far}, Min({s}, {far}))")  # fmt: skip
        yield _text(False, f"Max(-{far}, Min({s}, {far}))", f"Min({far}, Max({s}, -{far}))")
    bounds = {"role": "parameter", "sign": "real", "bounds": "[0, 3)"}
    for name in ("r", "k", "J"):
        yield (f"bounded {name}", False, version(f"f: Abs({name} + 1)*x", **{name: bounds}),
               version(f"f: ({name} + 1)*x", **{name: bounds}))  # fmt: skip
        yield (f"beyond the bound of {name}", True, version(f"f: Abs({name} - 2)*x", **{name: bounds}),
               version(f"f: (2 - {name})*x", **{name: bounds}))  # fmt: skip
        yield (f"bounds of {name}", True, version(f"f: {name}*x", **{name: bounds}),
               version(f"f: {name}*x", **{name: {**bounds, "bounds": "[0, 4)"}}))  # fmt: skip


PARTIAL = (
    ("sqrt({})", "({})**2"),
    ("log({})", "exp({})"),
    ("acos({})", "cos({})"),
    ("asin({})", "sin({})"),
    ("acosh({} + 2)", "cosh({}) - 2"),
    ("atanh({})", "tanh({})"),
)
"""Functions without a value on open sets, and their inverses."""


def _domains(draw: random.Random) -> Iterator[Row]:
    for there, back in PARTIAL:
        s, t, u = draw.sample(STATES, 3)
        p, n = draw.choice(PARAMETERS), draw.randrange(2, 60)
        for inner in (f"({s} + {n}*{t})", f"({p}*{s} - {n})", f"({s}**2 - {n})"):
            part = f"d = {there.format(inner)}\n"
            yield _text(True, f"{part}f: {u}*({back.format('d')})", f"f: {u}*{inner}")
            yield _text(
                False, f"{part}f: {u}*({back.format('d')} + {p})", f"{part}f: {u}*{p} + ({back.format('d')})*{u}"
            )
    for _ in range(4):
        x, y, z = draw.sample(STATES, 3)
        p, q = draw.sample(PARAMETERS, 2)
        n = draw.randrange(2, 60)
        near = n + sp.Rational(1, 10 ** draw.randrange(1, 9))
        yield _text(True, f"log({x}**2)*{y}", f"2*{y}*log({x})")
        yield _text(True, f"{z}*sqrt({x}*{y})", f"{z}*sqrt({x})*sqrt({y})")
        yield _text(True, f"Piecewise(({z}, {x} > {n}))", z)
        yield _text(True, f"Piecewise(({z}, {x} > {n}))", f"Piecewise(({z}, {x} > {near}))")
        yield _text(True, f"d = sqrt({x} - {n})\ne = sqrt({x} - {near})\nf: {z} + d**2 - {x}", f"d = sqrt({x} - {n})"
                    f"\ne = sqrt({x} - {near})\nf: {z} + e**2 - {x} + {near - n}")  # fmt: skip
        yield _text(True, f"Piecewise((sqrt({x}), {x} > -{n}), ({y}, True))",
                    f"Piecewise((sqrt(Max({x}, 0)), {x} > -{n}), ({y}, True))")  # fmt: skip
        yield _text(False, f"log({x}**2)*{y}", f"2*{y}*log(Abs({x}))")
        yield _text(False, f"sqrt({p}*{q}*{x})*{y}", f"sqrt({p})*{y}*sqrt({q})*sqrt({x})")
        yield _text(False, f"log({p}*{x}/{q})", f"log({p}) + log({x}) - log({q})")
        yield _text(
            False, f"sqrt({p}*{x}**2 + {p}*{n}*{x} + {p}*{n}**2/4)", f"sqrt({p})*Abs({x} + {sp.Rational(n, 2)})"
        )
        yield _text(False, f"{z}*sqrt({n} - {x})*sqrt({n} + {x})", f"{z}*sqrt({n * n} - {x}**2)")
        yield _text(False, f"d = asin({x})\nf: {p}*cos(d)", f"f: {p}*sqrt(1 - {x}**2)")
        yield _text(False, f"exp({y}*log({x}))", f"{x}**{y}")
        yield _text(False, f"Piecewise(({z}, {x} > {n}))", f"Piecewise(({z}, {n}*{p} < {x}*{p}))")
        yield _text(False, f"Piecewise((sqrt({x} - {n}), {x} > {n}), (0, True))", f"sqrt(Max({x}, {n}) - {n})")
        yield _text(False, f"{y}*asin({x}/sqrt({x}**2 + {p}**2))", f"{y}*atan({x}/{p})")
        yield _text(False, f"d = log({p}*{q})\nf: {x}*exp(d)", f"f: {x}*{p}*{q}")


def _hyperbolic(draw: random.Random) -> Iterator[Row]:
    for _ in range(3):
        x, y, z = draw.sample(STATES, 3)
        p, n = draw.choice(PARAMETERS), draw.randrange(2, 60)
        root = f"sqrt({x}**2 + {p}**2)"
        yield _text(False, f"{y}*asinh({x}/{p})", f"{y}*log(({x} + {root})/{p})")
        yield _text(False, f"{y} - asinh({n}*{x})", f"{y} + log(sqrt({n}**2*{x}**2 + 1) - {n}*{x})")
        yield _text(False, f"{z}*acosh({x})", f"{z}*log({x} + sqrt({x}**2 - 1))")
        yield _text(False, f"{z}*atanh({x}/{n})", f"{z}*(log({n} + {x}) - log({n} - {x}))/2")
        yield _text(False, f"{z}*sinh({p}*{x})**2", f"{z}*(exp(2*{p}*{x}) - 2 + exp(-2*{p}*{x}))/4")
        yield _text(False, f"{y}*tanh({x}/{n})", f"{y}*(1 - 2/(exp(2*{x}/{n}) + 1))")
        yield _text(True, f"{y}*asinh({x}/{p})", f"{y}*log((Abs({x}) + {root})/{p})")
        yield _text(True, f"{y}*asinh({x}/{p})", f"{y}*log(({x} + {root})/{n})")
        yield _text(True, f"{z}*acosh({x})", f"{z}*log({x} - sqrt({x}**2 - 1))")
        yield _text(True, f"{z}*atanh({x}/{n})", f"{z}*(log({n} + {x}) - log({n + 1} - {x}))/2")
        yield _text(True, f"{z}*acosh(cosh({x}))", f"{z}*{x}")


def _joint(draw: random.Random) -> Iterator[Row]:
    for size in (3, 5, 6, 7):
        names = draw.sample((*STATES, *ANGLES), size + 1)
        rest, *inputs = names
        places = [draw.randrange(1, 60) for _ in inputs]
        corner = "*".join(f"Max(0, {x} - {n})" for x, n in zip(inputs, places, strict=True))
        window = " & ".join(f"({x} > {n})" for x, n in zip(inputs, places, strict=True))
        limited = [f"Max(-{n}, Min({x}, {n}))" for x, n in zip(inputs, places, strict=True)]
        turned = [f"Min({n}, Max({x}, -{n}))" for x, n in zip(inputs, places, strict=True)]
        yield _text(True, f"{rest} + {corner}", rest)
        yield _text(True, f"{rest} + Piecewise((1, {window}), (0, True))", rest)
        yield _text(True, f"{rest}*{'*'.join(limited)}", f"{rest}*{'*'.join(turned)} + {corner}")
        yield _text(False, f"{rest}*{'*'.join(limited)}", f"{'*'.join(turned)}*{rest}")
        yield _text(False, f"{rest} - {' - '.join(limited)}", f"{rest} - ({' + '.join(turned)})")


def _steps(draw: random.Random) -> Iterator[Row]:
    for _ in range(5):
        x, y, z = draw.sample(STATES, 3)
        p, n = draw.choice(PARAMETERS), draw.choice((3, 6, 7, 9, 11, 13, 49))
        yield _text(False, f"{z}*floor({x}/{n} + 1)", f"{z}*floor({x}/{n}) + {z}")
        yield _text(False, f"Mod({x}, {n})*{z}", f"{n}*Mod({x}/{n}, 1)*{z}")
        yield _text(
            False,
            f"{n}*floor({x}/{n} + Rational(1, 2))",
            f"{x} - Mod({x} + {sp.Rational(n, 2)}, {n}) + {sp.Rational(n, 2)}",
        )
        yield _text(False, f"{y}*ceiling({x}/{n})", f"-{y}*floor(-{x}/{n})")
        yield _text(False, f"{y}*floor({p}*{x}/{n})", f"{y}*({p}*{x}/{n} - Mod({p}*{x}/{n}, 1))")
        yield _text(
            False, f"Piecewise(({y}, {x}/{n} > {p}), ({z}, True))", f"Piecewise(({y}, {x} > {n}*{p}), ({z}, True))"
        )
        yield _text(True, f"{z}*floor({x}/{n})", f"{z}*floor({x}/{n} + Rational(1, {10 ** draw.randrange(2, 9)}))")
        yield _text(True, f"Mod({x}, {n})", f"Mod({x}, {n + 1})")
        yield _text(True, f"{y}*floor({x}/{n})", f"-{y}*floor(-{x}/{n})")


def _implicit(draw: random.Random) -> Iterator[Row]:
    for _ in range(4):
        x, y = draw.sample(STATES, 2)
        p, q = draw.sample(PARAMETERS, 2)
        yield _text(False, f"0: {p}*{x} - {y}", f"0: {x} - {y}/{p}")
        yield _text(False, f"0: {p}*{x} - {y}", f"0: ({p}*{x} - {y})/({p} + {q}**2)")
        yield _text(True, f"0: {p}*{x} - {y}", f"0: ({p}*{x} - {y})*({p} - {q})")
        yield _text(True, f"0: {p}*{x} - {y}", f"0: {p}*{x} + {y}")


def _ordinary(draw: random.Random) -> Iterator[Row]:
    for _ in range(14):
        x, y, z = draw.sample(STATES, 3)
        p, q = draw.sample(PARAMETERS, 2)
        a, b = draw.sample(ANGLES, 2)
        n = draw.randrange(2, 6)
        text = draw.choice((
            f"{p}*({x} + {n}*{y})**2*sin({a}) + {q}*{z}*cos({a} - {b})",
            f"({p}*{x} + {q}*{y})/({p} + {n}*{q}*cos({a})**2) - {z}*exp(-{p}*{x})",
            f"{q}*{x}*{y}*sin({a} + {b}) + {p}*{z}**{n} - Max(-{p}, Min({x}, {p}))*{y}",
        ))  # fmt: skip
        names = {name: sp.Symbol(name, real=True) for name in (*STATES, *ANGLES)}
        names |= {name: sp.Symbol(name, positive=True) for name in PARAMETERS}
        rest = sp.sympify(text, locals=names)
        yield _text(False, text, str(sp.expand(sp.expand_trig(rest))))
        yield _text(True, text, text.replace(" + ", " - ", 1))
        yield _text(True, text, text.replace(str(n), str(n + 1), 1))
        yield _text(True, text, f"{text} + {sp.Rational(1, 10 ** draw.randrange(1, 12))}*{y}*{z}")


def manifest() -> Manifest:
    """Return the manifest of the pendulum with a value in every field."""
    plain = read_manifest(PENDULUM)
    law = plain.controllers["pd"]
    full = replace(
        plain,
        parameters=(replace(plain.parameters[0], upper=9.0), *plain.parameters[1:]),
        choices={"plant": Choice("plant", ("full", "linear"), "what moves")},
        noise=(Quantity("n_angle", "1", "of the angle"),),
        scenarios={
            name: replace(row, expect={"pd": {"peak": 20.0, "T_angle": 1.0}}) for name, row in plain.scenarios.items()
        },
        controllers={
            "pd": replace(
                law, period="m", delay="k_p", memory=(Quantity("last", "rad", "last angle"),),
                outputs=(Output("margin", "N m", "what is left", 5.0),), warnings=(Advice("soft", 1),),
                constraints=("k_p > 0",),
            )
        },
    )  # fmt: skip
    return replace(full, text=manifest_text(full))


GROUPS: dict[str, Callable[[random.Random], Iterator[Row]]] = {
    "angles": _angles,
    "roots": _roots,
    "regions": _regions,
    "tables": _tables,
    "limits": _limits,
    "domains": _domains,
    "hyperbolic": _hyperbolic,
    "joint": _joint,
    "steps": _steps,
    "implicit": _implicit,
    "ordinary": _ordinary,
    **windows.GROUPS,
    **mixed.GROUPS,
    **places.GROUPS,
}  # fmt: skip
