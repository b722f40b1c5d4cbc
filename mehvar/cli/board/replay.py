# SPDX-License-Identifier: Apache-2.0
"""`mehvar board replay`: repetition of a board's answers on this machine, with a bit-by-bit comparison."""

from __future__ import annotations

import typer

from mehvar.cli.board.loop import Law, compiled
from mehvar.cli.board.tune import Journal
from mehvar.runtime.board.tuning import replay
from mehvar.settings import ModelName
from mehvar.terminal import print_table


def command(model: ModelName, controller: Law, journal: Journal) -> int:
    """Replay and print; return 1 if an answer or the memory differs, 3 if the journal is incomplete."""
    result = replay(compiled(model), controller, journal)
    place = "same bits" if result.first is None else f"other bits from sample {result.first} on"
    typer.echo(
        f"{journal}: {result.samples} samples and {result.memories} numbers of the memory computed again: {place}"
    )
    if not result.complete:
        typer.echo("the journal ends there: the run did not end, or later records are lost")
    rows = [
        [str(tuning.sample), ", ".join(f"{n} = {v:g}" for n, v in tuning.values.items()), tuning.refusal or "set"]
        for tuning in result.tunings
    ]
    if rows:
        print_table("", ["before sample", "asked for", ""], rows)
    return 1 if result.first is not None else 0 if result.complete else 3
