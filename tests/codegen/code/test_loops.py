# SPDX-License-Identifier: Apache-2.0
"""Loops over the members of a family compute the bits of the statements that they stand for."""

from __future__ import annotations

import ctypes
import itertools
from collections.abc import Sequence
from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from mehvar.codegen.code.files import PrintedFunction, printed_functions
from mehvar.codegen.code.members import LEAST
from mehvar.codegen.functions.function import FunctionGraph
from mehvar.runtime.compiling.library import load_library, native_headers
from tests.codegen.test_oracle import aligned

N = LEAST + 1
EACH = [f"{k}" for k in range(N)]
BUILDS = [("double", 1), ("double", 2), ("double", 4), ("double", 8), ("float", 1), ("float", 8)]


def bodies(count: int = N, odd: bool = False) -> FunctionGraph:
    """Return N swinging bodies on a carrier: sums over them, a solve, and a rate of each from the solution.

    The sums go over the bodies in an order of their own; `odd` gives one body another law of its own.
    """
    x, p = ca.SX.sym("x", 1 + 2 * count), ca.SX.sym("p", 1 + 2 * count)
    order = [*range(1, count, 2), *range(0, count, 2)]
    angle, rate = [x[1 + k] for k in range(count)], [x[1 + count + k] for k in range(count)]
    mass, length = [p[1 + 2 * k] for k in range(count)], [p[2 + 2 * k] for k in range(count)]
    sines = [ca.sin(angle[k]) for k in range(count)]
    if odd:
        sines[3] = sines[3] * 2
    total, force = p[0], x[0]
    for k in order:
        total = (
            mass[k] * length[k] ** 2 * sines[k] ** 2 + total
            if k % 2
            else total + mass[k] * length[k] ** 2 * sines[k] ** 2
        )
    for k in reversed(order):
        force = force - mass[k] * length[k] * ca.cos(angle[k]) * rate[k] ** 2 + x[0] * sines[k]
    spring = ca.if_else(x[0] < 0, force, 2 * force)
    acceleration = spring / (total + sum(mass[k] for k in order))
    turned = [ca.fmin(acceleration * ca.cos(angle[k]) / length[k], rate[k] * sines[k]) for k in range(count)]
    names = {"x": ("v", *(f"angle{k}" for k in range(count)), *(f"rate{k}" for k in range(count)))}
    names["p"] = ("M", *itertools.chain(*((f"m{k}", f"l{k}") for k in range(count))))
    numbers = range(1, count + 1)
    return FunctionGraph(
        "f",
        "bodies",
        (("x", 1 + 2 * count), ("p", 1 + 2 * count)),
        (("dx", 1 + 2 * count),),
        ca.Function("f", [x, p], [ca.vertcat(acceleration, *rate, *turned)]),
        parameters=frozenset({1}),
        elements=names,
        families={
            "x": (("", 0), *(("angle", k) for k in numbers), *(("rate", k) for k in numbers)),
            "p": (("", 0), *itertools.chain(*((("m", k), ("l", k)) for k in numbers))),
        },
    )


def text(functions: Sequence[PrintedFunction]) -> str:
    """Return C with each function in loops, and in statements under a name that ends in `_straight`."""
    lines = ['#include "mehvar/private/arithmetic.h"']
    for f in functions:
        for names in f.places.values():
            lines.append(f"enum {{ {', '.join(names)} }};")
        for function, name in ((f, f.name), (replace(f, families={}), f"{f.name}_straight")):
            lines += [f"void {name}({function.c_signature('real')}) {{", *function.c_lines, "}"]
    return "\n".join(lines) + "\n"


def library(functions: Sequence[PrintedFunction], real: str, lanes: int) -> ctypes.CDLL:
    flags = ("-O2", "-Wno-psabi", "-I.", f"-DMEHVAR_LANES={lanes}", *(["-DMEHVAR_FLOAT"] if real == "float" else []))
    return load_library("loops", native_headers() | {"f.c": text(functions)}, ["f.c"], flags)


def called(function: ctypes._CFuncPtr, inputs: list[np.ndarray], size: int) -> np.ndarray:
    result = aligned((size, *inputs[0].shape[1:]), inputs[0].dtype.type)
    function(*(ctypes.c_void_p(a.ctypes.data) for a in (*inputs, result)))
    return result


def assert_same_bits(functions: Sequence[PrintedFunction], real: str, lanes: int) -> None:
    compiled, rng = library(functions, real, lanes), np.random.default_rng(1)
    kind = np.float32 if real == "float" else np.float64
    for f in functions:
        for _ in range(3):
            inputs = [aligned((size or 1, lanes), kind) for _, size in f.arguments]
            for array in inputs:
                array[...] = rng.uniform(-1, 1, array.shape)
            sizes = sum(size or 1 for _, size in f.results)
            if len(f.results) > 1:
                continue
            loop, straight = (called(getattr(compiled, name), inputs, sizes) for name in (f.name, f"{f.name}_straight"))
            assert np.isfinite(straight).any()
            np.testing.assert_array_equal(loop, straight, f.name)


@pytest.mark.parametrize("odd", [False, True])
@pytest.mark.parametrize(("real", "lanes"), BUILDS)
@pytest.mark.share(4)
def test_loops_have_the_bits_of_statements(real, lanes, odd):
    assert_same_bits(printed_functions([bodies(odd=odd)]), real, lanes)


def test_statements_do_not_grow_with_the_members():
    few, many = (printed_functions([bodies(count)]) for count in (N, 4 * N))
    for short, long in zip(few, many, strict=True):
        assert len(long.c_lines) == len(short.c_lines)
        assert long.operations > 3 * short.operations


def test_the_first_part_hands_members_on():
    """Values computed once per run for each member are read in a loop."""
    rest = printed_functions([bodies()])[-1]
    assert {number for _, number in rest.families["h"]} >= set(range(1, N + 1))
    assert sum(line.startswith("for (") for line in rest.c_lines) == 2


def test_a_member_unlike_the_others_has_statements():
    alike, odd = ("\n".join(printed_functions([bodies(odd=odd)])[0].c_lines) for odd in (False, True))
    assert "rate3]" not in alike
    assert "rate3]" in odd


def test_few_members_have_statements_in_the_order_of_the_model():
    graph = bodies(LEAST - 1)
    assert not any("for (" in line for f in printed_functions([graph]) for line in f.c_lines)
    plain = printed_functions([replace(graph, families={})])
    assert [f.c_lines for f in printed_functions([graph])] == [f.c_lines for f in plain]


def test_sums_in_another_order_are_the_same_sums():
    graph, rng = bodies(), np.random.default_rng(2)
    x, p = rng.uniform(0.5, 1, 2 * N + 1), rng.uniform(0.5, 1, 2 * N + 1)
    whole = printed_functions([graph])[:1]
    inputs = [aligned((2 * N + 1, 1), np.float64) for _ in range(2)]
    inputs[0][:, 0], inputs[1][:, 0] = x, p
    result = called(library(whole, "double", 1).f, inputs, 2 * N + 1)[:, 0]
    wanted = np.array(graph.graph(x, p))[:, 0]
    np.testing.assert_allclose(result, wanted, rtol=1e-14)
