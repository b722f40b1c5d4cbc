# SPDX-License-Identifier: Apache-2.0
"""`mehvar board run`: closed loop with the law on a board, compared with the same law on this machine."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

import typer

from mehvar.base.errors import bad_value, either
from mehvar.cli.board.loop import (
    Compiler,
    Inline,
    Law,
    Processor,
    Raw,
    Samples,
    Target,
    Tunable,
    compiled,
    outcome_of,
    status_of,
    tunable_of,
    with_settings,
)
from mehvar.report.board.facts import fact_rows, facts
from mehvar.runtime.board.run import BoardRequest, BoardRun
from mehvar.runtime.board.targets import TARGETS
from mehvar.runtime.files import check_file
from mehvar.settings import ModelName, Scenario, SettingTexts, whole_number
from mehvar.terminal import print_table

FORMATS = ("text", "json")


def command(
    model: ModelName,
    controller: Law,
    target: Target = "unicorn",
    samples: Samples = BoardRequest.samples,
    form: Annotated[str, typer.Option("--format", metavar="|".join(FORMATS), help="Output format.")] = FORMATS[0],
    board: Processor = None,
    compiler: Compiler = None,
    scenario: Scenario = None,
    settings: SettingTexts = None,
    raw: Raw = False,
    inline: Inline = False,
    tunable: Tunable = None,
    restarts: Annotated[
        int,
        typer.Option(
            parser=whole_number, metavar="N", help="Number of restarts at one sample after which the run ends."
        ),
    ] = BoardRequest.restarts,
    journal: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Record the samples; a stopped run continues from this file."),
    ] = None,
) -> int:
    """Run and print; return 1 if board and host differ, 3 if the run ended early."""
    if form not in FORMATS:
        raise bad_value("format", form, either(FORMATS), "--format")
    if journal is not None:
        check_file(journal)
    loaded = compiled(model)
    request = BoardRequest(
        controller, target, board, compiler, scenario, samples,
        raw=raw, journal=journal, tunable=tunable_of(inline, tunable), restarts=restarts,
    )  # fmt: skip
    outcome = outcome_of(loaded, with_settings(loaded, request, settings))
    if form == "json":
        typer.echo(json.dumps(facts(outcome), indent=1))
    else:
        _print_outcome(outcome)
    return status_of(outcome)


def _print_outcome(outcome: BoardRun) -> None:
    """Print the end of a run and a table of differences, costs and tunings."""
    numbers = facts(outcome)
    layout = outcome.image.program.layout
    typer.echo(
        f"{layout.model} {layout.law} on {numbers['target']} {numbers['board']}: {outcome.board.reason}, "
        f"{numbers['samples']} samples, {outcome.rate:.0f} a second"
    )
    rows = [[*row] for row in fact_rows(numbers)]
    if outcome.single.status is not outcome.board.status:
        rows += [["the loop on this machine", outcome.single.reason, "in float; its end differs from the board's"]]
    for tuning in outcome.tunings:
        rows += [[f"tuned before sample {tuning.sample}", _texts(tuning.values), tuning.refusal or "set over the link"]]
    for request in outcome.refused:
        place = "the end" if request.at is None else f"sample {request.at}"
        rows += [[f"requested from {place} on", _texts(request.values), "refused: after the last sample"]]
    where = outcome.image.toolchain.version
    if outcome.request.target not in TARGETS:
        where += "; built on this machine: the image on the board was not read"
    rows += [["image", str(outcome.image.path), where]]
    print_table("", ["", "value", ""], rows)


def _texts(values: Mapping[str, float]) -> str:
    return ", ".join(f"{name} = {value:g}" for name, value in values.items())
