# SPDX-License-Identifier: Apache-2.0
"""Vectors that answer to names: the same numbers, plain arrays once computed with."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest

import mehvar
from mehvar.runtime.model.named import named


def test_elements_are_read_and_written_by_name():
    model = mehvar.load("triangle")
    p, x = model.parameters(mass=2.0), model.state(theta=1.0)
    assert (p.mass, p["mass"], p[2]) == (2.0, 2.0, 2.0)
    p.disturbance, x["rho"] = 0.5, 0.25
    np.testing.assert_array_equal(p, [0.0, 0.5, 2.0])
    np.testing.assert_array_equal(x, [0.25, 0.0, 0.17, 1.0])  # masses at one point, mu = 0, have no rates
    assert {"mass", "disturbance"} <= set(dir(p))
    with pytest.raises(mehvar.InputError, match="did you mean mass"):
        p["mas"] = 1.0
    with pytest.raises(AttributeError, match="mas"):
        p.mas = 1.0


def test_a_call_with_names_has_the_bits_and_the_road_of_one_without():
    model = mehvar.load("triangle")
    x, p, u = model.state(rho=0.3, mu=0.2), model.parameters(disturbance=0.1), np.array([0.1, 0.2, 0.3])
    plain = model.rhs(np.array(x), u, np.array(p))
    assert type(plain) is type(model.rhs(x, u, p)) is np.ndarray
    np.testing.assert_array_equal(model.rhs(x, u, p), plain)
    assert model.functions["rhs"]._point((x, u, p)) is not None


def test_what_is_made_of_one_is_plain_or_has_its_names():
    x = named([1.0, 2.0], ("a", "T"))
    for made in (2 * x, x[:1], np.sin(x), pickle.loads(pickle.dumps(x)), np.stack([x, x])):
        assert type(made) is np.ndarray
    twin = x.copy()
    twin.a = 5.0
    assert (x.a, twin.a, twin["T"]) == (1.0, 5.0, 2.0)
    assert x.T.shape == (2,)
    assert float(x.sum()) == 3.0
    np.testing.assert_array_equal(copy.deepcopy(x), x)
