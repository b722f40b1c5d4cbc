# SPDX-License-Identifier: Apache-2.0
"""Programs, lines with faults, and a session with a law on an emulated board."""

from __future__ import annotations

import functools
import os
import subprocess
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from mehvar import runtime
from mehvar.runtime.board.image.build import Image, build, program
from mehvar.runtime.board.image.elf import Elf, read_elf
from mehvar.runtime.board.image.toolchains import board, toolchain
from mehvar.runtime.board.line.link import Link
from mehvar.runtime.board.session import BoardLaw
from mehvar.runtime.board.targets import MachinePort


@pytest.fixture(scope="session", autouse=True)
def _zig_cache() -> Iterator[None]:
    """Keep the compiler's libraries between test runs."""
    with pytest.MonkeyPatch.context() as patch:
        if "ZIG_GLOBAL_CACHE_DIR" not in os.environ:
            patch.setenv("ZIG_GLOBAL_CACHE_DIR", str(Path(tempfile.gettempdir()) / f"mehvar-zig-{os.getuid()}"))
        yield


@functools.cache
def load(model: str) -> runtime.Model:
    return runtime.load(model, backend="c")


@functools.cache
def image_of(model: str, law: str, tunable: tuple[str, ...] | None) -> Image:
    return build(program(load(model), law, tunable=tunable), board("stm32f4"), toolchain("gcc" if _gcc() else "zig"))


_SCRIPT = """\
ENTRY(Reset_Handler)
SECTIONS {
    . = 0x8000; .text : { KEEP(*(.text*)) } .rodata : { *(.rodata*) } .data : { *(.data*) } .bss : { *(.bss*) }
    __stack_limit = .; __stack_top = . + 64; /DISCARD/ : { *(.ARM*) *(.comment) }
}
"""


def linked(folder: Path, text: str, compiler: str) -> Elf:
    """Return an image for a Cortex-M4F of one C file, without inlined functions and unrolled loops."""
    (folder / "a.c").write_text(text)
    (folder / "a.ld").write_text(_SCRIPT)
    chosen = toolchain(compiler)
    flags = (*chosen.flags(board("stm32f4")), "-O1", "-ffreestanding", "-fno-inline", "-fno-optimize-sibling-calls")
    flags += ("-fno-unroll-loops", "-fno-vectorize") if compiler == "zig" else ()
    command = [*chosen.command, *flags, "-nostdlib", "-T", "a.ld", "a.c", "-o", "a.elf"]
    subprocess.run(command, cwd=folder, check=True)
    return read_elf(folder / "a.elf")


def closed_loop(
    model: runtime.Model, named: str, /, period: float, samples: int, delay: int, **options: object
) -> runtime.Run:
    sampling = {"t_end": (samples - 1) * period, "dt_out": period, "hold": period, "delay": delay}
    return runtime.simulate(model, named, **sampling, **options)


@functools.cache
def expected(model: str, law: str, samples: int, delay: int) -> runtime.Run:
    """Return the closed loop on the host, with the law in float."""
    period = image_of(model, law, None).program.period
    return closed_loop(load(model), law, period, samples, delay, real="float")


class Bench:
    """A law on an emulated board, its line, and the closed loop that the host expects."""

    def __init__(
        self,
        model: str = "satellite",
        law: str = "mrac",
        samples: int = 60,
        delay: int = 1,
        tunable: tuple[str, ...] | None = None,
    ) -> None:
        self.model, image = load(model), image_of(model, law, tunable)
        self.program = image.program
        self.samples, self.delay, self.law = samples, delay, law
        self.port = MachinePort(image)
        self.expected = expected(model, law, samples, delay)

    def link(self, port: object = None, tries: int = 200) -> Link:
        """Return a connected link over the board's line or a wrapped line."""
        link = Link(port or self.port, self.program.layout, tries=tries)  # type: ignore[arg-type]
        link.connect()
        return link

    def simulate(self, **options: object) -> runtime.Run:
        """Run the closed loop."""
        return closed_loop(self.model, self.law, self.program.period, self.samples, self.delay, **options)

    def numbers(self, k: int) -> np.ndarray:
        """Return the payload of sample k of the closed loop."""
        run = self.expected
        r = self.model.functions["reference"](run.t[k], run.parameters.p, run.parameters.s)
        applied = run.u[k - 1] if k else np.zeros(run.u.shape[1])
        return np.concatenate([run.x[k], r, applied]).astype(np.float32)

    def started(self, port: object = None) -> Link:
        """Return a connected link whose board is about to begin the closed loop."""
        link = self.link(port)
        self.start(link)
        return link

    def on_board(self, link: Link | None = None, **options: object) -> BoardLaw:
        """Return the law on the board, with the parameters of the closed loop."""
        return BoardLaw(link or self.link(), self.program, self.expected.parameters, **options)  # type: ignore[arg-type]

    def start(self, link: Link) -> None:
        """Set parameters and memory as the closed loop starts."""
        link.reset()
        for group, values in zip(
            "pcs", (self.expected.parameters.p, self.expected.parameters.c, self.expected.parameters.s), strict=True
        ):
            link.set(group, values)
        link.set("z", self.expected.z[0])

    def same(self, run: runtime.Run) -> bool:
        """Return True if a run is bit-identical to the run on the host."""
        return run.u_cmd.tobytes() == self.expected.u_cmd.tobytes() and run.x.tobytes() == self.expected.x.tobytes()


def _gcc() -> bool:
    import shutil

    return shutil.which("arm-none-eabi-gcc") is not None


@pytest.fixture
def bench() -> Bench:
    return Bench()


class Wrapped:
    """A line around a board's line, which passes on everything."""

    name = "wrapped line"

    def __init__(self, port: MachinePort) -> None:
        self._port = port

    def write(self, data: bytes) -> None:
        self._port.write(data)

    def read(self, timeout: float) -> bytes:
        return self._port.read(timeout)

    def close(self) -> None:
        self._port.close()


class Noisy(Wrapped):
    """A line that damages its data."""

    def __init__(self, port: MachinePort, damage: Callable[[bytes], bytes], back: Callable[[bytes], bytes]) -> None:
        super().__init__(port)
        self._damage, self._back = damage, back

    def write(self, data: bytes) -> None:
        super().write(self._damage(data))

    def read(self, timeout: float) -> bytes:
        return self._back(super().read(timeout))
