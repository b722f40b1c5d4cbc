# SPDX-License-Identifier: Apache-2.0
"""`mehvar simulate`: one run from the command line, its summary, file and picture."""

from __future__ import annotations

import os
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Any

import typer

from mehvar.errors import InputError, bad_value
from mehvar.pictures.files import checked_suffix
from mehvar.runtime.model.manifest import find_model
from mehvar.runtime.run.metrics import metrics
from mehvar.runtime.run.problem import Status
from mehvar.runtime.run.simulate import Run
from mehvar.runtime.run.simulate import simulate as simulate_run
from mehvar.terminal import print_table, progress

_NUMBERS = ("dt_out", "hold", "rtol", "atol", "step")
_WORDS = ("method", "backend", "real")
_COUNTS = ("delay", "max_steps", "seed")


def simulate_command(
    model: str,
    controller: str,
    scenario: str | None,
    settings: Sequence[str],
    t_end: float | None,
    out: Path | None,
    plot: Path | None,
) -> int:
    """Run, print, save; return the exit status.

    Raises
    ------
    InputError
        For anything unknown, malformed, out of bounds or not writable; files are tried before the run.
    """
    _check_outputs(out, plot)
    values, options = parse_settings(settings, find_model(model).choices)
    with progress(f"{model} {controller}") as advance:
        advance(0, 1, "(the first run compiles)")
        run = simulate_run(
            model, controller, scenario, values, t_end=t_end, progress=advance, origin="--set", **options
        )
    return _finish(run, out, plot)


def repeat_command(store_path: Path, number: int, out: Path | None, plot: Path | None) -> int:
    """Repeat one run of a batch with full logging, and say whether it is the same to the last bit.

    Raises
    ------
    InputError
        For a store that is none, a run that it does not have, or one whose drawn values are not allowed.
    """
    from mehvar.runtime.batch.fill import plan_of
    from mehvar.runtime.batch.repeat import difference, repeat_run
    from mehvar.runtime.batch.store import open_store

    _check_outputs(out, plot)
    store = open_store(store_path)
    plan = plan_of(store)
    with progress(f"{plan.model.name} run {number}") as advance:
        run = repeat_run(plan, store, number, advance)
    what = f"run {number} of {store_path}"
    drawn = ", ".join(f"{name} = {value!r}" for name, value in plan.drawn(number).items())
    typer.echo(f"{what}: {drawn}" if drawn else what)
    different = difference(run, store, number)
    if different is None:
        typer.echo("this run is not stored yet: there is nothing to compare with")
    else:
        typer.echo(different or "the same as in the store, bit for bit")
    return _finish(run, out, plot)


def _check_outputs(out: Path | None, plot: Path | None) -> None:
    for path in (out, plot):
        if path is not None:
            _check_folder(path)
    if plot is not None:
        checked_suffix(plot)


def _finish(run: Run, out: Path | None, plot: Path | None) -> int:
    _summary(run)
    _save(run, out, plot)
    if run.status is not Status.DONE:
        typer.echo(f"mehvar: the run ended early: {run.reason}", err=True)
        return 3
    return 0


def _check_folder(path: Path) -> None:
    """Refuse a file that cannot be written before the run, not after it."""
    if not path.parent.is_dir():
        raise bad_value("output file", str(path), "in a folder that exists")
    if path.is_dir() or not os.access(path.parent, os.W_OK):
        raise bad_value("output file", str(path), "a file in a folder that can be written")


def parse_settings(settings: Sequence[str], choices: Collection[str]) -> tuple[dict[str, float], dict[str, Any]]:
    """Return parameters, and options and choices, from texts NAME=VALUE; raise InputError for what is malformed."""
    values: dict[str, float] = {}
    options: dict[str, Any] = {}
    for item in settings:
        name, sign, text = item.partition("=")
        if not sign or not name or not text:
            raise bad_value("--set", item, "NAME=VALUE")
        if name in values or name in options:
            raise InputError(f"--set {name} is given twice")
        if name in _WORDS or name in choices:
            options[name] = text
        elif name in _COUNTS:
            options[name] = _number(name, text, int)
        elif name in _NUMBERS:
            options[name] = _number(name, text, float)
        else:
            values[name] = _number(name, text, float)
    return values, options


def _number(name: str, text: str, kind: type[int] | type[float]) -> Any:
    try:
        return kind(text)
    except ValueError:
        raise bad_value(name, text, "a whole number" if kind is int else "a number", "--set") from None


def _summary(run: Run) -> None:
    law, case = run.controller.name, run.scenario.name
    typer.echo(f"{run.manifest.model} {law} {case}: {run.reason}, t = {run.t_stop:g} s, {run.run_seconds * 1e3:.1f} ms")
    for text in run.exceeded():
        typer.echo(f"note: {text}")
    if run.backend == "python":
        typer.echo("run by the generated Python module; with a C compiler it is much faster (mehvar doctor)")
    rows = [
        [name, f"{value:.6g}", run.manifest.metrics[name].unit, run.manifest.metrics[name].description]
        for name, value in metrics(run, run.manifest).items()
    ]
    print_table("", ["metric", "value", "unit", "meaning"], rows)


def _save(run: Run, out: Path | None, plot: Path | None) -> None:
    if out is None and plot is None:
        return
    from mehvar.runtime.run.results import save, to_dataset

    dataset = to_dataset(run)
    if out is not None:
        save(dataset, out)
        typer.echo(f"saved {out}")
    if plot is not None:
        from mehvar.papers.reproduction import run_picture
        from mehvar.pictures.files import save as save_picture

        save_picture(run_picture(dataset, run.manifest), plot)
        typer.echo(f"saved {plot}")
