# SPDX-License-Identifier: Apache-2.0
"""One batch has one numerics: what decides bits is compared before a block is added."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from mehvar import runtime
from mehvar.errors import InputError
from mehvar.runtime.batch import blocks, numerics
from mehvar.runtime.batch.blocks import Blocks
from mehvar.runtime.batch.fill import run_batch
from mehvar.runtime.batch.numerics import other_numerics
from mehvar.runtime.batch.plan import Campaign, Plan
from mehvar.runtime.batch.store.store import open_store

PENDULUM = Path(__file__).parents[1] / "pendulum"
CAMPAIGN = Campaign("pd", n=8, vary={"g": "uniform(1, 9)"}, options={"t_end": 0.1})


def of(campaign: Campaign = CAMPAIGN) -> numerics.Numerics:
    return Blocks(Plan(runtime.load(PENDULUM, "c"), campaign), threads=1).numerics


def test_portable_numerics_are_the_same_on_another_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    here = of()
    monkeypatch.setattr(numerics, "kernel_flags", lambda *_: ("-mother",))
    monkeypatch.setattr(numerics.platform, "machine", lambda: "another")
    assert of() == here
    fast = replace(CAMPAIGN, options={"t_end": 0.1, "profile": "fast"})
    assert "another" in of(fast).processor
    assert "-mother" in of(fast).processor


@pytest.mark.parametrize(
    ("name", "meaning"),
    [("native", "mehvar's own C"), ("drawing", "what draws the values"), ("generated", "generated text of the model")],
)
def test_a_store_is_not_continued_with_other_numerics(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, meaning: str
) -> None:
    run_batch(PENDULUM, CAMPAIGN, tmp_path / "runs.zarr", chunk=4)
    (tmp_path / "runs.zarr" / "records" / "1.json").unlink()
    real = blocks.numerics_of
    monkeypatch.setattr(blocks, "numerics_of", lambda *given: replace(real(*given), **{name: "0" * 32}))
    with pytest.raises(InputError, match=f"made with other numerics, whose bits do not mix: .*{meaning}.*here 000000"):
        run_batch(PENDULUM, CAMPAIGN, tmp_path / "runs.zarr", resume=True)


def test_a_changed_line_of_c_changes_them(monkeypatch: pytest.MonkeyPatch) -> None:
    here, real = of(), numerics.kernel_sources
    monkeypatch.setattr(numerics, "kernel_sources", lambda loop: {**real(loop), "batch.c": "/* other */"})
    assert other_numerics(here.text(), of().text()).startswith("mehvar's own C (")


def test_a_block_says_what_computed_it(tmp_path: Path) -> None:
    run_batch(PENDULUM, CAMPAIGN, tmp_path / "runs.zarr")
    store = open_store(tmp_path / "runs.zarr")
    about = store.about(0)["provenance"]
    assert {"compiler", "flags", "lanes", "machine", "mehvar", "numpy"} <= about.keys()
    assert "-ffp-contract=off" in about["flags"]
    assert json.loads(store.attributes["numerics"])["profile"] == "portable"
