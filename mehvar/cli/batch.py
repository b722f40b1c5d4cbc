# SPDX-License-Identifier: Apache-2.0
"""`mehvar batch`: many runs with progress and statistics, in a store that can be continued."""

from __future__ import annotations

import logging
import shlex
import sys
from collections.abc import Mapping
from contextlib import nullcontext
from pathlib import Path
from typing import Annotated, Any

import typer

from mehvar.base.errors import InputError, MehvarError, Origin, bad_value, run_checks
from mehvar.campaign import CampaignFile, Save, read_campaign
from mehvar.cli.store.stats import print_statistics
from mehvar.runtime.batch.fill import run_batch
from mehvar.runtime.batch.plan import CAMPAIGN_OPTIONS
from mehvar.runtime.batch.store.store import open_store
from mehvar.runtime.model.catalogue import find_model
from mehvar.runtime.run.formats import ENDINGS as RESULT_ENDINGS
from mehvar.runtime.units import read_value
from mehvar.settings import (
    EndTime,
    Scenario,
    SettingTexts,
    complete_controllers,
    complete_models,
    complete_varied,
    end_time,
    read_settings,
    read_values,
    required_law,
    whole_number,
)
from mehvar.terminal import BatchMeter, progress

_FLAGS = {"n": "-n", "seed": "--seed", "sampling": "--sampling"}
"""Campaign options with a command line flag of their own."""


def command(
    model: Annotated[
        str,
        typer.Argument(
            metavar="MODEL", help="A model, a generated folder, or a campaign.toml.", autocompletion=complete_models
        ),
    ],
    controller: Annotated[
        str | None, typer.Option(metavar="C", help="The control law.", autocompletion=complete_controllers)
    ] = None,
    n: Annotated[
        int | None, typer.Option("-n", parser=whole_number, metavar="N", help=CAMPAIGN_OPTIONS["n"].help)
    ] = None,
    scenario: Scenario = None,
    seed: Annotated[
        int | None, typer.Option(parser=whole_number, metavar="K", help=CAMPAIGN_OPTIONS["seed"].help)
    ] = None,
    settings: SettingTexts = None,
    vary: Annotated[
        list[str] | None,
        typer.Option(
            metavar='"NAME=DIST(...)"',
            help="Draw a parameter or an initial state for each run; repeat as needed.",
            autocompletion=complete_varied,
        ),
    ] = None,
    out: Annotated[Path | None, typer.Option(metavar="STORE.zarr", help="The store, a new folder.")] = None,
    save: Annotated[str | None, typer.Option(metavar="DT", help=CAMPAIGN_OPTIONS["save_every"].help)] = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="Continue the store; damaged blocks are computed again.")
    ] = False,
    until: Annotated[
        str | None,
        typer.Option(metavar="EXPR", help='Stop at "ci(success) < 0.01", or at "decided" for all requirements.'),
    ] = None,
    success: Annotated[
        str | None,
        typer.Option(metavar="EXPR", help='Success condition besides reaching the end: "T_theta < 20 s".'),
    ] = None,
    sampling: Annotated[str | None, typer.Option(metavar="DESIGN", help=CAMPAIGN_OPTIONS["sampling"].help)] = None,
    t_end: EndTime = None,
    strict: Annotated[bool, typer.Option("--strict", help="Stop at a run with invalid drawn values.")] = False,
    scheduler: Annotated[str | None, typer.Option(metavar="ADDRESS", help="A dask scheduler: tcp://host:8786.")] = None,
    threads: Annotated[
        int | None,
        typer.Option(parser=whole_number, metavar="N", help="Threads of this process; default: all processors."),
    ] = None,
) -> int:
    """Run a batch and print its statistics; return the exit status.

    Raises
    ------
    InputError
        For anything unknown, malformed or out of bounds, and for an existing store.
    """
    manifest = find_model(read_campaign(Path(model)).model if model.endswith(".toml") else model)
    batch = _campaign(
        model, controller=controller, n=n, scenario=scenario, seed=seed, sampling=sampling, **end_time(t_end),
        out=out, until=until, success=success, save=_save(save), set=read_values(settings, manifest),
        vary=read_settings(vary, "--vary", 'NAME=DIST(...), as in "m1=normal(50, 2)"'),
    )  # fmt: skip
    origin = f"the command line or {model}" if model.endswith(".toml") else "the command line"
    origin = origin if t_end is None else Origin(origin, {"t_end": "--t-end"})
    if batch.out is None:
        raise InputError("a batch needs a store: --out STORE.zarr")
    if batch.out.suffix.lower() in RESULT_ENDINGS:
        raise bad_value(
            "out", str(batch.out), "the folder of a store, such as runs.zarr, not a file of results", "--out"
        )
    try:
        with _client(scheduler) as client, progress(f"{manifest.model} {batch.controller}") as advance:
            meter = BatchMeter(advance)
            store = run_batch(
                batch.model,
                batch.campaign(origin),
                batch.out,
                resume=resume,
                success=batch.success,
                until=batch.until,
                require=batch.require,
                confidence=batch.confidence,
                strict=strict,
                threads=threads,
                client=client,
                report=meter,
                origin=origin,
            )
    except KeyboardInterrupt:
        return _stopped("interrupted", batch.out, 130)
    except MehvarError as error:
        if not error.resumable:
            raise
        return _stopped(str(error), batch.out, error.exit_status)
    if meter.runs:
        typer.echo(f"{meter.runs} runs in {meter.seconds:.3g} s, {meter.rate}")
    print_statistics(store, batch.success)
    return 0


def _campaign(model: str, **fields: Any) -> CampaignFile:
    """Return the campaign of the command line, whose options override those of a file."""
    flags = {name: value for name, value in fields.items() if value is not None}
    for name, flag in _FLAGS.items():
        if name in flags:
            CAMPAIGN_OPTIONS[name].check(flags[name], flag)
    if model.endswith(".toml"):
        return read_campaign(Path(model)).under(flags)
    run_checks(
        lambda: required_law(find_model(model), flags.get("controller")),
        lambda: _required(flags, "n", "-n N"),
        lambda: _required(flags, "out", "a store: --out STORE.zarr"),
    )
    return CampaignFile(model=model, **flags)


def _required(flags: Mapping[str, Any], name: str, what: str) -> None:
    if name not in flags:
        raise InputError(f"a batch needs {what}")


def _save(text: str | None) -> Save | None:
    if text is None:
        return None
    value = read_value(text.removeprefix("every="), "s", "save", "--save")
    return Save(every=CAMPAIGN_OPTIONS["save_every"].check(value, "--save"))


def _client(scheduler: str | None) -> Any:
    """Return a client of dask's scheduler as a context; one that does nothing for a batch on this machine."""
    if scheduler is None:
        return nullcontext()
    from mehvar.runtime.batch.workers import connect

    client = connect(scheduler)
    # dask logs a page of tracebacks for a lost scheduler; our message has the advice
    for name in ("tornado.application", *(name for name in logging.root.manager.loggerDict if "distributed" in name)):
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    return client


def _stopped(why: str, out: Path, status: int) -> int:
    """Report the runs in the store of a stopped batch, and the command that continues it."""
    extent = ""
    try:
        store = open_store(out)
        runs = sum(len(store.runs(block)) for block in store.stored())
        extent = f"{runs} of {store.n} runs are stored; "
    except (MehvarError, OSError):
        pass
    words = ["mehvar", *sys.argv[1:]]
    again = shlex.join(words if "--resume" in words else [*words, "--resume"])
    typer.echo(f"mehvar: {why}; {extent}go on with: {again}", err=True)
    return status
