# SPDX-License-Identifier: Apache-2.0
"""`mehvar board emit`: a law and its link as a package for the build system of another project.

Each package has the same folder `src`, and the file that its build system reads. Settings that change bits are in the
sources, because not every build system gives a library its own flags. Headers have none: they would change the code of
a project that includes them.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Annotated

import typer

from mehvar.cli.board.loop import Inline, Law, ModelName, Scenario, Tunable, compiled, tunable_of
from mehvar.errors import unknown_name
from mehvar.names import identifier
from mehvar.runtime.board.image.build import Program, program, sources, write_sources
from mehvar.runtime.files import check_folder, filling

_NUMBERS = """\
/* Numbers of this package: the type of mv_real. The code calls memcpy and memset, and nothing else of a C library. */
#define MEHVAR_FLOAT
#define MEHVAR_SMALL
#define MEHVAR_NO_LIBM

"""
_ARITHMETIC = """\
/* Arithmetic of this file; a compiler without GNU C must be told not to contract a*b + c. */
#if defined __GNUC__ && !defined __clang__
#pragma GCC optimize("fp-contract=off", "no-math-errno")
#elif defined __clang__
#pragma STDC FP_CONTRACT OFF
#endif

"""
_NOT_IN_A_PACKAGE = ("boards/", "main.c")
"""Files that every project supplies itself: the functions of mehvar/board.h, and a main loop."""
_LICENSE = "# SPDX-License-Identifier: Apache-2.0\n"


def command(
    model: ModelName,
    controller: Law,
    kind: Annotated[
        str, typer.Option("--for", metavar="KIND", help="cmake, zephyr, platformio, arduino or stm32cube.")
    ],
    out: Annotated[Path, typer.Option(metavar="DIR", help="The folder to write.")],
    scenario: Scenario = None,
    inline: Inline = False,
    tunable: Tunable = None,
) -> None:
    """Write a package for a build system: sources, manifest, and what is yours to write."""
    if kind not in KINDS:
        raise unknown_name("build system", kind, KINDS, "--for")
    maker = f"mehvar board emit {model} {controller}"
    check_folder(out, maker, ["README.md", "src"])
    firmware = program(compiled(model), controller, scenario, tunable=tunable_of(inline, tunable))
    with filling(out, maker) as folder:
        write_sources(folder, package(firmware, kind))
    typer.echo(f"wrote {out}: {', '.join(sorted(path.name for path in out.iterdir() if path.name[0] != '.'))}")


def package(firmware: Program, kind: str) -> dict[str, str]:
    """Return the files of a package by path."""
    texts = {name: text for name, text in sources(firmware, None).items() if not name.startswith(_NOT_IN_A_PACKAGE)}
    texts["mehvar/real.h"] = texts["mehvar/real.h"].replace(
        "#ifndef MEHVAR_REAL_H", f"{_NUMBERS}#ifndef MEHVAR_REAL_H", 1
    )
    units = sorted(name for name in texts if name.endswith(".c"))
    texts |= {name: _ARITHMETIC + texts[name] for name in units}
    name = f"mehvar_{identifier(firmware.model.name)}_{identifier(firmware.law.name)}"
    files = {f"src/{path}": text for path, text in texts.items()}
    return files | KINDS[kind](name, units) | {"README.md": _readme(firmware, kind)}


def _readme(firmware: Program, kind: str) -> str:
    return (
        f"# {firmware.model.name} under {firmware.law.name}, for {kind}\n\n"
        f"Written by mehvar {version('mehvar')}. {_USE[kind]}\n\n"
        "Yours to write: the functions of `mehvar/board.h` (bytes in and out, time, what the outputs drive) and a loop "
        "that calls those of `mehvar/server.h`:\n\n"
        "```c\n"
        "mv_board_init();\nmv_server_init();\nfor (;;) {\n"
        "    for (int byte = mv_board_read(); byte >= 0; byte = mv_board_read()) mv_server_byte((uint8_t)byte);\n"
        "    mv_server_watch(mv_board_ms());\n    mv_board_wait();\n}\n```\n\n"
        "`mehvar board run MODEL --controller C --target PORT` compares the board with this machine bit for bit.\n"
    )


_USE = {
    "cmake": "`add_subdirectory` of this folder, then link with `mehvar`.",
    "zephyr": "A module: name this folder in `ZEPHYR_EXTRA_MODULES` and set `CONFIG_MEHVAR=y`.",
    "platformio": "A library: put this folder into `lib` of a project.",
    "arduino": "A library: put this folder into `libraries` of the sketchbook, and include its header.",
    "stm32cube": "A CMSIS pack's folder: add `src` to sources and include paths of a project, or install the pack.",
}


def _cmake(_name: str, units: list[str]) -> dict[str, str]:
    files = "".join(f"  src/{unit}\n" for unit in units)
    text = (
        f"{_LICENSE}cmake_minimum_required(VERSION 3.16)\nproject(mehvar C)\nadd_library(mehvar STATIC\n{files})\n"
        "target_include_directories(mehvar PUBLIC src)\ntarget_link_libraries(mehvar PUBLIC m)\n"
    )
    return {"CMakeLists.txt": text}


def _zephyr(_name: str, units: list[str]) -> dict[str, str]:
    files = "".join(f"    ../src/{unit}\n" for unit in units)
    return {
        "zephyr/module.yml": f"{_LICENSE}name: mehvar\nbuild:\n  cmake: zephyr\n  kconfig: zephyr/Kconfig\n",
        "zephyr/Kconfig": f'{_LICENSE}config MEHVAR\n\tbool "A control law with its link to mehvar"\n',
        "zephyr/CMakeLists.txt": (
            f"{_LICENSE}if(CONFIG_MEHVAR)\n  zephyr_include_directories(../src)\n  zephyr_library_named(mehvar)\n"
            f"  zephyr_library_sources(\n{files}  )\nendif()\n"
        ),
    }


def _platformio(name: str, _units: list[str]) -> dict[str, str]:
    manifest = {
        "name": name, "version": version("mehvar"), "description": "A control law with its link to mehvar",
        "license": "Apache-2.0", "headers": "mehvar/server.h", "frameworks": "*", "platforms": "*",
        "build": {"srcDir": "src", "includeDir": "src"},
    }  # fmt: skip
    return {"library.json": json.dumps(manifest, indent=2) + "\n"}


def _arduino(name: str, _units: list[str]) -> dict[str, str]:
    values = {
        "name": name, "version": version("mehvar"), "author": "mehvar", "maintainer": "mehvar",
        "sentence": "A control law with its link to mehvar.", "paragraph": "Generated C99; nothing is allocated.",
        "category": "Device Control", "url": "https://localhost/", "architectures": "*", "includes": f"{name}.h",
    }  # fmt: skip
    header = (
        f"/* SPDX-License-Identifier: Apache-2.0 */\n#ifndef {name.upper()}_H\n#define {name.upper()}_H\n\n"
        '#include "mehvar/board.h"\n#include "mehvar/board_model.h"\n#include "mehvar/server.h"\n\n#endif\n'
    )
    properties = "".join(f"{key}={value}\n" for key, value in values.items())
    return {"library.properties": properties, f"src/{name}.h": header}


def _stm32cube(name: str, units: list[str]) -> dict[str, str]:
    files = "".join(f'        <file category="source" name="src/{unit}"/>\n' for unit in units)
    text = (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<package schemaVersion="1.4">\n'
        f"  <vendor>mehvar</vendor>\n  <name>{name}</name>\n"
        "  <description>A control law with its link to mehvar</description>\n  <url></url>\n"
        f'  <releases>\n    <release version="{version("mehvar")}">First.</release>\n  </releases>\n'
        '  <components>\n    <component Cclass="Control" Cgroup="mehvar" '
        f'Cversion="{version("mehvar")}">\n      <description>Law and link</description>\n      <files>\n'
        '        <file category="include" name="src/"/>\n'
        f"{files}      </files>\n    </component>\n  </components>\n</package>\n"
    )
    return {f"mehvar.{name}.pdsc": text}


KINDS: Mapping[str, Callable[[str, list[str]], dict[str, str]]] = {
    "cmake": _cmake, "zephyr": _zephyr, "platformio": _platformio, "arduino": _arduino, "stm32cube": _stm32cube,
}  # fmt: skip
"""Files of each build system, from the package's name and the names of its sources."""
