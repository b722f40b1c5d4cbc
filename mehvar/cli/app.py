# SPDX-License-Identifier: Apache-2.0
"""The commands; each one parses, calls the package that does the work, and prints."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from mehvar.cli.ending import interruptible
from mehvar.versions import installed


class _Commands(TyperGroup):
    """The commands; an interrupted one says so, where typer would only exit."""

    def make_context(self, *arguments: Any, **more: Any) -> Any:
        with interruptible():
            return super().make_context(*arguments, **more)

    def invoke(self, ctx: Any) -> Any:
        with interruptible():
            return super().invoke(ctx)


app = typer.Typer(
    cls=_Commands,
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
        typer.echo(f"mehvar {installed('mehvar')['mehvar']}")
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
    from mehvar.cli.show import list_models

    list_models()


@app.command()
def show(
    model: Annotated[str, typer.Argument(metavar="MODEL", help="A model or a generated folder.")],
) -> None:
    """Show a model: states, inputs, parameters with unit, default, bounds and source."""
    from mehvar.cli.show import show_model

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
    from mehvar.cli.generate import check_models, generate_models

    if check:
        raise typer.Exit(check_models(models or []))
    generate_models(models or [], structure or [], out, emit)


@app.command()
def diff(
    old: Annotated[
        str | None, typer.Argument(metavar="[OLD]", help="A git revision, a folder or `work`; HEAD unless given.")
    ] = None,
    new: Annotated[
        str | None, typer.Argument(metavar="[NEW]", help="Likewise; `work`, what models/ derives now, unless given.")
    ] = None,
    model: Annotated[str | None, typer.Option(metavar="M", help="Compare this model only.")] = None,
    paper: Annotated[bool, typer.Option("--paper", help="Compare with the published equations.")] = False,
    form: Annotated[str | None, typer.Option("--format", metavar="text|json|html", help="What to write.")] = None,
    out: Annotated[Path | None, typer.Option(metavar="FILE", help="Save it; the ending implies the format.")] = None,
) -> None:
    """Say what changed between two versions of the derived equations; exit 1 if anything but the form did."""
    from mehvar.cli.diff import diff_command

    raise typer.Exit(diff_command(old, new, model, paper, form, out))


@app.command("git-diff", hidden=True)
def git_diff(arguments: Annotated[list[str], typer.Argument(help="What git passes to an external diff.")]) -> None:
    """Compare the two versions of an equations.json that git names; git's diff.NAME.command."""
    from mehvar.cli.git_drivers import external_diff

    external_diff(arguments)


@app.command("git-textconv", hidden=True)
def git_textconv(file: Annotated[Path, typer.Argument(help="An equations.json.")]) -> None:
    """Print an equations.json as text, one term a line; git's diff.NAME.textconv."""
    from mehvar.cli.git_drivers import textconv

    typer.echo(textconv(file), nl=False)


@app.command()
def simulate(
    model: Annotated[str | None, typer.Argument(metavar="MODEL", help="A model or a generated folder.")] = None,
    controller: Annotated[str | None, typer.Option(metavar="C", help="The control law.")] = None,
    scenario: Annotated[str | None, typer.Option(metavar="S", help="The scenario; the first unless given.")] = None,
    settings: Settings = None,
    t_end: Annotated[float | None, typer.Option(metavar="T", help="End time, s.")] = None,
    out: Annotated[Path | None, typer.Option(metavar="FILE.nc", help="Save the result as NetCDF.")] = None,
    plot: Annotated[Path | None, typer.Option(metavar="FILE.png", help="Save a picture of the run.")] = None,
    store: Annotated[
        Path | None, typer.Option("--from", metavar="STORE", help="Repeat a run of this batch; needs --run.")
    ] = None,
    run: Annotated[int | None, typer.Option(metavar="ID", help="Which run of the batch, counted from 0.")] = None,
) -> None:
    """Run one closed loop and print a summary, or repeat a run of a batch: --from STORE --run ID."""
    from mehvar.cli.simulate import repeat_command, simulate_command

    if store is not None or run is not None:
        if store is None or run is None or model or controller or scenario or settings or t_end:
            raise typer.BadParameter("--from STORE and --run ID come together and without what the batch decides")
        raise typer.Exit(repeat_command(store, run, out, plot))
    if model is None or controller is None:
        raise typer.BadParameter("MODEL and --controller C are needed, or --from STORE and --run ID")
    raise typer.Exit(simulate_command(model, controller, scenario, settings or [], t_end, out, plot))


@app.command()
def new(
    name: Annotated[str, typer.Argument(metavar="NAME", help="Name of the system, such as reaction_wheel.")],
) -> None:
    """Write a new system into a folder of its name: an example that generates, simulates and passes its tests."""
    from mehvar.cli.new import scaffold

    folder = scaffold(name, Path.cwd())
    typer.echo(f"wrote {folder}; {folder.name}/README.md says what is where and what to type next")


@app.command()
def batch(
    model: Annotated[str, typer.Argument(metavar="MODEL", help="A model, a generated folder, or a campaign.toml.")],
    controller: Annotated[str | None, typer.Option(metavar="C", help="The control law.")] = None,
    n: Annotated[int | None, typer.Option("-n", metavar="N", help="Number of runs.")] = None,
    scenario: Annotated[str | None, typer.Option(metavar="S", help="The scenario; the first unless given.")] = None,
    seed: Annotated[
        int | None, typer.Option(metavar="K", help="What random numbers start from; 0 unless given.")
    ] = None,
    settings: Settings = None,
    vary: Annotated[
        list[str] | None,
        typer.Option(metavar='"NAME=DIST(...)"', help="Draw a parameter or an initial state for each run; repeat."),
    ] = None,
    out: Annotated[Path | None, typer.Option(metavar="STORE.zarr", help="The store, a new folder.")] = None,
    save: Annotated[
        str | None, typer.Option(metavar="every=DT", help="Store series too, one sample each DT s.")
    ] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Continue the store.")] = False,
    until: Annotated[str | None, typer.Option(metavar="EXPR", help='Stop at "ci(success) < 0.01".')] = None,
    success: Annotated[
        str | None,
        typer.Option(metavar="EXPR", help='What a run must fulfil besides reaching its end: "T_theta < 20".'),
    ] = None,
    sampling: Annotated[
        str | None, typer.Option(metavar="DESIGN", help="random (unless given), latin, sobol or saltelli.")
    ] = None,
    t_end: Annotated[float | None, typer.Option(metavar="T", help="End time, s.")] = None,
    strict: Annotated[bool, typer.Option("--strict", help="Stop at a run whose values are not allowed.")] = False,
    scheduler: Annotated[str | None, typer.Option(metavar="ADDRESS", help="A dask scheduler: tcp://host:8786.")] = None,
    threads: Annotated[
        int | None, typer.Option(min=1, help="Threads of this process; all processors unless given.")
    ] = None,
) -> None:
    """Run many closed loops into a store, with statistics at the end; an interrupted batch goes on with --resume."""
    from mehvar.cli.batch import BatchOptions, batch_command

    given = BatchOptions(
        model, controller, n, scenario, seed, settings or [], vary or [], out, save, resume, until, success, sampling,
        t_end, strict, scheduler, threads,
    )  # fmt: skip
    raise typer.Exit(batch_command(given))


@app.command()
def stats(
    store: Annotated[Path, typer.Argument(metavar="STORE", help="A batch, finished or not.")],
    success: Annotated[
        str | None,
        typer.Option(metavar="EXPR", help="What counts as success; what the batch was asked for unless given."),
    ] = None,
    plot: Annotated[Path | None, typer.Option(metavar="FILE.png", help="Draw bands and worst cases.")] = None,
    of: Annotated[list[str] | None, typer.Option(metavar="NAME", help="What to draw; repeat.")] = None,
) -> None:
    """Print the statistics of a batch: success, metrics, worst runs, sensitivities."""
    from mehvar.cli.stats import stats_command

    raise typer.Exit(stats_command(store, success, plot, of or []))


@app.command()
def doctor() -> None:
    """Say what is installed, what is missing, and the command that would install it."""
    from mehvar.cli.doctor import examine

    raise typer.Exit(examine())


@app.command()
def reproduce(
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder of the report.")] = Path("report"),
) -> None:
    """Compute every figure and claim of the papers and write one HTML report."""
    from mehvar.cli.reproduce import reproduce as reproduce_papers
    from mehvar.terminal import progress

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
BoardTarget = Annotated[
    str, typer.Option(metavar="T", help="sil (a process here), unicorn, qemu, qemu-pty, or a serial port.")
]
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
    from mehvar.cli.board import build_command
    from mehvar.runtime.board.run import BoardRequest

    asked = BoardRequest(controller, target, board_, compiler, scenario, raw=raw)
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
    from mehvar.cli.board import run_command
    from mehvar.runtime.board.run import BoardRequest

    asked = BoardRequest(controller, target, board_, compiler, scenario, samples, raw=raw, journal=journal)
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
    from mehvar.report.board_page import report_command
    from mehvar.runtime.board.run import BoardRequest

    asked = BoardRequest(controller, target, board_, compiler, scenario, samples)
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
    from mehvar.cli.board import flash_command
    from mehvar.runtime.board.run import BoardRequest

    raise typer.Exit(flash_command(model, BoardRequest(controller, "port", board_, compiler, scenario), dry_run))
