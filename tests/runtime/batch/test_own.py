# SPDX-License-Identifier: Apache-2.0
"""A law in Python in a batch: called once a sample for all runs, and every run the one that it is alone."""

from __future__ import annotations

import decimal
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mehvar
from mehvar import runtime
from mehvar.base.errors import InputError
from mehvar.models.parts import Gyro, Hub, Spacecraft
from mehvar.runtime.batch.repeat import SESSION_LAWS, plan_of
from mehvar.runtime.batch.store.store import open_store
from mehvar.runtime.run.problem import Status
from mehvar.runtime.run.user.law import LawError, python_law

VARY = {"m": "normal(1, 0.05)", "angle": "uniform(-0.5, 0.5)"}
N = 37  # no multiple of any number of lanes
OWN = {"period": 0.05, "memory": [0.25], "t_end": 1.0}


def p_sum(_t, x, z):
    """The same text for one run and for many."""
    error = x.angle - x.angle_ref
    return -2.0 * error - 0.5 * z, z + error


def batch(model: runtime.Model, **arguments: Any) -> Any:
    return mehvar.batch(model, n=N, seed=3, vary=VARY, save=0.01, threads=2, **arguments)


def test_every_run_is_that_of_the_generated_law_and_that_alone(pendulum: runtime.Model) -> None:
    own = batch(pendulum, controller=p_sum, **OWN)
    generated = batch(pendulum, controller="p-sum", parameters={"Ts": 0.05}, t_end=1.0)
    for name in ("angle", "rate", "u_torque", "u_cmd_torque", "energy", "final", "steps", "status"):
        np.testing.assert_array_equal(own[name], generated[name], name)
    np.testing.assert_array_equal(own["memory_1"], generated["sum"])
    assert own.attrs["controller"] == "python:p_sum"
    assert "def p_sum" in own.attrs["law"]
    alone = mehvar.simulate(
        pendulum, p_sum, parameters={"m": float(own["m"][5])}, initial={"angle": float(own["initial_angle"][5])}, **OWN
    )
    for name in ("angle", "u_torque", "memory_1"):
        np.testing.assert_array_equal(own[name][5], alone[name], name)
    assert float(own["peak"][5]) == float(alone["peak"])


def test_it_is_called_once_a_sample_with_a_column_for_each_run(pendulum: runtime.Model) -> None:
    shapes = []

    def law(t, x, z):
        shapes.append((t, x.shape, x.angle.shape, x.r.shape, z.shape))
        return [0.0], z

    batch(pendulum, controller=law, **OWN)
    assert [t for t, *_ in shapes] == pytest.approx(np.arange(21) * 0.05)
    assert {tuple(rest) for _, *rest in shapes} == {((2, N), (N,), (1, N), (1, N))}


def test_a_law_has_the_context_of_the_caller(pendulum: runtime.Model) -> None:
    def law(t, x, z):
        return [float(decimal.Decimal(1) / 3)], z

    with decimal.localcontext(prec=3):
        many = batch(pendulum, controller=law, **OWN)
        one = mehvar.simulate(pendulum, law, **OWN)
    assert float(many["u_torque"][5, 0]) == float(one["u_torque"][0]) == 0.333


def test_noise_and_delay_are_those_of_a_single_run() -> None:
    def law(_t, x):
        return [-0.06 * x.roll - 1.2 * x.wx, 0.0, -0.01 * x.yaw]

    options: dict[str, Any] = {"scenario": "flight", "period": 0.5, "t_end": 5.0, "delay": 1}
    many = mehvar.batch("satellite", law, 3, seed=2, save=0.5, **options)
    one = mehvar.simulate("satellite", law, seed=2, run=1, **options)
    for name in ("roll", "u_Tx", "u_cmd_Tz"):
        np.testing.assert_array_equal(many[name][1], one[name], name)
    assert not np.array_equal(many["roll"][0], many["roll"][1])


def test_a_run_without_a_finite_input_ends_and_its_neighbours_do_not(pendulum: runtime.Model) -> None:
    lost = batch(
        pendulum,
        controller=lambda t, x: np.where((x.angle > 0) & (0.08 < t < 0.12), np.nan, 0.0),
        **{**OWN, "memory": None},
    )
    ended = lost["status"].values == Status.NOT_FINITE
    assert 0 < ended.sum() < N
    np.testing.assert_array_equal(lost["t_stop"].values == 1.0, ~ended)


def test_inputs_over_time_are_the_same_in_all_runs(pendulum: runtime.Model) -> None:
    inputs = {"torque": ([0.0, 0.5], [1.0, -1.0])}
    many = batch(pendulum, inputs=inputs, t_end=1.0)
    assert (many["u_torque"].values == np.where(many["t"].values < 0.5, 1.0, -1.0)).all()
    assert many.attrs["controller"] == "none"


def test_a_store_goes_on_under_the_same_text_only(pendulum: runtime.Model, tmp_path) -> None:
    out = tmp_path / "runs.zarr"
    batch(pendulum, controller=p_sum, out=out, **OWN)
    batch(pendulum, controller=p_sum, out=out, resume=True, **OWN)

    def other(_t, x, z):
        return -x.angle, z

    other.__name__ = "p_sum"
    for change in ({"controller": other}, {"controller": p_sum, "memory": [2.0]}):
        with pytest.raises(InputError, match="was made with law = "):
            batch(pendulum, out=out, resume=True, **{**OWN, **change})
    with pytest.raises(InputError, match="the law in Python cannot be identified: a lambda cannot be recorded"):
        batch(pendulum, controller=lambda _t, x, z: (-x.angle, z), out=out, resume=True, **OWN)
    assert repeated(out, pendulum) is not None
    SESSION_LAWS.clear()  # as in another session
    with pytest.raises(InputError, match="ran under python:p_sum, a law in Python that is not defined here"):
        repeated(out, pendulum)


def test_inputs_go_on_between_their_instants_as_they_began(pendulum: runtime.Model, tmp_path) -> None:
    options = {"inputs": {"torque": ([0.0, 0.1], [0.0, 1.0])}, "period": 0.05, "t_end": 0.1, "out": tmp_path / "a.zarr"}
    batch(pendulum, interpolation="hold", **options)
    with pytest.raises(InputError, match="was made with law = "):
        batch(pendulum, interpolation="linear", resume=True, **options)


def repeated(out: Any, model: runtime.Model) -> Any:
    return plan_of(open_store(out), model)


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({"controller": p_sum}, InputError, "period = None.*in Python are evaluated at samples only"),
        ({"inputs": {"torque": np.sin}}, InputError, "period = None"),
        ({"controller": p_sum, "period": 0.05, "hold": 0.05}, InputError, "hold = 0.05.*use period for other laws"),
        ({"controller": "p-sum", "period": 0.05}, InputError, "period = 0.05.*hold says"),
        ({}, InputError, "a batch needs n, the number of runs"),
        ({"controller": lambda _t, x: 1.0 if x.angle > 0 else 0.0, "period": 0.05}, LawError, "numpy.where decides"),
        ({"controller": lambda _t, x: x[:, :2], "period": 0.05}, LawError, r"t = 0 s .*\(2, 2\): must be .*\(1, 37\)"),
    ],
)
def test_what_a_batch_cannot_run_is_refused(
    pendulum: runtime.Model, arguments: dict[str, Any], error: type[Exception], message: str
) -> None:
    with pytest.raises(error, match=message):
        batch(pendulum, t_end=1.0, **arguments)


def test_a_law_of_a_model_without_inputs_returns_none_of_them() -> None:
    craft = Spacecraft("bare")
    craft.add(Hub("hub", mass=10.0, inertia=(1.0, 1.5, 2.0)))
    craft.add(Gyro("gyro", noise=1e-3))
    model = mehvar.build(craft)
    assert mehvar.batch(model, lambda _t, _x: [], n=4, period=0.1, t_end=0.5).sizes["run"] == 4
    with pytest.raises(
        LawError, match=r"returned u = 1.0: must be numbers of shape \(0, 4\), one for each of no inputs"
    ):
        mehvar.batch(model, lambda _t, _x: 1.0, n=4, period=0.1, t_end=0.5)


def test_a_memory_that_is_not_finite_ends_its_run_as_in_a_single_one(pendulum: runtime.Model) -> None:
    def counting(t, x, z):
        return 0.0 * x[:1], np.where((z > 4) & (x[0] > 0), np.nan, z + 1)

    options = {"period": 0.05, "memory": [0.0], "t_end": 0.3}
    runs = mehvar.batch(pendulum, counting, vary={"angle": [0.2, -0.2]}, **options)
    assert runs["status"].values.tolist() == [Status.NOT_FINITE, Status.DONE]
    assert runs["t_stop"].values.tolist() == pytest.approx([0.25, 0.3])
    with pytest.raises(LawError, match=r"at t = 0\.25 s returned z_next"):
        mehvar.simulate(pendulum, counting, initial={"angle": 0.2}, **options)


@pytest.fixture(scope="module")
def turning() -> runtime.Model:
    """A craft with three torques, whose law may be a product of matrices."""
    return mehvar.load("satellite")


def gains(_t, x):
    """BLAS has functions of their own for a product with one column, which round it otherwise."""
    error = np.stack([x.roll - x.ref_roll, x.pitch - x.ref_pitch, x.yaw - x.ref_yaw, x.wx, x.wy, x.wz])
    return GAINS @ error


GAINS = np.random.default_rng(3).normal(0, 0.003, (3, 6)) - np.hstack([0.05 * np.eye(3), 0.6 * np.eye(3)])


def test_a_law_of_matrices_is_repeated_bit_for_bit(turning: runtime.Model, tmp_path: Path) -> None:
    options = {"controller": gains, "period": 0.5, "t_end": 5.0, "n": 70, "vary": {"roll": "uniform(-0.3, 0.3)"}}
    mehvar.batch(turning, **options, out=tmp_path / "runs.zarr")
    whole = mehvar.batch(turning, **options)
    for runs in (mehvar.open_result(tmp_path / "runs.zarr"), whole, whole.drop_encoding()):
        for number in (0, 33, 64, 69):
            runs.mehvar.again(number)  # raises an error for other bits


def test_a_law_for_some_runs_has_their_columns_of_all(turning: runtime.Model) -> None:
    own = python_law(gains, turning.manifest, 0.5, None, "the call")
    rng, z = np.random.default_rng(1), np.empty((0, 70))
    x, r = (rng.normal(size=(len(of), 70)) for of in (turning.manifest.seen, turning.manifest.references))
    every, _ = own.command(0.0, x, r, z)
    for some in ([3, 40, 69], *range(70)):
        places = some if isinstance(some, list) else [some]
        few, _ = own.among(70, places).command(0.0, x[:, some], r[:, some], z[:, some])
        np.testing.assert_array_equal(few, every[:, some])
