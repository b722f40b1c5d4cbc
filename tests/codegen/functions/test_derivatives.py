# SPDX-License-Identifier: Apache-2.0
"""Derivatives where differences fail: at the cuts of angles, and of rows that are constant."""

import casadi as ca
import numpy as np
import pytest
import sympy as sp

from mehvar.codegen.functions.derivatives import directional, jacobian
from mehvar.codegen.functions.function import FunctionGraph
from mehvar.codegen.functions.graphs import generate_functions
from mehvar.codegen.functions.lower import to_casadi
from mehvar.codegen.generate import installed_tree, system_of

A, B = sp.symbols("a b", real=True)
angle = 3 * A - B / 2
"""Unwrapped: its derivatives are 3 and -1/2 everywhere."""
WRAPPED = {
    "atan2": sp.atan2(sp.sin(angle), sp.cos(angle)),
    "floor": angle - 2 * sp.pi * sp.floor((angle + sp.pi) / (2 * sp.pi)),
    "ceiling": angle - 2 * sp.pi * sp.ceiling((angle - sp.pi) / (2 * sp.pi)),
    "mod": sp.Mod(angle + sp.pi, 2 * sp.pi) - sp.pi,
    "if": sp.Piecewise((angle - 2 * sp.pi, angle > sp.pi), (angle + 2 * sp.pi, angle < -sp.pi), (angle, True)),
}


def function(*expressions: sp.Expr) -> FunctionGraph:
    x = ca.SX.sym("x", 2)
    value = ca.vertcat(*to_casadi(expressions, {A: x[0], B: x[1]}))
    graph = ca.Function("f", [x], [value], ["arg_x"], ["res_y"])
    return FunctionGraph("f", "", (("x", 2),), (("y", len(expressions)),), graph)


@pytest.mark.parametrize("wrap", WRAPPED)
def test_an_angle_is_differentiated_across_its_cut(wrap):
    exact = jacobian(function(WRAPPED[wrap]), ["x"], "f_jac", "jac").graph
    on_the_cut = [
        [np.pi / 3, 0.0],
        [-np.pi / 3, 0.0],
        [0.0, 2 * np.pi],
        [np.pi, 0.0],
        [np.nextafter(np.pi / 3, 9), 0.0],
    ]
    points = np.concatenate([on_the_cut, np.random.default_rng(0).uniform(-9, 9, (200, 2))])
    slopes = np.array([np.array(exact(point)).ravel() for point in points])
    np.testing.assert_allclose(slopes, np.tile([3.0, -0.5], (len(points), 1)), rtol=1e-13)


def test_a_constant_row_keeps_its_place():
    """A row that nothing changes is structurally zero, and CasADi leaves it out unless told otherwise."""
    graph = function(sp.Integer(7), A * B)
    assert np.array(jacobian(graph, ["x"], "f_jac", "jac").graph([2.0, 3.0])).ravel().tolist() == [0.0, 0.0, 3.0, 2.0]
    assert np.array(directional(graph, ["x"], "jac").graph([2.0, 3.0], [1.0, 10.0])).ravel().tolist() == [0.0, 23.0]


def test_the_angles_of_a_quaternion_follow_a_turn_across_their_cut():
    """At a yaw of pi the body's rate about z turns the yaw by as much, whichever side of the cut its value is on."""
    system = system_of(installed_tree(), "satellite", {"chart": "quaternion"})
    functions = {f.name: f for f in generate_functions(system)}
    outputs = [q.name for q in system.outputs]
    sizes = [len(g) for g in (system.states, system.inputs, system.references, system.parameters)]
    for yaw in (np.pi, np.nextafter(np.pi, 9.0), -np.pi, 0.3):
        x = np.zeros(sizes[0])
        x[:4] = np.cos(yaw / 2), 0.0, 0.0, np.sin(yaw / 2)
        turn = np.zeros(sizes[0])
        turn[:4] = -np.sin(yaw / 2) / 2, 0.0, 0.0, np.cos(yaw / 2) / 2
        J_x, *_ = functions["outputs_jac"].graph(x, *(np.full(n, 0.5) for n in sizes[1:]))
        rates = np.reshape(np.array(J_x), (len(outputs), sizes[0])) @ turn
        np.testing.assert_allclose(rates[outputs.index("yaw")], 1.0, rtol=1e-13)
