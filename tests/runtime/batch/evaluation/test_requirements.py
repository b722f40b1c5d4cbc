# SPDX-License-Identifier: Apache-2.0
"""Requirements: what the texts mean, bounds that err as seldom as they say, and batches that end when they decide."""

from __future__ import annotations

import itertools
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.special import xlogy

import mehvar
from mehvar.base.errors import InputError
from mehvar.report.verdicts import Verdicts
from mehvar.runtime.batch.blocks import IMPOSSIBLE
from mehvar.runtime.batch.evaluation.binomial import lower_bound
from mehvar.runtime.batch.evaluation.requirements import (
    DecisionRule,
    decide,
    evidence,
    log_evidence,
    read_requirements,
    sequential_bound,
)
from mehvar.runtime.batch.store.layout import STATUS
from mehvar.runtime.run.problem import Status
from tests.fuzz.campaign import in_process
from tests.runtime.batch.evaluation.test_statistics import filled

UNITS = {"peak": "rad", "a": "s", "final(x)": "m"}
RULES = {"until": "", "model": "m", "controller": "c", "scenario": "s", "seed": 0}


def read(text: str):
    (requirement,) = read_requirements({"r": text}, UNITS, {})
    return requirement


def test_a_quantile_is_a_share_of_the_runs_below_or_above_a_limit() -> None:
    below, above = read("quantile(0.9, abs(peak)) < 45 deg"), read("quantile(0.1, final(x)) >= 2 km")
    assert (below.share, below.condition.text, below.largest) == (0.9, f"abs(peak) < {math.pi / 4!r}", True)
    assert (above.share, above.condition.text, above.largest) == (0.9, "final(x) >= 2000.0", False)
    either = read("probability(peak < 1 and a < 2) > 0.99")
    assert (either.condition.text, either.units) == ("peak < 1 and a < 2", "a in s, peak in rad")
    assert (below.units, read("quantile(0.9, abs(peak)) < 0.8").units) == ("", "peak in rad")


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("quantile(0.9, peak) < 1 s", "a number in rad"),
        ("quantile(0.9, peek) < 1", "peek"),
        ("quantile(1.0, peak) < 1", "between 0 and 1"),
        ("quantile(0.9, peak < 1) < 1", "must be"),
        ("quantile(0.9, peak or a) < 1", "must be"),
        ("quantile(0.9, peak) < a", "no number in rad"),
        ("quantile(0.9, peak * a) < 1 deg", "must be"),
        ("probability(peak) > 0.5", "must be"),
        ("probability(peak < a) > 0.5", "the same unit"),
        ("probability(peak < 1) < 0.5", "must be"),
        ("peak < 1", "must be"),
        (1.0, "must be a text"),
    ],
)
def test_what_is_no_requirement_is_refused_by_name(text: object, part: str) -> None:
    with pytest.raises(InputError, match=part) as refusal:
        read_requirements({"r": text}, UNITS, {})  # type: ignore[dict-item]
    assert "r = " in str(refusal.value) or "unknown number" in str(refusal.value)


@given(runs=st.integers(1, 400), part=st.floats(0, 1), share=st.floats(0.01, 0.99))
def test_the_evidence_is_the_averaged_ratio_of_likelihoods(runs: int, part: float, share: float) -> None:
    successes = round(part * runs)

    def exponent(q: float) -> float:
        return float(xlogy(successes, q / share) + xlogy(runs - successes, (1 - q) / (1 - share)))

    peak = max(successes / runs, share)
    whole = quad(lambda q: math.exp(exponent(q) - exponent(peak)), share, 1, points=[peak], limit=400)[0]
    expected = math.log(whole / (1 - share)) + exponent(peak)
    evidence = log_evidence(successes, runs, share)
    assert evidence == pytest.approx(expected, abs=1e-5) or (evidence == -math.inf and expected < 0)


@given(runs=st.integers(1, 10**5), part=st.floats(0, 1), confidence=st.floats(0.5, 0.999))
def test_the_sequential_bound_separates_the_shares_that_the_evidence_excludes(runs, part, confidence) -> None:
    successes = round(part * runs)
    bound, needed = sequential_bound(successes, runs, confidence), -math.log1p(-confidence)
    assert 0 <= bound <= lower_bound(successes, runs, confidence) + 1e-12  # looking at any time costs width
    if bound > 1e-6:
        assert log_evidence(successes, runs, bound * (1 - 1e-6)) > needed - 1e-6
    if 0 < bound < 1 - 1e-6:
        assert log_evidence(successes, runs, bound + 1e-6 * (1 - bound)) < needed + 1e-6


@pytest.mark.soak
def test_a_rule_that_looks_after_each_run_errs_as_seldom_as_it_says() -> None:
    """300 batches of up to 1000 runs whose share is the required one, where every decision would be wrong."""
    confidence, share, rng = 0.95, 0.9, np.random.default_rng(20261124)
    needed, false = -math.log1p(-confidence), 0
    for _ in range(300):
        fulfilled = np.cumsum(rng.random(1000) < share)
        false += any(log_evidence(int(k), n, share) >= needed for n, k in enumerate(fulfilled, 1))
    assert false <= 300 * 0.05  # the bound is Ville's; the observed rate is below it because a batch ends
    assert false > 0  # the test would see a rule that never decides


def test_a_decision_comes_with_a_share_that_is_not_the_required_one() -> None:
    rng = np.random.default_rng(7)
    requirement = read("probability(peak < 1) > 0.9")
    for share, answer in ((0.97, "holds"), (0.8, "does not hold")):
        rule, fulfilled = DecisionRule([requirement], 0.99, "random"), np.cumsum(rng.random(5000) < share)
        n = next(n for n in itertools.count(1) if rule.holds([int(fulfilled[n - 1])], n))
        assert evidence(int(fulfilled[n - 1]), n, 0.99, False).answer(0.9) == answer


def test_a_store_of_known_numbers_has_known_verdicts() -> None:
    m = np.arange(1000.0)
    status = np.zeros(1000, np.uint8)
    status[5] = Status.LIMIT
    m[7] = math.nan
    store = filled({"m": m, STATUS: status}, **RULES)
    texts = {
        "low": "quantile(0.5, m) < 600 s",
        "high": "quantile(0.5, m) < 400 s",
        "near": "quantile(0.5, m) < 500 s",
        "large": "quantile(0.1, m) > 50 s",
    }
    verdicts = dict(zip(texts, decide(store, texts, 0.95), strict=True))
    assert {name: v.answer for name, v in verdicts.items()} == {
        "low": "holds", "high": "does not hold", "near": "undecided", "large": "holds",
    }  # fmt: skip
    assert verdicts["low"].evidence is not None
    assert verdicts["low"].evidence.fulfilled == 598  # run 5 did not end and run 7 has no number
    assert [run for run, _ in verdicts["low"].worst] == [5, 7, 999]
    assert verdicts["large"].worst[2] == (0, 0.0)
    text = repr(Verdicts(store, texts, None))
    for word in ("low: HOLDS", "high: DOES NOT HOLD", "near: UNDECIDED", "598 of 1000", "ended as 'limit'"):
        assert word in text


def test_the_worst_runs_are_among_those_that_were_counted() -> None:
    """A stop rule decides early; later runs are no evidence."""
    m = np.arange(1000.0)
    store = filled({"m": m, STATUS: np.zeros(1000, np.uint8)}, **{**RULES, "until": "decided"})
    (verdict,) = decide(store, {"low": "quantile(0.5, m) < 900 s"}, 0.95)
    assert verdict.answer == "holds"
    assert verdict.evidence is not None
    assert verdict.evidence.runs < 1000
    assert verdict.worst[0] == (verdict.evidence.runs - 1, verdict.evidence.runs - 1.0)


def test_a_bad_run_says_whether_it_ended_early_has_no_number_or_an_infinite_one() -> None:
    m = np.arange(1000.0)
    m[[3, 7, 500]] = math.inf, math.nan, math.inf
    status = np.zeros(1000, np.uint8)
    status[5] = Status.LIMIT
    texts = {"below": "quantile(0.5, m) < 600 s"}
    text = repr(Verdicts(filled({"m": m, STATUS: status}, **RULES), texts, None))
    assert text.splitlines()[-3:] == [
        "    run 3, m = inf",
        "    run 5, which ended as 'limit'",
        "    run 7, which has no m",
    ]
    late = repr(Verdicts(filled({"m": m, STATUS: status}, blocks=[7], **RULES), texts, None))
    assert "run 500, m = inf" in late


def test_a_verdict_counts_the_runs_with_values_that_are_not_allowed() -> None:
    status = np.zeros(1000, np.uint8)
    (verdict,) = decide(filled({STATUS: status}, **RULES), {"r": "quantile(0.5, m) < 1"}, 0.95)
    assert "not allowed" not in verdict.reason
    status[:3] = IMPOSSIBLE
    (verdict,) = decide(filled({STATUS: status}, **RULES), {"r": "quantile(0.5, m) < 1"}, 0.95)
    assert "; 3 runs with values that are not allowed count as not fulfilled" in verdict.reason


def test_listed_and_designed_runs_decide_nothing() -> None:
    for campaign in ('{"vary": {"a": "values(1, 2)"}}', '{"sampling": "sobol", "vary": {"a": "uniform(0, 1)"}}'):
        store = filled({}, **RULES, campaign=campaign)
        (verdict,) = decide(store, {"r": "quantile(0.5, m) < 1"})
        assert (verdict.answer, verdict.evidence) == ("undecided", None)


def test_a_campaign_ends_when_it_is_decided_and_its_store_says_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("c.toml").write_text(
        """
        model = "triangle"
        controller = "path"
        n = 40960
        t_end = 0.1
        out = "runs.zarr"
        confidence = 0.99
        [vary]
        theta_0 = "uniform(0.5, 1.5)"
        [require]
        near = "probability(theta_0 < 1.4) > 0.8"
        far = "quantile(0.5, theta_0) < 50 deg"
        """
    )
    status, text = in_process("require", "c.toml", "--page", "page.html")
    assert status == 1  # far does not hold
    assert "near: HOLDS" in text
    assert "far: DOES NOT HOLD" in text
    assert "mehvar simulate --from runs.zarr --run" in text
    again, stored = in_process("require", "runs.zarr")
    assert again == 1
    assert stored == text.replace("saved page.html\n", "")
    assert in_process("require", "runs.zarr", "--that", "near=probability(theta_0 < 1.4) > 0.8")[0] == 0
    page = Path("page.html").read_text()
    assert all(word in page for word in ("does not hold", "holds", "quantile(0.5, theta_0) &lt; 50 deg"))
    verdicts = mehvar.require("runs.zarr")
    assert verdicts["near"].evidence is not None
    assert verdicts["near"].evidence.runs < 40960
    assert not verdicts.hold
    one = mehvar.require(
        "triangle",
        {"near": "probability(theta_0 < 1.4) > 0.8"},
        confidence=0.99, controller="path", n=40960, vary={"theta_0": "uniform(0.5, 1.5)"}, t_end=0.1,
    )  # fmt: skip
    assert one.hold
    assert one["near"].evidence == verdicts["near"].evidence


@pytest.mark.parametrize(
    ("arguments", "part"),
    [
        ({"require": {}}, "left out without a requirement"),
        ({"require": {"r": "quantile(0.5, theta_0) < 1"}, "sampling": "sobol"}, "sobol design"),
        ({"require": {"r": "quantile(0.5, theta_0) < 1"}, "vary": {"theta_0": [1.0, 1.1]}, "n": 2}, "listed design"),
        ({"require": {"r": "quantile(0.5, theta_0) < 1"}, "confidence": 1.5}, "confidence = 1.5"),
        ({"require": {"r": "quantile(0.5, theta_9) < 1"}}, "theta_9"),
    ],
)
def test_a_batch_that_could_decide_nothing_is_refused_before_a_run(arguments: dict, part: str) -> None:
    usual = {"n": 100, "vary": {"theta_0": "uniform(0.5, 1.5)"}, "t_end": 0.1, "until": "decided"}
    with pytest.raises(InputError, match=part):
        mehvar.batch("triangle", "path", **{**usual, **arguments})


def test_listed_values_have_a_share_and_no_interval(tmp_path: Path) -> None:
    mehvar.batch("triangle", "path", vary={"theta_0": [0.5, 1.0, 1.5]}, t_end=0.1, out=tmp_path / "s.zarr")
    status, text = in_process("stats", str(tmp_path / "s.zarr"))
    assert status == 0
    assert "success: 3 of 3, share 1; no interval: the values are listed" in text
    assert "95 % interval" not in text.split("sensitivities")[0]
    with pytest.raises(InputError, match="lists are not random"):
        mehvar.batch("triangle", "path", vary={"theta_0": [0.5, 1.0]}, t_end=0.1, until="ci(success) < 0.9")


def test_only_a_whole_store_that_no_rule_ended_has_the_bounds_of_a_fixed_number() -> None:
    m = np.arange(1000.0)
    for store, runs, bound in (
        (filled({"m": m}, **RULES), 1000, lower_bound),
        (filled({"m": m}, **{**RULES, "until": "ci(success) < 0.1"}), 1000, sequential_bound),
        (filled({"m": m}, blocks=[0, 1, 2], **RULES), 192, sequential_bound),
        (filled({"m": m}, blocks=[0, 1, 5], **RULES), 128, sequential_bound),
    ):
        (verdict,) = decide(store, {"r": "quantile(0.9, m) < 100"}, 0.9999)
        assert verdict.evidence is not None
        counted = verdict.evidence.runs
        assert counted <= runs
        assert verdict.evidence.low == bound(min(counted, 100), counted, 0.9999)
