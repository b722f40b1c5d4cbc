# SPDX-License-Identifier: Apache-2.0
"""`mehvar batch`: many runs from the command line, with progress, statistics, and a way to go on after an end."""

from __future__ import annotations

import shlex
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import typer
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from mehvar.campaign import CampaignFile, campaign_of, read_campaign
from mehvar.cli.stats import print_statistics
from mehvar.errors import InputError, bad_value
from mehvar.runtime.batch.dispersions import split
from mehvar.runtime.batch.fill import ImpossibleRunError, Report, run_batch
from mehvar.runtime.batch.store import StoreError, open_store


@dataclass(frozen=True)
class BatchOptions:
    """The command line of `mehvar batch`; None is what was not given."""

    model: str
    controller: str | None
    n: int | None
    scenario: str | None
    seed: int | None
    settings: Sequence[str]
    vary: Sequence[str]
    out: Path | None
    save: str | None
    resume: bool
    until: str | None
    success: str | None
    sampling: str | None
    t_end: float | None
    strict: bool
    scheduler: str | None
    threads: int | None


def batch_command(given: BatchOptions) -> int:
    """Run, report, print statistics; return the exit status.

    Raises
    ------
    InputError
        For anything unknown, malformed or out of bounds, and for a store that is there already.
    """
    asked = _merged(given)
    if asked.out is None:
        raise InputError("a batch needs a store: --out STORE.zarr")
    campaign = campaign_of(asked, "the command line")
    client = _client(given.scheduler)
    clock = _Clock()
    try:
        with client as connected, _bar(f"{asked.model} {asked.controller}") as show:
            store = run_batch(
                asked.model,
                campaign,
                asked.out,
                resume=given.resume,
                success=asked.success,
                until=asked.until,
                strict=given.strict,
                threads=given.threads,
                client=connected,
                report=clock.then(show),
                origin="--set",
            )
    except KeyboardInterrupt:
        return _stopped("interrupted", asked.out, 130)
    except StoreError as error:
        return _stopped(str(error.strerror), asked.out, 3)
    except ImpossibleRunError as error:
        return _stopped(f"--strict: {error}", asked.out, 2)
    clock.say()
    print_statistics(store, asked.success)
    return 0


def _merged(given: BatchOptions) -> CampaignFile:
    """Put the command line over the campaign file, if there is one."""
    is_file = given.model.endswith(".toml")
    base: dict[str, Any] = {"model": given.model}
    if is_file:
        base = read_campaign(Path(given.model)).model_dump(exclude_none=True)
    direct = ("controller", "n", "scenario", "seed", "out", "until", "success", "sampling", "t_end")
    over: dict[str, Any] = {name: getattr(given, name) for name in direct if getattr(given, name) is not None}
    if given.save is not None:
        over["save"] = {"every": _every(given.save)}
    over["set"] = {**base.get("set", {}), **_settings(given.settings)}
    over["vary"] = {**base.get("vary", {}), **_vary(given.vary)}
    for name, flag in (("controller", "--controller C"), ("n", "-n N")):
        if name not in {**base, **over}:
            raise InputError(f"a batch needs {flag}")
    if over.get("n", 1) < 1:
        raise bad_value("n", over["n"], "a whole number >= 1", "-n")
    if over.get("seed", 0) < 0:
        raise bad_value("seed", over["seed"], "a whole number >= 0", "--seed")
    if over.get("sampling", "random") not in ("random", "latin", "sobol", "saltelli"):
        raise bad_value("sampling", over["sampling"], "random, latin, sobol or saltelli", "--sampling")
    return CampaignFile.model_validate({**base, **over})


def _settings(items: Sequence[str]) -> dict[str, str]:
    found: dict[str, str] = {}
    for item in items:
        name, sign, value = item.partition("=")
        if not sign or not name or not value:
            raise bad_value("--set", item, "NAME=VALUE")
        if name in found:
            raise InputError(f"--set {name} is given twice")
        found[name] = value
    return found


def _vary(items: Sequence[str]) -> dict[str, str]:
    found: dict[str, str] = {}
    for item in items:
        names, text = split(item)
        if names in found:
            raise InputError(f"--vary {names} is given twice")
        found[names] = text
    return found


def _every(text: str) -> float:
    name, _, value = text.partition("=")
    try:
        every = float(value)
    except ValueError:
        every = 0.0
    if name != "every" or not every > 0:
        raise bad_value("--save", text, "every=DT with DT > 0 in seconds")
    return every


def _client(scheduler: str | None) -> Any:
    if scheduler is None:
        return nullcontext()
    from mehvar.runtime.batch.workers import connect

    return connect(scheduler)


def _stopped(why: str, out: Path, status: int) -> int:
    """Say what is kept and how to go on."""
    kept = ""
    try:
        store = open_store(out)
        runs = sum(len(store.runs(block)) for block in store.stored())
        kept = f"{runs} of {store.n} runs are stored; "
    except (InputError, OSError):
        pass
    words = ["mehvar", *sys.argv[1:]]
    again = shlex.join(words if "--resume" in words else [*words, "--resume"])
    typer.echo(f"mehvar: {why}\n{kept}go on with:\n  {again}", err=True)
    return status


class _Clock:
    """How many runs were computed, and how long that took from the first report on."""

    def __init__(self) -> None:
        self._reports: list[tuple[float, int]] = []

    def then(self, show: Report) -> Report:
        """Return a report that is noted and shown."""

        def report(runs: int, total: int, failed: int) -> None:
            self._reports = [*self._reports[:1], (time.perf_counter(), runs)]
            show(runs, total, failed)

        return report

    def say(self) -> None:
        """Print runs, time and rate; nothing when no run was computed."""
        (begun, first), *rest = self._reports or [(0.0, 0)]
        if rest:
            (ended, last) = rest[0]
            runs, seconds = last - first, ended - begun
            typer.echo(f"{runs} runs in {seconds:.3g} s, {runs / seconds:.3g} runs/s")


@contextmanager
def _bar(what: str) -> Iterator[Report]:
    """Show rate, runs done, time left and failures on a terminal's standard error."""
    console = Console(stderr=True)
    bar = Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.completed:.0f}/{task.total:.0f} runs, {task.fields[rate]}, {task.fields[failed]} not done,"),
        TimeRemainingColumn(compact=True),
        TextColumn("left"),
        console=console,
        transient=True,
        disable=not console.is_terminal,
    )
    with bar:
        task = bar.add_task(what, total=1, rate="compiling", failed=0)
        begun = False

        def show(runs: int, total: int, failed: int) -> None:
            nonlocal begun
            if not begun:
                bar.reset(task, total=total, completed=runs)
                begun = True
            speed = bar.tasks[0].finished_speed or bar.tasks[0].speed
            rate = f"{speed:.3g} runs/s" if speed else "started"
            bar.update(task, completed=runs, total=total, rate=rate, failed=failed)

        yield show
