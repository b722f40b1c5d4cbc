# SPDX-License-Identifier: Apache-2.0
"""No input ends in a traceback or a signal, and a refused command writes nothing.

Short here; `make soak` runs a hundred thousand commands and expressions.
"""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from pathlib import Path
from random import Random

import pytest

from mehvar import runtime
from tests import commands

from . import campaign
from .inputs import PENDULUM

SOAK = 100_000


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a campaign file and a store."""
    campaign.furnish(tmp_path, campaign.in_process)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def sound(outcome: campaign.Outcome, *kinds: str) -> None:
    assert not outcome.findings, f"{len(outcome.findings)} of {outcome.counts}:\n" + "\n".join(outcome.findings[:5])
    for kind in kinds:
        assert outcome.counts[kind], f"no input was {kind}: {outcome.counts}"


def test_expressions() -> None:
    sound(campaign.expressions(1, 2_000), "taken", "refused")


def test_campaign_files(tmp_path: Path) -> None:
    sound(campaign.campaign_files(2, 300, tmp_path), "taken", "refused")


def test_commands(place: Path) -> None:
    sound(campaign.commands(3, 100, place, campaign.in_process), "simulate 2", "batch 2")


@pytest.mark.soak
def test_a_campaign_goes_on_where_it_was(tmp_path: Path) -> None:
    journal = tmp_path / "journal.jsonl"
    for sum_of_it in ("commands, seed 6: 5, of these",) * 2:
        done = subprocess.run(
            [commands.python(), "-P", "-m", "tests.fuzz", "commands", "6", "5", journal],
            cwd=campaign.ROOT, capture_output=True, text=True, check=False,
        )  # fmt: skip
        assert done.returncode == 0, done.stdout + done.stderr
        assert sum_of_it in done.stdout
    assert len(journal.read_text().splitlines()) == 1


@pytest.mark.soak
def test_commands_in_processes_of_their_own(place: Path) -> None:
    sound(campaign.commands(4, 3, place, campaign.as_process))


@pytest.mark.soak
def test_damaged_stores(place: Path) -> None:
    sound(campaign.damaged_stores(5, 40, place / "s.zarr", probe()))


@pytest.mark.soak
def test_a_hundred_thousand_expressions() -> None:
    sound(campaign.expressions(11, SOAK), "taken", "refused")


@pytest.mark.soak
def test_many_campaign_files(tmp_path: Path) -> None:
    sound(campaign.campaign_files(12, SOAK // 5, tmp_path), "taken", "refused")


@pytest.mark.soak
def test_many_commands_in_processes_of_their_own(place: Path) -> None:
    sound(campaign.commands(13, 500, place, campaign.as_process))


@pytest.mark.soak
def test_many_damaged_stores(place: Path) -> None:
    sound(campaign.damaged_stores(14, 5_000, place / "s.zarr", probe()))


@pytest.mark.soak
def test_many_damaged_results(tmp_path: Path) -> None:
    run = runtime.to_dataset(runtime.simulate(PENDULUM, "p-sum", t_end=0.1))
    path, random = tmp_path / "run.nc", Random(15)
    runtime.save(run, path)
    whole = path.read_bytes()
    for _ in range(5_000):
        place = random.randrange(len(whole))
        path.write_bytes(whole[:place] + bytes([whole[place] ^ 1 << random.randrange(8)]) + whole[place + 1 :])
        try:
            again = runtime.open_result(path)
        except runtime.InputError:
            continue
        assert all(again[name].equals(run[name]) for name in run.data_vars if run[name].ndim and name in again)


def probe() -> Callable[[], tuple[int, str]]:
    """Return a reader of a damaged store: its statistics, and each second time a repeat of a run."""
    commands = (("stats", "s.zarr"), ("simulate", "--from", "s.zarr", "--run", "1", "--trust-model"))
    count = iter(range(10**9))
    return lambda: campaign.in_process(*commands[next(count) % 2])
