# SPDX-License-Identifier: Apache-2.0
"""`mehvar verify`: check of a store for damaged and missing blocks."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mehvar.base.errors import first_names
from mehvar.runtime.batch.store.verification import Verification, verify
from mehvar.settings import AsJson
from mehvar.terminal import print_json, progress

_SHOWN = 20
"""Largest number of lines about damage on a terminal; --json has all."""


def command(
    path: Annotated[Path, typer.Argument(metavar="STORE", help="A batch, finished or not.")],
    as_json: AsJson = False,
) -> int:
    """Check every file against its checksum; return 0 for an undamaged store, else 1.

    Files without a record are listed, but do not affect the status, because nothing reads them.

    Raises
    ------
    InputError
        If the folder is not a store.
    """
    with progress(f"verifying {path}"):
        verification = verify(path)
    if as_json:
        print_json(verification.facts())
    else:
        _print(verification)
    return 0 if verification.complete else 1


def _print(verification: Verification) -> None:
    """Print the damaged and missing blocks, unknown files, the writer, and how to repair the store."""
    damage, word = verification.damage(), "damaged" if verification.writer is None else "being written"
    for line in damage[:_SHOWN]:
        typer.echo(f"{word}: {line}")
    if len(damage) > _SHOWN:
        typer.echo(f"... and {len(damage) - _SHOWN} more")
    if verification.missing:
        typer.echo(f"missing: {_numbers(verification.missing)}")
    whole = f"{len(verification.whole)} of {verification.blocks} blocks are whole"
    ended = "" if verification.ended or verification.missing else "; the end of the batch is not recorded"
    typer.echo(f"{verification.store}: {verification.runs} runs; {whole}{ended}")
    if verification.others:
        named = first_names(verification.others, _SHOWN)
        typer.echo(f"note: files that no record lists and mehvar does not read: {named}")
    if verification.writer is not None:
        typer.echo(f"being written by {verification.writer}")
    elif not verification.complete:
        typer.echo("to complete and repair the store, use the original command with --resume")


def _numbers(blocks: tuple[int, ...]) -> str:
    """Return block numbers as text, with ranges: "blocks 0 to 3, 7"."""
    ranges: list[list[int]] = []
    for block in blocks:
        if ranges and block == ranges[-1][-1] + 1:
            ranges[-1][1:] = [block]
        else:
            ranges.append([block])
    return "blocks " + ", ".join(" to ".join(map(str, ends)) for ends in ranges)
