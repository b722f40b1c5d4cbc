# SPDX-License-Identifier: Apache-2.0
"""Arguments, request and result of a closed loop with a law on a board, for several commands."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Annotated

import typer

from mehvar.base.errors import bad_value
from mehvar.runtime.board.image.processors import PROCESSORS
from mehvar.runtime.board.image.toolchains import BOARDS
from mehvar.runtime.board.run import BoardRequest, BoardRun, run_on_board
from mehvar.runtime.model.model import Model, load
from mehvar.runtime.run.options import split_settings
from mehvar.settings import complete_controllers, read_values, whole_number
from mehvar.terminal import progress

_BOARDS = f"{', '.join(BOARDS)}; default: the first."
_PROCESSORS = f"With --target sil also {', '.join(PROCESSORS)} under QEMU."
Law = Annotated[
    str, typer.Option("--controller", metavar="C", help="The control law.", autocompletion=complete_controllers)
]
Board = Annotated[str | None, typer.Option("--board", metavar="B", help=_BOARDS)]
Processor = Annotated[str | None, typer.Option("--board", metavar="B", help=f"{_BOARDS} {_PROCESSORS}")]
Compiler = Annotated[str | None, typer.Option(metavar="gcc|zig", help="Compiler; default: gcc if installed, else zig.")]
Target = Annotated[
    str, typer.Option(metavar="T", help="sil (a process on this machine), unicorn, qemu, or a serial port.")
]
Samples = Annotated[int, typer.Option(parser=whole_number, metavar="N", help="Number of evaluations of the law.")]
Raw = Annotated[bool, typer.Option("--raw", help="Bare packets, as in the satellite's paper.")]

Inline = Annotated[bool, typer.Option("--inline-parameters", help="Compile the parameters as constants.")]
Tunable = Annotated[
    str | None,
    typer.Option("--tunable", metavar="NAME,...", help="With --inline-parameters: parameters that stay adjustable."),
]


def tunable_of(inline: bool, names: str | None) -> tuple[str, ...] | None:
    """Return the parameters that stay tunable while all others become constants, or None if all stay tunable.

    Raises
    ------
    InputError
        If names are given without constants, where they have no effect.
    """
    if names is not None and not inline:
        raise bad_value(
            "tunable", names, "given with --inline-parameters; without it every parameter can be set", "--tunable"
        )
    return tuple(filter(None, map(str.strip, (names or "").split(",")))) if inline else None


def compiled(model: str) -> Model:
    """Return a model with compiled C functions, so that board and reference run the same C."""
    return load(model, backend="c")


def with_settings(model: Model, request: BoardRequest, settings: Sequence[str] | None) -> BoardRequest:
    """Add the values of `--set` to the request."""
    values = read_values(settings, model.manifest)
    parameters, options = split_settings(values, model.manifest.choices, "board", "--set")
    return replace(request, parameters=parameters, options=options)


def outcome_of(model: Model, request: BoardRequest) -> BoardRun:
    """Run a closed loop with its law on a board.

    Raises
    ------
    InputError
        For a user's mistake.
    LinkError
        If the board does not answer.
    """
    with progress(f"{request.controller} of {model.name} on {request.target}"):
        return run_on_board(model, request)


def status_of(outcome: BoardRun) -> int:
    """Return the exit status of a run."""
    if not outcome.board.status.complete:
        typer.echo(f"mehvar: the run ended early: {outcome.board.reason}", err=True)
        return 3
    return int(not outcome.same)
