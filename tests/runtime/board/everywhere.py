# SPDX-License-Identifier: Apache-2.0
"""Comparison of every law on every target; writes docs/reference/targets.md, and continues after a stop.

python -m tests.runtime.board.everywhere SAMPLES

The cells stand in benchmarks/results/targets.jsonl. One that has as many samples, of texts that are what they were, is
not run again.
"""

from __future__ import annotations

import functools
import hashlib
import json
import re
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

from mehvar import runtime
from mehvar.base.errors import MissingError
from mehvar.cli.new import scaffold
from mehvar.runtime.board.image.build import compile_commands, program, sources
from mehvar.runtime.board.image.processors import process_toolchain
from mehvar.runtime.board.image.toolchains import board as board_named
from mehvar.runtime.board.image.toolchains import toolchain
from mehvar.runtime.board.run import BoardRequest, run_on_board
from mehvar.runtime.compiling.library import NATIVE
from mehvar.runtime.model.generated import generated_text
from tests.runtime.batch.foreign import differing

ROOT = Path(__file__).parents[3]
PAGE = ROOT / "docs" / "reference" / "targets.md"
RECORD = ROOT / "benchmarks" / "results" / "targets.jsonl"
SELF_TEST = 100
"""Samples of the self-test in all cells, whose checksums are compared."""
_STEP = re.compile(r"\b[tm]_[0-9a-z]{5}(_\d+)?\b")
_COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/|(\"(?:\\.|[^\"\\])*\")", re.DOTALL)
OWN = "own"
BATCH = "batch"


@dataclass(frozen=True)
class Target:
    """Target of a law: the request of a board, or the lanes of a batch."""

    title: str
    target: str
    board: str | None = None
    compiler: str | None = None


TARGETS = (
    Target("this machine, gcc", "sil"),
    Target("this machine, zig", "sil", None, "zig"),
    *(
        Target(f"{title}, {emulator}, {compiler}", emulator.lower(), board, compiler)
        for title, board in (("Cortex-M4F", "stm32f4"), ("Cortex-M3", "mps2-m3"), ("Cortex-M7", "mps2-m7"))
        for emulator in ("Unicorn", "QEMU")
        for compiler in ("gcc", "zig")
    ),
    *(
        Target(f"{title}, QEMU, {compiler}", "sil", board, compiler)
        for title, board in (
            ("aarch64", "aarch64"), ("RISC-V, 64 bits", "riscv64"), ("PowerPC, 32 bits, big-endian", "powerpc"),
            ("s390x, big-endian", "s390x"),
        )
        for compiler in ("gcc", "zig")
    ),
    Target("RISC-V, 64 bits, no FPU, QEMU, zig", "sil", "riscv64-soft", "zig"),
    Target("aarch64, NEON lanes of a batch in double, QEMU, gcc", BATCH, "aarch64"),
)  # fmt: skip


@dataclass(frozen=True)
class Cell:
    """A law on a target.

    Attributes
    ----------
    ulp : int
        Largest difference of inputs, memory and states from this machine's, in units of the last place.
    compared : int
        Numbers that were compared.
    crc : str
        Of all inputs of the self-test; none in a batch.
    reason : str
        Why the run ended.
    """

    law: str
    title: str
    samples: int
    digest: str
    ulp: int
    compared: int
    crc: str
    reason: str
    stack: int = 0
    bound: int = 0
    flash: int = 0
    ram: int = 0
    instructions: int = 0


def laws() -> list[str]:
    """Return all laws, the scaffolded one last, as MODEL/LAW."""
    names = [f"{name}/{law}" for name in runtime.known_models() for law in runtime.load(name).manifest.controllers]
    return [*names, f"{OWN}/balance"]


def load(law: str, folder: Path) -> runtime.Model:
    """Return the model of a law; `mehvar new` makes the user's model in the folder."""
    name = law.partition("/")[0]
    if name != OWN:
        return runtime.load(name, backend="c")
    place = folder / OWN
    project = place if place.is_dir() else scaffold(OWN, folder)
    return runtime.load(project / "generated" / OWN, backend="c")


def short() -> Iterator[tuple[str, Target]]:
    """Yield the cells of the short table: each law and each target without zig's C library, at least once."""
    rows, columns = [t for t in TARGETS if t.target != "sil" or t.compiler != "zig"], laws()
    for i, target in enumerate(rows):
        for j, law in enumerate(columns):
            if (i + j) % len(columns) == 0:
                yield law, target


def digest(model: runtime.Model, law: str, target: Target) -> str:
    """Return the inputs of a cell besides its compiler: the C text and the words of the command."""
    words: list[str] = []
    if target.target == BATCH:
        folders = (NATIVE / name for name in ("include", "step", "methods", "batch", "random"))
        files = [path for folder in folders for path in folder.rglob("*.[chi]*")]
        texts = {str(path.relative_to(NATIVE)): path.read_text() for path in files}
        texts["model.c"] = generated_text(model.manifest, f"{model.name}.c")
    else:
        emulated = target.target != "sil"
        board = board_named(target.board or "stm32f4") if emulated else None
        tools = toolchain(target.compiler) if emulated else process_toolchain(target.board, target.compiler)
        texts = sources(program(model, law.partition("/")[2]), board)
        for command in compile_commands(texts, model.name, board, tools):
            words += command[len(tools.command) :]
    parts = [model.manifest.hash, *words]
    for name, text in sorted(texts.items()):
        parts += [name, _bare(text)]
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()[:16]


@functools.cache
def _bare(text: str) -> str:
    """Remove comments, and number unnamed values; neither changes the compiled code."""
    text = _COMMENT.sub(r"\1", text)
    functions = []
    for function in text.split("\n}\n"):
        names: dict[str, str] = {}
        functions.append(_STEP.sub(partial(_numbered, names), function))
    return "\n}\n".join(functions)


def _numbered(names: dict[str, str], match: re.Match[str]) -> str:
    return names.setdefault(match[0], f"step{len(names)}")


def cell(law: str, target: Target, samples: int, folder: Path) -> Cell:
    """Run a law on a target and compare it with this machine."""
    model, name = load(law, folder), law.partition("/")[2]
    given = {"law": law, "title": target.title, "samples": samples, "digest": digest(model, law, target)}
    if target.target == BATCH:
        assert target.board is not None
        with tempfile.TemporaryDirectory(dir=folder) as place:
            names = differing(model, name, target.board, Path(place), samples)
        return Cell(**given, ulp=int(bool(names)), compared=0, crc="", reason=", ".join(names) or "every result")
    counted = target.target == "unicorn" and target.board == "stm32f4"
    request = BoardRequest(
        name,
        target.target,
        target.board,
        target.compiler,
        samples=samples,
        every=5,
        selftest=SELF_TEST,
        profiled=counted,
    )
    o = run_on_board(model, request)
    sizes: dict[str, Any] = {}
    if o.elf is not None:
        sizes = {"stack": o.stats["stack_used"], "flash": o.elf.flash, "ram": o.elf.ram}
        sizes["bound"] = o.bound.bytes if o.bound else 0
    sizes["instructions"] = o.profile.most if o.profile else 0
    assert o.selftest is not None
    compared = o.u.compared + o.z.compared + o.x.compared
    ulp = max(o.max_ulp, o.x.ulp)
    return Cell(**given, ulp=ulp, compared=compared, crc=f"{o.selftest.crc:08x}", reason=o.board.reason, **sizes)


_HEAD = """\
# Every law on every target

`make soak` writes this page (`python -m tests.runtime.board.everywhere`); a test repeats a part of it. @run@.

A number is the largest difference between the target and this machine, an x86-64 with gcc, in units of the last place.
It covers the law's inputs and memory and the plant's states. The self-test, in which the target computes law and plant,
must have the same checksum here. The firmware is compiled with `-std=c99 -pedantic`. Emulators are not silicon. `–` was
not run.

"""
_TAKES = """\

## What a law takes

STM32F405, Cortex-M4F under Unicorn, in bytes. The bound of the stack is computed from the instructions.

| law | compiler | instructions of a step | flash | static RAM | stack used | bound |
|---|---|---|---|---|---|---|
"""


def page(cells: Sequence[Cell]) -> str:
    """Return the page of the table."""
    columns = laws()
    by_place = {(cell.law, cell.title): cell for cell in cells}
    samples = sorted({cell.samples for cell in cells})
    counts = f"{len(cells)} of {len(TARGETS) * len(columns)} cells were run"
    run = f"{counts}, with {' and '.join(map(str, samples))} samples"
    head = f"| target | {' | '.join(law.replace('/', ' ') for law in columns)} |"
    lines = [*_HEAD.replace("@run@", run).splitlines(), head, "|---" * (len(columns) + 1) + "|"]
    for target in TARGETS:
        texts = [_text(by_place.get((law, target.title)), by_place.get((law, TARGETS[0].title))) for law in columns]
        lines.append(f"| {target.title} | {' | '.join(texts)} |")
    lines += _TAKES.splitlines()
    for law in columns:
        for target in TARGETS:
            result = by_place.get((law, target.title))
            if result and result.instructions:
                numbers = (result.instructions, result.flash, result.ram, result.stack, result.bound or "none")
                lines.append(f"| {law.replace('/', ' ')} | {target.compiler} | {' | '.join(map(str, numbers))} |")
    return "\n".join(lines) + "\n"


def _text(result: Cell | None, reference: Cell | None) -> str:
    if result is None:
        return "–"
    same = not result.crc or (reference is not None and reference.crc == result.crc)
    return str(result.ulp) if same else f"{result.ulp}, checksum {result.crc}"


def read(record: Path) -> list[Cell]:
    """Return the cells of a record."""
    return [Cell(**json.loads(line)) for line in record.read_text().splitlines()] if record.is_file() else []


def fill(samples: int, record: Path = RECORD) -> None:
    """Run the cells that a record does not have, the short table's first, and write the page."""
    record.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        everything = [*((law, TARGETS[0]) for law in laws()), *short()]
        everything += [(law, target) for target in TARGETS for law in laws()]
        present = {(c.law, c.title, c.digest): c for c in read(record) if c.samples >= samples}
        cells: dict[tuple[str, str], Cell] = {}
        for law, target in dict.fromkeys(everything):
            try:
                old = present.get((law, target.title, digest(load(law, folder), law, target)))
            except MissingError:
                continue
            if old is not None:
                cells[law, target.title] = old
        for law, target in everything:
            if (law, target.title) in cells:
                continue
            try:
                result = cells[law, target.title] = cell(law, target, samples, folder)
            except MissingError as error:
                print(f"{target.title}: {error}", flush=True)
                continue
            print(result, flush=True)
            with record.open("a") as file:
                file.write(json.dumps(asdict(result)) + "\n")
            PAGE.write_text(page(list(cells.values())))


if __name__ == "__main__":
    fill(int(sys.argv[1]))
