# SPDX-License-Identifier: Apache-2.0
"""Fits of recorded runs: recovered values, intervals that cover, what the data do not see, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import solve_ivp
from scipy.optimize import curve_fit
from scipy.stats import binom, chi2

import mehvar
from mehvar import Group, Parameter, Quantity, Scenario, System
from mehvar.base.errors import InputError
from mehvar.parts import Bob, ExternalForce, Hub, Spacecraft
from mehvar.runtime.model.model import Model
from tests.runtime.batch.forgery import PENDULUM

NOISE = 1e-3


@pytest.fixture(scope="module")
def truth() -> xr.Dataset:
    """A slew of the satellite with another inertia than the model's."""
    return mehvar.simulate("satellite", "pd", t_end=60.0, dt_out=1.0, I_x=2.3)


def noisy(truth: xr.Dataset, rng: np.random.Generator) -> xr.Dataset:
    return xr.Dataset({name: truth[name] + rng.normal(0, NOISE, truth.sizes["t"]) for name in ("roll", "wx")})


def test_a_run_without_noise_gives_its_values_back(truth: xr.Dataset) -> None:
    fit = mehvar.fit(
        "satellite", truth, ["I_x", "roll"], "pd", initial={"roll": 0.1}, sigma={"roll": NOISE, "wx": NOISE}
    )
    assert fit["I_x"] == pytest.approx(2.3, rel=1e-9)
    assert fit["roll"] == pytest.approx(float(truth["roll"][0]), rel=1e-9)
    assert float(abs(fit.run.wx - truth.wx).max()) < 1e-11


def test_a_free_value_starts_where_an_argument_sets_it(truth: xr.Dataset) -> None:
    starts = [
        mehvar.fit("satellite", truth, ["I_x"], "pd", sigma={"wx": NOISE}, **given)
        for given in ({"I_x": 2.45}, {"parameters": {"I_x": 2.45}})
    ]
    assert starts[0]["I_x"] == starts[1]["I_x"] == pytest.approx(2.3, rel=1e-9)
    with pytest.raises(InputError, match="I_x is given twice"):
        mehvar.fit("satellite", truth, ["I_x"], "pd", parameters={"I_x": 2.45}, I_x=2.5)


def test_estimate_and_covariance_are_those_of_curve_fit(truth: xr.Dataset) -> None:
    data = noisy(truth, np.random.default_rng(1))
    data["roll"][7:9] = np.nan  # missing samples
    fit = mehvar.fit("satellite", data, ["I_x"], "pd", sigma={"roll": NOISE, "wx": NOISE})
    kept = np.isfinite(data["roll"].values)

    def model(_: object, inertia: float) -> np.ndarray:
        run = mehvar.simulate("satellite", "pd", t_end=60.0, dt_out=1.0, I_x=float(inertia))
        return np.concatenate([run["roll"].values[kept], run.wx.values])

    measured = np.concatenate([data["roll"].values[kept], data.wx.values])
    value, covariance = curve_fit(model, 0, measured, [2.2], NOISE * np.ones(len(measured)), True, epsfcn=1e-9)
    assert fit["I_x"] == pytest.approx(value[0], abs=1e-3 * fit.deviation("I_x"))
    assert fit.deviation("I_x") == pytest.approx(covariance[0, 0] ** 0.5, rel=1e-3)


def sloshing() -> tuple[Model, xr.Dataset]:
    """Return a craft with a tank that swings, and a run of it over 100 s with another inertia and damping."""
    craft = Spacecraft("sloshing", motion="attitude")
    craft.add(Hub("hub", mass=120.0, inertia=(12.0, 14.0, 10.0)))
    craft.add(Bob("tank", mass=20.0, length=0.25, at=(0, 0, -0.3), damping=0.5, rest=(0, 0, -1)))
    craft.add(ExternalForce("push"))
    model = mehvar.build(craft)
    truth = mehvar.simulate(model, None, inputs={"pushz": 30.0}, t_end=100.0, dt_out=0.5, **START, **VALUES)
    return model, truth


START, VALUES = {"tank_phi_0": 0.3, "wz_0": 0.02}, {"hub_Jxx": 12.5, "tank_c": 0.6}


def coverage(trials: int, seed: int) -> tuple[dict[str, int], int, list[float]]:
    """Return how many intervals of 95 % hold each value and all at once, and the misfits."""
    model, truth = sloshing()
    rng, covered, together, misfits = np.random.default_rng(seed), dict.fromkeys(VALUES, 0), 0, []
    for _ in range(trials):
        rates = {f"w{axis}": truth[f"w{axis}"] + rng.normal(0, NOISE, truth.sizes["t"]) for axis in "xy"}
        record = xr.Dataset(rates | {f"u_push{axis}": truth[f"u_push{axis}"] for axis in "xyz"})
        fit = mehvar.fit(model, record, list(VALUES), sigma=dict.fromkeys(rates, NOISE), **START)
        for name, value in VALUES.items():
            low, high = fit.interval(name)
            covered[name] += low <= value <= high
        error = fit.values - np.array(list(VALUES.values()))
        together += error @ np.linalg.solve(fit.covariance, error) < chi2.ppf(0.95, len(VALUES))
        misfits.append(fit.misfit)
    return covered, together, misfits


@pytest.mark.parametrize("trials", [4, pytest.param(500, marks=pytest.mark.soak)])
def test_intervals_cover_as_often_as_they_say(trials: int) -> None:
    """Inertia and damping of a craft with a tank that swings; each interval, and both in their ellipse."""
    covered, together, misfits = coverage(trials, 20261128)
    for count in (*covered.values(), together):
        assert binom.ppf(0.001, trials, 0.95) <= count <= binom.ppf(0.999, trials, 0.95)
    assert 0.5 - 2 / np.sqrt(trials) < np.mean(misfits) < 0.5 + 2 / np.sqrt(trials)  # uniform, if the noise is as given


def test_covariance_is_that_of_exact_sensitivities() -> None:
    """The slopes of central differences agree with S' = f_x S + f_p of the generated Jacobians to 2e-7."""
    model, truth = sloshing()
    record = truth[["wx", "wy", "u_pushx", "u_pushy", "u_pushz"]]
    fit = mehvar.fit(model, record, list(VALUES), sigma={"wx": NOISE, "wy": NOISE}, **START)
    p, u = model.parameters(**dict(zip(VALUES, map(float, fit.values), strict=True))), [0, 0, 30.0]
    columns, size = [model.parameter_names.index(name) for name in VALUES], len(model.state_names)

    def rates(_: float, y: np.ndarray) -> np.ndarray:
        x, slopes = y[:size], y[size:].reshape(size, -1)
        moved = model.jac_x(x, u, p) @ slopes + model.jac_p(x, u, p)[:, columns]
        return np.concatenate([model.rhs(x, u, p), moved.ravel()])

    start = np.concatenate([[float(truth[name][0]) for name in model.state_names], np.zeros(2 * size)])
    flown = solve_ivp(rates, (0, 100), start, "DOP853", rtol=1e-10, atol=1e-12, t_eval=truth.t.values)
    rows = flown.y[size:].reshape(size, 2, -1)[[model.state_names.index(name) for name in ("wx", "wy")]]
    unit = np.sqrt(np.diag(fit.covariance))
    slopes = rows.transpose(0, 2, 1).reshape(-1, 2) * unit / NOISE
    np.testing.assert_allclose(fit.covariance / np.outer(unit, unit) @ slopes.T @ slopes, np.eye(2), atol=4e-7)


def test_noise_is_estimated_and_correlated_residuals_are_told(truth: xr.Dataset) -> None:
    data = noisy(truth, np.random.default_rng(3))
    fit = mehvar.fit("satellite", data, ["I_x"], "pd")
    assert fit.sigma["wx"] == pytest.approx(NOISE, rel=0.3)
    assert min(fit.correlation.values()) > 0.001
    wrong = mehvar.fit("satellite", data, ["I_y"], "pd", sigma={"roll": NOISE, "wx": NOISE})  # the error is in I_x
    assert min(wrong.correlation.values()) < 0.001
    assert wrong.misfit < 0.001
    assert "I_y = " in repr(wrong)


def test_a_combination_that_the_data_do_not_see_is_named() -> None:
    """A pendulum without torque and damping swings as one of another mass."""
    data = mehvar.simulate(PENDULUM, None, inputs={}, t_end=2.0, dt_out=0.05, initial={"angle": 0.5}, b=0.0)
    fit = mehvar.fit(PENDULUM, data, ["m"], initial={"angle": 0.5}, sigma={"angle": 1e-3}, b=0.0)
    assert fit.deviation("m") == np.inf
    assert "m" in fit.unseen[0]
    assert "not seen" in repr(fit)


@pytest.fixture(scope="module")
def oscillator() -> Model:
    """A mass on a spring with a turn that grows at a rate of its own."""
    x = Group(
        "x", (Quantity("place", "m", "place"), Quantity("speed", "m/s", "speed"), Quantity("turn", "rad", "turn"))
    )
    p = Group(
        "p",
        (
            Parameter("k", "1/s^2", "stiffness", default=1.5),
            Parameter("c", "1/s", "damping", default=0.2),
            Parameter("rate", "rad/s", "rate of turn", default=0.1),
        ),
    )
    s = Group("s", (Parameter("place_0", "m", "place at the start", default=1.0),))
    return mehvar.build(
        System(
            name="oscillator",
            states=x,
            parameters=p,
            scenario_parameters=s,
            rhs=(x.speed, -p.k * x.place - p.c * x.speed, p.rate),
            initial=(s.place_0, 0, 0),
            scenarios=(Scenario("free", "a free run", duration=10.0, step=0.1),),
        )
    )


def test_an_unseen_value_moves_no_other(oscillator: Model) -> None:
    """The search followed errors of its slopes, and stopped 9 standard deviations from the least residuals."""
    truth = mehvar.simulate(oscillator, None, inputs={}, k=1.75)
    data = xr.Dataset({"place": truth["place"] + np.random.default_rng(4).normal(0, 0.01, truth.sizes["t"])})
    alone, both = (mehvar.fit(oscillator, data, free, sigma={"place": 0.01}) for free in (["k"], ["rate", "k"]))
    assert both["k"] == pytest.approx(alone["k"], abs=1e-3 * alone.deviation("k"))
    assert both.deviation("k") == pytest.approx(alone.deviation("k"), rel=1e-6)
    assert both["rate"] == pytest.approx(0.1, rel=1e-9)
    assert both.unseen == ({"rate": 1.0},)
    assert alone.converged
    assert both.converged


def test_two_names_of_one_start_are_refused(oscillator: Model) -> None:
    data = mehvar.simulate(oscillator, None, inputs={})[["place"]]
    for free, parameters in ((["place", "place_0"], {}), (["place"], {"place_0": 2.0})):
        with pytest.raises(InputError, match="it only determines place, which is given too: give one of them"):
            mehvar.fit(oscillator, data, free, parameters=parameters)


def test_a_precise_variable_hides_no_value_that_another_sees(oscillator: Model) -> None:
    truth, rng = mehvar.simulate(oscillator, None, inputs={}, k=1.75, rate=0.2), np.random.default_rng(1)
    sigma = {"place": np.float32(0.01), "turn": 1e-9}
    data = xr.Dataset({name: truth[name] + rng.normal(0, s, truth.sizes["t"]) for name, s in sigma.items()})
    fit = mehvar.fit(oscillator, data, ["rate", "k"], sigma=sigma)
    assert fit["k"] == pytest.approx(1.75, abs=3 * fit.deviation("k"))
    assert fit["rate"] == pytest.approx(0.2, abs=3 * fit.deviation("rate"))
    assert fit.converged


@pytest.mark.parametrize(
    ("change", "part"),
    [
        ({"free": ["I_w"]}, "I_w"),
        ({"free": []}, "free"),
        ({"free": "I_x"}, "free"),
        ({"free": ["I_x", "I_x"]}, "twice"),
        ({"sigma": {"rol": 1.0}}, "rol"),
        ({"sigma": {"roll": 0.0}}, "roll = 0"),
        ({"t_end": 3.0}, "t_end"),
        ({"data": 3}, "data"),
        ({"free": ["Ts"]}, "Ts, listed in 'free', cannot be fitted: it determines the sample times of pd"),
        ({"free": ["half_period"], "sigma": {"roll": NOISE}, "half_period": 45.25}, "half_period, listed in 'free'"),
    ],
)
def test_what_cannot_be_fitted_is_refused(truth: xr.Dataset, change: dict, part: str) -> None:
    usual = {"data": truth, "free": ["I_x"], "controller": "pd"}
    with pytest.raises(InputError, match=part):
        mehvar.fit("satellite", **{**usual, **change})


def in_unit(data: xr.Dataset, name: str, unit: str) -> xr.Dataset:
    return data.assign({name: data[name].assign_attrs(units=unit)})


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda data: in_unit(data, "roll", "deg"), "unit of roll = 'deg' .*must be rad, or left out"),
        (lambda data: data.assign_coords(t=data["t"].assign_attrs(units="ms")), "unit of t = 'ms' .*must be s"),
        (lambda data: data.assign_coords(t=data["t"].values.astype("timedelta64[s]")), "values of t .*numbers in s"),
        (
            lambda data: data.assign(roll=data["roll"] + 0j),
            "values of roll = 'complex128' .*must be real numbers",
        ),
        (lambda data: data.assign(roll=data["roll"].astype(str)), "values of roll = '<U.*must be real numbers in rad"),
        (lambda data: data.assign(roll=np.nan * data["roll"]), "roll without a sample"),
        (lambda data: data.rename(wx="wx_gyro"), "unknown variable 'wx_gyro' .*leave it out, or name the variables"),
        (lambda data: data.where(data["t"] != 7, np.inf), "roll infinite at t = 7 s"),
    ],
)
def test_data_in_another_unit_or_without_samples_are_refused(truth: xr.Dataset, change, message: str) -> None:
    data = truth[["roll", "wx"]]
    with pytest.raises(InputError, match=message):
        mehvar.fit("satellite", change(data), ["I_x"], "pd")


def test_samples_that_are_not_even_are_refused(truth: xr.Dataset) -> None:
    with pytest.raises(InputError, match=r"t = '3 at sample 2' .*must be at 0, DT, 2 DT, ..., 4: resample"):
        mehvar.fit("satellite", truth.isel(t=[0, 1, 3, 4]), ["I_x"], "pd")


def test_times_in_single_precision_are_those_of_the_samples(oscillator: Model) -> None:
    """At 200 s they are off by a thousandth of a step."""
    data = mehvar.simulate(oscillator, None, inputs={}, t_end=200.0, dt_out=0.1, initial={"place": 1.0})
    t = data["t"].values.astype(np.float32)
    fit = mehvar.fit(oscillator, data[["place"]].assign_coords(t=("t", t, {"units": "s"})), ["place"])
    np.testing.assert_array_equal(fit.run["t"], data["t"])


def test_a_value_at_its_bound_and_a_variable_without_residuals_are_told(truth: xr.Dataset) -> None:
    """Gravity cannot be negative, as this record would have it; a pendulum that hangs still shows nothing of it."""
    data = mehvar.simulate(PENDULUM, None, inputs={}, t_end=1.0, dt_out=0.05, initial={"angle": 3.0}, g=0.0, k_wall=0.0)
    fit = mehvar.fit(PENDULUM, data, ["g"], initial={"angle": 2.9}, sigma={"angle": 1e-3})
    assert fit.bounded == ("g",)
    assert "g is at a bound" in repr(fit)
    still = xr.Dataset({name: data[name] * 0.0 for name in ("angle", "rate", "u_torque")})
    fit = mehvar.fit(PENDULUM, still, ["g"], initial={"angle": 0.0, "rate": 0.0})
    assert fit.deviation("g") == np.inf


def test_an_interval_needs_a_confidence(truth: xr.Dataset) -> None:
    fit = mehvar.fit("satellite", truth, ["I_x"], "pd", sigma={"roll": NOISE})
    assert fit.converged
    with pytest.raises(InputError, match="confidence = 95"):
        fit.interval("I_x", 95)
    for read in (fit.deviation, fit.interval, fit.__getitem__):
        with pytest.raises(InputError, match="unknown free value 'I_y' of the fit: did you mean I_x"):
            read("I_y")
