# SPDX-License-Identifier: Apache-2.0
"""Time in a law, continuous and sampled, against exact solutions."""

import dataclasses

import numpy as np
import pytest
import sympy as sp

from mehvar.codegen.code.files import printed, texts
from mehvar.codegen.functions.graphs import generate_functions
from mehvar.codegen.manifest import manifest_of
from mehvar.manifest import manifest_text
from mehvar.models.check import check
from mehvar.models.clock import with_clock
from mehvar.models.system import TIME, Controller, Group, System
from mehvar.runtime import simulate
from tests.models.edits import POSITIVE, cart, parameter, quantity


def pushed() -> System:
    """A speed v' = a, with a = k cos(w t)."""
    c = Group("c", (parameter("k", "m/s^2", 2.0), parameter("w", "1/s", 3.0)))
    push = (c.k * sp.cos(c.w * TIME.symbol),)
    u, p = Group("u", (quantity("a", "m/s^2"),)), Group("p", (parameter("Ts", "s", 0.1, POSITIVE),))
    return dataclasses.replace(
        cart(), name="pushed", states=Group("x", (quantity("v", "m/s"),)), inputs=u, references=Group("r", ()),
        outputs=Group("y", ()), output=(), parameters=p, scenario_parameters=Group("s", ()), rhs=(u.a,), steps=(),
        limits=(), initial=(sp.S.Zero,), reference=(), constraints=(), functions=(), metrics=(), actuator=None,
        sensor=None, choices=(), variants=(), rates={}, residual=(),
        scenarios=(dataclasses.replace(cart().scenarios[0], values={}),),
        controllers=(Controller("wave", "", c, push), Controller("steps", "", c, push, period="Ts")),
    )  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    system, path = pushed(), tmp_path_factory.mktemp("pushed")
    check(system)
    functions = printed(generate_functions(with_clock(system)))
    manifest = manifest_of(with_clock(system), functions, {})
    for name, text in {**texts(manifest, functions), "manifest.json": manifest_text(manifest)}.items():
        (path / name).write_text(text)
    return path


@pytest.mark.parametrize("backend", ["c", "python"])
def test_a_law_of_time(folder, backend):
    run = simulate(folder, "wave", backend=backend)
    np.testing.assert_allclose(run.x[:, 0], 2 / 3 * np.sin(3 * run.t), atol=1e-8)
    run = simulate(folder, "steps", backend=backend)
    np.testing.assert_allclose(run.u[:-1, 0], 2 * np.cos(3 * run.t[:-1]), atol=1e-12)
    np.testing.assert_allclose(run.x[1:, 0], np.cumsum(0.1 * run.u[:-1, 0]), atol=1e-12)


def test_a_system_without_time_in_its_laws_stays_as_it_is():
    system = cart()
    assert with_clock(system) is system
