# SPDX-License-Identifier: Apache-2.0
"""`mehvar board`: build firmware, run a closed loop with the law on a board, report, and say how to flash."""

from __future__ import annotations

import json
import shlex
import shutil
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import typer

from mehvar.cli.simulate import parse_settings
from mehvar.errors import InputError, bad_value
from mehvar.report.board_facts import facts
from mehvar.runtime.board.image.build import FIRMWARE, Image, compile_commands, sources, write_sources
from mehvar.runtime.board.image.elf import read_elf
from mehvar.runtime.board.line.link import LinkError
from mehvar.runtime.board.run import BoardRequest, BoardRun, build_image, ended, run_on_board
from mehvar.runtime.files import check_folder, filling
from mehvar.runtime.model.manifest import find_model
from mehvar.runtime.model.model import Model, load
from mehvar.terminal import print_table, working

FORMATS = ("text", "json")


def asked_for(model: str, settings: Sequence[str], asked: BoardRequest) -> tuple[Model, BoardRequest]:
    """Return the model and what is asked for, with the settings of `--set` filled in."""
    values, options = parse_settings(settings, find_model(model).choices)
    refused = {"backend", "real", "dt_out", "hold"} & set(options)
    if refused:
        name = min(refused)
        raise bad_value(name, options[name], "left out: the board decides it", "--set")
    return load(model, backend="c"), replace(asked, values=values, options=options)


def build_command(model: str, asked: BoardRequest, out: Path | None) -> int:
    """Compile a firmware; with a folder, write its sources and images there."""
    loaded, asked = asked_for(model, (), asked)
    if out is not None:
        check_folder(out)
    image = build_image(loaded, asked)
    _print_image(image)
    if out is not None:
        export(image, out)
        typer.echo(f"wrote {out}")
    return 0


def run_command(model: str, settings: Sequence[str], asked: BoardRequest, form: str) -> int:
    """Run, print, and return the exit status: 1 when board and host differ, 3 when the run ended early."""
    if form not in FORMATS:
        raise bad_value("format", form, " or ".join(FORMATS), "--format")
    outcome = outcome_of(model, settings, asked)
    found = facts(outcome)
    if form == "json":
        typer.echo(json.dumps(found, indent=1))
    else:
        _print_outcome(outcome)
    return status_of(outcome)


def outcome_of(model: str, settings: Sequence[str], asked: BoardRequest) -> BoardRun:
    """Run a closed loop on a board.

    Raises
    ------
    InputError
        For a user's mistake.
    typer.Exit
        With status 3 when the board does not answer.
    """
    loaded, asked = asked_for(model, settings, asked)
    try:
        with working(f"{asked.controller} of {model} on {asked.target}"):
            return run_on_board(loaded, asked)
    except LinkError as error:
        typer.echo(f"mehvar: {error}", err=True)
        raise typer.Exit(3) from error


def status_of(outcome: BoardRun) -> int:
    """Return the exit status of a run."""
    if not ended(outcome):
        typer.echo(f"mehvar: the run ended early: {outcome.board.reason}", err=True)
        return 3
    return int(outcome.max_ulp > 0 or outcome.x.ulp > 0)


def flash_command(model: str, asked: BoardRequest, dry: bool) -> int:
    """Flash a board with the first tool that is installed, or print the commands."""
    import subprocess

    loaded, asked = asked_for(model, (), asked)
    image = build_image(loaded, asked)
    if image.board is None or not image.board.name.startswith("stm32"):
        raise bad_value("board", asked.board, "an STM32 board: stm32f4 or stm32f4-usart2", "--board")
    commands = flash_commands(image)
    typer.echo("not tested on silicon: nobody has run this on a real board yet")
    for command in commands:
        typer.echo("$ " + shlex.join(command))
    if dry:
        return 0
    for command in commands:
        if shutil.which(command[0]):
            return 3 if subprocess.run(command, check=False).returncode else 0
    tools = ", ".join(command[0] for command in commands)
    raise InputError(f"no tool to flash with: install one of {tools}, or run a command above elsewhere")


def flash_commands(image: Image) -> list[list[str]]:
    """Return the commands that would flash an STM32 board, one for each tool."""
    path = str(image.path)
    return [
        ["openocd", "-f", "board/st_nucleo_f4.cfg", "-c", f"program {path} verify reset exit"],
        ["probe-rs", "run", "--chip", "STM32F405RGTx", path],
        ["STM32_Programmer_CLI", "-c", "port=SWD", "-w", path, "-v", "-rst"],
    ]


def export(image: Image, out: Path) -> None:
    """Write sources, a CMake and a Make fragment, and the image into a folder that a vendor's project can take."""
    model = image.program.model.manifest.model
    texts = sources(image.program, image.board)
    law = f"{model}.c"
    portable = [law, "app.c", "link.c", "raw.c" if image.program.raw else "server.c"]
    commands = compile_commands(texts, model, image.board, image.toolchain)
    texts["mehvar.mk"] = _make_fragment(portable)
    texts["mehvar.cmake"] = _cmake_fragment(portable)
    texts["build.sh"] = "set -e\n" + "".join(f"{shlex.join(command)}\n" for command in commands)
    with filling(out) as folder:
        write_sources(folder, texts)
        shutil.copyfile(image.path, folder / "firmware.elf")
        if image.board is not None:
            (folder / "firmware.bin").write_bytes(_flash_contents(image.path))


def _flash_contents(elf: Path) -> bytes:
    segments = sorted(read_elf(elf).segments)
    first = segments[0][0]
    binary = bytearray()
    for address, content in segments:
        binary += b"\xff" * (address - first - len(binary)) + content
    return bytes(binary)


def _make_fragment(portable: Sequence[str]) -> str:
    return (
        "# SPDX-License-Identifier: Apache-2.0\n"
        "# Law, mathematics and link for your project: set MEHVAR to this folder and include this file. Write the\n"
        "# functions of mehvar/board.h for your board; call those of mehvar/server.h as main.c does.\n"
        f"MEHVAR_SOURCES = {' '.join(f'$(MEHVAR)/{name}' for name in portable)}\n"
        "MEHVAR_CFLAGS = -I$(MEHVAR) -DMEHVAR_FLOAT -DMEHVAR_SMALL -ffp-contract=off -fno-math-errno\n"
    )


def _cmake_fragment(portable: Sequence[str]) -> str:
    files = " ".join(f"${{CMAKE_CURRENT_LIST_DIR}}/{name}" for name in portable)
    return (
        "# SPDX-License-Identifier: Apache-2.0\n"
        "# Law, mathematics and link as a library: include this file and link your program with `mehvar`. Write the\n"
        "# functions of mehvar/board.h for your board; call those of mehvar/server.h as main.c does.\n"
        f"add_library(mehvar STATIC {files})\n"
        "target_include_directories(mehvar PUBLIC ${CMAKE_CURRENT_LIST_DIR})\n"
        "target_compile_definitions(mehvar PUBLIC MEHVAR_FLOAT MEHVAR_SMALL)\n"
        "target_compile_options(mehvar PUBLIC -ffp-contract=off -fno-math-errno)\n"
    )


def _print_image(image: Image) -> None:
    board = "software in the loop" if image.board is None else image.board.title
    rows = [["board", board], ["compiler", image.toolchain.version], ["image", str(image.path)]]
    if image.board is not None:
        elf = read_elf(image.path)
        rows += [["flash", f"{elf.flash} bytes"], ["static RAM", f"{elf.ram} bytes and {elf.stack} for the stack"]]
    print_table("", ["", ""], rows)


def _print_outcome(outcome: BoardRun) -> None:
    found = facts(outcome)
    made = outcome.image.program
    typer.echo(
        f"{made.layout.model} {made.layout.law} on {found['target']} {found['board']}: {outcome.board.reason}, "
        f"{found['samples']} samples, {outcome.rate:.0f} a second"
    )
    rows = [
        ["board against host, in float", f"{found['max_ulp']} ulp", "all inputs and the law's memory, bit for bit"],
        ["float against double", f"{found['float_against_double']['max_input']:.3g}", "largest difference of an input"],
    ]
    if found["instructions_per_step"] is not None:
        rows += [
            ["instructions of a step", str(found["instructions_per_step"]), "exact, the most of all samples"],
            ["cycles of a step", str(found["cycles_per_step"] or "-"), "estimate for a Cortex-M4F, no wait states"],
        ]
    if outcome.elf is not None:
        rows += [["flash", f"{outcome.elf.flash} bytes", ""], ["static RAM", f"{outcome.elf.ram} bytes", ""]]
    if outcome.stats.get("stack_used"):
        rows += [["stack used", f"{outcome.stats['stack_used']} bytes", "high water, self-test included"]]
    if outcome.bound is not None:
        rows += [["stack at most", f"{outcome.bound.bytes} bytes", "bound from the image, a fault included"]]
    if outcome.selftest is not None:
        rows += [["self-test", f"{outcome.selftest.crc:08x}", f"CRC-32 of {outcome.selftest.samples} samples"]]
    rows += [["image", str(outcome.image.path), outcome.image.toolchain.version]]
    print_table("", ["", "value", ""], rows)


__all__ = ["FIRMWARE", "FORMATS", "asked_for", "build_command", "export", "flash_command", "outcome_of", "run_command"]
