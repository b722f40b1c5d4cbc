# SPDX-License-Identifier: Apache-2.0
"""From vocabulary to run: a small system with everything a sampled loop can have, against a loop written by hand."""

import dataclasses
import json
import sys
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

from mehvar.base.errors import InputError
from mehvar.codegen.functions.verify import VerificationError, verify
from mehvar.models.system import (  # fmt: skip
    Actuator,
    Choice,
    Condition,
    Controller,
    Group,
    Interval,
    Parameter,
    Quantity,
    Scenario,
    Sensor,
    System,
    Variant,
)
from mehvar.runtime import load, simulate
from mehvar.runtime.batch.kernel import compile_kernel
from mehvar.runtime.run.noise import normals
from mehvar.runtime.run.options import RunOptions
from tests.models.written import written
from tests.runtime.batch.one_by_one import run_alone

ANY = Interval(-np.inf, np.inf, True, True)


def parameter(name: str, default: float, unit: str = "1") -> Parameter:
    bounds = Interval(0.0, np.inf, True, True) if name == "Ts" else ANY
    return Parameter(name, unit, name, default=default, bounds=bounds, source="assumption: test")


def quantity(name: str, unit: str = "1") -> Quantity:
    return Quantity(name, unit, name)


def spinner() -> System:
    """A unit vector (c, s) turned at the rate w: a saturated motor, a noisy sensor, a circle."""
    x = Group("x", (quantity("c"), quantity("s"), quantity("w", "1/s")))
    u, r = Group("u", (quantity("torque", "1/s^2"),)), Group("r", (quantity("w_ref", "1/s"),))
    v = Group("v", (quantity("torque_was", "1/s^2"),))
    p = Group("p", (
        parameter("Ts", 0.1, "s"), parameter("top", 0.4, "1/s^2"), parameter("sigma", 0.0, "1/s"),
        parameter("drag", 0.5, "1/s"),
    ))  # fmt: skip
    s = Group("s", (parameter("w_0", 1.0, "1/s"), parameter("w_goal", 2.0, "1/s^2")))
    gain = Group("c", (parameter("k", 3.0, "1/s"), parameter("leak", 0.1, "1/s")))
    law = Controller(
        "sum-law", "a law with memory", gain,
        command=(gain.k * (r.w_ref - x.w) + sp.Symbol("total", real=True),),
        period="Ts", applied=v, memory=Group("z", (quantity("total"), quantity("last"))),
        start=(sp.Integer(0), x.w),
        update=(sp.Symbol("total", real=True) + gain.leak * (r.w_ref - x.w), v.torque_was), in_numbers=True,
    )  # fmt: skip
    smooth = Controller(
        "smooth", "continuous in time", Group("c", (parameter("k", 3.0, "1/s"),)), (gain.k * (r.w_ref - x.w),)
    )
    limited = sp.Max(-p.top, sp.Min(p.top, sp.Symbol("asked", real=True)))
    norm = 1 / sp.sqrt(x.c**2 + x.s**2)
    return System(
        name="spinner", title="a spinner", source="test", structure={}, states=x, inputs=u, references=r,
        outputs=Group("y", (quantity("angle"),)), parameters=p, scenario_parameters=s,
        rhs=(-x.s * x.w, x.c * x.w, u.torque - p.drag * x.w), output=(sp.atan2(x.s, x.c),), steps=(),
        limits=(Condition(sp.Rational(1, 2) - p.Ts * x.w, "too fast: half a radian in {Ts} s"),),
        initial=(sp.Integer(1), sp.Integer(0), s.w_0),
        reference=(s.w_goal * sp.Symbol("t", real=True) / 10,), constraints=(), functions=(),
        controllers=(law, smooth), scenarios=(Scenario("plain", "plain", 5.0, 0.1, {}, {}, {}),), metrics=(),
        actuator=Actuator(Group("u_cmd", (quantity("asked", "1/s^2"),)), (limited,)),
        sensor=Sensor(Group("e", (quantity("w_noise"),)), (x.c, x.s, x.w + p.sigma * sp.Symbol("w_noise", real=True))),
        projection=(x.c * norm, x.s * norm, x.w), choices=(Choice("plant", ("full", "free"), "with or without drag"),),
        variants=(Variant(("free",), (-x.s * x.w, x.c * x.w, u.torque), {}),),
    )  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    return written(spinner(), tmp_path_factory.mktemp("spinner"))


def by_hand(drag: float, sigma: float, delay: int, noise: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The sampled loop in exact form: w' = torque - drag w between samples."""
    w, total, applied, queue = 1.0, 0.0, 0.0, [0.0] * delay
    speeds, torques, memories = [], [], []
    for k in range(51):
        seen, goal = w + sigma * noise[k], 2.0 * k * 0.1 / 10
        memories.append(total)
        queue.append(3.0 * (goal - seen) + total)
        total += 0.1 * (goal - seen)
        applied = float(np.clip(queue.pop(0), -0.4, 0.4))
        speeds.append(w)
        torques.append(applied)
        decay = np.exp(-drag * 0.1)
        w = w * decay + applied * ((1 - decay) / drag if drag else 0.1)
    return np.array(speeds), np.array(torques), np.array(memories)


@pytest.mark.parametrize("backend", ["c", "python"])
@pytest.mark.parametrize(("plant", "drag"), [("full", 0.5), ("free", 0.0)])
@pytest.mark.parametrize(("delay", "sigma"), [(0, 0.0), (1, 0.0), (2, 0.05)])
def test_a_sampled_loop_with_all_its_parts(folder, backend, plant, drag, delay, sigma):
    run = simulate(load(folder, backend), "sum-law", plant=plant, delay=delay, sigma=sigma, seed=7)
    noise = normals(7, 0, 51, 1)[:, 0]
    speeds, torques, memories = by_hand(drag, sigma, delay, noise)
    np.testing.assert_allclose(run.x[:, 2], speeds, atol=1e-9)
    np.testing.assert_allclose(run.u[:, 0], torques, atol=1e-9)
    np.testing.assert_allclose(run.z[:, 0], memories, atol=1e-9)
    np.testing.assert_allclose(run.z[2:, 1], run.u[:-2, 0], atol=1e-12)
    np.testing.assert_allclose(np.hypot(run.x[:, 0], run.x[:, 1]), 1.0, atol=1e-15)


@pytest.mark.parametrize("backend", ["c", "python"])
def test_a_continuous_loop_logs_what_it_asked_and_what_it_got(folder, backend):
    run = simulate(load(folder, backend), "smooth")
    assert np.all(np.abs(run.u) <= 0.4 + 1e-15)
    wanted = 3.0 * (2.0 * run.t / 10 - run.x[:, 2])
    np.testing.assert_allclose(run.u_cmd[:, 0], wanted, atol=1e-12)
    assert np.abs(run.u_cmd).max() > 1
    np.testing.assert_allclose(np.hypot(run.x[:, 0], run.x[:, 1]), 1.0, atol=1e-13)


def test_the_same_seed_gives_the_same_noise(folder):
    runs = [simulate(folder, "sum-law", sigma=0.1, seed=seed).x for seed in (3, 3, 4)]
    assert np.array_equal(runs[0], runs[1])
    assert not np.array_equal(runs[0], runs[2])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"plant": "fre"}, "plant = 'fre'.*must be 'full' or 'free'"),
        ({"plnt": "free"}, "unknown .* 'plnt'.*plant"),
        ({"seed": -1}, "seed = -1"),
    ],
)
def test_wrong_choices_are_refused(folder, options, message):
    with pytest.raises(InputError, match=message):
        simulate(folder, "sum-law", **options)


def test_the_manifest_tells_of_the_parts(folder):
    data = json.loads((folder / "manifest.json").read_text())
    assert data["choices"]["plant"]["values"] == ["full", "free"]
    assert data["controllers"]["sum-law"]["period"] == "Ts"
    assert [q["name"] for q in data["noise"]] == ["w_noise"]
    assert {"actuate", "measure", "project", "rhs_free", "smooth_loop_free", "sum_law_start"} <= set(data["functions"])


def residual(drag: sp.Expr) -> tuple[dict[str, sp.Symbol], tuple[sp.Expr, ...]]:
    rate, w, torque = (sp.Symbol(name, real=True) for name in ("w_rate", "w", "torque"))
    return {"w": rate}, (2 * rate + 2 * drag * w - 2 * torque,)


def test_the_evaluation_form_is_held_against_the_derived_equations():
    system = spinner()
    rates, right = residual(system.parameters.drag)
    verify(dataclasses.replace(system, rates=rates, residual=right))
    _, wrong = residual(-system.parameters.drag)
    with pytest.raises(VerificationError, match=r"\.py:\d+: w' of rhs differs from the derived equations"):
        verify(dataclasses.replace(system, rates=rates, residual=wrong))


def test_derived_equations_that_determine_no_rate_are_refused():
    system = spinner()
    rates, (right,) = residual(system.parameters.drag)
    for wrong in (
        sp.S.One,
        sp.S.Zero,
        right.xreplace({rates["w"]: sp.S.Zero}),
        right.xreplace({rates["w"]: system.states.w}),
    ):
        with pytest.raises(
            VerificationError, match=r"\.py:\d+: residual does not determine w: its derivative with respect to w_rate"
        ):
            verify(dataclasses.replace(system, rates=rates, residual=(wrong,)))


def test_a_law_may_compute_in_float(folder):
    wide, narrow = (simulate(folder, "sum-law", real=real) for real in ("double", "float"))
    assert 0 < np.abs(wide.x - narrow.x).max() < 1e-5
    assert np.array_equal(narrow.z, narrow.z.astype(np.float32))
    for model, law in ((load(folder, "python"), "sum-law"), (load(folder, "c"), "smooth")):
        with pytest.raises(InputError, match="real = 'float'"):
            simulate(model, law, real="float")


@pytest.mark.parametrize(
    ("law", "options"), [("sum-law", {"delay": 2}), ("smooth", {}), ("smooth", {"method": "dopri5"})]
)
@pytest.mark.parametrize("plant", ["full", "free"])
@pytest.mark.share(3)
def test_a_batch_of_it_is_the_runs_alone(folder, law, plant, options):
    """Projection, actuator, noise, delay, memory, a moving reference and a variant, lane by lane."""
    model = load(folder, "c")
    noise = {"sigma": 0.05} if law == "sum-law" else {}  # a continuous loop measures nothing
    resolved = simulate(model, law, plant=plant, t_end=0.1, **noise).parameters
    p, c, s = (np.tile(v, (5, 1)) for v in (resolved.p, resolved.c, resolved.s))
    p[:, model.parameter_names.index("drag")] = np.linspace(0.1, 0.9, 5)
    x0 = np.array(model.functions["initial"](p, s))
    kernel = compile_kernel(model, law, {"plant": plant}, RunOptions(**options))
    result = kernel.run(2, p, c, s, x0, seed=7, t_end=5.0, dt=0.1, save_every=0.1)
    expected = run_alone(model, kernel, p, c, s, x0, t_end=5.0, dt=0.1, seed=7, first_run=2)
    for name in ("final", "minimum", "maximum", "status", "t_stop", "steps", "series"):
        np.testing.assert_array_equal(getattr(result, name), getattr(expected, name), err_msg=name)


@pytest.mark.soak
def test_lanes_threads_chunks_and_compilers_do_not_change_a_bit_of_a_batch(folder, monkeypatch):
    def run(chosen: slice = slice(None), lanes: int | None = None, threads: int = 1) -> list[np.ndarray]:
        model = load(folder, "c")
        resolved = simulate(model, "sum-law", sigma=0.05, t_end=0.1).parameters
        p, c, s = (np.tile(v, (11, 1)) for v in (resolved.p, resolved.c, resolved.s))
        p[:, model.parameter_names.index("drag")] = np.linspace(0.1, 0.9, 11)
        vectors = [v[chosen] for v in (p, c, s, np.array(model.functions["initial"](p, s)))]
        kernel = compile_kernel(model, "sum-law", options=RunOptions(delay=1), lanes=lanes)
        result = kernel.run(chosen.start or 0, *vectors, seed=3, t_end=5.0, dt=0.1, save_every=0.5, threads=threads)
        return list(vars(result).values())

    def same(result: list[np.ndarray], wanted: list[np.ndarray]) -> None:
        for one, other in zip(result, wanted, strict=True):
            np.testing.assert_array_equal(one, other)

    expected = run()
    assert np.unique(expected[0], axis=0).shape[0] == 11
    same(run(lanes=1), expected)
    same(run(lanes=4, threads=2), expected)
    for chosen in (slice(0, 1), slice(1, 4), slice(4, 11)):
        same(run(chosen), [values[chosen] for values in expected])
    monkeypatch.setenv("CC", f"{sys.executable} -m ziglang cc")
    same(run(), expected)
