# SPDX-License-Identifier: Apache-2.0
"""Rare failures of runs: known probabilities, failures that repeat, and what is refused or undecided."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
from scipy.stats import norm

import mehvar
from mehvar.base.errors import InputError
from mehvar.runtime.batch.evaluation.requirements import RareEvidence
from tests.fuzz.campaign import in_process

RUN: dict[str, Any] = {"controller": "path", "n": 40_000, "t_end": 0.02, "rare": True}


def required(texts: dict[str, str], **options: Any) -> Any:
    options = {"vary": {"theta_0": "normal(1, 0.1)"}, **RUN, **options}
    return mehvar.require("triangle", texts, **options)


def test_a_known_probability_is_between_the_bounds_and_decides() -> None:
    """theta_0 is beyond 1 + 0.1 k with the probability of a normal number beyond k."""
    texts = {
        "above": f"quantile(0.99999, theta_0) < {1 + 0.1 * norm.isf(1e-6)}",
        "below": f"quantile(0.00001, theta_0) >= {1 - 0.1 * norm.isf(1e-4)}",
    }
    verdicts = required(texts, confidence=0.999)
    assert [v.answer for v in verdicts] == ["holds", "does not hold"]
    for verdict, probability in zip(verdicts, (1e-6, 1e-4), strict=True):
        assert isinstance(verdict.evidence, RareEvidence)
        assert verdict.evidence.least < probability < verdict.evidence.most
        assert verdict.evidence.runs <= 40_000
    assert "fail, allowed 1e-05" in repr(verdicts)
    assert verdicts.facts()[0]["high"] > 0.99999
    assert repr(required(texts, confidence=0.999)) == repr(verdicts)


def test_runs_that_failed_fail_again() -> None:
    text = "quantile(0.9999, final(theta)) < 1.42"
    (verdict,) = required({"r": text})
    some = {name: values[:50] for name, values in verdict.failures.items()}
    again = mehvar.batch("triangle", "path", points=some, t_end=0.02)
    assert (again["final"][:, 3] >= 1.42).all()
    assert float(again["final"][0, 3]) >= float(again["final"][49, 3])


def test_a_number_that_never_reaches_its_limit_holds() -> None:
    (verdict,) = required({"r": "quantile(0.9999, theta_0) < 1.5"}, vary={"theta_0": "uniform(0.5, 1.499)"})
    assert verdict.answer == "holds"
    assert isinstance(verdict.evidence, RareEvidence)
    assert verdict.evidence.least == 0  # no failure was met
    assert not len(verdict.failures["theta_0"])


def test_too_few_runs_leave_it_undecided() -> None:
    (verdict,) = required({"r": "quantile(0.999999, theta_0) < 1.5"}, n=5000)
    assert (verdict.answer, verdict.evidence) == ("undecided", None)
    assert verdict.reason == "undecided: n = 5000 is too small: 43479 runs are enough"


def test_so_many_runs_as_are_called_enough_decide() -> None:
    (verdict,) = required({"r": "quantile(0.9999, theta_0) < 1.5"}, n=5250)
    few = re.search(r"(\d+) runs are enough", verdict.reason)
    assert few
    (verdict,) = required({"r": "quantile(0.9999, theta_0) < 1.5"}, n=int(few[1]))
    assert verdict.answer != "undecided"
    assert verdict.evidence.runs <= int(few[1])


def test_noise_that_decides_more_than_what_varies_leaves_it_undecided() -> None:
    (verdict,) = mehvar.require(
        "satellite", {"r": "quantile(0.999999, maximum(wx)) < 1"}, controller="pd", n=40_000, t_end=1.0, noise=1e-3,
        vary={"I_x": "normal(2, 1e-6)"}, rare=True,
    )  # fmt: skip
    assert verdict.answer == "undecided"
    assert "noise may matter more" in verdict.reason


@pytest.mark.parametrize(
    ("options", "part"),
    [
        ({"vary": {}}, "vary = {}"),
        ({"vary": {"theta_0": [1.0, 2.0]}, "n": 2}, "must be distributions"),
        ({"sampling": "sobol"}, "sampling = 'sobol'"),
        ({"save": 0.01}, "save = 0.01"),
        ({"out": "runs.zarr"}, "out = 'runs.zarr'"),
        ({"until": "decided"}, "until = 'decided'"),
        ({"threads": 0}, "threads = 0"),
        ({"rare": "yes"}, "rare = 'yes'"),
    ],
)
def test_what_a_search_cannot_use_is_refused_by_name(options: dict[str, Any], part: str) -> None:
    with pytest.raises(InputError) as refusal:
        required({"r": "quantile(0.999, theta_0) < 2"}, **options)
    assert part in str(refusal.value)


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("probability(theta_0 < 2) > 0.999", "a quantile with rare"),
        ("quantile(0.99999999999999, theta_0) < 2", "at least 1e-12"),
    ],
)
def test_a_requirement_needs_a_number_and_a_share_that_doubles_resolve(text: str, part: str) -> None:
    with pytest.raises(InputError, match=part):
        required({"r": text})


def test_the_command_seeks_failures_of_a_campaign(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    lines = ['model = "triangle"', 'controller = "path"', "n = 40000", "t_end = 0.02", "[vary]"]
    lines += ['theta_0 = "normal(1, 0.1)"', "[require]", 'near = "quantile(0.99999, theta_0) < 1.6"']
    Path("c.toml").write_text("\n".join(lines))
    status, text = in_process("require", "c.toml", "--rare", "--page", "p.html")
    assert status == 0
    assert "near: HOLDS" in text
    assert "failures sought" in Path("p.html").read_text()
    Path("kept.toml").write_text("\n".join(["until = 'decided'", *lines]))
    status, text = in_process("require", "kept.toml", "--rare")
    assert status == 2
    assert "until = 'decided' (from kept.toml): must be left out with rare" in " ".join(text.split())
    assert in_process("require", "c.toml", "--rare", "--out", "runs.zarr")[0] == 2
    assert in_process("require", "runs.zarr", "--rare")[0] == 2
