# SPDX-License-Identifier: Apache-2.0
"""List of commands. Each command is the function `command` of a module that is imported when it is called."""

from __future__ import annotations

import importlib
import os
import traceback
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Annotated, Any

import typer
from typer.core import TyperCommand, TyperGroup

from mehvar.base.errors import InputError
from mehvar.terminal import interruptible, print_version

_DEBUG = "mehvar.debug"
_HELP = {"help_option_names": ["-h", "--help"]}
COMMANDS = {
    "list": "List the generated models with their laws and scenarios.",
    "show": "Show a model: states, inputs, parameters with unit, default, bounds and source.",
    "generate": "Derive models and write generated/MODEL/, unless it is up to date.",
    "diff": "Compare two versions of the derived equations; exit 1 if more than the form differs.",
    "simulate": "Run one closed loop and print a summary, or repeat a run of a batch: --from STORE --run ID.",
    "new": "Write a new system into a folder of its name: an example that generates, simulates and passes its tests.",
    "batch": "Run many closed loops into a store and print statistics; --resume continues a stopped batch.",
    "stats": "Print the statistics of a batch: success, metrics, worst runs, sensitivities.",
    "require": "Decide requirements from the runs of a batch or a campaign; exit 1 unless all hold.",
    "verify": "Check every file of a batch against its checksum; exit 1 if one is missing or damaged.",
    "convert": "Write a result or a batch as Parquet, NetCDF, CSV or MATLAB, units in names and metadata.",
    "doctor": "List installed and missing parts, and the commands that install them.",
    "report": "Write a page about a model, a result or a batch: equations, numbers, runs, pictures, animation.",
    "reproduce": "Compute every figure and claim of the papers and write an HTML report.",
}
PLACES = {name: f"store.{name}" for name in ("stats", "require", "verify")} | {
    "convert": "export.convert",
    "git-diff": "git.diff",
    "git-textconv": "git.textconv",
}
"""Modules of commands that share a folder."""
FOR_GIT = {
    "git-diff": "Compare two versions of an equations.json, for git's diff.NAME.command.",
    "git-textconv": "Print an equations.json as text, one term per line, for git's diff.NAME.textconv.",
}
BOARD = {
    "build": "Compile the firmware of a law.",
    "run": "Run a closed loop with the law on a board and compare it, bit for bit, with the law on this machine.",
    "tune": "Set parameters of a law that runs on a board with a journal, between two samples.",
    "replay": "Compute the samples of a journal on this machine and compare them bit for bit.",
    "report": "Run a law as `board run` does and write a report as HTML and JSON.",
    "evidence": "Write evidence about a law in an image: addresses of equations, longest path, stack, coverage, MISRA.",
    "emit": "Write a law as a package for CMake, Zephyr, PlatformIO, Arduino, cFS, F Prime or STM32Cube.",
    "flash": "Build for an STM32 board and flash it; not tested on silicon.",
}

EXPORT = {
    "fmu": "Write a functional mock-up unit: FMI 2.0 or 3.0, model exchange or co-simulation, sources and a binary.",
    "web": "Write a page that simulates a model: its C as WebAssembly, sliders, plots, a checksum; needs no network.",
}


class _Command(TyperCommand):
    """Command that converts plain values itself: the import of pydantic for it takes a quarter of a short command."""

    def get_params(self, ctx: Any) -> list[Any]:
        return [_converted(parameter) for parameter in super().get_params(ctx)]


class _Commands(TyperGroup):
    """Commands by name, from the tables above, whose modules are imported when called.

    The result of a command is its exit status. Unlike with typer, an interrupted command prints a message.
    """

    def get_params(self, ctx: Any) -> list[Any]:
        return [_converted(parameter) for parameter in super().get_params(ctx)]

    def make_context(self, *arguments: Any, **more: Any) -> Any:
        with interruptible():
            return super().make_context(*arguments, **more)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        name, listed, rest = super().resolve_command(ctx, args)
        if name is None or isinstance(listed, TyperGroup):
            return name, listed, rest
        room = __package__ if ctx.parent is None else f"{__package__}.{self.name}"
        place = PLACES.get(name, name) if ctx.parent is None else name
        return name, _imported(f"{room}.{place.replace('-', '_')}", listed), rest

    def invoke(self, ctx: Any) -> Any:
        with interruptible(), _shown_if_asked(ctx), _missing_by_name():
            status = super().invoke(ctx)
        return status if ctx.parent else ctx.exit(status or 0)


def _group(commands: Mapping[str, str], *, hidden: Mapping[str, str] | None = None, **more: Any) -> typer.Typer:
    """Return a group of commands with help texts; those in `hidden` run but are not listed."""
    group = typer.Typer(
        cls=_Commands,
        no_args_is_help=True,
        pretty_exceptions_enable=False,
        rich_markup_mode=None,
        context_settings=_HELP,
        **more,
    )
    for name, text in {**commands, **(hidden or {})}.items():
        group.command(name, help=text, hidden=name not in commands)(lambda: None)
    return group


def _imported(module: str, listed: Any) -> Any:
    """Return the command of a module with its help text for the list of commands."""
    single = typer.Typer(add_completion=False, pretty_exceptions_enable=False, rich_markup_mode=None)
    single.command(listed.name, cls=_Command, help=listed.help, context_settings=_HELP)(
        importlib.import_module(module).command
    )
    command = typer.main.get_command(single)
    command.params.append(_debug_option())
    return command


def _converted(parameter: Any) -> Any:
    """Return a parameter that leaves to typer only values that are not plain, and those that it refuses."""
    if "get_runtime_param" in vars(parameter) or not hasattr(parameter, "get_runtime_param"):  # typer before pydantic
        return parameter
    described, by_typer = parameter.type_descriptor, parameter.get_runtime_param

    def coerce(value: Any, **place: Any) -> Any:
        try:
            return _plain(value, described.annotation, described.parameter_info.parser, parameter)
        except ValueError:
            return by_typer().coerce(value, **place)

    parameter.get_runtime_param = lambda: SimpleNamespace(coerce=coerce)
    return parameter


def _plain(value: Any, annotation: Any, parser: Any, parameter: Any) -> Any:
    """Return a value of a parameter as typer does; raise ValueError if it is not plain."""
    several = parameter.multiple or parameter.nargs == -1
    if value is None:
        return () if several else None
    for text in value if several else (value,):
        str(text).encode()  # refuses what is no UTF-8
    if parser is not None and not several:
        return parser(value)
    if annotation is str or annotation == list[str]:
        return list(value) if several else str(value)
    if annotation is Path and (os.access(value, os.R_OK) or not Path(value).exists()):
        return Path(value)
    raise ValueError(annotation)


def _remember(ctx: typer.Context, debug: bool) -> None:
    ctx.meta[_DEBUG] = ctx.meta.get(_DEBUG, False) or debug


Debug = Annotated[
    bool,
    typer.Option("--debug", callback=_remember, expose_value=False, help="Print the traceback of an error too."),
]


def _debug_option() -> Any:
    """Return the option --debug, which every command has."""

    def flag(debug: Debug = False) -> None:
        pass

    single = typer.Typer(add_completion=False)
    single.command()(flag)
    return typer.main.get_command(single).params[0]


@contextmanager
def _shown_if_asked(ctx: Any) -> Iterator[None]:
    """Print the traceback of an error if --debug was given; the message follows in any case."""
    try:
        yield
    except Exception:
        if ctx.parent is None and ctx.meta.get(_DEBUG):
            traceback.print_exc()
        raise


@contextmanager
def _missing_by_name() -> Iterator[None]:
    """Report a missing argument in the style of our messages, instead of typer's usage text."""
    try:
        yield
    except typer.BadParameter as error:
        if type(error).__name__ != "MissingParameter" or error.ctx is None or error.param is None:
            raise
        param: Any = error.param
        name = [param.opts[0]] if param.opts[0].startswith("-") else []
        words = " ".join([*name, param.metavar or "VALUE"])
        command = error.ctx.command_path.removeprefix(f"{error.ctx.find_root().command_path} ")
        raise InputError(f"{command} needs {words}: {param.help}") from None


app = _group(
    COMMANDS,
    hidden=FOR_GIT,
    add_completion=True,
    help="Derive spacecraft attitude models, generate code from them, and simulate them.",
)
app.add_typer(_group(BOARD, help="Run a law on a microcontroller, emulated or real."), name="board")
app.add_typer(_group(EXPORT, help="Write a model as a file that other programs run."), name="export")


def _version(shown: bool) -> None:
    if shown:
        print_version()
        raise typer.Exit


@app.callback()
def _main(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and exit.")
    ] = False,
    debug: Debug = False,
) -> None:
    pass
