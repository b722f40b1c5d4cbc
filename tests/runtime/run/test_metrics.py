# SPDX-License-Identifier: Apache-2.0
"""Metrics of series whose answers are known."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from mehvar import runtime
from mehvar.base.manifest import Metric
from mehvar.runtime import InputError, Model
from mehvar.runtime.run.metrics import evaluate, undetermined

T = np.array([0.0, 1.0, 2.0, 3.0, 4.0])
SERIES = {
    "a": np.array([4.0, 2.0, -2.0, 0.5, 0.0]),
    "b": np.array([-1.0, 1.0, -1.0, 0.1, -0.1]),
    "calm": np.zeros(5),
    "broken": np.array([1.0, 0.0, np.nan, 0.0, 0.0]),
}


def value(kind: str, *of: str, band: float = 0.0, since: float = 0.0, until: float = math.inf) -> float:
    return evaluate(Metric("test", kind, of, "1", "", band=band, since=since, until=until), T, SERIES)


@pytest.mark.parametrize(
    ("kind", "of", "band", "expected"),
    [
        ("settling", ("a",), 1.0, 2.4),
        ("settling", ("a",), 2.0, 0.0 + 1.0),
        ("settling", ("a", "b"), 0.9, 2.44),
        ("settling", ("calm",), 0.1, 0.0),
        ("settling", ("b",), 0.05, math.inf),
        ("settling", ("broken",), 1.0, 3.0),
        ("max", ("a", "b"), 0.0, 4.0),
        ("min", ("a", "b"), 0.0, -2.0),
        ("max_abs", ("b",), 0.0, 1.0),
        ("travel", ("a",), 0.0, 9.0),
        ("travel", ("a", "b"), 0.0, 14.3),
        ("sign_changes", ("b",), 0.0, 4.0),
        ("sign_changes", ("b",), 0.5, 2.0),
        ("sign_changes", ("a", "b"), 0.5, 3.0),
        ("sign_changes", ("calm",), 0.0, 0.0),
        ("final", ("b",), 0.0, -0.1),
        ("rms", ("a",), 0.0, math.sqrt((16 + 4 + 4 + 0.25) / 5)),
        ("settling_about_end", ("b",), 0.25, 2 + 0.65 / 1.1),
        ("max_abs", ("a - b",), 0.0, 5.0),
    ],
)
def test_kinds(kind: str, of: tuple[str, ...], band: float, expected: float) -> None:
    assert value(kind, *of, band=band) == pytest.approx(expected)


def test_only_the_part_that_counts_is_looked_at() -> None:
    assert value("max", "a", since=1.0) == 2.0
    assert value("travel", "a", until=2.0) == 6.0
    assert value("min", "a", since=3.0, until=3.5) == 0.5
    assert math.isnan(value("max", "a", since=9.0))


def test_nan_shows() -> None:
    assert math.isnan(value("max", "broken"))
    assert math.isnan(value("travel", "broken"))


def test_bad_metrics() -> None:
    with pytest.raises(InputError, match="unknown variable 'c' in metric test"):
        value("max", "c")
    with pytest.raises(InputError, match="unknown kind 'maxi' of metric test: did you mean max"):
        value("maxi", "a")
    with pytest.raises(InputError, match="names no variable"):
        value("max")


def test_settling_time_does_not_depend_on_the_sampling(pendulum: Model) -> None:
    times = [
        runtime.metrics(runtime.simulate(pendulum, "pd", angle_ref=0.0, dt_out=dt), pendulum.manifest)["T_angle"]
        for dt in (0.05, 0.001)
    ]
    assert times[0] == pytest.approx(times[1], abs=5e-3)


def test_metrics_of_run_and_dataset_agree(pendulum: Model) -> None:
    run = runtime.simulate(pendulum, "pd")
    expected = runtime.metrics(run, pendulum.manifest)
    assert expected == runtime.metrics(runtime.to_dataset(run), pendulum.manifest)
    assert expected["peak"] == np.max(np.abs(run.u))
    only_peak = dataclasses.replace(pendulum.manifest, metrics={"peak": pendulum.manifest.metrics["peak"]})
    assert list(runtime.metrics(run, only_peak)) == ["peak"]


WINDOWS = st.tuples(st.floats(0.0, 3.0), st.floats(0.001, 3.0))


@given(WINDOWS, st.integers(1, 30), st.sampled_from([0.01, 0.1, 0.3, 1 / 3]))
def test_a_metric_is_said_to_be_undetermined_where_no_sample_is_in_its_window(window, steps, dt):
    metric = Metric("m", "max", ("x",), since=window[0], until=window[0] + window[1], unit="1", description="")
    t = np.arange(steps + 1) * dt
    assume(np.abs(np.subtract.outer(t, [metric.since, metric.until])).min() > 1e-9)
    value = evaluate(metric, t, {"x": np.ones(len(t))})
    assert bool(undetermined({"m": metric}, float(t[-1]), dt)) == math.isnan(value)
