# SPDX-License-Identifier: Apache-2.0
"""A saturated value has the derivative zero also under a root or an arc function, whose slope is infinite there."""

import casadi as ca
import numpy as np
import pytest

from mehvar.codegen.functions.plateaus import plateaus

STEEP = {
    "arc sine": lambda v: ca.asin(ca.fmax(-1, ca.fmin(1, v))),
    "arc cosine": lambda v: ca.acos(ca.fmin(v, 1)),
    "root of the rest": lambda v: ca.sqrt(1 - ca.fmin(1, v) ** 2),
    "root of what is left": lambda v: ca.sqrt(ca.fmax(1 - v, 0)),
    "within an arc": lambda v: ca.asin(ca.sqrt(ca.fmin(1, v))),
    "after an arc": lambda v: v * ca.cos(ca.asin(ca.fmin(1, v)) / 2),
    "switched": lambda v: ca.sqrt(ca.if_else(v > 1, 0, 1 - v)),
}


def slope(function, at):
    """Return the value of a function of one variable and its derivative, both by the plateaus."""
    x = ca.SX.sym("x")
    graph = ca.Function("f", [x], [function(x)])
    flat = plateaus(graph, [x], [0])
    (derivative,) = flat.filled([ca.jacobian(flat.values[0], x)])
    return float(graph(at)), float(ca.Function("d", [x], [ca.densify(derivative)])(at))


@pytest.mark.parametrize("name", STEEP)
@pytest.mark.parametrize("at", [0.3, 0.9, 1.5, 40.0])
def test_the_derivative_is_that_of_differences(name, at):
    function = STEEP[name]
    x = ca.SX.sym("x")
    value = ca.Function("f", [x], [function(x)])
    near = float(value(at + 1e-6) - value(at - 1e-6)) / 2e-6
    assert slope(function, at)[1] == pytest.approx(near, abs=1e-8, rel=1e-6)


def test_a_bound_may_be_an_argument():
    x, most = ca.SX.sym("x"), ca.SX.sym("most")
    graph = ca.Function("f", [x, most], [ca.asin(ca.fmin(x, most))])
    by_x, by_both = (plateaus(graph, [x, most], varying) for varying in ([0], [0, 1]))
    (derivative,) = by_x.filled([ca.jacobian(by_x.values[0], x)])
    assert float(ca.Function("d", [x, most], [derivative])(2.0, 1.0)) == 0.0
    assert not by_both.values[0].is_constant()
    (derivative,) = by_both.filled([ca.jacobian(by_both.values[0], most)])
    assert np.isinf(float(ca.Function("d", [x, most], [derivative])(2.0, 1.0)))  # the bound moves the value


@pytest.mark.parametrize("at", [0.0, -1.0])
def test_a_root_without_a_derivative_keeps_none(at):
    """The length of a vector that vanishes is no plateau."""
    assert not np.isfinite(slope(lambda v: ca.sqrt(v**2 * (v + 1) ** 2), at)[1])


def test_what_has_no_plateau_is_left_as_it_is():
    x = ca.SX.sym("x", 2)
    graph = ca.Function("f", [x], [ca.sqrt(x[0] ** 2 + x[1]) * ca.fmin(x[0], 1)])
    flat = plateaus(graph, [x], [0])
    assert ca.is_equal(flat.values[0], graph.call([x])[0], 20)
