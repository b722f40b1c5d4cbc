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
    from mehvar.diff_command import diff_command

    raise typer.Exit(diff_command(old, new, model, paper, form, out))


@app.command("git-diff", hidden=True)
def git_diff(arguments: Annotated[list[str], typer.Argument(help="What git passes to an external diff.")]) -> None:
    """Compare the two versions of an equations.json that git names; git's diff.NAME.command."""
    from mehvar.diff_drivers import external_diff

    external_diff(arguments)


@app.command("git-textconv", hidden=True)
def git_textconv(file: Annotated[Path, typer.Argument(help="An equations.json.")]) -> None:
    """Print an equations.json as text, one term a line; git's diff.NAME.textconv."""
    from mehvar.diff_drivers import textconv

    typer.echo(textconv(file), nl=False)


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
