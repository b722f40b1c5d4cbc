# SPDX-License-Identifier: Apache-2.0
"""`mehvar board evidence`: evidence about a law in an image, from equations to addresses."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mehvar.base.errors import bad_value, unknown_name
from mehvar.base.names import identifier
from mehvar.cli.board.loop import Board, Compiler, Law, Samples, compiled, status_of
from mehvar.report.board.evidence import EVIDENCE_NAMES, write_evidence, write_inspection
from mehvar.runtime.board.evidence.collect import collect
from mehvar.runtime.board.evidence.foreign import inspect
from mehvar.runtime.board.evidence.linkmap import read_map
from mehvar.runtime.board.evidence.misra import findings
from mehvar.runtime.files import check_folder
from mehvar.runtime.model.model import load
from mehvar.settings import ModelName, whole_number
from mehvar.terminal import progress


def command(
    model: ModelName,
    controller: Law,
    board: Board = None,
    compiler: Compiler = None,
    samples: Samples = 200,
    disturbed: Annotated[
        int,
        typer.Option(
            parser=whole_number, metavar="N", help="Further steps, with random memories, parameters and measurements."
        ),
    ] = 400,
    elf: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Inspect your image with the law, without building or running it."),
    ] = None,
    linked: Annotated[
        Path | None, typer.Option("--map", metavar="FILE", help="With --elf: the linker's map of that image.")
    ] = None,
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder of the page.")] = Path("board-evidence"),
) -> int:
    """Compile the law, run and disturb it, write the evidence; return the exit status."""
    maker = f"mehvar board evidence {model} {controller}"
    check_folder(out, maker, EVIDENCE_NAMES)
    if elf is not None:
        _inspect(model, controller, elf, linked, board or compiler, out, maker)
        return 0
    if linked is not None:
        raise bad_value("map", str(linked), "given together with --elf, the image that the map describes", "--map")
    if disturbed < 0:
        raise bad_value("disturbed", disturbed, "a whole number >= 0", "--disturbed")
    loaded = compiled(model)
    with progress(f"{controller} of {model}: evidence"):
        evidence = collect(loaded, controller, board, compiler, samples, disturbed)
        misra = findings(evidence.run.image)
    write_evidence(evidence, misra, out, maker)
    step = evidence.lengths[0]
    both = sum(len(c.outcomes) == 2 for c in evidence.conditions)
    typer.echo(
        f"a step: {step.seen} instructions seen, at most {step.bound or 'unbounded'}; "
        f"{both} of {len(evidence.conditions)} conditions went both ways"
    )
    typer.echo(f"evidence: {out / 'evidence.md'}")
    return status_of(evidence.run)


def _inspect(
    model: str, controller: str, elf: Path, linked: Path | None, build: str | None, out: Path, maker: str
) -> None:
    """Write the evidence for an image that another project built."""
    if build is not None:
        raise bad_value("elf", str(elf), "given without --board and --compiler: the image is already built", "--elf")
    manifest = load(model).manifest
    if controller not in manifest.controllers:
        raise unknown_name("controller", controller, manifest.controllers, "--controller")
    symbol = f"{identifier(manifest.model)}_{identifier(controller)}"
    inspection = inspect(elf, symbol, None if linked is None else read_map(linked))
    write_inspection(inspection, symbol, out, maker)
    law = inspection.functions[0]
    typer.echo(
        f"{symbol}: at most {law.bound or 'undecided'} instructions, {'undecided' if law.stack is None else law.stack} "
        "bytes of stack"
    )
    typer.echo(f"evidence: {out / 'evidence.md'}")
