# SPDX-License-Identifier: Apache-2.0
"""One batch has one numerics: what decides bits is compared before a block is added."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from mehvar import runtime
from mehvar.base.errors import InputError
from mehvar.runtime.batch import blocks, numerics, source, workers
from mehvar.runtime.batch.blocks import Blocks
from mehvar.runtime.batch.fill import run_batch
from mehvar.runtime.batch.numerics import generated_digest, other_numerics
from mehvar.runtime.batch.plan import Campaign, Plan
from mehvar.runtime.batch.repeat import plan_of
from mehvar.runtime.batch.store.store import open_store
from mehvar.runtime.run import options

PENDULUM = Path(__file__).parents[1] / "pendulum"
CAMPAIGN = Campaign("pd", n=8, vary={"g": "uniform(1, 9)"}, options={"t_end": 0.1})


def of(campaign: Campaign = CAMPAIGN) -> str:
    return Blocks(Plan(runtime.load(PENDULUM, "c"), campaign), threads=1).numerics


def test_portable_numerics_are_the_same_on_another_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    here = of()
    monkeypatch.setattr(numerics, "kernel_flags", lambda *_: ("-mother",))
    monkeypatch.setattr(numerics.platform, "machine", lambda: "another")
    assert of() == here
    fast = replace(CAMPAIGN, options={"t_end": 0.1, "profile": "fast"})
    processor = json.loads(of(fast))["processor"]
    assert "another" in processor
    assert "-mother" in processor


@pytest.mark.parametrize(
    ("name", "meaning"),
    [("native", "mehvar's own C"), ("drawing", "code that draws values"), ("generated", "generated text of the model")],
)
def test_a_store_is_not_continued_with_other_numerics(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, meaning: str
) -> None:
    run_batch(PENDULUM, CAMPAIGN, tmp_path / "runs.zarr", chunk=4)
    (tmp_path / "runs.zarr" / "records" / "1.json").unlink()
    real = blocks.numerics_of
    monkeypatch.setattr(
        blocks, "numerics_of", lambda *given: json.dumps({**json.loads(real(*given)), name: "0" * 32}, sort_keys=True)
    )
    with pytest.raises(InputError, match=f"made with other numerics: .*{meaning}.*here 000000"):
        run_batch(PENDULUM, CAMPAIGN, tmp_path / "runs.zarr", resume=True)


def test_a_changed_line_of_c_changes_them(monkeypatch: pytest.MonkeyPatch) -> None:
    here, real = of(), source.native_sources
    monkeypatch.setattr(
        source, "native_sources", lambda *names: {name: f"{text}/* other */" for name, text in real(*names).items()}
    )
    assert other_numerics(here, of()).startswith("mehvar's own C (")


def test_a_block_says_what_computed_it(tmp_path: Path) -> None:
    run_batch(PENDULUM, CAMPAIGN, tmp_path / "runs.zarr")
    store = open_store(tmp_path / "runs.zarr")
    about = store.about(0)["provenance"]
    assert {"compiler", "flags", "lanes", "machine", "mehvar", "numpy"} <= about.keys()
    assert "-ffp-contract=off" in about["flags"]
    assert json.loads(store.attributes["numerics"])["profile"] == "portable"


OTHERS: dict[str, object] = {
    **{"t_end": 0.2, "dt_out": 0.005, "hold": 0.05, "delay": 1, "method": "dopri5", "rtol": 1e-4, "atol": 1e-4},
    **{"step": 0.001, "max_steps": 50_000, "profile": "fast"},
}
"""A default of another build for each option of a batch."""


def test_each_option_of_a_batch_is_recorded() -> None:
    names = {name for name, row in options.OPTIONS.items() if "batch" not in row.refused}
    assert json.loads(json.loads(of())["options"]).keys() == names == OTHERS.keys()


@pytest.mark.parametrize("name", OTHERS)
@pytest.mark.share(4)
def test_a_build_with_another_default_adds_no_block(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Neither by going on, nor as a worker of a cluster; nor does it repeat a run of the store as its own."""
    sampled: dict[str, float | str] = {"hold": 0.05, "t_end": 0.5} if name == "delay" else {}
    campaign, out = replace(CAMPAIGN, options=sampled), tmp_path / "runs.zarr"
    run_batch(PENDULUM, campaign, out, chunk=4)
    (out / "records" / "1.json").unlink()
    plan = Plan(runtime.load(PENDULUM, "c"), campaign)
    bundle = workers._bundle(plan, Blocks(plan, threads=1).numerics)
    monkeypatch.setitem(options.RunOptions.__init__.__kwdefaults__, name, OTHERS[name])
    monkeypatch.setitem(options.OPTIONS, name, replace(options.OPTIONS[name], default=OTHERS[name]))
    monkeypatch.setattr(workers, "_READY", {})
    said = f"{name} = .*, here {OTHERS[name]!r}"
    with pytest.raises(InputError, match=f"made with other numerics: .*{said}"):
        run_batch(PENDULUM, campaign, out, resume=True)
    with pytest.raises(InputError, match=f"its numerics differ: .*{said}"):
        workers._blocks(bundle.key(), bundle)
    with pytest.raises(InputError, match=f"was made with other options, by another build: .*{said}"):
        plan_of(open_store(out), PENDULUM)


def test_an_edit_that_leaves_the_code_unchanged_leaves_the_batch_unchanged() -> None:
    """A batch could not be repeated after an edit of a source that its model reads without effect."""
    manifest = runtime.load("triangle").manifest
    digest = generated_digest(manifest)
    assert generated_digest(replace(manifest, inputs_sha256={"models/other.py": "0"}, text="")) == digest
    first, *others = manifest.parameters
    changed = (replace(first, description="another mass"), *others)
    assert generated_digest(replace(manifest, parameters=changed)) != digest
