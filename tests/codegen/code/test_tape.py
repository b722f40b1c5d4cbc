# SPDX-License-Identifier: Apache-2.0
"""The tape keeps the values of CasADi's graph while it renames, shares, fuses and drops."""

import casadi as ca
import numpy as np
import pytest

from mehvar.codegen.code.spelling import PYTHON, C, Printer
from mehvar.codegen.code.tape import Instruction, Tape, TapeError, tape

X, Y = ca.SX.sym("x", 3), ca.SX.sym("y")


def ops(t: Tape) -> list[str]:
    return [i.op for i in t.instructions if i.op not in ("input", "const")]


def run_python(t: Tape, *values: float) -> list[float]:
    """Execute the printed Python."""
    lines, results = Printer(t, (("x", 3), ("y", None)), PYTHON).print()
    names = {"np": np, "x": np.array(values[:3]), "y": values[3]}
    with np.errstate(all="ignore"):
        exec("\n".join(lines), names)
        return [float(eval(text, names)) for result in results for text in result]


def build(*outputs: ca.SX) -> tuple[Tape, ca.Function]:
    function = ca.Function("f", [X, Y], list(outputs))
    return tape(function), function


def test_a_shared_denominator_is_divided_by_once():
    t, f = build(X[0] / Y + X[1] / Y * X[2])
    assert ops(t).count("div") == 1
    assert run_python(t, 1.0, 2.0, 3.0, 7.0)[0] == pytest.approx(float(f([1, 2, 3], 7)), rel=1e-15)


def test_a_single_division_stays_a_division():
    assert ops(build(X[0] / Y)[0]) == ["div"]


def test_if_else_becomes_one_select():
    t, f = build(ca.if_else(X[0] < X[1], X[2], Y))
    assert ops(t).count("select") == 1
    assert "select0" not in ops(t)
    for values in ([1, 2, 3, 4], [2, 1, 3, 4]):
        assert run_python(t, *values)[0] == float(f(values[:3], values[3]))


def test_a_branch_not_taken_cannot_poison():
    t, _ = build(ca.if_else(Y > 0, X[0] / Y, 0))
    assert run_python(t, 1.0, 2.0, 3.0, 0.0) == [0.0]


@pytest.mark.parametrize(("low", "high", "kept"), [(0.5, 1.0, 1), (0.0, 1.0, 1), (1.0, 1.0, 2), (-0.5, 1.0, 2)])
def test_a_flag_compared_again_is_the_comparison_it_came_from(low, high, kept):
    t, f = build(ca.if_else(low < ca.if_else(X[0] < X[1], high, 0), X[2], Y))
    assert ops(t).count("lt") == kept
    for values in ([1, 2, 3, 4], [2, 1, 3, 4], [np.nan, 1, 3, 4]):
        assert run_python(t, *values)[0] == float(f(values[:3], values[3]))


def test_comparisons_used_as_numbers_are_converted():
    t, f = build((X[0] < X[1]) + (X[1] < X[2]) * 2)
    assert run_python(t, 1.0, 2.0, 3.0, 0.0)[0] == float(f([1, 2, 3], 0)) == 3.0


def test_what_no_result_needs_is_dropped():
    assert len(build(X[0] + 1)[0].instructions) == 3


def test_equal_values_are_computed_once():
    assert ops(build(ca.sin(X[0]) + 1, ca.sin(X[0]) + 2)[0]).count("sin") == 1


def test_operations_count_arithmetic_only():
    assert build(ca.sin(X[0]) * X[1] + 2)[0].operations == 3


def test_the_longest_chain_leaves_out_what_can_be_computed_beside_it():
    assert build(ca.sin(X[0]) * X[1] + ca.cos(X[2]))[0].chain == 3
    assert build(-X[0])[0].chain == 0


def test_sine_and_cosine_of_one_angle_are_fused():
    lines, _ = Printer(build(ca.sin(Y) + ca.cos(Y))[0], (("x", 3), ("y", None)), C).print()
    assert sum("mv_sincos" in line for line in lines) == 1
    assert not any("mv_sin(" in line or "mv_cos(" in line for line in lines)


def test_constant_results_have_full_width():
    _, results = Printer(build(ca.SX(2.5))[0], (("x", 3), ("y", None)), C).print()
    assert results == [["SPLAT(K(2.5))"]]


@pytest.mark.parametrize("value", [0.1, 1 / 3, 1e-300, 5e-324, 1.7976931348623157e308, 2.0, -0.0, 123456789.123456789])
def test_literals_keep_their_bits(value):
    for language in (C, PYTHON):
        text = language.constant(value).removeprefix("K(").removesuffix(")")
        assert np.float64(text).tobytes() == np.float64(value).tobytes()
        assert any(mark in text for mark in ".e"), "an integer literal would change the type of a C expression"


def test_rounding_order_survives_printing():
    """(a + b) + c and a + (b + c) differ; brackets may only go where the grammar puts them back."""
    a, b, c = (Instruction("input", (0, k)) for k in range(3))
    left = Tape((a, b, Instruction("add", (0, 1)), c, Instruction("add", (2, 3))), ((4,),))
    right = Tape((a, b, c, Instruction("add", (1, 2)), Instruction("add", (0, 3))), ((4,),))
    values = (1e16, -1e16, 1.0, 0.0)
    assert run_python(left, *values) == [1.0]
    assert run_python(right, *values) == [0.0]


def test_an_unknown_operation_is_named():
    function = ca.Function("f", [Y], [ca.SX(1) * Y])
    assert tape(function).operations == 0
    with pytest.raises(TapeError, match="operation number"):
        tape(ca.Function("f", [Y], [Y.printme(Y)]))
