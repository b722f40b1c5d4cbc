# SPDX-License-Identifier: Apache-2.0
"""Events in an FMU: inside our steps in co-simulation, by guards as event indicators in model exchange."""

from __future__ import annotations

import ctypes as c
import json
from pathlib import Path

import numpy as np
import pytest

import mehvar
from tests.examples.models.bounce import system
from tests.mehvar.fmu.test_exchange import OK
from tests.mehvar.fmu.test_exchange import Unit as Exchange
from tests.mehvar.fmu.test_values import Unit
from tests.models.written import written


@pytest.fixture(scope="module")
def bounce(tmp_path_factory: pytest.TempPathFactory) -> str:
    return str(written(system(), tmp_path_factory.mktemp("bounce")))


def test_a_ball_that_bounces_has_our_bits(bounce: str, tmp_path: Path) -> None:
    run = mehvar.simulate(bounce, "fall", t_end=4.0, dt_out=0.25)
    assert len(json.loads(run.attrs["events"])["t"]) > 3
    unit = Unit(tmp_path, bounce, None)
    assert unit.begin() == OK
    for k in range(16):
        unit.step(k * 0.25, 0.25)
        assert unit.get("height", "speed") == [run[name].values[k + 1] for name in ("height", "speed")]


def test_an_importer_that_finds_a_crossing_gets_the_state_after_it(bounce: str, tmp_path: Path) -> None:
    """In the order of calls of the standard; a crossing that the importer has not seen is asked for by the unit."""
    unit, flags, instant = Exchange(tmp_path, "3.0", bounce, None), (c.c_bool * 5)(), c.c_double()
    places = [*(c.byref(flags, k) for k in range(5)), c.byref(instant)]
    event, ends, x, g = c.c_bool(), c.c_bool(), (c.c_double * 2)(), c.c_double()

    def update() -> list[bool]:
        assert unit("UpdateDiscreteStates", *places) == OK
        return [flags[1], flags[3]]

    def step(*state: float) -> bool:
        assert unit("SetContinuousStates", (c.c_double * 2)(*state), c.c_size_t(2)) == OK
        assert unit("CompletedIntegratorStep", True, c.byref(event), c.byref(ends)) == OK
        return event.value

    assert update() == [False, False]
    assert unit("EnterContinuousTimeMode") == OK
    assert not step(0.5, -3.0)
    assert step(-1e-16, -4.0)
    assert unit("GetEventIndicators", c.byref(g), c.c_size_t(1)) == OK
    assert g.value == -1e-16
    assert unit("EnterEventMode") == OK
    assert update() == [False, True]
    assert update() == [False, False], "it bounces once"
    assert unit("GetContinuousStates", x, c.c_size_t(2)) == OK
    np.testing.assert_allclose(list(x), [-1e-16, 4.0 * 0.97])
    assert unit("EnterContinuousTimeMode") == OK
    assert not step(1e-3, 3.8)
    assert step(-1e-17, -3.8)
    for _ in range(5):
        assert unit("EnterEventMode") == OK
        stalled = update()
        assert unit("EnterContinuousTimeMode") == OK
        step(-1e-17, -1e-4)
    assert stalled == [True, True], "events without progress in time end the run"
