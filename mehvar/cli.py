# SPDX-License-Identifier: Apache-2.0
"""The commands; each one parses, calls the package that does the work, and prints."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

app = typer.Typer(
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    help="Derive spacecraft attitude models, generate code from them, and simulate them.",
)

Settings = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="NAME=VALUE", help="Set a parameter or an option; repeat as needed."),
]


def _version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        typer.echo(f"mehvar {version('mehvar')}")
        raise typer.Exit


@app.callback()
def _main(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    pass


@app.command("list")
def list_() -> None:
    """List the generated models with their laws and scenarios."""
    from mehvar.tables import list_models

    list_models()


@app.command()
def show(
    model: Annotated[str, typer.Argument(metavar="MODEL", help="A model or a generated folder.")],
) -> None:
    """Show a model: states, inputs, parameters with unit, default, bounds and source."""
    from mehvar.tables import show_model

    show_model(model)


@app.command()
def generate(
    models: Annotated[list[str] | None, typer.Argument(metavar="MODEL...", help="Models; all unless given.")] = None,
    check: Annotated[bool, typer.Option("--check", help="Change nothing; exit 1 and name what is stale.")] = False,
    structure: Annotated[
        list[str] | None, typer.Option(metavar="NAME=VALUE", help="Derive a structural variant; needs --out.")
    ] = None,
    out: Annotated[Path | None, typer.Option(metavar="DIR", help="Write here instead of generated/MODEL.")] = None,
    emit: Annotated[str | None, typer.Option(metavar="casadi", help="Write CasADi's own C beside ours.")] = None,
) -> None:
    """Derive models and write generated/MODEL/; what is up to date is not derived again."""
    from mehvar.generating import check_models, generate_models

    if check:
        raise typer.Exit(check_models(models or []))
    generate_models(models or [], structure or [], out, emit)


@app.command()
def simulate(
    model: Annotated[str, typer.Argument(metavar="MODEL", help="A model or a generated folder.")],
    controller: Annotated[str, typer.Option(metavar="C", help="The control law.")],
    scenario: Annotated[str | None, typer.Option(metavar="S", help="The scenario; the first unless given.")] = None,
    settings: Settings = None,
    t_end: Annotated[float | None, typer.Option(metavar="T", help="End time, s.")] = None,
    out: Annotated[Path | None, typer.Option(metavar="FILE.nc", help="Save the result as NetCDF.")] = None,
    plot: Annotated[Path | None, typer.Option(metavar="FILE.png", help="Save a picture of the run.")] = None,
) -> None:
    """Run one closed loop and print a summary."""
    from mehvar.simulating import simulate_command

    raise typer.Exit(simulate_command(model, controller, scenario, settings or [], t_end, out, plot))


@app.command()
def doctor() -> None:
    """Say what is installed, what is missing, and the command that would install it."""
    from mehvar.doctor import examine

    raise typer.Exit(examine())


@app.command()
def reproduce(
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder of the report.")] = Path("report"),
) -> None:
    """Compute every figure and claim of the papers and write one HTML report."""
    from mehvar.console import progress
    from mehvar.reproduce import reproduce as reproduce_papers

    with progress("reproduce") as advance:
        holds = reproduce_papers(out, advance)
    typer.echo(f"report: {out / 'index.html'}")
    if not holds:
        typer.echo("some claims do not hold; see the report")
        raise typer.Exit(1)


board = typer.Typer(help="Take a law to a microcontroller, emulated or real.", no_args_is_help=True)
app.add_typer(board, name="board")

BoardModel = Annotated[str, typer.Argument(metavar="MODEL", help="A model or a generated folder.")]
BoardLaw = Annotated[str, typer.Option(metavar="C", help="The control law.")]
BoardName = Annotated[
    str | None,
    typer.Option("--board", metavar="B", help="stm32f4 (default), stm32f4-usart2, mps2-m3, mps2-m4f or mps2-m7."),
]
BoardCompiler = Annotated[str | None, typer.Option(metavar="gcc|zig", help="gcc when installed, else zig.")]
BoardScenario = Annotated[str | None, typer.Option(metavar="S", help="The scenario; the first unless given.")]
BoardTarget = Annotated[str, typer.Option(metavar="T", help="sil, unicorn, qemu, or a serial port.")]
BoardSamples = Annotated[int, typer.Option(metavar="N", help="Evaluations of the law.")]
BoardRaw = Annotated[bool, typer.Option("--raw", help="Bare packets, as in the satellite's paper.")]


@board.command("build")
def board_build(
    model: BoardModel,
    controller: BoardLaw,
    board_: BoardName = None,
    compiler: BoardCompiler = None,
    scenario: BoardScenario = None,
    target: BoardTarget = "unicorn",
    raw: BoardRaw = False,
    out: Annotated[Path | None, typer.Option(metavar="DIR", help="Write sources, fragments and images here.")] = None,
) -> None:
    """Compile the firmware of a law."""
    from mehvar.boarding import build_command
    from runtime.board.run import Asked

    asked = Asked(controller, target, board_, compiler, scenario, raw=raw)
    raise typer.Exit(build_command(model, asked, out))


@board.command("run")
def board_run(
    model: BoardModel,
    controller: BoardLaw,
    target: BoardTarget = "unicorn",
    samples: BoardSamples = 600,
    format_: Annotated[str, typer.Option("--format", metavar="text|json", help="How to print.")] = "text",
    board_: BoardName = None,
    compiler: BoardCompiler = None,
    scenario: BoardScenario = None,
    settings: Settings = None,
    raw: BoardRaw = False,
    journal: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Keep what was answered; a run that was stopped goes on from it."),
    ] = None,
) -> None:
    """Run a closed loop with the law on a board and compare it, bit for bit, with the law on this machine."""
    from mehvar.boarding import run_command
    from runtime.board.run import Asked

    asked = Asked(controller, target, board_, compiler, scenario, samples, raw=raw, journal=journal)
    raise typer.Exit(run_command(model, settings or [], asked, format_))


@board.command("report")
def board_report(
    model: BoardModel,
    controller: BoardLaw,
    target: BoardTarget = "unicorn",
    samples: BoardSamples = 1600,
    board_: BoardName = None,
    compiler: BoardCompiler = None,
    scenario: BoardScenario = None,
    settings: Settings = None,
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder of the report.")] = Path("board-report"),
) -> None:
    """Run as `board run` does, and write what was found as HTML and JSON."""
    from mehvar.boardreport import report_command
    from runtime.board.run import Asked

    asked = Asked(controller, target, board_, compiler, scenario, samples)
    raise typer.Exit(report_command(model, settings or [], asked, out))


@board.command("flash")
def board_flash(
    model: BoardModel,
    controller: BoardLaw,
    board_: BoardName = None,
    compiler: BoardCompiler = None,
    scenario: BoardScenario = None,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Only print the commands.")] = False,
) -> None:
    """Build for an STM32 board and flash it. Not tested on silicon."""
    from mehvar.boarding import flash_command
    from runtime.board.run import Asked

    raise typer.Exit(flash_command(model, Asked(controller, "port", board_, compiler, scenario), dry_run))
