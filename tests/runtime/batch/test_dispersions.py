# SPDX-License-Identifier: Apache-2.0
"""Drawn values: the right distributions, the same bits however a batch is cut, plain refusals."""

from __future__ import annotations

import hashlib
from typing import Any

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats
from scipy.special import ndtri

import mehvar
from mehvar.base.errors import InputError
from mehvar.runtime.batch.dispersions import read_dispersions
from mehvar.runtime.batch.points import lists_as_distributions
from mehvar.runtime.batch.repeat import plan_of, repeat_run
from mehvar.runtime.batch.sampling import DESIGNS, Sampler, exponential, normal_quantile, permuted, stream, uniforms
from mehvar.runtime.batch.store.store import open_store

FACTORS = [("a",), ("b", "c"), ("d",)]
RUNS = 5 * 256


def values(names: str, text: str, n: int = 20_000, seed: int = 1) -> np.ndarray:
    (dispersion,) = read_dispersions({names: text})
    return dispersion.quantile(Sampler("random", [dispersion.names], n, seed).points(0, n))


@given(first=st.integers(0, RUNS - 1), count=st.integers(1, 200), design=st.sampled_from(DESIGNS))
@settings(deadline=None, max_examples=60)
def test_a_run_is_the_same_point_in_every_piece(first: int, count: int, design: str) -> None:
    count = min(count, RUNS - first)
    sampler = Sampler(design, FACTORS, RUNS, 7)
    whole = sampler.points(0, RUNS)
    assert np.array_equal(sampler.points(first, count), whole[first : first + count])
    assert ((whole > 0) & (whole < 1)).all()


def test_listed_values_are_those_of_the_runs(tmp_path) -> None:
    """More runs than a block, beside drawn values, in every design; a run is repeated from its store alone."""
    angles = np.linspace(-1, 1, 301)
    options = {"controller": "path", "t_end": 0.02, "vary": {"theta_0": angles, "rho": "uniform(0.2, 0.4)"}}
    drawn = mehvar.batch("triangle", "path", 301, t_end=0.02, vary={"rho": "uniform(0.2, 0.4)"})
    for design in ("random", "latin", "sobol"):
        runs = mehvar.batch("triangle", sampling=design, out=tmp_path / design, **options)
        assert runs.sizes["run"] == 301
        np.testing.assert_array_equal(runs["theta_0"], angles)
        if design == "random":
            np.testing.assert_array_equal(runs["initial_rho"], drawn["initial_rho"])
    plan = plan_of(open_store(tmp_path / "random"), "triangle")
    assert repeat_run(plan, open_store(tmp_path / "random"), 300).parameters.values["theta_0"] == 1.0


@pytest.mark.parametrize(
    ("vary", "given", "message"),
    [
        ({"theta_0": [0.1, 0.2]}, {"n": 3}, "n = 3 .*: must be 2, as theta_0 lists as many values"),
        ({"theta_0": [0.1, 0.2], "rho": [0.3]}, {}, "must be 1, as rho lists as many values"),
        ({"theta_0": [0.1, 0.2]}, {"sampling": "saltelli"}, "sampling = 'saltelli'"),
        ({"theta_0": [[0.1], [0.2]]}, {"n": 2}, "theta_0 = .*: must be a text"),
        ({"theta_0": [0.1, "x"]}, {}, r"theta_0 = 'x' \(from the call\): must be a number"),
        ({"theta_0": [0.1, float("nan")]}, {}, "must be a finite number"),
        ({"theta_0": []}, {"n": 1}, r"theta_0 = \[\] .*: must be a list with one value for each run"),
        ({"theta_0": [0.1, [0.2]]}, {"n": 2}, r"theta_0 = \[0.1, \[0.2\]\] .*, or a list, tuple or array of numbers"),
        ({"theta_0": {0.1, 0.2}}, {"n": 2}, "must be a text such as .normal.50, 2.., or a list, tuple or array"),
        ({"theta_0": "normal(1 deg, 10 %)"}, {"n": 2}, r"theta_0 = 'normal\(1 deg, 10 %\)' .from the call.: must be a"),
        ({"theta_0": "uniform(2 deg, 1 deg)"}, {"n": 2}, r"theta_0 = 'uniform\(2 deg, 1 deg\)' .*: must be uniform"),
    ],
)
def test_listed_values_that_do_not_fit_are_refused(vary, given, message) -> None:
    with pytest.raises(InputError, match=message):
        mehvar.batch("triangle", "path", t_end=0.02, vary=vary, **given)


@pytest.mark.parametrize("values", [range(1, 3), (1, 2.0), np.array([1, 2]), pd.Series([1.0, 2.0])], ids=type)
def test_any_sequence_of_numbers_is_a_list(values) -> None:
    assert lists_as_distributions({"a": values}, "the call")["a"].replace(".0", "") == "values(1, 2)"


def test_another_seed_gives_other_points_and_another_dispersion_does_not() -> None:
    one = Sampler("random", [("a",)], 100, 1).points(0, 100)
    assert not np.array_equal(one, Sampler("random", [("a",)], 100, 2).points(0, 100))
    assert np.array_equal(one[:, 0], Sampler("random", [("z",), ("a",)], 100, 1).points(0, 100)[:, 1])


@given(n=st.integers(1, 3000), seed=st.integers(0, 2**32))
@settings(deadline=None, max_examples=50)
def test_the_keyed_permutation_hits_every_place_once(n: int, seed: int) -> None:
    order = permuted(np.arange(n, dtype=np.uint64), n, stream(seed, "x"))
    assert sorted(order.tolist()) == list(range(n))


def test_latin_hypercube_has_one_run_in_every_stratum_and_no_correlation() -> None:
    points = Sampler("latin", FACTORS, 4000, 3).points(0, 4000)
    for column in points.T:
        assert sorted(np.floor(column * 4000).astype(int).tolist()) == list(range(4000))
    off_diagonal = np.corrcoef(points.T)[~np.eye(4, dtype=bool)]
    assert np.abs(off_diagonal).max() < 5 / np.sqrt(4000)


def test_sobol_fills_the_cube_better_than_chance() -> None:
    sobol, random = (Sampler(design, FACTORS, 1024, 1).points(0, 1024) for design in ("sobol", "random"))
    assert stats.qmc.discrepancy(sobol) < 0.1 * stats.qmc.discrepancy(random)


def test_saltelli_groups_are_a_then_b_then_a_with_one_factor_of_b() -> None:
    groups = Sampler("saltelli", FACTORS, RUNS, 7).points(0, RUNS).reshape(-1, 5, 4)
    a, b, first, second, third = np.moveaxis(groups, 1, 0)
    assert np.array_equal(first, np.column_stack([b[:, :1], a[:, 1:]]))
    assert np.array_equal(second, np.column_stack([a[:, :1], b[:, 1:3], a[:, 3:]]))
    assert np.array_equal(third, np.column_stack([a[:, :3], b[:, 3:]]))
    assert abs(np.corrcoef(a[:, 0], b[:, 0])[0, 1]) < 0.1


def test_the_normal_quantile_agrees_with_scipy_to_the_last_digits() -> None:
    u = np.concatenate([uniforms(1, "u", 0, 10_000), [2.0**-53, 1e-300, 0.5, 1 - 2.0**-53]])
    assert np.allclose(normal_quantile(u), ndtri(u), rtol=4e-15, atol=4e-16)


def test_bits_are_pinned() -> None:
    """Elementary operations and our own logarithm and exponential: every machine must give these bytes."""
    u = uniforms(1, "u", 0, 4096)
    z = normal_quantile(u)
    assert digest(u) == "b3cf5ff8b0b849bc"
    assert digest(z) == "13a22c981ef742e2"
    assert digest(exponential(z)) == "4609f8e2548ad4ef"


def test_points_of_a_sobol_sequence_are_in_the_middle_of_their_cells() -> None:
    """Cells of 2^-32: no point is at zero or one, where a quantile is infinite."""
    halves = Sampler("sobol", [("a",), ("b",)], 64, 5).points(0, 64) * 2.0**33
    np.testing.assert_array_equal(halves % 2, 1)


@pytest.mark.parametrize(("design", "numbers"), [("random", "cff89538f32865c3"), ("latin", "f91455604b0b3bf6")])
def test_a_seed_means_the_same_runs_in_every_version(design: Any, numbers: str) -> None:
    """A changed constant of the permutation would make another campaign of the same seed."""
    assert digest(Sampler(design, [("a",), ("b",)], 60, 5).points(0, 60)) == numbers


def digest(array: np.ndarray) -> str:
    return hashlib.sha256(array.astype("<f8").tobytes()).hexdigest()[:16]


@pytest.mark.parametrize(
    ("text", "distribution"),
    [
        ("normal(50, 2)", stats.norm(50, 2)),
        ("normal(mean=-1, sd=0.5)", stats.norm(-1, 0.5)),
        ("uniform(-1, 3)", stats.uniform(-1, 4)),
        ("lognormal(0.5, 0.25)", stats.lognorm(0.25, scale=np.exp(0.5))),
        ("triangular(1, 2, 5)", stats.triang(0.25, 1, 4)),
        ("triangular(1, 1, 5)", stats.triang(0, 1, 4)),
        ("triangular(1, 5, 5)", stats.triang(1, 1, 4)),
    ],
)
def test_one_name(text: str, distribution: stats.rv_continuous) -> None:
    drawn = values("x", text)[:, 0]
    assert np.isfinite(list(read_dispersions({"x": text})[0].centre().values())).all()
    assert stats.kstest(drawn, distribution.cdf).pvalue > 1e-3
    assert not stats.kstest(drawn * 1.05, distribution.cdf).pvalue > 1e-3


def test_a_lognormal_is_the_exponential_of_the_normal_of_the_same_numbers() -> None:
    """Not of their reflection, which has the same distribution and turns a run repeated by its number into another."""
    assert values("x", "lognormal(0.5, 0.25)") == pytest.approx(np.exp(values("x", "normal(0.5, 0.25)")), rel=1e-14)


def test_choice_takes_each_value_equally_often() -> None:
    drawn = values("x", "choice(1, 2.5, -3)")[:, 0]
    result, counts = np.unique(drawn, return_counts=True)
    assert result.tolist() == [-3.0, 1.0, 2.5]
    assert stats.chisquare(counts).pvalue > 1e-3


def test_correlated_names_have_the_covariance_that_was_asked_for() -> None:
    covariance = np.array([[4.0, 1.0, 0.5], [1.0, 1.0, 0.2], [0.5, 0.2, 2.0]])
    drawn = values("a, b,c", f"normal([50, 10, 0], {covariance.tolist()})")
    assert np.allclose(drawn.mean(axis=0), [50, 10, 0], atol=0.05)
    assert np.allclose(np.cov(drawn.T), covariance, atol=0.1)


@pytest.mark.parametrize("names", ["x,y", "x,y,z"])
def test_directions_are_uniform_on_the_sphere(names: str) -> None:
    drawn = values(names, "sphere(2)")
    assert np.allclose(np.linalg.norm(drawn, axis=1), 2, rtol=1e-14)
    assert np.abs(drawn.mean(axis=0)).max() < 0.05
    if drawn.shape[1] == 3:  # Archimedes: each coordinate is uniform
        assert stats.kstest(drawn[:, 0], stats.uniform(-2, 4).cdf).pvalue > 1e-3


def test_the_centre_of_directions_points_along_the_last_axis() -> None:
    (dispersion,) = read_dispersions({"a,b,c": "sphere(2)"})
    assert dispersion.centre() == {"a": 0.0, "b": 0.0, "c": pytest.approx(2.0)}
    (dispersion,) = read_dispersions({"a,b": "sphere()"})
    assert dispersion.centre() == {"a": 0.0, "b": pytest.approx(1.0)}


@pytest.mark.parametrize(
    ("vary", "message"),
    [
        ({"a": "normal(50, -2)"}, r"a = 'normal\(50, -2\)' \(from vary\): must be normal\(mean, sd\) with sd > 0"),
        ({"a": "norml(1, 2)"}, "unknown distribution 'norml' of a.*did you mean normal"),
        ({"a": "normal(1)"}, r"must be normal\(mean, sd\)"),
        ({"a": "normal([1], [[2]])"}, r"must be normal\(mean, sd\)"),
        ({"a": "uniform(2, 1)"}, "low < high"),
        ({"a": "uniform(1, 1)"}, "low < high"),
        ({"a": "triangular(1, 0, 2)"}, "low <= mode <= high"),
        ({"a": "triangular(0, 2, 1)"}, "low <= mode <= high"),
        ({"a": "triangular(-1e200, 0, 1e200)"}, "low <= mode <= high"),
        ({"a": "lognormal(0, -1)"}, "sigma > 0"),
        ({"a,b": "lognormal(0, 1)"}, "for one name"),
        ({"a": "choice()"}, r"choice\(value, ...\)"),
        ({"a": "sphere(1)"}, "two or more components"),
        ({"a,b": "sphere(0)"}, "radius > 0"),
        ({"a,b": "uniform(0, 1)"}, "for one name"),
        ({"a,b": "normal([1, 2], [[1, 2], [2, 1]])"}, "positive definite"),
        ({"a,b": "normal([1, 2], [[1, 0.5], [0.4, 1]])"}, "positive definite"),
        ({"a,b": "normal([1, 2], [[1, 1], [1, 1]])"}, "positive definite"),
        ({"a": "1 + 2"}, "a distribution with numbers"),
        ({"a": "normal(x, 2)"}, "a distribution with numbers"),
        ({"a": "normal(nan, 2)"}, "a distribution with numbers"),
        ({"a": "__import__('os').system('true')"}, "a distribution with numbers"),
        ({"a": "normal(1, 2)", "a,b": "sphere(1)"}, "a is given twice"),
    ],
)
def test_what_is_no_distribution_is_refused(vary: dict[str, str], message: str) -> None:
    with pytest.raises(InputError, match=message):
        read_dispersions(vary)


def test_a_design_that_needs_another_number_of_runs_says_which() -> None:
    with pytest.raises(InputError, match=r"n = 1000: must be 4 times a power of two .*such as 512 or 1024"):
        Sampler("saltelli", [("a",), ("b",)], 1000, 1)
    with pytest.raises(InputError, match="sampling = 'halton'"):
        Sampler("halton", [("a",)], 10, 1)  # type: ignore[arg-type]


@pytest.mark.parametrize("value", ["bar", 3.0, [1.0]])
def test_an_unknown_name_is_refused_as_such_whatever_its_value(value: object) -> None:
    with pytest.raises(InputError, match="unknown parameter or option 'foo' of triangle with path"):
        mehvar.batch("triangle", "path", n=2, foo=value)
