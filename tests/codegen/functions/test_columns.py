# SPDX-License-Identifier: Apache-2.0
"""Jacobians of many equal parts, by columns, have the values of Jacobians with all elements."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

import mehvar
from mehvar import Controller, Group, Quantity, Scenario, System
from mehvar.codegen.functions.function import MANY
from mehvar.runtime import load
from mehvar.runtime.model.functions import BackendName
from tests.models.edits import POSITIVE, parameter, quantity
from tests.models.feedback import table
from tests.models.written import written

JACOBIANS = ("jac_x", "jac_u", "jac_p", "outputs_jac", "outputs_jac_p", "damp_loop_jac")


def pendulums(count: int, equal: bool = True) -> System:
    """Pendulums on a cart that is pushed; with `equal` False they count as unlike each other."""
    numbers = range(1, count + 1)

    def members(name: str, one: Quantity) -> list[Quantity]:
        family = name if equal else ""
        return [dataclasses.replace(one, name=f"{name}{k}", family=family, index=k * equal) for k in numbers]

    own = members("angle", quantity("angle", "rad")) + members("rate", quantity("rate", "rad/s"))
    x = Group("x", (quantity("speed", "m/s"), *own))
    u, r = Group("u", (quantity("push", "N"),)), Group("r", (quantity("goal", "m/s"),))
    p = Group(
        "p",
        (
            parameter("M", "kg", 9.0, POSITIVE),
            parameter("g", "m/s^2", 9.81),
            *members("length", parameter("length", "m", 1.1, POSITIVE)),
        ),
    )
    s = Group("s", (parameter("goal_0", "m/s", 0.5),))
    c = Group("c", (parameter("k", "N s/m", 2.0),))
    angle, rate, length = x.symbols[1 : count + 1], x.symbols[count + 1 :], p.symbols[2:]
    mass = p.M * (1 + sum(sp.sin(a) ** 2 for a in angle))
    pulls = (sp.sin(a) * (p.g * sp.cos(a) + n * w**2) for a, w, n in zip(angle, rate, length, strict=True))
    push = (u.push + p.M * sum(pulls)) / mass
    turns = [-(p.g * sp.sin(a) + sp.cos(a) * push) / n for a, n in zip(angle, length, strict=True)]
    swing = sum(n**2 * w**2 for w, n in zip(rate, length, strict=True))
    energy = p.M * (x.speed**2 + swing) / 2 - p.M * x.speed * r.goal
    return table(
        x, u, p, name="pendulums", title="pendulums on a cart", rhs=(push, *rate, *turns),
        references=r, reference=(s.goal_0,), outputs=Group("y", (quantity("E", "J"),)), output=(energy,),
        scenario_parameters=s, initial=(2 * s.goal_0, *(sp.Rational(k, 50) for k in numbers), *[sp.S.Zero] * count),
        controllers=(Controller("damp", "", c, (-c.k * (x.speed - r.goal),)),),
        scenarios=(Scenario("plain", "plain", 2.0, 0.5, {}, {}, {}),),
    )  # fmt: skip


@pytest.fixture(scope="module")
def folders(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """The same pendulums with Jacobians by columns, and with all elements."""
    systems = {"columns": pendulums(MANY), "elements": pendulums(MANY, equal=False)}
    columns, elements = (written(system, tmp_path_factory.mktemp(name)) for name, system in systems.items())
    return columns, elements


@pytest.mark.parametrize("backend", ["c", "python", "casadi"])
def test_columns_are_the_jacobian(folders: tuple[Path, Path], backend: BackendName) -> None:
    columns, elements = load(folders[0], backend=backend), load(folders[1])
    rng = np.random.default_rng(3)
    for name in JACOBIANS:
        sizes = [a.size for a in elements.functions[name].function.arguments]
        point = [rng.uniform(0.5, 1.0, (3, size)) for size in sizes]
        results = (model.functions[name](*point) for model in (columns, elements))
        for by_columns, every in zip(*(r if isinstance(r, tuple) else (r,) for r in results), strict=True):
            np.testing.assert_allclose(by_columns, every, rtol=1e-12, atol=1e-13, err_msg=name)


def test_casadi_takes_them(folders: tuple[Path, Path]) -> None:
    model = load(folders[0])
    x, u, p = np.linspace(0.1, 0.9, 2 * MANY + 1), np.array([0.3]), model.parameters()
    np.testing.assert_allclose(np.array(model.to_casadi("jac_x")(x, u, p)), model.jac_x(x, u, p), rtol=1e-12)


def lines(path: Path) -> list[str]:
    return path.read_text().splitlines()


def test_the_text_of_jacobians_does_not_grow(folders: tuple[Path, Path], tmp_path: Path) -> None:
    more = written(pendulums(MANY + 3), tmp_path)
    for file in ("pendulums_jac.c", "pendulums_outputs_jac.c", "pendulums_loops_jac.c"):
        assert len(lines(folders[0] / file)) == len(lines(more / file)), file
    assert len(lines(folders[0] / "pendulums_jac.c")) < len(lines(folders[1] / "pendulums_jac.c")) / 4
    assert "_jvp" not in (folders[1] / "pendulums_outputs_jac.c").read_text()


def test_an_implicit_method_runs_alone_and_in_lanes(folders: tuple[Path, Path]) -> None:
    columns, elements = (load(folder) for folder in folders)
    options = {"method": "rodas5p", "rtol": 1e-9, "atol": 1e-11}
    alone, other = (mehvar.simulate(model, "damp", **options) for model in (columns, elements))
    np.testing.assert_allclose(alone["speed"], other["speed"], rtol=1e-7)
    many = mehvar.batch(columns, "damp", n=9, vary={"length3": "uniform(1, 1.2)"}, **options)
    last = mehvar.simulate(columns, "damp", parameters={"length3": float(many["length3"][8])}, **options)
    assert float(many["final"].sel(state="speed")[8]) == float(last["speed"][-1])
