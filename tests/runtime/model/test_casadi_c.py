# SPDX-License-Identifier: Apache-2.0
"""CasADi's own C as a backend: the same functions, the same runs, and what it does not do."""

import ctypes

import numpy as np
import pytest

import mehvar
from mehvar.base.errors import InputError
from mehvar.base.names import identifier
from mehvar.runtime.board.run import BoardRequest, run_on_board
from mehvar.runtime.model.catalogue import find_model, known_models
from mehvar.runtime.model.model import load
from mehvar.runtime.run.metrics import metrics
from mehvar.runtime.run.simulate import simulate
from tests.papers.shared import LIGHT

LAWS = [(name, law) for name in known_models() for law in find_model(name).controllers]


@pytest.mark.parametrize(
    "name", [name if name == LIGHT else pytest.param(name, marks=pytest.mark.soak) for name in known_models()]
)
def test_it_has_every_function_but_those_in_two_parts(name):
    ours, casadi = load(name, "c"), load(name, "casadi")
    assert casadi.backend == "casadi"
    assert set(ours.functions) - set(casadi.functions) == {
        function.name for function in ours.manifest.functions.values() if function.file.endswith("_prepared.c")
    }
    assert {"rhs", "jac_x", "jac_u", "jvp"} <= set(casadi.functions)


@pytest.mark.parametrize(
    "name", [name if name == LIGHT else pytest.param(name, marks=pytest.mark.soak) for name in known_models()]
)
def test_its_functions_need_no_work_space(name):
    """The calls pass none: a graph of scalars has none."""
    model = load(name, "casadi")
    library = model.evaluator._library(f"{name}_casadi.c")
    for function in model.functions:
        sizes = [ctypes.c_longlong(-1) for _ in range(4)]
        assert getattr(library, f"{name}_{identifier(function)}_work")(*map(ctypes.byref, sizes)) == 0
        assert [size.value for size in sizes[2:]] == [0, 0]


def test_leading_axes_broadcast_and_shapes_are_those_of_ours():
    ours, casadi = load("triangle", "c"), load("triangle", "casadi")
    x = np.random.default_rng(0).uniform(0.1, 0.5, (5, 1, 4))
    u, p = np.ones((3, 3)), ours.parameters()
    for name in ("rhs", "jac_x", "jac_u"):
        one, other = ours.functions[name](x, u, p), casadi.functions[name](x, u, p)
        assert one.shape == other.shape
        assert np.allclose(one, other, rtol=1e-13, atol=0)
    assert np.allclose(casadi.jac_x(x, u, p), ours.jac_x(x, u, p), rtol=1e-13, atol=0)
    with pytest.raises(InputError, match=r"u must have the shape"):
        casadi.rhs(x, np.ones(2), p)


@pytest.mark.parametrize(
    ("name", "law"),
    [
        pytest.param(*pair, marks=pytest.mark.soak if pair[0] == "slosh" else ())  # its C takes the compiler 3 s
        for pair in LAWS
        if pair[1] != "mrac-literal"
    ],
)
@pytest.mark.share(2)
def test_a_run_has_the_metrics_of_ours(name, law):
    """Law (32) is left out: its loop is unstable with the exact plant, and a rounding grows with it."""
    ours = simulate(load(name, "c"), law)
    casadi = simulate(load(name, "casadi"), law)
    assert (casadi.backend, casadi.reason) == ("casadi", ours.reason)
    values = metrics(ours, ours.manifest)
    assert metrics(casadi, ours.manifest) == pytest.approx(values, rel=1e-8, abs=1e-8)


def test_noise_is_the_same():
    ours, casadi = (mehvar.simulate("satellite", "pd", backend=b, noise=1e-3, t_end=20.0) for b in ("c", "casadi"))
    assert np.allclose(ours["roll"], casadi["roll"], rtol=1e-10, atol=1e-13)
    assert casadi.attrs["backend"] == "casadi"


def test_what_needs_our_own_text_is_refused(tmp_path):
    model = load("triangle", "casadi")
    with pytest.raises(InputError, match=r"backend = 'casadi' .*must be 'c': batches need mehvar's C"):
        mehvar.batch(model, "path", 4)
    with pytest.raises(InputError, match=r"backend = 'casadi' .*left out: a batch runs our own C in lanes"):
        mehvar.batch("triangle", "path", 4, backend="casadi")
    with pytest.raises(InputError, match=r"real = 'float'.*C backend"):
        simulate(model, "path", hold=0.01, real="float")
    with pytest.raises(InputError, match=r"law = .*C backend"):
        simulate(model, "path", hold=0.01, law=lambda x, r, v, z: (np.zeros(3), z))
    with pytest.raises(InputError, match=r"backend = 'casadi' .*left out: the board decides it"):
        run_on_board(load("triangle", "c"), BoardRequest("path", "sil", samples=10, options={"backend": "casadi"}))
    with pytest.raises(InputError, match=r"backend = 'casadi' .*must be 'c', as the model was loaded"):
        simulate(load("triangle", "c"), "path", backend="casadi")


def test_an_unknown_backend_is_refused():
    with pytest.raises(InputError, match=r"backend = 'casady': must be 'c', 'python' or 'casadi'"):
        load("triangle", "casady")
