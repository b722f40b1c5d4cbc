# SPDX-License-Identifier: Apache-2.0
"""Inputs of least effort: a closed form, a slew of a flexible craft that is flown, and what is refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import mehvar
from mehvar.base.errors import InputError
from mehvar.parts import Bob, Hinge, Hub, Spacecraft, Torquer, Wheel
from mehvar.runtime.model.model import Model

REST = dict.fromkeys(("q1", "q2", "q3", "wx", "wy", "wz", "panel_angle", "panel_rate"), 0.0)
LIMITS = {f"wheel{k}_torque": 0.1 for k in (1, 2, 3, 4)}
START = {"roll_0": 1.0, "yaw_0": 0.3}


def test_the_least_effort_of_a_turn_is_the_known_one() -> None:
    """Torque 6 J a (1 - 2 t/T) / T^2 turns by a; its effort is 12 J^2 a^2 / T^3, a little more in 50 pieces."""
    craft = Spacecraft("turning", motion="attitude", attitude="euler")
    craft.add(Hub("hub", mass=10.0, inertia=(3.0, 3.5, 4.0)))
    craft.add(Torquer("turn"))
    plan = mehvar.steer(mehvar.build(craft), {"yaw": np.int64(0), "wz": np.float32(0)}, 10.0, parameters={"yaw_0": 0.6})
    assert plan.effort == pytest.approx(12 * 16 * 0.36 / 1000, rel=1e-3)
    middle = plan.plan.t.values[:-1] + 0.1
    expected = -6 * 4 * 0.6 * (1 - 2 * middle / 10) / 100
    np.testing.assert_allclose(plan.plan["u_turnz"].values[:-1], expected, atol=1e-4)


def wheeled(name: str) -> Spacecraft:
    """Return a hub with four wheels."""
    craft = Spacecraft(name, motion="attitude")
    craft.add(Hub("hub", mass=120.0, inertia=(12.0, 14.0, 10.0)))
    for k, axis in enumerate([(1, 0, 1), (0, 1, 1), (-1, 0, 1), (0, -1, 1)], 1):
        craft.add(Wheel(f"wheel{k}", axis=axis, inertia=0.02, torque_limit=0.1))
    return craft


@pytest.fixture(scope="module")
def rigid() -> Model:
    """A craft with wheels."""
    return mehvar.build(wheeled("rigid"))


@pytest.fixture(scope="module")
def flexible() -> Model:
    """A craft with wheels, a panel on a spring and a tank that swings."""
    craft = wheeled("flexible")
    panel = {"mass": 8.0, "inertia": (1.0, 0.1, 1.0), "axis": (0, 1, 0), "at": (0, 0.5, 0), "centre": (0, 0.9, 0)}
    craft.add(Hinge("panel", **panel, stiffness=15.0, damping=0.3))
    craft.add(Bob("tank", mass=20.0, length=0.25, at=(0, 0, -0.3), damping=0.5, rest=(0, 0, -1)))
    return mehvar.build(craft)


@pytest.mark.parametrize("craft", ["rigid", pytest.param("flexible", marks=pytest.mark.soak)])
def test_a_slew_is_flown_and_its_law_holds_another_craft(craft: str, request: pytest.FixtureRequest) -> None:
    model: Model = request.getfixturevalue(craft)
    rest = {name: value for name, value in REST.items() if name in model.state_names}
    plan = mehvar.steer(model, rest, 40.0, n=40, limits=LIMITS, parameters=START)
    assert max(map(abs, plan.miss.values())) < 1e-6
    inputs = np.stack([plan.plan[f"u_{name}"].values for name in model.input_names])
    assert np.abs(inputs).max() <= 0.1 * (1 + 1e-6)
    panel = {"panel_k": 14.0} if craft == "flexible" else {}
    other = {"roll_0": 1.02, "yaw_0": 0.3, "hub_Jxx": 12.3, **panel}
    alone, held = (
        mehvar.simulate(model, t_end=40.0, parameters=other, **given)
        for given in ({"controller": None, "inputs": plan.plan}, {"controller": plan.law, "period": plan.period})
    )
    off = [float(np.hypot(run["q1"][-1], run["q2"][-1])) for run in (alone, held)]
    assert off[1] < 0.2 * off[0]
    runs = mehvar.batch(
        model, plan.law, 8, period=plan.period, t_end=40.0, parameters={"yaw_0": 0.3},
        vary={"roll_0": "normal(1, 0.02)"},
    )  # fmt: skip
    assert float(abs(runs["final"].sel(state="q1")).max()) < 2e-3


@pytest.mark.parametrize(
    ("change", "part"),
    [
        ({"to": {}}, "to = {}"),
        ({"to": {"q9": 0.0}}, "unknown state 'q9'"),
        ({"to": {"q1": float("nan")}}, "q1 = nan"),
        ({"limits": {"wheel1": 0.1}}, "unknown input 'wheel1'"),
        ({"limits": {"wheel1_torque": 0.0}}, "wheel1_torque = 0.0 (from limits): must be a number > 0"),
        ({"n": 1}, "n = 1"),
        ({"t_end": -1.0}, "t_end = -1.0"),
        ({"t_end": 40_000.0}, "n = 50 (from the call): must be at least 15365"),
    ],
)
def test_what_cannot_be_planned_is_refused_by_name(flexible: Model, change: dict[str, Any], part: str) -> None:
    with pytest.raises(InputError) as refusal:
        mehvar.steer(flexible, **{"to": REST, "t_end": 40.0, "limits": LIMITS, **change})
    assert part in str(refusal.value)


def test_a_sampled_actuator_holds_the_plan() -> None:
    rest = dict.fromkeys(("wx", "wy", "wz"), 0.0)
    assert max(map(abs, mehvar.steer("satellite", rest, 20.0, n=10, initial={"wx": 0.01}).miss.values())) < 1e-6
    with pytest.raises(
        InputError, match=r"n = 9 .*: must be a number for which an interval, 2.22222 s, is a multiple of Ts"
    ):
        mehvar.steer("satellite", rest, 20.0, n=9)


def test_too_short_a_time_is_told(rigid: Model) -> None:
    rest = {name: value for name, value in REST.items() if name in rigid.state_names}
    with pytest.raises(mehvar.SteeringError, match=r"no inputs found to the final state in 4 s \(.*\): give more time"):
        mehvar.steer(rigid, rest, 4.0, n=10, limits=LIMITS, parameters=START)
