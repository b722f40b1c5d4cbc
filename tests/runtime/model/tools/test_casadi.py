# SPDX-License-Identifier: Apache-2.0
"""Functions for CasADi: the numbers of the C, CasADi's derivatives of them, without sources."""

from __future__ import annotations

import sys

import casadi as ca
import numpy as np
import pytest

import mehvar
from mehvar.base.errors import InputError
from mehvar.base.names import identifier

from .conftest import LONGEST, close, point


@pytest.mark.share(4)
def test_functions_are_those_of_the_c(model):
    laws = [identifier(law) for law in model.manifest.controllers]
    for name in ("rhs", "outputs", "initial", "jac_x", "jac_u", *laws):
        function = model.functions[name]
        about = function.function
        if about.operations > LONGEST:
            continue
        symbolic, arguments = model.to_casadi(about.name), point(about)
        assert symbolic.name_in() == [a.name for a in about.arguments]
        out = symbolic.call(arguments)
        expected = function(*arguments)
        for value, result in zip(out, expected if len(out) > 1 else [expected], strict=True):
            shape = np.shape(result)
            if np.all(np.isfinite(result)):
                close(value.full().reshape(shape), result)


def test_derivatives_are_our_jacobians(model):
    arguments = point(model.functions["rhs"].function)
    x, u, p = (ca.SX.sym(name, len(value)) for name, value in zip("xup", arguments, strict=True))
    rhs = model.to_casadi()(x, u, p)
    for name, by in (("jac_x", x), ("jac_u", u)):
        derivative = ca.Function("derivative", [x, u, p], [ca.densify(ca.jacobian(rhs, by))])
        close(derivative(*arguments).full(), model.functions[name](*arguments))


def test_an_unknown_function_is_refused(model):
    with pytest.raises(mehvar.MehvarError, match="unknown function"):
        model.to_casadi("no_such")


def test_what_is_missing_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "casadi", None)
    with pytest.raises(InputError, match="to_casadi needs casadi: pip install casadi"):
        mehvar.load("triangle").to_casadi()
