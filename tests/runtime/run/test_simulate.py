# SPDX-License-Identifier: Apache-2.0
"""Closed loops against SciPy and against hand computation; early ends; what is refused."""

from __future__ import annotations

import ctypes
import math
import os
import signal
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.integrate._ivp import dop853_coefficients

from mehvar import runtime
from mehvar.base.manifest import FILE, Output
from mehvar.runtime import InputError, Model, Status, load, simulate
from mehvar.runtime.batch.kernel import compile_kernel
from mehvar.runtime.compiling.library import load_native
from mehvar.runtime.run.calls import loop_calls
from mehvar.runtime.run.options import OPTIONS, RunOptions
from tests.reference.scipy_loop import by_scipy

Edit = Callable[[str, str, str], Path]
Array = NDArray[np.float64]


def test_what_a_law_reports_above_its_most_is_told_from_the_first_sample_to_the_last(pendulum):
    report = Output("strain", "N", "strain", at_most=2.0)
    run = simulate(pendulum, "pd", t_end=1.0, dt_out=0.1)
    for above in ([3, 4, 8], [5], [0, 9], [], list(range(11))):
        strain = np.full((11, 1), 2.0)
        strain[above, 0] += 1.0 + np.arange(len(above))
        law = replace(run.controller, outputs=(report,))
        texts = replace(run, controller=law, w=strain).exceeded()
        if not above:
            assert texts == []
            continue
        first, last = run.t[above[0]], run.t[above[-1]]
        assert texts == [
            f"strain is above 2 N at {len(above)} of 11 samples from t = {first:.6g} s to {last:.6g} s, "
            f"most at t = {last:.6g} s: {2 + len(above)} N"
        ]
        assert run.options["t_end"] == run.t[-1]
        low = replace(run.controller, outputs=(replace(report, at_most=math.inf, at_least=-2.0),))
        mirrored = [text.replace("above 2", "below -2").replace("s: ", "s: -") for text in texts]
        assert replace(run, controller=low, w=-strain).exceeded() == mirrored


@pytest.fixture(params=["c", "python"])
def model(request: pytest.FixtureRequest, pendulum: Model, slow_pendulum: Model) -> Model:
    return pendulum if request.param == "c" else slow_pendulum


def reference(model: Model, times: Array, x0: Array, torque: Callable[[float, Array], float], **p: float) -> Array:
    """Integrate the pendulum with SciPy at its tightest."""
    values = model.parameters(**p)
    result = solve_ivp(
        lambda t, x: model.rhs(x, [torque(t, x)], values),
        (times[0], times[-1]),
        x0,
        method="DOP853",
        t_eval=times,
        rtol=1e-13,
        atol=1e-13,
    )
    return np.asarray(result.y.T)


def pd_torque(t: float, x: Array) -> float:
    return float(-20.0 * (x[0] - 0.5) - 2 * np.sqrt(20.0) * x[1])


def test_dop853_has_the_published_coefficients() -> None:
    library = load_native()
    for name, expected in {
        "mv_dop853_a": dop853_coefficients.A,
        "mv_dop853_b": dop853_coefficients.B,
        "mv_dop853_c": dop853_coefficients.C,
        "mv_dop853_e3": dop853_coefficients.E3,
        "mv_dop853_e5": dop853_coefficients.E5,
        "mv_dop853_dense": dop853_coefficients.D,
    }.items():
        coefficients = np.ctypeslib.as_array((ctypes.c_double * expected.size).in_dll(library, name))
        np.testing.assert_array_equal(coefficients.reshape(expected.shape), expected, err_msg=name)


class Tableau(ctypes.Structure):
    """The first fields of a method's coefficients in C."""

    _fields_ = [
        *((name, ctypes.c_int) for name in ("stages", "order", "end_in_error")),
        *((name, ctypes.POINTER(ctypes.c_double)) for name in ("a", "b", "c", "e", "e3", "g", "d")),
        *((name, ctypes.c_int) for name in ("dense", "slopes")),
        ("dense_g", ctypes.POINTER(ctypes.c_double)),
    ]


@pytest.mark.parametrize(("number", "order"), [(0, 4), (1, 5), (2, 8)], ids=["rk4", "dopri5", "dop853"])
def test_explicit_methods_have_the_order_they_are_known_for(number: int, order: int) -> None:
    """Stages stand where the sums of their rows are; polynomials in time alone are integrated up to the order."""
    method = (Tableau * 3).in_dll(load_native(), "mv_tableaux")[number]
    n = method.stages
    a = np.ctypeslib.as_array(method.a, (n, 16))[:, :n]
    b, c = (np.ctypeslib.as_array(values, (n,)) for values in (method.b, method.c))
    np.testing.assert_allclose(a.sum(axis=1), c, atol=1e-13)
    for power in range(order):
        assert b @ c**power == pytest.approx(1 / (power + 1), abs=1e-13)
    assert b @ a @ c == pytest.approx(1 / 6, abs=1e-13)


@pytest.mark.parametrize(("method", "tolerance"), [("dop853", 1e-9), ("dopri5", 1e-8), ("rock4", 1e-8), ("rk4", 1e-7)])
@pytest.mark.share(2)
def test_continuous_loop_against_scipy(model: Model, method: Any, tolerance: float) -> None:
    run = simulate(model, "pd", method=method)
    assert run.status is Status.DONE
    assert run.reason == "end time reached"
    expected = reference(model, run.t, np.array([1.0, 0.0]), pd_torque)
    np.testing.assert_allclose(run.x, expected, atol=tolerance)
    np.testing.assert_allclose(run.u[:, 0], [pd_torque(0.0, x) for x in run.x], atol=1e-12)
    np.testing.assert_array_equal(run.u, run.u_cmd)
    np.testing.assert_allclose(run.y[:, 1], run.x[:, 0] - 0.5)
    np.testing.assert_allclose(run.y[:, 2], run.u[:, 0] * run.x[:, 1])


def test_scipy_agrees_and_called_back_functions_do_to_rounding(pendulum: Model, slow_pendulum: Model) -> None:
    for law, options in (("pd", {}), ("pd", {"hold": 0.02, "delay": 2}), ("p-sum", {"delay": 1})):
        fast, slow = (simulate(m, law, ref_rate=0.3, **options) for m in (pendulum, slow_pendulum))
        with by_scipy():
            other = simulate(pendulum, law, ref_rate=0.3, **options)
        for name, values in fast.variables().items():
            np.testing.assert_allclose(values, slow.variables()[name], atol=1e-13, err_msg=f"{law} {name}")
            np.testing.assert_allclose(values, other.variables()[name], atol=2e-9, err_msg=f"{law} {name}")
        np.testing.assert_array_equal(fast.t, other.t)


def test_a_law_elsewhere_is_asked_for_a_sampled_one_in_c(pendulum: Model, slow_pendulum: Model) -> None:
    usual = simulate(pendulum, "pd", hold=0.1, t_end=1.0)

    def elsewhere(x: Array, r: Array, _: Array, z: Array) -> tuple[Array, Array]:
        return np.asarray(pendulum.functions["pd"](x, r, usual.parameters.p, usual.parameters.c)), z

    run = simulate(pendulum, "pd", hold=0.1, t_end=1.0, law=elsewhere)
    np.testing.assert_array_equal(run.x, usual.x)
    others: list[tuple[Model, dict[str, Any]]] = [(pendulum, {}), (slow_pendulum, {"hold": 0.1})]
    for other, options in others:
        with pytest.raises(InputError, match=r"law = .*left out unless a sampled law runs on the C backend"):
            simulate(other, "pd", law=elsewhere, **options)


def test_moving_reference(model: Model) -> None:
    run = simulate(model, "pd", ref_rate=0.7)
    moving = reference(model, run.t, np.array([1.0, 0.0]), lambda t, x: pd_torque(t, x) + 20.0 * 0.7 * t)
    np.testing.assert_allclose(run.x, moving, atol=1e-9)
    np.testing.assert_allclose(run.y[:, 1], run.x[:, 0] - (0.5 + 0.7 * run.t), atol=1e-14)


def test_constant_reference_is_evaluated_once(edited: Edit, pendulum: Model) -> None:
    constant = runtime.load(edited(FILE, '"reference_constant": false', '"reference_constant": true'), backend="c")
    for options, tolerance in (({"hold": 0.05}, 0.0), ({}, 1e-10)):  # without hold, steps pass over samples
        runs = [simulate(model, "pd", **options).x for model in (constant, pendulum)]
        np.testing.assert_allclose(*runs, rtol=0, atol=tolerance)


def test_samples_are_at_multiples_of_the_step(model: Model) -> None:
    run = simulate(model, "pd", t_end=0.7, dt_out=0.1)
    assert run.t.tolist() == [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7]
    assert run.t[-1] == run.t_stop == 0.7
    held = simulate(model, "pd", t_end=0.7, dt_out=0.1, hold=0.025)
    np.testing.assert_array_equal(held.t, run.t)


def test_end_between_samples_is_sampled(model: Model) -> None:
    run = simulate(model, "pd", t_end=0.25, dt_out=0.1)
    np.testing.assert_array_equal(run.t, [0.0, 0.1, 0.2, 0.25])
    exact = reference(model, run.t, np.array([1.0, 0.0]), pd_torque)
    np.testing.assert_allclose(run.x, exact, atol=1e-9)
    np.testing.assert_array_equal(simulate(model, "pd", t_end=0.004).t, [0.0, 0.004])


def test_rk4_is_of_fourth_order(pendulum: Model) -> None:
    exact = simulate(pendulum, "pd", t_end=1.0, rtol=1e-13, atol=1e-13).x[-1]
    steps = np.array([0.05, 0.025, 0.0125])
    errors = [
        np.max(np.abs(simulate(pendulum, "pd", t_end=1.0, dt_out=0.5, method="rk4", step=h).x[-1] - exact))
        for h in steps
    ]
    slope = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert slope == pytest.approx(4.0, abs=0.15)


@pytest.mark.parametrize("method", ["dop853", "dopri5", "rock4"])
def test_error_follows_the_tolerance(pendulum: Model, method: Any) -> None:
    options: dict[str, Any] = {"t_end": 10.0, "dt_out": 10.0, "angle_0": 3.0, "k_p": 9.9, "k_d": 0.0}
    exact = simulate(pendulum, "pd", rtol=1e-13, atol=1e-13, **options).x[-1]
    for tolerance in (1e-4, 1e-7, 1e-10):
        run = simulate(pendulum, "pd", method=method, rtol=tolerance, atol=tolerance, **options)
        assert np.max(np.abs(run.x[-1] - exact)) < 200 * tolerance
        assert run.statistics["steps"] > 10


def test_step_size_survives_the_samples(pendulum: Model) -> None:
    fine = simulate(pendulum, "pd", dt_out=0.001)
    assert fine.statistics["steps"] == 2000
    assert fine.statistics["rejected"] == 0
    assert simulate(pendulum, "pd", dt_out=1.0).statistics["steps"] < 100


@pytest.mark.parametrize("delay", [0, 1, 3])
def test_hold_and_delay_by_hand(model: Model, delay: int) -> None:
    hold, count, z, inputs = 0.05, 12, 0.25, [0.0] * delay
    x, states, memory = np.array([1.0, 0.2]), [], []
    for _ in range(count):
        states.append(x)
        memory.append(z)
        error = x[0] - 0.5
        inputs.append(-2.0 * error - 0.5 * z)
        z += error
        applied = inputs[len(states) - 1]
        x = reference(model, np.array([0.0, hold]), x, lambda _t, _x, u=applied: u)[-1]  # type: ignore[misc]
    run = simulate(model, "p-sum", delay=delay, dt_out=hold, t_end=(count - 1) * hold, initial={"rate": 0.2})
    np.testing.assert_allclose(run.x, states, atol=1e-9)
    np.testing.assert_allclose(run.u[:, 0], inputs[:count], atol=1e-9)
    np.testing.assert_allclose(run.u_cmd[:, 0], inputs[delay : count + delay], atol=1e-9)
    np.testing.assert_allclose(run.z[:, 0], memory, atol=1e-9)
    assert run.hold == hold


def test_recording_does_not_change_a_sampled_run(model: Model) -> None:
    every = simulate(model, "p-sum", dt_out=0.05)
    coarse, fine = simulate(model, "p-sum", dt_out=0.2), simulate(model, "p-sum", dt_out=0.01)
    np.testing.assert_allclose(coarse.x, every.x[::4], atol=1e-13)
    np.testing.assert_allclose(fine.x[::5], every.x, atol=1e-9)
    for i in range(5):
        np.testing.assert_allclose(fine.u[i:-1:5], every.u[:-1], atol=1e-9)
        np.testing.assert_allclose(fine.z[i + 1 :: 5], every.z[1:], atol=1e-9)


def test_hold_of_a_continuous_law_tends_to_the_continuous_loop(pendulum: Model) -> None:
    exact = simulate(pendulum, "pd").x[-1]
    errors = [np.max(np.abs(simulate(pendulum, "pd", hold=h).x[-1] - exact)) for h in (0.01, 0.001)]
    assert errors[1] < errors[0] / 5


def test_not_finite_derivative_ends_the_run(model: Model) -> None:
    run = simulate(model, "pd", t_end=5.0, angle_ref=2.0, k_wall=0.1, wall=1.2)
    assert run.status is Status.NOT_FINITE
    assert run.reason.startswith("the state derivative is not finite at t = ")
    assert 0 < run.t_stop < 5.0
    assert run.t[-1] <= run.t_stop < run.t[-1] + 0.011
    assert np.all(np.isfinite(run.x))
    assert run.x[-1, 0] < 1.2


def test_not_finite_from_the_start(model: Model) -> None:
    run = simulate(model, "pd", k_wall=0.1, wall=0.9)
    assert (run.status, run.t_stop, len(run.t)) == (Status.NOT_FINITE, 0.0, 1)


def test_not_finite_input_names_the_law(edited: Edit) -> None:
    copy = edited("pendulum.c", "u[0] = -c[0] * (x[0] - r[0]) - c[1] * z[0];", "u[0] = mv_sqrt(x[0]);")
    run = simulate(runtime.load(copy, backend="c"), "p-sum", t_end=5.0, dt_out=0.05)
    assert run.status is Status.NOT_FINITE
    assert run.reason.startswith("the input torque of p-sum is not finite at t = ")
    assert run.x[-1, 0] < 0 < run.x[-2, 0]


@pytest.mark.parametrize("options", [{}, {"hold": 0.01}, {"method": "dopri5"}])
def test_blow_up_in_finite_time_ends_the_run(model: Model, options: dict[str, Any]) -> None:
    run = simulate(model, "pd", cube=100.0, rate_max=1e300, torque_max=1e300, t_end=100.0, **options)
    assert run.status in (Status.NOT_FINITE, Status.STEP_UNDERFLOW)
    assert 0 < run.t_stop < 5.0
    assert np.all(np.isfinite(run.x))


def test_blow_up_ends_a_fixed_step_run(model: Model) -> None:
    run = simulate(model, "pd", cube=100.0, rate_max=1e300, torque_max=1e300, t_end=100.0, method="rk4")
    assert run.status is Status.NOT_FINITE
    assert np.all(np.isfinite(run.x))


@pytest.mark.parametrize("options", [{}, {"hold": 0.01}, {"method": "rk4", "step": 0.001}])
def test_limit_ends_the_run(model: Model, options: dict[str, Any]) -> None:
    run = simulate(model, "pd", rate_max=1.0, dt_out=0.01, **options)
    assert run.status is Status.LIMIT
    assert run.reason.startswith("the rate -1")
    assert " rad/s reached 1 rad/s (at t = 0.0" in run.reason
    before = len(run.t) - 1
    assert run.t[before - 1] < run.t_stop <= run.t[before - 1] + 0.0101
    assert run.t[before] == run.t_stop
    assert abs(run.x[before, 1]) >= 1.0
    assert np.all(np.abs(run.x[:before, 1]) < 1.0)
    free = simulate(model, "pd", **options)
    np.testing.assert_allclose(run.x[:before], free.x[:before], atol=1e-9)
    assert abs(free.x[before, 1]) > 1.0


@pytest.mark.parametrize("options", [{}, {"hold": 0.01}, {"hold": 0.01, "delay": 2}, {"method": "rk4"}])
def test_limit_of_the_input_ends_the_run(model: Model, options: dict[str, Any]) -> None:
    run = simulate(model, "pd", ref_rate=10.0, angle_0=0.5, torque_max=8.0, **options)
    assert run.status is Status.LIMIT
    assert run.reason.startswith("the torque reached 8 N m (at t = ")
    assert np.all(run.u[:-1] < 8.0)
    free = simulate(model, "pd", ref_rate=10.0, angle_0=0.5, **options)
    first = free.t[np.argmax(free.u_cmd[:, 0] > 8.0)]
    assert run.t_stop == pytest.approx(first, abs=0.0101)


@pytest.mark.parametrize("options", [{}, {"method": "rk4", "step": 1e-4}, {"hold": 10.0}])
def test_too_many_steps_end_the_run(model: Model, options: dict[str, Any]) -> None:
    run = simulate(model, "pd", t_end=10.0, dt_out=10.0, max_steps=5, **options)
    assert run.status is Status.TOO_MANY_STEPS
    assert run.reason.startswith("more than 5 steps from one sample to the next at t = ")
    assert run.t.tolist() == [0.0, run.t_stop]
    hold = {"hold": run.t_stop} if "hold" in options else {}
    whole = simulate(model, "pd", t_end=run.t_stop, dt_out=run.t_stop, **hold)
    np.testing.assert_allclose(run.x[-1], whole.x[-1], atol=1e-8)


CONSTANT = (FILE, '"reference_constant": false', '"reference_constant": true')
"""Steps of a continuous loop pass over samples under a reference that does not move."""


@pytest.mark.parametrize("backend", ["c", "python"])
def test_trials_are_counted_from_one_sample_to_the_next(edited: Edit, folder: Path, backend: Any) -> None:
    """Steps pass over samples, or stop there."""
    passing, stopping = (runtime.load(place, backend=backend) for place in (edited(*CONSTANT), folder))
    every = {"dt_out": 0.5}
    for model, options in ((passing, every), (stopping, every), (stopping, {"dt_out": 0.1, "hold": 0.1})):
        run = simulate(model, "pd", t_end=8.0, max_steps=20, **options)
        assert run.status is Status.DONE
        assert run.statistics["steps"] > 40


@pytest.mark.parametrize("backend", ["c", "python"])
def test_a_limit_is_held_at_samples_that_a_step_passes_over(edited: Edit, backend: Any) -> None:
    """The rate is beyond it for four samples, and at the end of no step."""
    model = runtime.load(edited(*CONSTANT), backend=backend)
    options: dict[str, Any] = {"k_d": 0.0, "rtol": 1e-4, "atol": 1e-4, "t_end": 2.0, "dt_out": 0.01}
    free = simulate(model, "pd", **options)
    rate = np.abs(free.x[:, 1])
    run = simulate(model, "pd", rate_max=float(np.sort(rate)[-4]), **options)
    assert run.status is Status.LIMIT
    assert run.t_stop == free.t[np.argmax(rate >= np.sort(rate)[-4])]


def test_progress_and_interrupt(pendulum: Model) -> None:
    seen: list[float] = []
    simulate(pendulum, "pd", t_end=200.0, progress=lambda t, end: seen.append(t / end))
    assert len(seen) > 3
    assert seen == sorted(seen)
    assert seen[-1] == 1.0

    def interrupt(t: float, _end: float) -> None:
        if t > 1.0:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        simulate(pendulum, "pd", t_end=1e4, progress=interrupt)


def test_interrupt_from_the_keyboard(pendulum: Model) -> None:
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # ignored where the tests are a background job
    timer = threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    start = time.perf_counter()
    try:
        with pytest.raises(KeyboardInterrupt):
            simulate(pendulum, "pd", t_end=1e5, dt_out=1.0, hold=0.01)
    finally:
        signal.signal(signal.SIGINT, before)
    assert time.perf_counter() - start < 3.0


def test_chunks_do_not_change_the_result(pendulum: Model, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = simulate(pendulum, "p-sum", t_end=20.0, delay=2)
    monkeypatch.setattr(runtime.run.loop, "_CHUNK_SECONDS", 0.0)
    single = simulate(pendulum, "p-sum", t_end=20.0, delay=2)
    np.testing.assert_array_equal(whole.x, single.x)
    np.testing.assert_array_equal(whole.u, single.u)


def test_initial_state(model: Model) -> None:
    run = simulate(model, "pd", initial={"angle": -0.3})
    np.testing.assert_array_equal(run.x[0], [-0.3, 0.0])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"initial": {"angel": 1.0}}, r"unknown state 'angel' of .* \(from --set\): did you mean angle"),
        ({"initial": {"angle": float("nan")}}, r"angle = nan \(from --set\): must be a finite number"),
        (
            {"initial": {"rate": 60.0}},
            r"initial state \(from scenario swing with rate from --set\) is outside the limits: the rate 60",
        ),
        (
            {"torque_max": -1.0},
            r"\(from scenario swing with torque_max from --set\) is outside the limits: the torque reached -1",
        ),
        ({"rate_0": 60.0}, r"initial state \(from scenario swing with rate_0 from --set\) is outside the limits"),
        ({"scenario": "swingg"}, "unknown scenario 'swingg' of pendulum: did you mean swing"),
        ({"t_end": 0.0}, r"t_end = 0.0 \(from --set\): must be a number > 0"),
        ({"t_end": float("inf")}, "t_end = inf .*: must be a finite number"),
        ({"t_end": 1e9}, "t_end = 1000000000.0 .* at most 20000000 times"),
        ({"t_end": 1e3, "dt_out": 1e-4}, "dt_out = 0.0001 .* at least 0.0002 s, for 5000000 samples"),
        ({"dt_out": -1}, "dt_out = -1 .*: must be a number > 0"),
        ({"hold": 0.015}, r"hold = 0.015 s \(from --set\) and dt_out = 0.01 s \(from scenario swing\): one must be"),
        ({"hold": "x"}, "hold = 'x' .*: must be a number"),
        ({"delay": 1}, "delay = 1 .* left out unless the law is sampled"),
        ({"delay": -1, "hold": 0.01}, "delay = -1 .*: must be a whole number >= 0"),
        ({"delay": 0.5, "hold": 0.01}, "delay = 0.5 .*: must be a whole number >= 0"),
        ({"method": "heun"}, "method = 'heun' .*: must be rk4, dopri5, dop853, rock4, rodas5p, euler, platen or auto"),
        ({"method": "euler"}, "method = 'euler' .*: must be another one: pendulum has no process noise"),
        ({"rtol": 1e-15}, r"rtol = 1e-15 .*: must be a number >= 2.22e-14 and < 1"),
        ({"atol": 0.0}, "atol = 0.0"),
        ({"step": 0.0, "method": "rk4"}, "step = 0.0 .*: must be a number > 0"),
        ({"max_steps": 0}, "max_steps = 0 .*: must be a whole number >= 1"),
        ({"parameters": {"m": 1.0}, "m": 2.0}, r"m is given twice \(from --set\)"),
        ({"k_pp": 1.0}, r"unknown parameter or option 'k_pp' of pendulum with pd \(from --set\): did you mean k_p"),
        ({"t_ned": 1.0}, "did you mean t_end"),
        ({"initial": {"angle_0": 1.0}}, "angle_0 is a parameter of the scenario: give it beside initial; known: angle"),
    ],
)
def test_bad_input(model: Model, options: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        simulate(model, "pd", origin="--set", **options)


@pytest.mark.parametrize("name", [*(name for name, row in OPTIONS.items() if row.kind != "word"), "m", "k_p"])
def test_a_text_is_no_number(model: Model, name: str) -> None:
    with pytest.raises(InputError, match=rf"^{name} = '1' \(from the call\): must be a number"):
        simulate(model, "pd", **{name: "1"})  # type: ignore[arg-type]


def test_a_law_is_sampled_by_its_own_period(model: Model) -> None:
    period = simulate(model, "p-sum", t_end=0.1).hold
    assert simulate(model, "p-sum", t_end=0.1, hold=period).hold == period
    with pytest.raises(InputError, match=r"hold = 0.1 .*: must be left out, or 0.05 s, the period .*: set Ts"):
        simulate(model, "p-sum", hold=0.1)
    assert simulate(model, "p-sum", t_end=0.2, hold=0.1, Ts=0.1).hold == 0.1
    kernel = compile_kernel(load(model.manifest.folder, "c"), "p-sum", options=RunOptions(hold=0.1))
    with pytest.raises(InputError, match=r"hold = 0.1 .*: must be left out, or 0.05 s"):
        kernel.check(model.parameters()[None], 1.0, 0.1)


@pytest.mark.parametrize(("end", "periods"), [(1.0, 20), (0.97, 20), (0.06, 2), (0.05, 1)])
def test_a_delay_ends_before_the_run(model: Model, end: float, periods: int) -> None:
    """The input computed first must act at some time of the run."""
    if periods > 1:
        run = simulate(model, "p-sum", t_end=end, dt_out=0.01, delay=periods - 1, initial={"angle": 0.5})
        assert run.u[:, 0].any()
    with pytest.raises(InputError, match=f"delay = {periods} .*: must be less than {periods}, the number of periods"):
        simulate(model, "p-sum", t_end=end, dt_out=0.01, delay=periods)


def test_loaded_model_keeps_its_backend(pendulum: Model) -> None:
    with pytest.raises(InputError, match=r"backend = 'python' .*: must be 'c', as the model was loaded"):
        simulate(pendulum, "pd", backend="python")


def test_unknown_controller(model: Model) -> None:
    with pytest.raises(InputError, match=r"unknown controller 'pdd' of pendulum: did you mean pd\? known: pd, p-sum"):
        simulate(model, "pdd")


def test_a_law_with_memory_and_no_period_is_refused(edited: Edit) -> None:
    with pytest.raises(InputError, match=r"functions.p_sum = 'x r v .*: must be 'x r z p"):
        runtime.load(edited(FILE, '"period": "Ts"', '"period": null'), backend="python")


def test_functions_of_another_signature_are_refused(edited: Edit, slow_pendulum: Model) -> None:
    observe = '"pd_observe": {"description": "", "args": [["%s", 2], '
    copy = edited(FILE, observe % "q", observe % "w")
    with pytest.raises(InputError, match=r"functions.pd_observe = 'w r p c .*: must be 'q r p c"):
        runtime.load(copy)
    edited(FILE, observe % "w", observe % "q")
    copy = edited(
        FILE, '"outputs_jac": {"description": "", "args": [["x"', '"outputs_jac": {"description": "", "args": [["w"'
    )
    with pytest.raises(InputError, match="PENDULUM_OUTPUTS_JAC_NW is nothing"):
        simulate(runtime.load(copy, backend="c"), "pd")
    copy = edited(FILE, '"swing": {"description": "", "args": [["l"', '"swing": {"description": "", "args": [["w"')
    with pytest.raises(InputError, match=r"SIZES\['swing'\] is"):
        simulate(runtime.load(copy, backend="python"), "pd")
    manifest = slow_pendulum.manifest
    other = {name: function for name, function in manifest.functions.items() if name != "pd_observe"}
    with pytest.raises(InputError, match=r"lacks the function pd_observe; generate the model again"):
        loop_calls(replace(manifest, functions=other), manifest.controllers["pd"], "", sampled=False)
    loop = manifest.functions["pd_loop"]
    turned = manifest.functions | {"pd_loop_fast": replace(loop, name="pd_loop_fast", arguments=loop.arguments[::-1])}
    with pytest.raises(InputError, match=r"pd_loop_fast takes c p r q, must be q r p c; generate the model again"):
        loop_calls(replace(manifest, functions=turned), manifest.controllers["pd"], "_fast", sampled=False)


def test_model_by_folder(folder: Path) -> None:
    run = simulate(folder, "pd", backend="c", t_end=0.1)
    assert (run.backend, run.status) == ("c", Status.DONE)
    assert run.compile_seconds > 0
    assert run.run_seconds > 0
    assert run.options["method"] == "dop853"
    assert run.parameters.values["k_p"] == 20.0
