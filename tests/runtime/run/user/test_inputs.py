# SPDX-License-Identifier: Apache-2.0
"""Open loops: inputs over time, and the inputs of an earlier run again."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import mehvar
from mehvar import runtime
from mehvar.base.errors import InputError
from mehvar.runtime.run.user.law import LawError


def run(model: runtime.Model, inputs: Any, **options: Any) -> runtime.Run:
    return runtime.simulate(model, None, **{"inputs": inputs, "t_end": 1.0, **options})


def equal(one: runtime.Run, other: runtime.Run) -> None:
    for name in ("t", "x", "u", "y"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name), name)


def test_a_sampled_run_from_its_own_inputs_is_the_same_to_the_bit(pendulum: runtime.Model) -> None:
    """Whatever the delay, the sampling step and the method are."""
    for options in ({}, {"delay": 2}, {"dt_out": 0.05}, {"dt_out": 0.025, "method": "rk4"}):
        before = runtime.simulate(pendulum, "p-sum", t_end=1.0, parameters={"Ts": 0.05}, **options)
        options.pop("delay", None)
        equal(run(pendulum, runtime.to_dataset(before), **options), before)


def test_a_record_without_the_attributes_of_a_run_gives_the_inputs_that_acted(pendulum: runtime.Model) -> None:
    before = runtime.simulate(pendulum, "p-sum", t_end=1.0, parameters={"Ts": 0.05}, dt_out=0.05, delay=2)
    record = runtime.to_dataset(before)
    record.attrs = {}
    np.testing.assert_array_equal(run(pendulum, record, dt_out=0.05).u[:-1], before.u[:-1])
    with pytest.raises(InputError, match=r"has no u_torque: add this input of pendulum.*or give a controller"):
        run(pendulum, record[["angle"]])


def test_a_run_that_does_not_hold_all_its_inputs_is_refused(pendulum: runtime.Model) -> None:
    coarse = runtime.simulate(pendulum, "p-sum", t_end=1.0, parameters={"Ts": 0.05}, dt_out=0.1)
    with pytest.raises(InputError, match=r"samples every 0.1 s.*repeat the run with dt_out=0.05"):
        run(pendulum, runtime.to_dataset(coarse))
    late = runtime.to_dataset(runtime.simulate(pendulum, "p-sum", t_end=1.0, parameters={"Ts": 0.05}, dt_out=0.05))
    with pytest.raises(InputError, match=r"first sample is at 0.1 s'.*must be one from its start, 0 s"):
        run(pendulum, late.isel(t=slice(2, None)), t_end=0.5)
    with pytest.raises(InputError, match="the given run ends at 1 s: set t_end"):
        run(pendulum, runtime.to_dataset(coarse), t_end=2.0)


@pytest.mark.parametrize(
    "options",
    [
        *("", "[]", "1", "{", '{"hold": 0.1, "hold": 0.05, "delay": 0}', '{"hold": 0.05}', '{"hold": "a", "delay": 0}'),
        *('{"hold": -1, "delay": 0}', '{"hold": 0, "delay": 0}', '{"hold": 1e999, "delay": 0}'),
        *('{"hold": 0.05, "delay": -1}', '{"hold": 0.05, "delay": []}'),
    ],
)
def test_what_a_run_says_of_itself_is_read_or_refused(pendulum: runtime.Model, options: str) -> None:
    before = runtime.to_dataset(runtime.simulate(pendulum, "p-sum", t_end=1.0, parameters={"Ts": 0.05}))
    before.attrs["options"] = options
    with pytest.raises(InputError, match=r"attribute 'options' of inputs \(from .*\) is damaged: ."):
        run(pendulum, before)


def test_a_run_in_other_units_is_refused(pendulum: runtime.Model) -> None:
    before = runtime.to_dataset(runtime.simulate(pendulum, "p-sum", t_end=1.0))
    torque = before["u_torque"].assign_attrs(units="mN m")
    name = "u_cmd_torque" if "u_cmd_torque" in before else "u_torque"
    with pytest.raises(InputError, match=f"unit of {name} = 'mN m' .*must be N m, or left out"):
        run(pendulum, before.assign({name: torque}))
    with pytest.raises(InputError, match=r"values of t = .*must be real numbers in s"):
        run(pendulum, before.assign_coords(t=(before["t"].values * 1e9).astype("timedelta64[ns]")))


def test_an_input_that_the_model_lacks_is_refused(pendulum: runtime.Model) -> None:
    before = runtime.to_dataset(runtime.simulate(pendulum, "p-sum", t_end=1.0))
    with pytest.raises(InputError, match=r"unknown input 'u_torqe' of pendulum.*did you mean u_torque"):
        run(pendulum, before.assign(u_torqe=before["u_torque"]))


def test_a_run_without_numbers_is_refused(pendulum: runtime.Model) -> None:
    before = runtime.to_dataset(runtime.simulate(pendulum, "p-sum", t_end=1.0))
    words = ("t", ["a"] * before.sizes["t"])
    with pytest.raises(InputError, match=r"inputs = 'a dataset w.*the result of one run"):
        run(pendulum, before.isel(t=slice(0)))
    for damage in (before.assign_coords(t=words), before.assign(u_cmd_torque=words), before * 1j):
        with pytest.raises(InputError, match=r"values of (t|u_cmd_torque) = .*must be real numbers in"):
            run(pendulum, damage.assign_attrs(before.attrs))


def test_the_inputs_of_a_continuous_run_are_arrays(pendulum: runtime.Model) -> None:
    before = runtime.simulate(pendulum, "pd", t_end=1.0)
    again = run(pendulum, runtime.to_dataset(before), interpolation="linear")
    assert again.hold is None
    assert 0 < np.abs(again.x - before.x).max() < 2e-3


def test_numbers_arrays_and_functions_say_the_same(pendulum: runtime.Model) -> None:
    """A staircase is a held array, and a function that is looked at on its grid; the breaks of another are met."""
    t, values = [0.0, 0.25, 0.75], [0.5, -0.5, 0.2]
    held = run(pendulum, {"torque": (t, values)})
    assert held.hold == 0.01
    assert held.backend == "c"
    np.testing.assert_array_equal(held.u[:, 0], np.select([held.t < 0.25, held.t < 0.75], values[:2], values[2]))
    stairs = run(pendulum, {"torque": lambda now: values[int(np.searchsorted(t, now, "right")) - 1]}, period=0.01)
    equal(held, stairs)
    equal(run(pendulum, {"torque": 0.5}), run(pendulum, {"torque": ([0.0], [0.5])}))
    equal(run(pendulum, {}), run(pendulum, {"torque": 0.0}))
    assert run(pendulum, {"torque": np.float32(0.5)}).changed["u_torque"] == 0.5
    assert run(pendulum, {"torque": ([0, 0.005], [0, 1])}).hold == 0.005  # between two samples of the result


@pytest.mark.parametrize("period", [None, 0.1])
@pytest.mark.parametrize(
    "t",
    [
        np.arange(0.0, 1.0, 0.1),  # 0.30000000000000004 among them
        np.cumsum(np.full(10, 0.1)) - 0.1,
        np.linspace(0.0, 0.9, 10) + 1e-12 * np.array([0, 1, -1, 1, -1, 1, -1, 1, -1, 1]),
    ],
)
def test_instants_that_are_rounded_are_those_that_were_meant(
    pendulum: runtime.Model, t: np.ndarray, period: float | None
) -> None:
    staircase = run(pendulum, {"torque": (t, np.arange(10.0) / 10)}, period=period)
    np.testing.assert_array_equal(staircase.u[:-1, 0], np.repeat(np.arange(10.0) / 10, 10))
    assert staircase.hold == (period or 0.01)


def test_a_line_is_integrated_from_break_to_break(pendulum: runtime.Model) -> None:
    ramp = run(pendulum, {"torque": ([0.0, 0.333, 1.0], [0.0, 0.5, 0.0])}, interpolation="linear", dt_out=0.1)
    fine = run(
        pendulum, {"torque": lambda t: np.interp(t, [0.0, 0.333, 1.0], [0.0, 0.5, 0.0])}, period=1e-4, dt_out=0.1
    )
    np.testing.assert_allclose(ramp.x, fine.x, rtol=0, atol=1e-4)
    assert ramp.hold is None
    assert ramp.u[5, 0] == pytest.approx(0.5 * (1 - 0.5) / (1 - 0.333))


def test_a_short_pulse_is_not_stepped_over(pendulum: runtime.Model) -> None:
    at_rest = {"angle_0": 0.0, "angle_ref": 0.0}
    hit = run(pendulum, {"torque": lambda t: 5.0 * (0.5 < t < 0.51)}, parameters=at_rest)
    assert np.abs(hit.x[60:]).max() > 1e-3


@pytest.mark.parametrize(
    ("inputs", "options", "message"),
    [
        ({"torqe": 1.0}, {}, "unknown input 'torqe' of pendulum.*did you mean torque"),
        ({"torque": 0.1}, {"interpolation": "linear"}, "interpolation = 'linear'.*unless an input is an array"),
        ({"torque": "1"}, {"interpolation": "spline"}, "interpolation = 'spline'.*'hold' or 'linear'"),
        ({"torque": np.nan}, {}, r"inputs\['torque'\] = nan"),
        ({"torque": "much"}, {}, r"inputs\['torque'\] = 'much'.*a number, a pair"),
        ({"torque": True}, {}, r"inputs\['torque'\] = True"),
        ({"torque": np.zeros(3)}, {}, r"inputs\['torque'\] = array.*a pair \(t, values\)"),
        ({"torque": ([0, 1], [0, 1j])}, {}, r"a pair \(t, values\) of arrays of real numbers"),
        ({"torque": ([0, 1], [0])}, {}, r"of one length, not of shapes \(2,\) and \(1,\)"),
        ({"torque": ([0, 0], [0, 1])}, {}, r"instants of inputs\['torque'\] = 0.0.*must increase"),
        ({"torque": ([0.1, 1], [0, 1])}, {}, "at most 0 for the first"),
        ({"torque": ([0, 1], [0, np.inf])}, {}, r"values of inputs\['torque'\] = inf.*finite"),
        ({"torque": ([0, 0.5], [0, 1])}, {"interpolation": "linear"}, "known until the end of the run, 1 s.*0.5 s"),
        ({"torque": ([0, 0.123456789], [0, 1])}, {}, "the instants of inputs.*: resample them, or give a period"),
        ({"torque": 1.0}, {"memory": [0.0]}, "memory = .*left out without a law"),
        ([1.0], {}, "inputs = .*a mapping of names"),
    ],
)
def test_inputs_that_are_none_are_refused(
    pendulum: runtime.Model, inputs: Any, options: dict[str, Any], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        run(pendulum, inputs, **options)


@pytest.mark.parametrize(("value", "message"), [(lambda _t: np.nan, "is nan"), (lambda _t: "a", "is 'a'"),
                                                (lambda t: 1 / (t - 0.5), "raised ZeroDivisionError")])  # fmt: skip
def test_a_function_of_time_that_gives_no_number_is_said(pendulum: runtime.Model, value: Any, message: str) -> None:
    with pytest.raises(LawError, match=rf"^inputs\['torque'\] at t = 0(\.5)? s {message}"):
        run(pendulum, {"torque": value}, period=0.5)


ONE, TWO = np.ma.masked_array([1.0, 2.0], [0, 1]), np.ma.masked_array([0.0, 2.0], [0, 0])
MASKED = {
    "instants": lambda model: mehvar.simulate(model, None, inputs={"torque": (ONE, TWO)}, t_end=3.0),
    "values": lambda model: mehvar.simulate(model, None, inputs={"torque": (TWO, ONE)}, t_end=3.0),
    "law": lambda model: mehvar.simulate(model, lambda t, x: ONE[1:], period=0.5, t_end=3.0),
    "memory": lambda model: mehvar.simulate(model, lambda t, x, z: ([0.0], z), memory=ONE, period=0.5, t_end=3.0),
    "points": lambda model: mehvar.batch(model, None, points={"m": ONE}, t_end=3.0),
    "vary": lambda model: mehvar.batch(model, None, vary={"m": ONE}, t_end=3.0),
}


@pytest.mark.parametrize("call", MASKED.values(), ids=MASKED)
def test_a_masked_number_is_never_flown(pendulum, call):
    """NumPy takes the number under the mask."""
    with pytest.raises((InputError, LawError), match="finite"):
        call(pendulum)
