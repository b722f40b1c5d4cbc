# SPDX-License-Identifier: Apache-2.0
"""Rewriting an expression is never called a change; a change of one term is never called equal."""

import itertools
import math

import pytest
import sympy as sp
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from mehvar.codegen.diff import compare
from mehvar.codegen.diff.report import EquationVerdict
from tests.codegen.diff.documents import document, flipped, summands
from tests.codegen.diff.pairs import PARTIAL

NAMES = ("x", "y", "z", "m", "l", "phi", "theta")
LOCAL = {name: sp.Symbol(name, positive=True) if name in ("m", "l") else sp.Symbol(name, real=True) for name in NAMES}
SETTINGS = settings(max_examples=30, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow])


def _powers(inner):
    return st.tuples(inner, st.sampled_from((2, 3, -1))).map(lambda pair: f"({pair[0]})**({pair[1]})")


def _joined(inner, sign):
    return st.lists(inner, min_size=2, max_size=3).map(lambda parts: sign.join(f"({part})" for part in parts))


atoms = st.one_of(
    st.sampled_from(NAMES),
    st.sampled_from(("sin(phi)", "cos(phi)", "sin(theta)", "cos(phi + theta)", "cos(2*theta)")),
    st.sampled_from(("2", "3", "Rational(1, 2)")),
)
smooth = st.recursive(
    atoms, lambda inner: st.one_of(_joined(inner, "+"), _joined(inner, "*"), _powers(inner)), max_leaves=8
)
branching = st.recursive(
    atoms,
    lambda inner: st.one_of(
        _joined(inner, "+"),
        _joined(inner, "*"),
        inner.map(lambda part: f"sqrt(1 + ({part})**2)"),
        inner.map(lambda part: f"Abs({part})"),
        st.tuples(inner, inner).map(lambda pair: f"Max({pair[0]}, {pair[1]})"),
        st.tuples(inner, inner, inner).map(lambda t: f"Piecewise(({t[0]}, ({t[1]}) > 0), ({t[2]}, True))"),
    ),
    max_leaves=6,
)


def squares_as_cosines(expr):
    return expr.replace(
        lambda e: isinstance(e, sp.Pow) and isinstance(e.base, sp.sin) and e.exp == 2,
        lambda e: 1 - sp.cos(e.base.args[0]) ** 2,
    )


def half_angles(expr):
    return expr.replace(sp.sin, lambda a: 2 * sp.sin(a / 2) * sp.cos(a / 2)).replace(
        sp.cos, lambda a: 1 - 2 * sp.sin(a / 2) ** 2
    )


def shared(expr):
    """Common subexpressions as definitions."""
    parts, (rest,) = sp.cse(expr, symbols=(sp.Symbol(f"t{k}", real=True) for k in range(1000)))
    return "\n".join([*(f"{name} = {part}" for name, part in parts), f"f: {rest}"])


REWRITINGS = {
    "expand": lambda e: f"f: {sp.expand(e)}",
    "factor": lambda e: f"f: {sp.factor(e)}",
    "together": lambda e: f"f: {sp.together(e)}",
    "expand angles": lambda e: f"f: {sp.expand_trig(e)}",
    "squares of sines": lambda e: f"f: {squares_as_cosines(sp.expand(e))}",
    "half angles": lambda e: f"f: {half_angles(e)}",
    "share": shared,
    "expand, then share": lambda e: shared(sp.expand(e)),
}


def written(text):
    expr = sp.sympify(text, locals=LOCAL)
    assume(expr.free_symbols and expr.is_finite is not False and not expr.has(sp.zoo, sp.nan))
    return expr


@pytest.mark.parametrize("name", REWRITINGS)
@given(text=smooth)
@SETTINGS
@pytest.mark.share(4)
def test_a_rewriting_is_no_change(name, text):
    expr = written(text)
    comparison = compare(document(f"f: {expr}"), document(REWRITINGS[name](expr)))
    assert not comparison.differs, comparison["f"].how


@pytest.mark.parametrize("name", ["expand", "share"])
@given(text=branching)
@SETTINGS
def test_a_rewriting_with_branches_is_never_called_a_change(name, text):
    expr = written(text)
    comparison = compare(document(f"f: {expr}"), document(REWRITINGS[name](expr)))
    assert not comparison.of(EquationVerdict.CHANGED), comparison["f"].how


@pytest.mark.parametrize("strategy", [smooth, branching], ids=["smooth", "branching"])
@given(data=st.data())
@SETTINGS
@pytest.mark.share(2)
def test_a_flipped_term_is_never_called_equal(strategy, data):
    """Numbers decide whether the flipped sign changes the function at all."""
    text = data.draw(strategy)
    expr = written(text)
    old = document(f"f: {expr}")
    (row,) = old.results
    terms = summands(old.nodes, row.node)
    assume(terms)
    _, path = data.draw(st.sampled_from(terms))
    new = flipped(old, row, path)
    assume(numbers_differ(old, new))
    comparison = compare(old, new)
    assert comparison["f"].verdict is EquationVerdict.CHANGED, comparison["f"].how
    assert comparison["f"].edits


def numbers_differ(old, new):
    """Evaluate both documents with doubles at a few points, by a few lines that share nothing with the engine."""
    points = [
        {name: math.sin(3.7 * k + 1.3 * n) * 2 for n, name in enumerate(NAMES)} | {"m": 0.7 + k, "l": 1.9 / (k + 1)}
        for k in range(12)
    ]
    return any(
        a is not None and b is not None and abs(a - b) > 1e-6 * (1 + abs(a) + abs(b))
        for a, b in ((evaluated(old, p), evaluated(new, p)) for p in points)
    )


FUNCTIONS = {
    "add": lambda *v: sum(v), "mul": lambda *v: math.prod(v), "pow": lambda a, b: a**b, "sin": math.sin,
    "cos": math.cos, "abs": abs, "max": max, "strictgreaterthan": lambda a, b: a > b,
    "exprcondpair": lambda a, b: (a, b), "piecewise": lambda *v: next(a for a, b in v if b),
    "strictlessthan": lambda a, b: a < b,
}  # fmt: skip


def evaluated(made, point):
    values = []
    try:
        for operation, *operands in made.nodes:
            if operation == "sym":
                values.append(point.get(operands[0], 0.3))
            elif operation in ("num", "const"):
                values.append(True if operands[0] == "True" else float(sp.Rational(operands[0])))
            else:
                values.append(FUNCTIONS[operation](*(values[o] for o in operands)))
        value = values[made.results[0].node]
        return value if isinstance(value, float) and math.isfinite(value) else None
    except (ArithmeticError, ValueError, StopIteration, TypeError):
        return None


NUMBERS = st.integers(2, 60)
SHIFTS = st.integers(1, 12).map(lambda k: sp.Rational(1, 10**k))
SMALL = settings(max_examples=12, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow])
INNER = ("x", "x + y", "m*x", "x*y - z", "x**2 - y")
"""Conditions of branches, which take both signs."""
OUTER = ("{}", "m*{} + z", "z - l*{}", "{}*(x**2 + l)", "sin(phi) + {}/m")
"""Expressions around a branch, in which it always counts."""


def edits_of_thresholds(inner, number, shift):
    moved = number * (1 + shift)
    yield f"Piecewise((1, {inner} > {number}), (3, True))", f"Piecewise((1, {inner} > {moved}), (3, True))"
    yield f"Max(-{number}, Min({inner}, {number}))", f"Max(-{number}, Min({inner}, {moved}))"
    yield f"sign({inner} - {number})", f"sign({inner} - {moved})"
    yield f"floor({inner})", f"floor({inner} + {shift})"
    yield (
        f"Piecewise((1, ({inner} > {number}) & (z < {number})), (3, True))",
        f"Piecewise((1, ({inner} > {number}) & (z < {moved})), (3, True))",
    )


def edits_of_angles(angle, factor):
    yield f"atan2(sin({angle}), cos({angle}))", f"({angle})"
    yield f"atan2(sin({factor}*({angle})), cos({factor}*({angle})))", f"{factor}*atan2(sin({angle}), cos({angle}))"
    yield f"acos(cos({angle}))", f"Abs({angle})"


def edits_of_roots(inner, number):
    square = sp.expand(sp.sympify(f"({inner} + {number})**2", locals=LOCAL))
    yield f"sqrt({square})", f"({inner} + {number})"
    yield f"sqrt({square})", f"Abs({inner} - {number})"
    yield "sqrt((1 + cos(phi))/2)", "cos(phi/2)"


def edits_of_tables(inner, knots, edited, shift):
    values = [sp.Rational(k * k % 7 + 1) for k in range(len(knots))]
    other = [v * (1 + shift) if k == edited else v for k, v in enumerate(values)]
    moved = [v + shift if k == edited else v for k, v in enumerate(knots)]
    yield table(inner, knots, values), table(inner, knots, other)
    yield table(inner, knots, values), table(inner, moved, values)


def table(inner, knots, values):
    pieces = [f"({values[0]}, {inner} < {knots[0]})"]
    for (a, p), (b, q) in itertools.pairwise(zip(knots, values, strict=True)):
        pieces.append(f"({p} + ({inner} - ({a}))*({(q - p) / (b - a)}), {inner} < {b})")
    return f"Piecewise({', '.join(pieces)}, ({values[-1]}, True))"


def is_seen(pairs_, data):
    old, new = data.draw(st.sampled_from(list(pairs_)))
    outer = data.draw(st.sampled_from(OUTER))
    comparison = compare(document(f"f: {outer.format(old)}"), document(f"f: {outer.format(new)}"))
    assert comparison["f"].verdict in (EquationVerdict.CHANGED, EquationVerdict.UNDECIDED), (
        outer.format(old),
        outer.format(new),
    )


@given(inner=st.sampled_from(INNER), number=NUMBERS, shift=SHIFTS, data=st.data())
@SMALL
def test_a_moved_threshold_is_never_called_the_same(inner, number, shift, data):
    is_seen(edits_of_thresholds(inner, number, shift), data)


@given(angle=st.sampled_from(("phi", "phi - theta", "m*x", "2*theta + phi")), factor=st.integers(2, 4), data=st.data())
@SMALL
@pytest.mark.soak
def test_an_edit_of_an_angle_is_never_called_the_same(angle, factor, data):
    is_seen(edits_of_angles(angle, factor), data)


@given(inner=st.sampled_from(INNER[:4]), number=NUMBERS, data=st.data())
@SMALL
@pytest.mark.soak
def test_an_edit_of_a_root_is_never_called_the_same(inner, number, data):
    is_seen(edits_of_roots(inner, number), data)


@given(inner=st.sampled_from(INNER), first=st.integers(1, 300), count=st.integers(2, 6), shift=SHIFTS, data=st.data())
@SMALL
@pytest.mark.soak
def test_an_edit_of_a_table_is_never_called_the_same(inner, first, count, shift, data):
    knots = [sp.Rational(first) + k for k in range(count)]
    edited = data.draw(st.integers(0, count - 1))
    is_seen(edits_of_tables(inner, knots, edited, shift), data)


@given(inner=st.sampled_from(INNER), pair=st.sampled_from(PARTIAL), number=NUMBERS, data=st.data())
@SMALL
@pytest.mark.soak
def test_a_lost_limit_of_a_domain_is_never_called_the_same(inner, pair, number, data):
    there, back = pair
    outer = data.draw(st.sampled_from(OUTER))
    part = f"d = {there.format(f'({inner} - {number})')}\n"
    old, new = f"f: {outer.format('(' + back.format('d') + ')')}", f"f: {outer.format(f'({inner} - {number})')}"
    for texts in ((part + old, new), (new, part + old)):
        verdict = compare(*map(document, texts))["f"].verdict
        assert verdict in (EquationVerdict.CHANGED, EquationVerdict.UNDECIDED), texts


@given(x=st.sampled_from(("x", "m*x", "x + y", "x/y")), number=st.integers(2, 99), data=st.data())
@SMALL
def test_equal_steps_are_never_called_a_change(x, number, data):
    """Also at the points of a step, where rounding says on which side a form is."""
    x = f"({x})"
    forms = (
        f"{number}*floor({x}/{number})",
        f"{x} - Mod({x}, {number})",
        f"{number}*floor(({x} + z)/{number} - z/{number})",
        f"-{number}*ceiling(-({x})/{number})",
        f"{x} - {number}*Mod({x}/{number}, 1)",
    )
    old, new = data.draw(st.permutations(forms))[:2]
    assert not compare(document(f"f: {old}"), document(f"f: {new}")).of(EquationVerdict.CHANGED), (old, new)


@pytest.mark.parametrize(("there", "back"), [("atanh(tanh(x))", "x"), ("log(exp(x))", "x"), ("asinh(sinh(x))", "x"),
                                         ("acosh(cosh(x))", "Abs(x)")])  # fmt: skip
def test_what_rounding_alone_tells_apart_is_no_change(there, back):
    """Sizes do not see how errors grow: beside one, of a hyperbolic tangent that is undone, by any number of digits."""
    assert not compare(document(f"f: y*{there}"), document(f"f: {back}*y")).differs


@given(names=st.permutations(("x", "y", "z")), first=NUMBERS, second=NUMBERS, third=NUMBERS, data=st.data())
@SMALL
def test_a_term_in_a_joint_state_of_three_branches_is_never_lost(names, first, second, third, data):
    a, b, c = names
    ramps = f"Max(0, {a} - {first})*Max(0, -{b} - {second})*Max(0, {c} - {third})"
    window = f"Piecewise((1, ({a} > {first}) & ({a} < {first + 1}) & ({b} < -{second})), (0, True))"
    is_seen([(f"({c} + {ramps})", c), (f"({c} + {window})", c)], data)


@pytest.mark.parametrize("count", [5, 6, 8])
def test_a_term_in_a_joint_state_of_many_branches_is_never_lost(count):
    names = ("y", "z", "v", "w", "a", "b", "phi", "theta")[:count]
    term = "*".join(f"Max(0, {name} - {place})" for place, name in enumerate(names, start=2))
    comparison = compare(document(f"f: x + {term}"), document("f: x"))
    assert comparison.differs
