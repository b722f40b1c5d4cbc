# SPDX-License-Identifier: Apache-2.0
"""`mehvar board tune`: change of a law's parameter on a board while it runs, between two samples."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mehvar.cli.board.loop import Law, compiled
from mehvar.runtime.board.tuning import tune
from mehvar.settings import ModelName, SettingTexts, read_values, whole_number

Journal = Annotated[Path, typer.Option(metavar="FILE", help="The journal of the run: `board run --journal FILE`.")]


def command(
    model: ModelName,
    controller: Law,
    journal: Journal,
    settings: SettingTexts = None,
    at: Annotated[
        int | None,
        typer.Option(
            "--at", parser=whole_number, metavar="K", help="First sample with the new values; default: the next one."
        ),
    ] = None,
) -> None:
    """Send the change to the running process that writes the journal."""
    loaded, running = compiled(model), journal.is_file()
    numbers = tune(loaded, controller, journal, read_values(settings, loaded.manifest), at)
    texts = ", ".join(f"{name} = {value:g}" for name, value in numbers.items())
    when = "the next sample" if at is None else f"sample {at}"
    run = "run" if running else "next run"
    typer.echo(f"requested {texts} for the {run} of {journal}, from {when} on")
