# SPDX-License-Identifier: Apache-2.0
"""JAX, Numba and python-control; `make peers` installs them and runs this."""

from __future__ import annotations

import numpy as np
import pytest

import mehvar
from mehvar.base.errors import InputError

from .conftest import LONGEST, close, point

pytestmark = pytest.mark.peers


@pytest.fixture(autouse=True)
def _double():
    jax = pytest.importorskip("jax", reason="make peers installs it")
    jax.config.update("jax_enable_x64", True)


def shared(model):
    """Yield the functions that are compared, with a point."""
    for name in ("rhs", "outputs", "jac_x", "jac_u"):
        function = model.functions[name]
        if function.function.operations <= LONGEST:
            yield name, point(function.function), function


def test_jax(model):
    import jax

    functions = model.to_jax()
    for name, arguments, function in shared(model):
        close(getattr(functions, name)(*arguments), function(*arguments))
    x, u, p = point(model.functions["rhs"].function)
    close(jax.jit(functions.rhs)(x, u, p), model.rhs(x, u, p))
    many = np.stack([x, 1.1 * x, 0.9 * x])
    close(jax.vmap(functions.rhs, (0, None, None))(many, u, p), model.rhs(many, u, p))
    close(jax.jacfwd(functions.rhs)(x, u, p), model.jac_x(x, u, p))


def test_numba(model):
    functions = model.to_numba()
    for name, arguments, function in shared(model):
        if function.function.operations < 1000:  # compiling takes seconds for each thousand
            close(getattr(functions, name)(*arguments), function(*arguments))
    with pytest.raises(AttributeError, match="unknown function"):
        _ = functions.no_such


def test_control_has_our_matrices_and_names(model):
    x, u, p = point(model.functions["rhs"].function)
    system = model.to_control(x, u, p)
    for ours, theirs in zip(model.linearize(x, u, p), (system.A, system.B, system.C, system.D), strict=True):
        np.testing.assert_array_equal(ours, theirs)
    assert (system.state_labels, system.input_labels) == (list(model.state_names), list(model.input_names))
    with pytest.raises(InputError, match="one point"):
        model.to_control(np.stack([x, x]), u, p)


def test_a_loop_in_control_is_our_run():
    import control

    model = mehvar.load("triangle")
    loop = model.to_nlsys(controller="path")
    run = mehvar.simulate(model, "path", t_end=5.0)
    states = np.array([run[name].values for name in model.state_names])
    case = model.manifest.scenario(None)
    s = np.array([case.values.get(q.name, q.default) for q in model.manifest.scenario_parameters])
    r = model.functions["reference"](0.0, model.parameters(), s)
    response = control.input_output_response(
        loop, run["t"].values, np.outer(r, np.ones(run.sizes["t"])), states[:, 0],
        solve_ivp_kwargs={"rtol": 1e-9, "atol": 1e-12},
    )  # fmt: skip
    np.testing.assert_allclose(response.states, states, atol=1e-6)


def test_a_sampled_law_in_control_is_ours():
    model = mehvar.load("satellite")
    law, p = model.manifest.controller("pd"), model.parameters()
    system = model.to_nlsys(controller="pd", part="law")
    assert system.dt == p[model.parameter_names.index(law.period)]
    x, r, v, z, _, c = point(model.functions["pd"].function)
    c = model.law_parameters("pd")
    u, z_next = model.functions["pd"](x, r, v, z, p, c)
    inputs = np.concatenate([x, r, v])
    close(model.to_nlsys(controller="pd", part="law").output(0.0, z, inputs), u)
    close(system.dynamics(0.0, z, inputs), z_next)
    with pytest.raises(InputError, match="a continuous law"):
        model.to_nlsys(controller="pd")
    with pytest.raises(InputError, match="'plant', 'law' or 'loop'"):
        model.to_nlsys(part="none")
