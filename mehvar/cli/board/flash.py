# SPDX-License-Identifier: Apache-2.0
"""`mehvar board flash`: commands that write a firmware to an STM32 board."""

from __future__ import annotations

import shlex
import shutil
import subprocess
from typing import Annotated

import typer

from mehvar.base.errors import InputError, bad_value
from mehvar.cli.board.loop import Board, Compiler, Inline, Law, Tunable, compiled, tunable_of
from mehvar.runtime.board.image.build import Image
from mehvar.runtime.board.run import BoardRequest, build_image
from mehvar.settings import ModelName, Scenario


def command(
    model: ModelName,
    controller: Law,
    board: Board = None,
    compiler: Compiler = None,
    scenario: Scenario = None,
    inline: Inline = False,
    tunable: Tunable = None,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Only print the commands.")] = False,
) -> int:
    """Flash a board with the first installed tool, or print the commands; return the exit status."""
    image = build_image(
        compiled(model),
        BoardRequest(controller, "port", board, compiler, scenario, tunable=tunable_of(inline, tunable)),
    )
    if image.board is None or not image.board.name.startswith("stm32"):
        raise bad_value("board", board, "an STM32 board: stm32f4 or stm32f4-usart2", "--board")
    commands = flash_commands(image)
    typer.echo("not tested on silicon: this has not run on a real board")
    for command in commands:
        typer.echo("$ " + shlex.join(command))
    if dry_run:
        return 0
    for command in commands:
        if shutil.which(command[0]):
            return 3 if subprocess.run(command, check=False).returncode else 0
    tools = ", ".join(command[0] for command in commands)
    raise InputError(
        f"no flash tool is installed: install one of {tools}, or run one of these commands on another machine"
    )


def flash_commands(image: Image) -> list[list[str]]:
    """Return the commands of each tool that can flash an STM32 board."""
    path = str(image.path)
    return [
        ["openocd", "-f", "board/st_nucleo_f4.cfg", "-c", f"program {path} verify reset exit"],
        ["probe-rs", "run", "--chip", "STM32F405RGTx", path],
        ["STM32_Programmer_CLI", "-c", "port=SWD", "-w", path, "-v", "-rst"],
    ]
