# SPDX-License-Identifier: Apache-2.0
"""Build of a board's program from a generated model, cached by contents."""

from __future__ import annotations

import math
import os
import posixpath
import re
import shutil
import tempfile
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from mehvar.base import cache
from mehvar.base.capabilities import Operation, refuse
from mehvar.base.errors import bad_value
from mehvar.base.manifest import Controller, Scenario

from ...compiling.compiler import run_compiler, write_sources
from ...compiling.library import native_headers
from ...model.generated import generated_text
from ...model.model import Model
from ...model.parameters import Resolved, resolve
from .folded import law_source
from .header import Layout, board_law_header, board_model_header, layout
from .toolchains import Board, Toolchain

FIRMWARE = Path(__file__).parents[1] / "firmware"
STACK_SIZE = 1536
"""Reserved bytes of stack."""
FLAGS = (
    "-std=c99", "-pedantic", "-g", "-ffp-contract=off", "-fno-math-errno", "-DMEHVAR_FLOAT", "-DMEHVAR_SMALL", "-I.",
    "-ffunction-sections", "-fdata-sections", "-fno-unwind-tables", "-fno-asynchronous-unwind-tables",
)  # fmt: skip
"""Compiler flags for all boards, without contraction and reassociation, so that they do not affect results."""
LAW_FLAGS, OTHER_FLAGS = ("-O2",), ("-Os",)
"""Optimisation flags: for speed in generated code, for size elsewhere."""
_KIND, _OBJECTS, _ELF, _LAW = "boards", "objects", "firmware.elf", "law.c"
_INCLUDE = re.compile(r'^#\s*include\s*["<](.+?)[">]', re.MULTILINE)
_LARGEST = (2 - 2.0**-23) * 2.0**127
"""The largest finite float."""
_LONGEST_HOLD = 0.02
_PORTABLE = ("app.c", "link.c", "main.c")
_SMALL = ("-ffreestanding", "-fno-builtin", "-Ilibc", "-fno-strict-aliasing")


@dataclass(frozen=True)
class Program:
    """Inputs of a firmware build.

    Attributes
    ----------
    model, law, scenario, resolved
        The model, its law, scenario, and compiled-in parameters.
    period : float
        Sample period of the law, s.
    raw : bool
        Bare packets instead of frames.
    tunable : tuple of str, optional
        Parameters that stay variable while all others are constants of the law's code; None if no parameter is
        constant.
    """

    model: Model
    law: Controller
    scenario: Scenario
    resolved: Resolved
    period: float
    raw: bool = False
    tunable: tuple[str, ...] | None = None

    @property
    def layout(self) -> Layout:
        """Layout of the data on the link."""
        return layout(self.model.manifest, self.law)


@dataclass(frozen=True)
class Image:
    """A compiled program.

    Attributes
    ----------
    path : Path
        ELF file; an ordinary program for software in the loop.
    board : Board or None
        None for software in the loop.
    """

    path: Path
    program: Program
    board: Board | None
    toolchain: Toolchain
    built: bool


def period_of(law: Controller, scenario: Scenario, resolved: Resolved) -> float:
    """Return the time between two samples, s; a continuous law is sampled every 20 ms or faster."""
    return resolved.values[law.period] if law.period else min(scenario.step, _LONGEST_HOLD)


def delay_of(law: Controller) -> int:
    """Return the samples between computing and applying an input: one if the law is designed for a delay."""
    return int(law.delay is not None)


def program(
    model: Model,
    law: str,
    scenario: str | None = None,
    raw: bool = False,
    period: float | None = None,
    tunable: Sequence[str] | None = None,
    resolved: Resolved | None = None,
) -> Program:
    """Return the inputs of a firmware build for a law; a scenario gives the compiled-in parameters.

    Over a line, a command acts one sample after its computation. A law with a parameter for this delay is designed
    for it.

    Parameters
    ----------
    period : float, optional
        Time between two samples, s, which the output watchdog uses; default: that of the law.
    tunable : sequence of str, optional
        Parameters to keep variable while all others become constants of the law's code.
    resolved : Resolved, optional
        Parameters other than the scenario's.
    """
    controller, case = model.manifest.controller(law), model.manifest.scenario(scenario)
    refuse(model.manifest, Operation.BOARD, controller)
    if raw and model.manifest.measured and controller.memory:
        allowed = f"left out: the memory of {law} starts from the state, and bare packets hold what is measured"
        raise bad_value("raw", raw, allowed)
    values = {controller.delay: 1.0} if controller.delay else {}
    if resolved is None:
        resolved = resolve(model.manifest, model.functions, controller, case, values, "the board's one sample of delay")
    check_float(resolved)
    own = None if tunable is None else tuple(tunable)
    return Program(model, controller, case, resolved, period or period_of(controller, case, resolved), raw, own)


def check_float(resolved: Resolved) -> None:
    """Refuse finite parameters that overflow in float.

    Raises
    ------
    InputError
        With the parameter's name and origin.
    """
    for name, value in resolved.values.items():
        if _LARGEST < abs(value) < math.inf:
            raise bad_value(
                name, value, f"at most {_LARGEST:.6g} in size: a board computes in float", resolved.origins[name]
            )


def sources(firmware: Program, board: Board | None) -> dict[str, str]:
    """Return all files of a firmware by name: generated C, mathematics, link, application, board."""
    manifest = firmware.model.manifest
    name = manifest.model
    server = "raw.c" if firmware.raw else "server.c"
    names = [*_PORTABLE, server, *_below("mehvar")]
    names += ["boards/posix.c"] if board is None else [f"boards/{board.source}", "cortexm.c", *_below("libc")]
    texts = {file: (FIRMWARE / file).read_text(encoding="utf-8") for file in names}
    texts |= native_headers()
    texts |= {file: generated_text(manifest, file) for file in (f"{name}.c", f"{name}.h")}
    texts["mehvar/board_model.h"] = board_model_header(manifest, firmware.law, firmware.period)
    delay = delay_of(firmware.law)
    texts["mehvar/private/board_law.h"] = board_law_header(
        manifest, firmware.law, firmware.resolved, firmware.period, delay, tunable=firmware.tunable
    )
    if firmware.tunable is not None:
        texts[_LAW] = law_source(manifest, firmware.law, firmware.tunable, texts[f"{name}.c"])
    if board is not None:
        texts["board.ld"] = _linker_script(board)
    return texts


def build(firmware: Program, board: Board | None, toolchain: Toolchain) -> Image:
    """Compile a firmware, or return it from the cache.

    Parameters
    ----------
    board : Board or None
        Board, or None for software in the loop, a process on this machine.

    Raises
    ------
    BuildError
        If the compiler fails; the message holds the command and its output.
    """
    texts = sources(firmware, board)
    commands = compile_commands(texts, firmware.model.manifest.model, board, toolchain)
    words = (word for command in commands for word in command)
    files = (text for item in sorted(texts.items()) for text in item)
    entry = f"{firmware.model.manifest.model}-{cache.key(toolchain.version, *words, *files)}"
    folder = cache.find(_KIND, entry)
    built = folder is None
    if folder is None:
        folder = cache.entry(_KIND, entry, lambda place: _compile(place, texts, commands, toolchain))
    return Image(folder / _ELF, firmware, board, toolchain, built)


def _compile(folder: Path, texts: Mapping[str, str], commands: list[list[str]], toolchain: Toolchain) -> None:
    failure = f"{toolchain.version} could not compile the firmware"
    with tempfile.TemporaryDirectory(dir=folder) as name:
        scratch = Path(name)
        write_sources(scratch, texts)
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            list(pool.map(lambda command: _object(command, texts, scratch, toolchain, failure), commands[:-1]))
        run_compiler(commands[-1], scratch, failure)
        (scratch / _ELF).replace(folder / _ELF)


def _object(command: list[str], texts: Mapping[str, str], scratch: Path, toolchain: Toolchain, failure: str) -> None:
    """Write a unit's object file into a folder, from the cache that firmwares share."""
    unit, name = command[-3], command[-1]
    read = (text for item in sorted(_included(unit, texts).items()) for text in item)

    def fill(place: Path) -> None:
        run_compiler(command, scratch, failure)
        (scratch / name).replace(place / name)

    key = cache.key(toolchain.version, *command, *read)
    shutil.copyfile(cache.entry(_OBJECTS, f"{Path(name).stem}-{key}", fill) / name, scratch / name)


def _included(unit: str, texts: Mapping[str, str]) -> dict[str, str]:
    """Return a unit and all files that it may include."""
    names, rest = {unit}, [unit]
    while rest:
        place = rest.pop()
        for name in _INCLUDE.findall(texts[place]):
            meant = {posixpath.normpath(posixpath.join(posixpath.dirname(place), name)), name, f"libc/{name}"}
            rest += (new := meant & texts.keys() - names)
            names |= new
    return {name: texts[name] for name in names}


def compile_commands(
    texts: Mapping[str, str], model: str, board: Board | None, toolchain: Toolchain
) -> list[list[str]]:
    """Return the commands that compile a folder of sources to firmware.elf; the last one links."""
    own: tuple[str, ...] = ()
    link: tuple[str, ...] = ("-lm",)
    if board is not None:
        defines = (f"-D{name}={value}" for name, value in board.defines.items())
        own = (*toolchain.flags(board), *_SMALL, *defines)
        own += ("-fno-tree-loop-distribute-patterns",) if toolchain.name == "gcc" else ()
        link = ("-T", "board.ld", *toolchain.libraries)
    units = [name for name in texts if name.endswith(".c")]
    objects = {name: Path(name).with_suffix(".o").name for name in units}
    start = [*toolchain.command, *own, *FLAGS]
    flags = {_LAW: (*LAW_FLAGS, *(toolchain.folding(board) if board else ())), f"{model}.c": LAW_FLAGS}
    return [
        *([*start, *flags.get(name, OTHER_FLAGS), "-c", name, "-o", objects[name]] for name in units),
        [*start, *LAW_FLAGS, "-Wl,--gc-sections", *objects.values(), *link, "-o", _ELF],
    ]


def _below(folder: str) -> list[str]:
    """Return the paths of the firmware's files below one of its folders."""
    return [path.relative_to(FIRMWARE).as_posix() for path in sorted((FIRMWARE / folder).rglob("*.[ch]"))]


def _linker_script(board: Board) -> str:
    text = (FIRMWARE / "cortexm.ld").read_text(encoding="utf-8")
    values = {"FLASH": board.flash[0], "FLASH_SIZE": board.flash[1], "RAM": board.ram[0], "RAM_SIZE": board.ram[1]}
    for name, value in {**values, "STACK_SIZE": STACK_SIZE}.items():
        text = text.replace(f"@{name}@", f"{value:#x}")
    return text
