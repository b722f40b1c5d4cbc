# SPDX-License-Identifier: Apache-2.0
"""Write docs/reference/options.md: the options of every command, as `--help` prints them, and the options of a run."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import typer

from mehvar.cli.app import app
from mehvar.runtime.run.options import OPTIONS, Option

PAGE = Path(__file__).parents[1] / "reference" / "options.md"
_HEAD = """# Options

`mehvar COMMAND --help` prints these tables; `python -m docs.site.options` writes this page from the same texts.
[The command line](command-line.md) has exit statuses, examples and rules. Every command also takes `--debug`, which
prints the traceback of an error, and `-h`.
"""
_RUN = """## Options of a run

`--set NAME=VALUE` takes these options, parameters and the choices of a model. In Python they are keyword arguments,
in a campaign file entries of `set`.

| name | values | default | meaning | taken by |
|---|---|---|---|---|"""
_SHARED = ("--debug", "--help")
_PLACES = {"run": "`simulate`", "batch": "`batch`", "board": "`board`"}


def page() -> str:
    """Return the text of the page."""
    return "\n".join([_HEAD, *_commands(), _RUN, *map(row, OPTIONS.values())]) + "\n"


def row(option: Option) -> str:
    """Return an option of a run as a row of its table."""
    default = option.otherwise or f"`{option.default}`"
    where = ", ".join(text for place, text in _PLACES.items() if place not in option.refused)
    values = f"{option.allowed}, {option.unit}" if option.unit else option.allowed
    return f"| `{option.name}` | {values} | {default} | {option.meaning} | {where} |"


def _commands() -> Iterator[str]:
    root = typer.main.get_command(app)
    assert isinstance(root, typer.core.TyperGroup)
    yield from _of_group(root, typer.Context(root, info_name="mehvar"))


def _of_group(group: typer.core.TyperGroup, context: typer.Context) -> Iterator[str]:
    """Yield the sections of the commands of a group, in the order of its help."""
    for name in group.list_commands(context):
        _, command, _ = group.resolve_command(context, [name])
        own = typer.Context(command, info_name=name, parent=context)
        if isinstance(command, typer.core.TyperGroup):
            yield from _of_group(command, own)
            continue
        yield f"## {own.command_path}\n"
        yield f"{' '.join((command.help or '').split())}\n"
        records = [record for parameter in command.get_params(own) if (record := parameter.get_help_record(own))]
        rows = [_cells(*record) for record in records if not record[0].startswith(_SHARED)]
        if rows:
            yield "| | |\n|---|---|"
            yield "\n".join(rows) + "\n"


def _cells(option: str, meaning: str) -> str:
    """Return a row of a table, with escaped bars."""
    return "| `{}` | {} |".format(*(" ".join(text.split()).replace("|", "\\|") for text in (option, meaning)))


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
