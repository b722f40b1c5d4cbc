# SPDX-License-Identifier: Apache-2.0
"""The paper's run: the metric table of full and reduced model under both laws, and its seven statements."""

from pathlib import Path

import numpy as np
import pytest

import mehvar
from mehvar.codegen.generate import write
from mehvar.runtime.run.simulate import simulate
from tests.derived import generated, variant
from tests.reference.scipy_loop import by_scipy

TABLE = {
    "t_vy": (552.3, 559.5, 551.3, 558.9, 554.6, 562.3),
    "t_vz": (589.3, 595.5, 588.4, 595.0, 568.9, 574.8),
    "t_att": (162.2, 162.1, 162.1, 162.0, 163.5, 163.5),
    "t_phi1": (660.1, 666.6, 659.1, 666.0, 659.1, 666.0),
    "t_phi2": (660.0, 666.5, 659.0, 665.9, 659.1, 666.0),
    "t_theta1": (19.3, 33.4, 31.2, 33.4, 47.2, 35.0),
    "t_theta2": (54.0, 52.2, 53.4, 51.5, 54.4, 52.2),
    "min_vy": (-114.1, -112.3, -114.3, -112.2, -117.0, -114.9),
    "min_vz": (-52.1, -50.2, -52.2, -50.1, -45.9, -43.9),
    "travel_phi1": (36.7, 84.0, 36.7, 77.6, 36.7, 77.7),
    "travel_phi2": (86.2, 175.9, 80.7, 166.3, 80.8, 166.4),
    "theta1_end": (65.8, 66.1, 65.8, 66.1, 69.5, 69.8),
    "vx_end": (4618, 4618, 4571, 4573, 4571, 4573),
    "max_lateral": (0.618, 0.607, 0.618, 0.606, 0.618, 0.606),
}
"""Published in degrees where an angle; columns as in RUNS."""
INPUTS = {
    "delta1": (24.4, 17.3, 21.9, 17.3, 21.9, 15.2),
    "delta2": (34.2, 33.6, 34.2, 33.6, 35.2, 34.5),
    "Mx": (81, 81, 81, 81, 81, 81),
    "My": (964, 603, 876, 602, 876, 527),
    "Mz": (1369, 1350, 1370, 1348, 1403, 1380),
}
"""Largest inputs at whole seconds: between them V1 asks for up to 2 % more in the first second."""
RUNS = [
    (plant, attitude, law)
    for plant, attitude in (("reduced", "small"), ("full", "small"), ("full", "euler"))
    for law in ("lyapunov-v1", "lyapunov-v2")
]
ANGLES = ("travel_phi1", "travel_phi2", "theta1_end", "delta1", "delta2")


@pytest.fixture(scope="module")
def folder() -> Path:
    return generated("slosh")


@pytest.fixture(scope="module")
def runs(folder):
    result = {}
    for plant, attitude, law in RUNS:
        result[plant, attitude, law] = mehvar.simulate(
            str(folder), controller=law, scenario="paper", plant=plant, attitude=attitude
        )
    return result


def metrics(folder: Path, run) -> dict[str, float]:
    from mehvar.base.manifest import read_manifest
    from mehvar.runtime.run.metrics import metrics as evaluate

    return evaluate(run, read_manifest(folder))


@pytest.mark.parametrize("column", range(6), ids=["-".join(run) for run in RUNS])
def test_metric_table(folder, runs, column):
    run = runs[RUNS[column]]
    assert run.attrs["status"] == "done"
    result = metrics(folder, run)
    whole = np.isclose(run.t.values, np.round(run.t.values), atol=1e-6)
    for name in INPUTS:
        result[name] = float(np.nanmax(np.abs(run[f"u_{name}"].values[whole])))
    for name, row in (TABLE | INPUTS).items():
        value = np.degrees(result[name]) if name in ANGLES else result[name]
        assert value == pytest.approx(row[column], rel=0.01), name


def at(run, name: str, t: float) -> float:
    return float(run[name].sel(t=t, method="nearest"))


@pytest.fixture(params=["lyapunov-v1", "lyapunov-v2"])
def full(runs, request):
    return runs["full", "small", request.param]


def test_1_lateral_velocities_come_down_by_500_seconds(full):
    assert abs(at(full, "vy", 500)) <= 6.0
    assert abs(at(full, "vz", 500)) <= 2.7
    later, sooner = (abs(at(full, "vy", t)) for t in (600, 475))
    assert 125 / np.log(sooner / later) == pytest.approx(125, rel=0.02)


def test_2_attitude_is_zero_by_200_seconds(full):
    for k in (1, 2, 3):
        assert abs(np.degrees(at(full, f"att{k}", 200))) < 0.05


def test_3_pendulums_hang_straight_by_700_seconds(full):
    for k in (1, 2):
        assert abs(np.degrees(at(full, f"phi{k}", 700))) < 0.4


def test_4_azimuths_are_settled_as_said_but_not_in_the_papers_order(full):
    """Both lock to the direction of the lateral acceleration; theta_1 is not the slow one."""
    end = [float(full[f"theta{k}"][-1]) for k in (1, 2)]
    assert abs(np.degrees(at(full, "theta1", 700) - end[0])) < 0.01
    assert abs(np.degrees(at(full, "theta2", 100) - end[1])) < 0.7
    late = full.sel(t=slice(60, None))
    for k in (1, 2):
        assert float(abs(np.degrees(late[f"theta{k}"] - end[k - 1])).max()) < 2


@pytest.mark.parametrize(("plant", "vy", "vz"), [("reduced", 2.1, 2.5), ("full", 2.3, 2.5)])
def test_5_both_laws_give_the_same_velocities_and_attitude(runs, plant, vy, vz):
    first, second = (runs[plant, "small", law] for law in ("lyapunov-v1", "lyapunov-v2"))
    assert float(abs(first.vy - second.vy).max()) < vy
    assert float(abs(first.vz - second.vz).max()) < vz
    for k in (1, 2, 3):
        assert float(np.degrees(abs(first[f"att{k}"] - second[f"att{k}"]).max())) < 3e-4


@pytest.mark.parametrize(("plant", "largest", "late"), [("reduced", 17.3, 0.6), ("full", 17.3, 1.2)])
def test_6_pendulums_swing_more_without_their_rates_in_v(runs, plant, largest, late):
    first, second = (runs[plant, "small", law].sel(t=slice(0, 999)) for law in ("lyapunov-v1", "lyapunov-v2"))
    swings = [np.diff(run.phi1.sel(t=slice(0, 30)).values) for run in (first, second)]
    assert [int(np.count_nonzero(np.diff(np.sign(swing)))) for swing in swings] == [0, 6]
    difference = np.degrees(np.abs(first.phi2.values - second.phi2.values))
    assert difference.max() == pytest.approx(largest, abs=0.1)
    assert first.t.values[difference.argmax()] == pytest.approx(3.2, abs=0.15)
    assert difference[first.t.values > 100].max() < late


def test_7_the_craft_gains_speed_while_it_steers(full):
    assert np.all(np.diff(full.vx.sel(t=slice(100, None))) > 0)
    assert float(full.vx[-1]) > 4500


def test_no_run_of_the_table_comes_near_the_whole_thrust(runs):
    for run in runs.values():
        assert float(run.lateral.max()) < 0.62


def test_gimbal_limits_hold_in_a_run(folder):
    run = mehvar.simulate(
        str(folder), controller="lyapunov-v2", scenario="paper", t_end=120.0, parameters={"delta2_max": 0.4}
    )
    assert float(abs(run.u_delta2).max()) == 0.4
    free = mehvar.simulate(str(folder), controller="lyapunov-v2", scenario="paper", t_end=120.0)
    assert float(abs(free.u_delta2).max()) > 0.5
    for k in (1, 2, 3):
        np.testing.assert_allclose(run[f"alpha{k}"][0], free[f"alpha{k}"][0], atol=1e-12)


@pytest.mark.soak
def test_a_tumble_over_the_top_keeps_energy_and_momentum(tmp_path):
    """On ball joints with a quaternion no chart is lost: free motion with pendulums that swing through phi = 0, 180."""
    folder = tmp_path / "slosh"
    write(folder, variant("slosh", inertia="ball", attitude="quaternion"))
    m = mehvar.load(str(folder))
    p = m.parameters(eps1=0.0, eps2=0.0, F=0.0)
    s = np.array([-np.cos(0.3), 0.0, np.sin(0.3)])
    sigma = np.cross([0.0, 4.0, 0.0], s)
    x = m.state(q0=1.0, wx=0.8, wy=-1.1, wz=0.6)
    names = list(m.state_names)
    for k in (1, 2):
        at = names.index(f"s{k}x")
        x[at : at + 3], x[at + 3 : at + 6] = s, sigma
    energy, momentum = (m.functions[n] for n in ("energy", "momentum"))
    before = energy(x, p), np.linalg.norm(momentum(x, p)[:3])
    run = tumble(m, x, p)
    after = energy(run, p), np.linalg.norm(momentum(run, p)[:3])
    np.testing.assert_allclose(after, before, rtol=1e-9)


def tumble(m, x, p, step: float = 2e-3, steps: int = 5000) -> np.ndarray:
    """Ten seconds by classical Runge-Kutta steps, projected after each; arms pass phi = 0 and 180 degrees."""
    u, project = np.zeros(5), m.functions["project"]
    lowest, highest = 1.0, -1.0
    at = list(m.state_names).index("s1x")
    for _ in range(steps):
        k1 = m.rhs(x, u, p)
        k2 = m.rhs(x + step / 2 * k1, u, p)
        k3 = m.rhs(x + step / 2 * k2, u, p)
        k4 = m.rhs(x + step * k3, u, p)
        x = project(x + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4))
        lowest, highest = min(lowest, x[at]), max(highest, x[at])
    assert lowest < -0.97
    assert highest > 0.97
    return x


def test_an_infeasible_demand_is_reported_with_time_and_amount():
    run = simulate("slosh", "lyapunov-v2", parameters={"vy_0": 400.0}, t_end=50.0)
    excess = run.variables()["lateral_excess"]
    beyond = run.t[excess > 0]
    assert beyond.size > 1
    assert np.allclose(excess, np.maximum(run.variables()["lateral_demand"] - run.parameters.values["F"], 0))
    (text,) = run.exceeded()
    assert f"from t = {beyond[0]:.6g} s to {beyond[-1]:.6g} s" in text
    assert f"{excess.max():.6g} N" in text
    assert not simulate("slosh", "lyapunov-v2", t_end=5.0).exceeded()


def test_c_and_scipy_agree(folder):
    options = {"t_end": 0.5, "dt_out": 0.1}
    compiled = simulate(str(folder), "lyapunov-v2", **options)
    with by_scipy():
        interpreted = simulate(str(folder), "lyapunov-v2", **options)
    np.testing.assert_allclose(compiled.x, interpreted.x, rtol=1e-9, atol=1e-8)
