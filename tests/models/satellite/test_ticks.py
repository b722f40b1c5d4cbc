# SPDX-License-Identifier: Apache-2.0
"""A reference that switches does so at the tick, wherever it is evaluated, for any decimal periods."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from mehvar import runtime
from mehvar.runtime.batch.kernel import compile_kernel
from mehvar.runtime.board.run import BoardRequest, run_on_board
from mehvar.runtime.run.options import RunOptions
from mehvar.runtime.run.ticks import fraction, multiples
from tests.reference.scipy_loop import by_scipy

SLOW, FAST = runtime.load("satellite", backend="python"), runtime.load("satellite", backend="c")
SPANS = st.builds(lambda digits, places: Fraction(digits, 10**places), st.integers(1, 10**4), st.integers(0, 4))
PERIODS = [("0.3", "0.9"), ("0.1", "0.3"), ("0.7", "4.9"), ("0.25", "0.6"), ("1.1", "12.1")]


def sides(ticks: int, Ts: Fraction, half_period: Fraction) -> list[int]:
    """Return the sign of the square wave at each tick."""
    return [1 if math.floor(k * Ts / half_period) % 2 == 0 else -1 for k in range(ticks)]


@given(SPANS, SPANS)
@settings(deadline=None, max_examples=25)
def test_a_square_wave_turns_at_the_tick(Ts: Fraction, half_period: Fraction) -> None:
    assume(Ts < half_period)
    resolved = runtime.simulate(FAST, "pd", parameters={"half_period": 1e6}, t_end=0.5).parameters
    s = resolved.s.copy()
    s[[q.name for q in FAST.manifest.scenario_parameters].index("half_period")] = float(half_period)
    t, amplitude = multiples(fraction(float(Ts)), 1000), np.deg2rad(25.0)
    for model in (SLOW, FAST):
        roll = np.asarray(model.functions["reference"](t, resolved.p, s))[:, 0]
        assert (roll / amplitude).tolist() == pytest.approx(sides(1000, Ts, half_period), rel=1e-15)


@pytest.mark.parametrize(("Ts", "half_period"), PERIODS)
@pytest.mark.share(2)
def test_every_way_to_run_a_loop_sees_the_same_reference(Ts: str, half_period: str) -> None:
    n, values = 101, {"Ts": float(Ts), "half_period": float(half_period)}
    options = {"t_end": float(100 * Fraction(Ts)), "dt_out": float(Ts)}
    single = runtime.simulate(FAST, "pd", parameters=values, **options)
    with by_scipy():
        interpreted = runtime.simulate(FAST, "pd", parameters=values, **options)
    expected = np.array(sides(n, Fraction(Ts), Fraction(half_period))) * single.variables()["ref_roll"][0]
    resolved = single.parameters
    kernel = compile_kernel(FAST, "pd", options=RunOptions())
    vectors = (np.tile(v, (3, 1)) for v in (resolved.p, resolved.c, resolved.s, single.x[0]))
    lanes = kernel.run(
        0, *vectors, seed=0, **{"t_end": options["t_end"], "dt": options["dt_out"]}, save_every=float(Ts)
    )
    assert lanes is not None
    column = list(kernel.variables).index("ref_roll")
    board = run_on_board(FAST, BoardRequest("pd", "sil", samples=n, parameters=values, delay=0))
    for series in (single.variables()["ref_roll"], interpreted.variables()["ref_roll"], lanes.series[0, :, column],
                   board.board.variables()["ref_roll"]):  # fmt: skip
        np.testing.assert_array_equal(series, expected)
    instants = [float(k * Fraction(Ts)) for k in range(n)]
    for run in (single, interpreted, board.board):
        assert run.t.tolist() == instants
