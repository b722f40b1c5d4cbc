# SPDX-License-Identifier: Apache-2.0
"""`mehvar board build`: the firmware of a law, and its sources for a user's project."""

from __future__ import annotations

import shlex
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from mehvar.base.errors import bad_value, either
from mehvar.cli.board.loop import Compiler, Inline, Law, Processor, Raw, Tunable, compiled, tunable_of
from mehvar.runtime.board.image.build import Image, compile_commands, sources
from mehvar.runtime.board.image.elf import read_elf
from mehvar.runtime.board.run import BoardRequest, build_image
from mehvar.runtime.compiling.compiler import write_sources
from mehvar.runtime.files import check_folder, filling
from mehvar.settings import ModelName, Scenario
from mehvar.terminal import print_table

_TARGETS = ("sil", "unicorn")
_NAMES = ("mehvar.mk", "mehvar.cmake", "build.sh", "firmware.elf")


def command(
    model: ModelName,
    controller: Law,
    board: Processor = None,
    compiler: Compiler = None,
    scenario: Scenario = None,
    target: Annotated[
        str, typer.Option(metavar="|".join(_TARGETS), help="sil: a process on this machine.")
    ] = "unicorn",
    raw: Raw = False,
    inline: Inline = False,
    tunable: Tunable = None,
    out: Annotated[Path | None, typer.Option(metavar="DIR", help="Write sources, fragments and images here.")] = None,
) -> None:
    """Compile a firmware; with a folder, write its sources and images there."""
    if target not in _TARGETS:
        raise bad_value("target", target, f"{either(_TARGETS)}: one image serves emulators and hardware", "--target")
    maker = f"mehvar board build {model} {controller}"
    if out is not None:
        check_folder(out, maker, _NAMES)
    image = build_image(
        compiled(model),
        BoardRequest(controller, target, board, compiler, scenario, raw=raw, tunable=tunable_of(inline, tunable)),
    )
    _print_image(image)
    if out is not None:
        export(image, out, maker)
        typer.echo(f"wrote {out}")


def export(image: Image, out: Path, maker: str) -> None:
    """Write sources, CMake and Make fragments and the image into a folder for use in a vendor's project."""
    model = image.program.model.manifest.model
    texts = sources(image.program, image.board)
    laws = [name for name in ("law.c", f"{model}.c") if name in texts]
    portable = [*laws, "app.c", "link.c", "raw.c" if image.program.raw else "server.c"]
    commands = compile_commands(texts, model, image.board, image.toolchain)
    texts["mehvar.mk"] = _make_fragment(portable)
    texts["mehvar.cmake"] = _cmake_fragment(portable)
    texts["build.sh"] = "set -e\n" + "".join(f"{shlex.join(command)}\n" for command in commands)
    with filling(out, maker) as folder:
        write_sources(folder, texts)
        shutil.copy(image.path, folder / "firmware.elf")  # it stays a program
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
    """Return the makefile that a user's project includes; `portable` are the sources that it compiles."""
    return (
        "# SPDX-License-Identifier: Apache-2.0\n"
        "# Law, mathematics and link for your project: set MEHVAR to this folder and include this file. Write the\n"
        "# functions of mehvar/board.h for your board; call those of mehvar/server.h as main.c does.\n"
        f"MEHVAR_SOURCES = {' '.join(f'$(MEHVAR)/{name}' for name in portable)}\n"
        "MEHVAR_LIBRARIES = -lm\n"
        "# for MEHVAR_SOURCES; your own files need MEHVAR_CPPFLAGS only\n"
        "MEHVAR_CPPFLAGS = -I$(MEHVAR) -DMEHVAR_FLOAT -DMEHVAR_SMALL\n"
        "MEHVAR_CFLAGS = $(MEHVAR_CPPFLAGS) -ffp-contract=off -fno-math-errno\n"
    )


def _cmake_fragment(portable: Sequence[str]) -> str:
    """Return the CMake file that a user's project includes; `portable` are the sources of the library."""
    files = " ".join(f"${{CMAKE_CURRENT_LIST_DIR}}/{name}" for name in portable)
    return (
        "# SPDX-License-Identifier: Apache-2.0\n"
        "# Law, mathematics and link as a library: include this file and link your program with `mehvar`. Write the\n"
        "# functions of mehvar/board.h for your board; call those of mehvar/server.h as main.c does.\n"
        f"add_library(mehvar STATIC {files})\n"
        "target_include_directories(mehvar PUBLIC ${CMAKE_CURRENT_LIST_DIR})\n"
        "target_compile_definitions(mehvar PUBLIC MEHVAR_FLOAT MEHVAR_SMALL)\n"
        "target_compile_options(mehvar PRIVATE -ffp-contract=off -fno-math-errno)\n"
        "target_link_libraries(mehvar PUBLIC m)\n"
    )


def _print_image(image: Image) -> None:
    board = "software in the loop" if image.board is None else image.board.title
    rows = [["board", board], ["compiler", image.toolchain.version], ["image", str(image.path)]]
    if image.board is not None:
        elf = read_elf(image.path)
        rows += [["flash", f"{elf.flash} bytes"], ["static RAM", f"{elf.ram} bytes and {elf.stack} for the stack"]]
    print_table("", ["", ""], rows)
