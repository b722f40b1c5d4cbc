# SPDX-License-Identifier: Apache-2.0
"""Linear systems of every model and law against differences, at a random point near each model's first start."""

import numpy as np
import pytest

import mehvar
from mehvar.base.manifest import Array, result_shape
from mehvar.base.names import identifier
from mehvar.runtime.model.linear import jacobians
from mehvar.runtime.model.parameters import vector

MODELS = mehvar.runtime.model.catalogue.known_models()
LAWS = [(name, law) for name in MODELS for law in mehvar.load(name, backend="python").manifest.controllers]


def point(model):
    """Return state, parameters and reference, off the start by a thousandth: nothing is at rest, nothing at a kink."""
    manifest, rng = model.manifest, np.random.default_rng(0)
    p, s = model.parameters(), vector(manifest.scenario_parameters, {})
    x = model.functions["initial"](p, s)
    r = np.asarray(model.functions["reference"](0.0, p, s))
    x = x + 1e-3 * np.maximum(1, np.abs(x)) * rng.uniform(0.5, 1, x.shape)
    return x, p, r


def differences(function, at, h=1e-6, least=1.0):
    """Return central differences; the step is relative, for states of kilometres a second."""
    steps = h * np.maximum(least, np.abs(at))
    return np.transpose(
        [(function(at + d * e) - function(at - d * e)) / (2 * d) for d, e in zip(steps, np.eye(len(at)), strict=True)]
    )


def close(exact, near):
    scale = np.maximum(1e-3, np.abs(near).max(initial=0.0))
    return np.abs(exact - near).max(initial=0.0) < 1e-5 * scale


@pytest.mark.parametrize(("name", "law"), LAWS)
@pytest.mark.share(3)
def test_a_law_closes_the_loop(name, law):
    model = mehvar.load(name, backend="python")
    controller = model.manifest.controller(law)
    x, p, r = point(model)
    c, functions, nx, nu = model.law_parameters(law), model.functions, len(x), len(model.input_names)
    system = model.linearize(x, None, p, model.output_names, r, controller=law)
    z = functions[f"{law}_start"](x, r, p, c) if controller.memory else np.zeros(0)

    def commanded(s, reference):
        memory = (s[nx : nx + nu], s[nx + nu :]) if controller.memory else ()
        results = functions[law](s[:nx], reference, *memory, p, c)
        u, z_next = results if memory else (results, np.zeros(0))
        return (functions["actuate"](s[:nx], u, p) if "actuate" in functions else u), z_next

    def seen(s, reference):
        return functions["outputs"](s[:nx], commanded(s, reference)[0], reference, p)

    s = np.concatenate([x, np.zeros(nu), z]) if controller.memory else x
    rows = slice(nx, None) if controller.period else slice(None)
    advance = (
        (lambda s, r: np.concatenate(commanded(s, r)))
        if controller.period
        else (lambda s, r: model.rhs(s, commanded(s, r)[0], p))
    )
    assert len(system.states) == len(s)
    assert close(system.A[rows], differences(lambda v: advance(v, r), s))
    assert close(system.C, differences(lambda v: seen(v, r), s))
    if len(r):
        assert close(system.B[rows], differences(lambda v: advance(s, v), r))
        assert close(system.D, differences(lambda v: seen(s, v), r))


@pytest.mark.parametrize("name", MODELS)
def test_the_loop_that_is_integrated_follows_its_chart(name):
    """T(x) A = J_q T(x) - (dT/dt): the same loop in the regular chart and in the state's."""
    model = mehvar.load(name, backend="python")
    x, p, r = point(model)
    chart = model.functions.get("to_coordinates", np.array)
    for law in (law for law in model.manifest.controllers.values() if law.period is None):
        c, loop = model.law_parameters(law.name), identifier(law.name)
        inside = jacobians(model.functions[f"{loop}_loop_jac"], chart(x), r, p, c)["q"]
        system = model.linearize(x, None, p, r=r, controller=law.name)
        rate = model.rhs(x, model.functions[law.name](x, r, p, c), p)
        if "actuate" in model.functions:
            rate = model.rhs(x, model.functions["actuate"](x, model.functions[law.name](x, r, p, c), p), p)
        turning = (differences(chart, x + 1e-5 * rate) - differences(chart, x - 1e-5 * rate)) / 2e-5
        T = differences(chart, x)
        assert close(T @ system.A + turning, inside @ T)


@pytest.mark.parametrize("name", MODELS)
def test_derivatives_by_parameters(name):
    model = mehvar.load(name, backend="python")
    x, p, r = point(model)
    u = np.full(len(model.input_names), 0.1)
    assert close(model.jac_p(x, u, p), differences(lambda v: model.rhs(x, u, v), p, 1e-5, 1e-6))
    names = (*model.output_names, model.state_names[0])
    exact = model.jac_p(x, u, p, outputs=names, r=r)
    assert close(exact[:-1], differences(lambda v: model.functions["outputs"](x, u, r, v), p, 1e-5, 1e-6))
    assert not exact[-1].any()
    wide = model.jac_p(np.stack([x, x]), u, p)
    assert wide.shape == (2, len(x), len(p))


def test_only_derivatives_have_matrices():
    """A moment of inertia may be called J_x, and take x."""
    x = Array("x", 2)
    assert result_shape("outputs_jac", Array("J_x", 6), [x]) == (3, 2)
    assert result_shape("jac_x", Array("J", 4), [x]) == (2, 2)
    assert result_shape("inertia", Array("J_x", 6), [x]) == (6,)
    assert result_shape("jac_x", Array("J", None), [x]) == ()


@pytest.mark.parametrize("law", ["lyapunov-v1", "lyapunov-v2"])
@pytest.mark.parametrize(("vy", "vz"), [(75.0, 25.0), (-75.0, 525.0), (775.0, 25.0), (5000.0, 0.0)])
@pytest.mark.share(3)
def test_a_loop_whose_gimbals_saturate_is_linearised(law, vy, vz):
    """The sine of a gimbal angle is clipped at 1, where its arc sine has no slope; the loop is smooth there."""
    model = mehvar.load("slosh", backend="python")
    x = model.state(vx=3000, vy=vy, vz=vz, phi1=0.5, phi2=0.7, theta1=0.3, theta2=0.2, wz=0.05)
    p, c, r = model.parameters(), model.law_parameters(law), np.zeros(len(model.manifest.references))

    def command(state):
        return model.functions[identifier(law)](state, r, p, c)

    def rates(state):
        return model.rhs(state, model.functions["actuate"](state, command(state), p), p)

    assert np.isclose(np.abs(command(x)[-2:]), np.pi / 2, atol=1e-6).any()
    assert close(model.linearize(x, None, p, controller=law).A, differences(rates, x))
