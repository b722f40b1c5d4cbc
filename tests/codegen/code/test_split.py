# SPDX-License-Identifier: Apache-2.0
"""A function in parts, computed once per run, when the input changes and at every call, is the plain function."""

import casadi as ca
import numpy as np
import pytest

from mehvar.codegen.code.split import split
from mehvar.codegen.code.tape import Tape, tape
from mehvar.runtime import load

X, P = ca.SX.sym("x", 2), ca.SX.sym("p", 2)
ARGUMENTS = (("x", 2), ("p", 2))


def halves(*outputs: ca.SX):
    return split(tape(ca.Function("f", [X, P], list(outputs)), frozenset({1})), ARGUMENTS, {1}, "h")


def ops(t: Tape) -> list[str]:
    return [i.op for i in t.instructions if i.op not in ("input", "const")]


def test_what_depends_on_parameters_alone_moves():
    found = halves(X[0] * ca.sin(P[0]) + X[1] * ca.sqrt(P[1] * P[0]))
    assert sorted(ops(found.prepare)) == ["mul", "sin", "sqrt"]
    assert sorted(ops(found.prepared)) == ["add", "mul", "mul"]
    assert found.first == (("p", 2),)
    assert found.second == (("x", 2), ("h", 2))


def test_a_parameter_that_is_read_as_it_is_stays_an_argument():
    found = halves(X[0] * ca.exp(P[0]) + P[1])
    assert found.second == (("x", 2), ("p", 2), ("h", 1))


def test_a_divisor_is_inverted_once():
    found = halves(X[0] / P[0])
    assert ops(found.prepare) == ["div"]
    assert ops(found.prepared) == ["mul"]


def test_signs_and_comparisons_stay():
    """They cost no more than a load, and a truth value is no number."""
    assert halves(X[0] * -P[0]) is None
    assert halves(ca.if_else(P[0] < P[1], X[0], X[1])) is None


def test_nothing_to_move():
    assert halves(X[0] * P[0]) is None
    assert halves(X[0] + 2) is None


def test_a_result_may_depend_on_parameters_alone():
    found = halves(ca.vertcat(P[0] * P[1], X[0]))
    assert ops(found.prepared) == []
    assert found.size == 1


@pytest.mark.parametrize("model", ["triangle", "slosh", "satellite"])
@pytest.mark.share(3)
def test_parts_are_the_function(model):
    """Bit for bit, at random arguments within the bounds of parameters."""
    loaded = load(model, "c")
    manifest, functions = loaded.manifest, loaded.functions
    generator = np.random.default_rng(1)
    p = loaded.parameters() * generator.uniform(0.99, 1.01, (20, len(loaded.parameter_names)))
    names = [name.removesuffix("_prepared") for name in manifest.functions if name.endswith("_prepared")]
    assert {"rhs", "outputs"} <= set(names)
    for name in names:
        plain = manifest.functions[name]
        values = {a.name: generator.uniform(0.1, 0.5, (20, *a.shape)) for a in plain.arguments} | {"p": p}
        expected = functions[name](*(values[a.name] for a in plain.arguments))
        for step in ("prepare", "hold", "prepared"):
            part = manifest.functions.get(f"{name}_{step}")
            if part is None:
                continue
            found = functions[part.name](*(values[a.name] for a in part.arguments))
            values[part.results[0].name] = found
            assert part.operations < plain.operations
        for one, other in zip(_several(found), _several(expected), strict=True):
            np.testing.assert_array_equal(one, other, err_msg=name)
            assert np.isfinite(one).mean() > 0.5


def _several(results):
    return results if isinstance(results, tuple) else (results,)
