# SPDX-License-Identifier: Apache-2.0
"""The batch kernel against the loop of a single run, to the last bit; and lanes that fail beside lanes that do not."""

from __future__ import annotations

import json
import shutil
from functools import cache

import numpy as np
import pytest

from mehvar import runtime
from mehvar.base.manifest import METRIC_KINDS
from mehvar.runtime import InputError
from mehvar.runtime.batch import kernel as kernel_module
from mehvar.runtime.batch.kernel import Block, compile_kernel, kernel_flags, suitable_lanes
from mehvar.runtime.batch.plan import Campaign, Plan
from mehvar.runtime.batch.source import KernelLoop
from mehvar.runtime.compiling.compiler import require_compiler
from mehvar.runtime.compiling.processor import widest
from mehvar.runtime.model.parameters import resolve
from mehvar.runtime.run.options import RunOptions
from mehvar.runtime.run.problem import Status
from tests.manifests import write_manifest
from tests.runtime.batch.one_by_one import run_alone

EXACT = ("final", "minimum", "maximum", "status", "violated", "t_stop", "steps", "series", "events")

CASES = {
    "triangle path": ("triangle", "path", {"rtol": 1e-8, "atol": 1e-8}, 4.0, 0.05),
    "triangle path, saved rarely": ("triangle", "path", {"method": "dopri5", "rtol": 1e-6, "atol": 1e-6}, 4.03, 0.5),
    "triangle sliding, rk4": ("triangle", "sliding", {"method": "rk4", "step": 0.02}, 3.0, 0.05),
    "triangle sliding, sampled": ("triangle", "sliding", {"hold": 0.1, "delay": 1}, 3.0, 0.05),
    "triangle path, sampled rarely": ("triangle", "path", {"hold": 0.5, "method": "dopri5"}, 6.2, 0.5),
    "slosh": ("slosh", "lyapunov-v1", {"rtol": 1e-7, "atol": 1e-7}, 10.0, 0.5),
    "slosh reduced": ("slosh", "lyapunov-v2", {"choices": {"plant": "reduced"}, "rtol": 1e-7, "atol": 1e-7}, 8.0, 0.5),
    "slosh rk4": ("slosh", "lyapunov-v2", {"method": "rk4", "step": 0.01, "choices": {"attitude": "euler"}}, 2.0, 0.5),
    "slosh rock4": ("slosh", "lyapunov-v2", {"method": "rock4", "rtol": 1e-6, "atol": 1e-6}, 20.0, 1.0),
    "triangle rock4": ("triangle", "path", {"method": "rock4", "rtol": 1e-6, "atol": 1e-6}, 4.0, 0.5),
    "slosh rodas5p": ("slosh", "lyapunov-v2", {"method": "rodas5p", "rtol": 1e-6, "atol": 1e-6}, 20.0, 0.25),
    "triangle rodas5p": ("triangle", "path", {"method": "rodas5p", "rtol": 1e-6, "atol": 1e-6}, 6.0, 0.05),
    "triangle rodas5p, sampled": ("triangle", "sliding", {"method": "rodas5p", "hold": 0.1, "rtol": 1e-8}, 3.0, 0.05),
    "satellite rodas5p": ("satellite", "mrac", {"method": "rodas5p", "rtol": 1e-8, "atol": 1e-8}, 20.0, 0.5),
    "satellite mrac": ("satellite", "mrac", {"rtol": 1e-9, "atol": 1e-9}, 20.0, 0.5),
    "satellite literal": ("satellite", "mrac-literal", {"method": "rk4"}, 20.0, 1.0),
    "satellite pd, delayed": ("satellite", "pd", {"delay": 1, "method": "dopri5"}, 20.0, 0.5),
}


@cache
def model(name: str) -> runtime.Model:
    return runtime.load(name, backend="c")


def dispersed(name: str, law: str, n: int, spread: float = 0.02, seed: int = 1):
    """Vectors of n runs around the first scenario's values, with noise where there may be any."""
    loaded = model(name)
    resolved = runtime.simulate(loaded, law, t_end=0.5, dt_out=0.5).parameters
    generator = np.random.Generator(np.random.Philox(seed))
    p, c, s = (v * (1 + spread * (generator.random((n, v.size)) - 0.5)) for v in (resolved.p, resolved.c, resolved.s))
    period = loaded.manifest.controller(law).period
    if period is not None:
        column = loaded.parameter_names.index(period)
        p[:, column] = resolved.p[column]
    p[:, [i for i, q in enumerate(loaded.parameter_names) if q.startswith("noise")]] = 1e-5
    return p, c, s, np.array(loaded.functions["initial"](p, s))


def nominal(loaded: runtime.Model, law: str, n: int):
    """Vectors of n nominal runs."""
    manifest = loaded.manifest
    controller, scenario = manifest.controller(law), manifest.scenario(None)
    values = resolve(manifest, loaded.functions, controller, scenario, {}, "the test", ())
    p, c, s = (np.tile(v, (n, 1)) for v in (values.p, values.c, values.s))
    return p, c, s, np.array(loaded.functions["initial"](p, s))


def equal(block: Block, expected: Block, names=EXACT) -> None:
    for name in names:
        np.testing.assert_array_equal(getattr(block, name), getattr(expected, name), err_msg=name)


@pytest.mark.parametrize("case", CASES)
@pytest.mark.share(9)
def test_a_lane_is_the_run_alone(case):
    name, law, settings, t_end, dt = CASES[case]
    choices = settings.get("choices", {})
    options = RunOptions(**{name: value for name, value in settings.items() if name != "choices"})
    vectors = dispersed(name, law, 6)
    kernel = compile_kernel(model(name), law, choices, options)
    block = kernel.run(3, *vectors, seed=5, t_end=t_end, dt=dt, save_every=dt)
    expected = run_alone(model(name), kernel, *vectors, t_end=t_end, dt=dt, seed=5, first_run=3)
    equal(block, expected)
    np.testing.assert_allclose(block.metric_values, expected.metric_values, rtol=1e-12, atol=1e-13)
    assert (block.status == Status.DONE).sum() >= 4
    assert (block.error > 0).all()
    assert kernel.loop.method == "rk4" or (block.error <= 1).all()


def test_the_pendulum_with_memory_and_a_moving_reference(pendulum):
    """A law with memory, a limit on the input, a reference that depends on time."""
    for law, hold in (("pd", None), ("pd", 0.05), ("p-sum", 0.05)):
        vectors = nominal(pendulum, law, 5)
        vectors[3][:, 0] += np.linspace(-0.1, 0.1, 5)
        kernel = compile_kernel(pendulum, law, options=RunOptions(hold=hold, rtol=1e-9, atol=1e-9))
        block = kernel.run(0, *vectors, seed=0, t_end=3.0, dt=0.1, save_every=0.1)
        equal(block, run_alone(pendulum, kernel, *vectors, t_end=3.0, dt=0.1))


@pytest.mark.parametrize("law", ["pd", "p-sum"])
def test_every_kind_of_metric_is_that_of_the_run_alone(law, pendulum, tmp_path):
    """Over the whole run and a part of it, of one signal and of two; some bands are left again, some never reached."""
    data = json.loads((pendulum.manifest.folder / "manifest.json").read_text(encoding="utf-8"))
    first = next(iter(data["metrics"].values()))
    parts = {"whole": (0.0, None), "part": (0.7, 2.2)}
    signals = {"one": ["angle_error"], "two": ["angle_error", "u_torque"]}
    data["metrics"] = {
        f"{kind}_{part}_{signal}_{k}": {**first, "kind": kind, "of": of, "band": band, "since": since, "until": until}
        for kind in METRIC_KINDS
        if kind != "events"  # of a model that has some: tests/runtime/run/test_events.py
        for part, (since, until) in parts.items()
        for signal, of in signals.items()
        for k, band in enumerate((0.3, 0.03, 1e-9))
    }
    folder = shutil.copytree(pendulum.manifest.folder, tmp_path / "pendulum")
    write_manifest(folder, data)
    model, hold = runtime.load(folder, backend="c"), 0.05 if law == "p-sum" else None
    vectors = nominal(model, law, 5)
    vectors[3][:, 0] += np.linspace(-0.1, 0.1, 5)
    kernel = compile_kernel(model, law, options=RunOptions(hold=hold))
    block = kernel.run(0, *vectors, seed=0, t_end=3.0, dt=0.05)
    expected = run_alone(model, kernel, *vectors, t_end=3.0, dt=0.05)
    np.testing.assert_allclose(block.metric_values, expected.metric_values, rtol=1e-12, atol=1e-13)
    assert np.mean([len({*column}) > 1 for column in expected.metric_values.T]) > 0.5  # else they say little


@pytest.mark.parametrize(
    ("name", "law"), [("triangle", "path"), pytest.param("slosh", "lyapunov-v2", marks=pytest.mark.soak)]
)
def test_the_fast_profile_agrees_within_tolerances(name, law):
    vectors = dispersed(name, law, 4)
    portable, fast = (
        compile_kernel(model(name), law, options=RunOptions(profile=profile, rtol=1e-10, atol=1e-10)).run(
            0, *vectors, seed=0, t_end=5.0, dt=1.0
        )
        for profile in ("portable", "fast")
    )
    np.testing.assert_allclose(fast.final, portable.final, rtol=1e-7, atol=1e-7)
    assert not np.array_equal(fast.final, portable.final)


def test_lanes_that_fail_do_not_harm_their_neighbours():
    p, c, s, x0 = dispersed("triangle", "path", 8)
    kernel = compile_kernel(model("triangle"), "path", options=RunOptions(hold=0.1, rtol=1e-8, atol=1e-8))
    healthy = kernel.run(0, p, c, s, x0, seed=0, t_end=3.0, dt=0.1, save_every=0.1)
    c_bad, x0_bad = c.copy(), x0.copy()
    c_bad[1] = np.nan
    c_bad[2, 0] *= -1  # a gain that drives the run out, past the law's own barrier
    x0_bad[2, 0] = 0.7071
    x0_bad[5] = np.inf
    block = kernel.run(0, p, c_bad, s, x0_bad, seed=0, t_end=3.0, dt=0.1, save_every=0.1)
    assert block.status[[1, 2, 5]].tolist() == [Status.NOT_FINITE, Status.LIMIT, Status.NOT_FINITE]
    assert block.violated.tolist() == [-1, -1, 0, -1, -1, -1, -1, -1]
    assert block.t_stop[1] == block.t_stop[5] == 0.0
    assert 0.0 < block.t_stop[2] < 3.0
    assert np.isnan(block.series[2, -1]).all()
    others = [0, 3, 4, 6, 7]
    for name in EXACT:
        np.testing.assert_array_equal(getattr(block, name)[others], getattr(healthy, name)[others])


@pytest.mark.parametrize(("options", "dt"), [({}, 0.5), ({"hold": 0.1}, 0.1)])
def test_a_lane_that_a_limit_ends_counts_its_end_and_no_other_does(pendulum: runtime.Model, options, dt):
    """Between two samples, in blocks in which other lanes go on or have ended."""
    vectors = nominal(pendulum, "pd", 8)
    vectors[0][:, pendulum.parameter_names.index("rate_max")] = [0.2, 0.5, 1.0, 1.1, 1.2, 5.0, 6.0, 0.9]
    kernel = compile_kernel(pendulum, "pd", options=RunOptions(**options))
    block = kernel.run(0, *vectors, seed=0, t_end=3.0, dt=dt, save_every=dt)
    assert sorted(set(block.status.tolist())) == [Status.DONE, Status.LIMIT]
    equal(block, run_alone(pendulum, kernel, *vectors, t_end=3.0, dt=dt))
    rate = pendulum.state_names.index("rate")
    ended = block.status == Status.LIMIT
    limits = vectors[0][ended, pendulum.parameter_names.index("rate_max")]
    np.testing.assert_allclose(np.abs(block.final[ended, rate]), limits, rtol=1e-6)
    reached = np.maximum(block.maximum, -block.minimum)[ended, rate]
    np.testing.assert_array_equal(reached, np.abs(block.final[ended, rate]))


def test_a_lane_that_needs_too_many_steps_is_retired_alone():
    vectors = dispersed("slosh", "lyapunov-v2", 4)
    vectors[3][1, model("slosh").state_names.index("phi1_dot")] = 20.0
    kernel = compile_kernel(model("slosh"), "lyapunov-v2", options=RunOptions(rtol=1e-6, atol=1e-6, max_steps=40))
    block = kernel.run(0, *vectors, seed=0, t_end=2.0, dt=1.0, save_every=1.0)
    assert block.status.tolist() == [Status.DONE, Status.TOO_MANY_STEPS, Status.DONE, Status.DONE]
    equal(block, run_alone(model("slosh"), kernel, *vectors, t_end=2.0, dt=1.0))


def test_stops_on_demand():
    vectors = dispersed("slosh", "lyapunov-v1", 8)
    kernel = compile_kernel(model("slosh"), "lyapunov-v1")
    assert kernel.run(0, *vectors, seed=0, t_end=1e4, dt=0.1, stop=lambda: True) is None


def test_refuses_what_it_cannot_do():
    triangle, satellite = model("triangle"), model("satellite")
    with pytest.raises(InputError, match=r"profile = 'quick'.*portable or fast"):
        RunOptions(profile="quick")
    with pytest.raises(InputError, match=r"real = 'float'.*a batch computes in double"):
        Plan(triangle, Campaign("path", n=1, options={"real": "float"}))
    with pytest.raises(InputError, match=r"lanes = 3.*1, 2, 4, 8 or 16"):
        compile_kernel(triangle, "path", lanes=3)
    with pytest.raises(InputError, match=r"delay = 1.*hold"):
        Plan(triangle, Campaign("path", n=1, options={"delay": 1}))
    p, c, s, x0 = dispersed("satellite", "pd", 2)
    p[1, satellite.parameter_names.index("Ts")] *= 2
    with pytest.raises(InputError, match=r"Ts.*same in all runs"):
        compile_kernel(satellite, "pd").run(0, p, c, s, x0, seed=0, t_end=1.0, dt=0.5)


def test_a_long_function_compiles_without_scheduling_and_keeps_its_bits(monkeypatch: pytest.MonkeyPatch) -> None:
    def final() -> tuple[set[str], np.ndarray]:
        kernel = compile_kernel(model("triangle"), "path", options=RunOptions(rtol=1e-8, atol=1e-8))
        block = kernel.run(0, *nominal(model("triangle"), "path", 3), seed=0, t_end=2.0, dt=0.1)
        return set(kernel_flags(kernel.loop, "portable", kernel.lanes)), block.final

    flags, short = final()
    monkeypatch.setattr(kernel_module, "LONGEST_SCHEDULED", 0)
    fewer, long = final()
    assert flags - fewer == set(require_compiler().scheduling)
    assert fewer <= flags
    np.testing.assert_array_equal(short, long)


def test_runs_of_a_law_that_is_one_chain_fill_two_registers(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each run has the same bits, in a block that ends with idle lanes and with steps far ahead of others."""
    vectors = dispersed("triangle", "path", 5, spread=0.5)
    options = RunOptions(rtol=1e-8, atol=1e-8)
    monkeypatch.setattr(kernel_module, "_copies_registers", lambda: False)
    narrow = compile_kernel(model("triangle"), "path", options=options)
    expected = narrow.run(0, *vectors, seed=0, t_end=4.0, dt=0.1, save_every=0.1)
    for wide in {2 * widest(), 16}:
        monkeypatch.setattr(kernel_module, "suitable_lanes", lambda _, wide=wide: wide)
        kernel = compile_kernel(model("triangle"), "path", options=options)
        block = kernel.run(0, *vectors, seed=0, t_end=4.0, dt=0.1, save_every=0.1)
        equal(block, expected, (*EXACT, "metric_values", "error"))


def test_lanes_follow_the_longest_chain(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(kernel_module, "_copies_registers", lambda: True)

    def registers(name: str, law: str, **options: object) -> float:
        loaded = model(name)
        suffix, sampled = "", loaded.manifest.controller(law).period is not None
        loop = KernelLoop(loaded.manifest, loaded.manifest.controller(law), suffix, sampled, **options)
        return suitable_lanes(loop) / widest()

    assert registers("triangle", "path", method="dop853") == registers("triangle", "sliding", method="rk4") == 2
    assert registers("triangle", "path", method="rodas5p") == 1  # its matrices fill the registers
    assert registers("slosh", "lyapunov-v1", method="dop853") == registers("satellite", "pd", method="dop853") == 1
