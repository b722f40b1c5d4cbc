# SPDX-License-Identifier: Apache-2.0
"""`mehvar board report`: HTML and JSON report of a run on a board."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mehvar.cli.board.loop import (
    Compiler,
    Law,
    Processor,
    Samples,
    Target,
    compiled,
    outcome_of,
    status_of,
    with_settings,
)
from mehvar.pictures.style import require_matplotlib
from mehvar.report.board.page import REPORT_NAMES, write_report
from mehvar.runtime.board.run import BoardRequest
from mehvar.runtime.files import check_folder
from mehvar.settings import ModelName, Scenario, SettingTexts


def command(
    model: ModelName,
    controller: Law,
    target: Target = "unicorn",
    samples: Samples = 1600,
    board: Processor = None,
    compiler: Compiler = None,
    scenario: Scenario = None,
    settings: SettingTexts = None,
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder of the report.")] = Path("board-report"),
) -> int:
    """Run and write; return the exit status."""
    require_matplotlib()
    maker = f"mehvar board report {model} {controller}"
    check_folder(out, maker, REPORT_NAMES)
    loaded = compiled(model)
    request = BoardRequest(controller, target, board, compiler, scenario, samples, every=1)
    outcome = outcome_of(loaded, with_settings(loaded, request, settings))
    write_report(outcome, out, maker)
    typer.echo(f"report: {out / 'index.html'}")
    return status_of(outcome)
