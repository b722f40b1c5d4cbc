# SPDX-License-Identifier: Apache-2.0
"""Linear systems of the pendulum against derivatives by hand and by differences, alone and under its laws."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

from mehvar.base.errors import InputError
from mehvar.models.system import Actuator, Controller, Group, Scenario
from mehvar.runtime import Model, load
from mehvar.runtime.model.linear import ClosedLoop
from mehvar.runtime.model.parameters import vector
from tests.models.edits import parameter, quantity
from tests.models.feedback import table
from tests.models.written import written

Vector = np.ndarray


@pytest.fixture(params=["c", "python"])
def model(request: pytest.FixtureRequest, pendulum: Model, slow_pendulum: Model) -> Model:
    return pendulum if request.param == "c" else slow_pendulum


def differences(function: Callable[[Vector], Vector], point: Vector, h: float = 1e-6) -> Vector:
    return np.transpose([(function(point + h * e) - function(point - h * e)) / (2 * h) for e in np.eye(len(point))])


def test_the_plant(model: Model) -> None:
    p, u, x = model.parameters(), np.array([0.4]), np.array([0.7, -0.2])
    A, B, C, D = model.linearize(x, u, p)
    np.testing.assert_array_equal(A, model.jac_x(x, u, p))
    np.testing.assert_array_equal(B, model.jac_u(x, u, p))
    np.testing.assert_array_equal(C, np.eye(2))
    np.testing.assert_array_equal(D, np.zeros((2, 1)))
    *_, C, D = model.linearize(x, u, p, outputs=["energy", "rate", "power"])
    np.testing.assert_allclose(C, [[9.81 * np.sin(0.7), -0.2], [0.0, 1.0], [0.0, 0.4]], rtol=1e-15)
    np.testing.assert_array_equal(D, [[0.0], [0.0], [-0.2]])
    *_, C, _ = model.linearize(np.stack([x, x, x]), u, p, outputs=["angle_error"])
    np.testing.assert_array_equal(C, np.tile([[1.0, 0.0]], (3, 1, 1)))


def test_rows_and_columns_have_names(model: Model) -> None:
    system = model.linearize([0.7, -0.2], [0.4], model.parameters(), outputs=["energy", "rate"])
    assert (system.states, system.inputs, system.outputs) == (("angle", "rate"), ("torque",), ("energy", "rate"))
    assert len(system) == 4
    assert system[2] is system.C
    assert system.period is None


def test_a_continuous_loop(model: Model) -> None:
    p, c, r, x = model.parameters(), model.law_parameters("pd", k_p=30.0), np.array([0.1]), np.array([0.7, -0.2])
    loop = model.linearize(x, None, p, ["energy", "power", "angle_error"], r, controller="pd", c=c)

    def rate(point: Vector, reference: Vector) -> Vector:
        return model.rhs(point, model.functions["pd"](point, reference, p, c), p)

    def seen(point: Vector, reference: Vector) -> Vector:
        u = model.functions["pd"](point, reference, p, c)
        return model.functions["outputs"](point, u, reference, p)[[0, 2, 1]]

    np.testing.assert_allclose(loop.A, differences(lambda v: rate(v, r), x), atol=1e-7)
    np.testing.assert_allclose(loop.B, differences(lambda v: rate(x, v), r), atol=1e-7)
    np.testing.assert_allclose(loop.C, differences(lambda v: seen(v, r), x), atol=1e-7)
    np.testing.assert_allclose(loop.D, differences(lambda v: seen(x, v), r), atol=1e-7)
    assert loop.inputs == tuple(q.name for q in model.manifest.references)
    np.testing.assert_allclose(np.sort(loop.eigenvalues), np.sort(np.linalg.eigvals(loop.A)))


def test_an_actuator_that_depends_on_the_state(tmp_path: Path) -> None:
    """A jet that pushes less the faster it turns: its own slope and that of the law's command."""
    x, u = Group("x", (quantity("v", "1"),)), Group("u", (quantity("a", "1/s"),))
    asked = quantity("asked", "1/s")
    p, c = Group("p", (parameter("m", "1", 2.0),)), Group("c", (parameter("k", "1/s", 3.0),))
    jet = Actuator(Group("u_cmd", (asked,)), (asked.symbol * sp.cos(p.m * x.v),))
    law = Controller("brake", "", c, (-c.k * x.v,))
    system = table(
        x, u, p, name="jet", scenario_parameters=Group("s", ()), rhs=(u.a,), initial=(sp.S.One,), actuator=jet,
        controllers=(law,), scenarios=(Scenario("plain", "", 1.0, 0.1, {}, {}, {}),),
    )  # fmt: skip
    model = load(written(system, tmp_path), backend="c")
    loop = model.linearize([0.3], None, model.parameters(), controller="brake", c=model.law_parameters("brake"))
    expected = -3.0 * np.cos(0.6) + 3.0 * 0.3 * 2.0 * np.sin(0.6)
    np.testing.assert_allclose(loop.A, [[expected]], rtol=1e-14)


def test_a_sampled_loop(model: Model) -> None:
    """At rest, where the map over a period is that of the plant linearised; beside it the memory."""
    p, c = model.parameters(Ts=0.2, wall=9.0), model.law_parameters("p-sum")
    loop = model.linearize([0.0, 0.0], None, p, controller="p-sum", c=c, z=[0.0])
    assert loop.states == ("angle", "rate", "applied_torque", "sum")
    assert loop.period == 0.2

    def after(s: Vector, r: Vector) -> Vector:
        u, z = model.functions["p-sum"](s[:2], r, s[2:3], s[3:], p, c)
        x, h = s[:2], 0.2 / 200
        for _ in range(200):
            k1 = model.rhs(x, u, p)
            k2 = model.rhs(x + h / 2 * k1, u, p)
            k3 = model.rhs(x + h / 2 * k2, u, p)
            x = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + model.rhs(x + h * k3, u, p))
        return np.concatenate([x, u, z])

    np.testing.assert_allclose(loop.A, differences(lambda s: after(s, np.zeros(1)), np.zeros(4)), atol=1e-8)
    np.testing.assert_allclose(loop.B, differences(lambda r: after(np.zeros(4), r), np.zeros(1)), atol=1e-8)
    np.testing.assert_array_equal(loop.C, np.eye(2, 4))


def test_many_points_at_once(model: Model) -> None:
    x, p = np.array([[0.0, 0.0], [0.3, 0.1]]), model.parameters(Ts=0.2)
    many = model.linearize(x, None, p, ["energy"], controller="p-sum")
    for place, point in enumerate(x):
        for one, several in zip(model.linearize(point, None, p, ["energy"], controller="p-sum"), many, strict=True):
            np.testing.assert_allclose(several[place] if several.ndim == 3 else several, one, rtol=1e-14, atol=1e-15)


def test_a_point_without_input_and_parameters_has_their_defaults(model: Model) -> None:
    x = model.state()
    whole = model.linearize(x, np.zeros(len(model.input_names)), model.parameters())
    for one, other in zip(model.linearize(x), whole, strict=True):
        np.testing.assert_array_equal(one, other)
    assert "<caption>A</caption>" in whole._repr_html_()
    assert repr(whole).startswith("<linear system, continuous: states ")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"u": [0.0], "outputs": ["enrgy"]}, "unknown output 'enrgy' of pendulum: did you mean energy"),
        ({"u": [0.0], "z": [0.0]}, r"z = \[0.0\]: must be None without a controller"),
        ({"u": [0.0], "c": [0.0]}, r"c = \[0.0\]: must be None without a controller"),
        ({"u": [0.0], "controller": "pd"}, r"u = \[0.0\]: must be None: the law pd gives the input"),
        ({"u": None, "controller": "pd", "z": [0.0]}, r"z = \[0.0\]: must be None: the law pd"),
        ({"u": None, "controller": "pid"}, "unknown controller 'pid' of pendulum"),
    ],
)
def test_what_has_no_meaning_is_refused(model: Model, arguments: dict, message: str) -> None:
    with pytest.raises(InputError, match=message):
        model.linearize([0.0, 0.0], p=model.parameters(), **arguments)


def test_eigenvalues_of_what_has_no_derivative_are_no_numbers(model: Model) -> None:
    """At the wall, where the root is zero, its slope is infinite."""
    p = model.parameters(k_wall=1.0, wall=0.5)
    system = model.linearize([[0.5, 0.0], [0.0, 0.0]], [0.0], p)
    assert np.isnan(system.eigenvalues[0]).all()
    np.testing.assert_array_equal(system.eigenvalues[1], model.linearize([0.0, 0.0], [0.0], p).eigenvalues)


def test_law_parameters(model: Model) -> None:
    assert model.law_parameters("pd", k_p=25.0).tolist() == [25.0, 10.0]
    with pytest.raises(InputError, match="unknown parameter 'k_q' of the law pd"):
        model.law_parameters("pd", k_q=1.0)


@pytest.mark.parametrize("name", ["triangle", "slosh", "satellite"])
def test_a_cut_loop_that_is_closed_again_is_the_loop(name: str) -> None:
    model = load(name, "python")
    manifest, functions, p = model.manifest, model.functions, model.parameters()
    start = functions["initial"](p, vector(manifest.scenario_parameters, {}))
    r = functions["reference"](0.0, p, vector(manifest.scenario_parameters, {}))
    for law in manifest.controllers.values():
        c = model.law_parameters(law.name)
        cut = ClosedLoop(manifest, functions, law, start, None, p, r, c, None).cut()
        loop = model.linearize(start, None, p, r=r, controller=law.name)
        assert (cut.states, cut.inputs, cut.outputs) == (loop.states, model.input_names, model.input_names)
        np.testing.assert_allclose(cut.A + cut.B @ cut.C, loop.A, rtol=1e-9, atol=1e-12)
