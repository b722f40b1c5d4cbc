# SPDX-License-Identifier: Apache-2.0
"""The firmware as text and as an image: warnings, analysers, sanitizers, sizes, what a step costs."""

from __future__ import annotations

import ctypes
import json
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from mehvar.runtime.board.emulator.machine import EmulatedBoard
from mehvar.runtime.board.emulator.profile import _cost
from mehvar.runtime.board.image.build import FIRMWARE, build, compile_commands, program, sources
from mehvar.runtime.board.image.elf import Elf, read_elf
from mehvar.runtime.board.image.header import layout
from mehvar.runtime.board.image.instructions import decoded
from mehvar.runtime.board.image.toolchains import board, host_toolchain, toolchain
from mehvar.runtime.board.run import BoardRequest, run_on_board
from mehvar.runtime.compiling.compiler import write_sources
from mehvar.runtime.compiling.library import load_library, native_headers
from tests.runtime.board.conftest import load
from tests.tools import needs

HERE = Path(__file__).parent
STRICT = ("-Wall", "-Wextra", "-Wconversion", "-Wdouble-promotion", "-Wpedantic", "-Werror")
BUDGET = json.loads((HERE / "budget.json").read_text())
NEEDS_GCC = needs("arm-none-eabi-gcc")
COMPILERS = [pytest.param("gcc", marks=NEEDS_GCC), pytest.param("zig", marks=pytest.mark.soak)]
LAWS = [
    ("satellite", "mrac", "stm32f4"), ("satellite", "pd", "mps2-m3"), ("triangle", "path", "stm32f4-usart2"),
    ("triangle", "sliding", "mps2-m4f"), ("slosh", "lyapunov-v1", "mps2-m7"),
]  # fmt: skip


def check(folder, firmware, platform, compiler):
    """Compile every file of a firmware without writing anything."""
    texts = sources(firmware, platform)
    write_sources(folder, texts)
    for command in compile_commands(texts, firmware.model.manifest.model, platform, compiler)[:-1]:
        done = subprocess.run(
            [*command, *STRICT, "-fsyntax-only"], cwd=folder, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stderr


@NEEDS_GCC
@pytest.mark.parametrize(("model", "law", "name"), LAWS)
def test_no_file_has_a_warning(tmp_path, model, law, name):
    check(tmp_path, program(load(model), law, raw=name == "mps2-m3"), board(name), toolchain("gcc"))


def test_the_process_has_no_warning(tmp_path):
    check(tmp_path, program(load("satellite"), "mrac"), None, host_toolchain())


@needs("cppcheck")
def test_cppcheck_finds_nothing(tmp_path):
    write_sources(tmp_path, sources(program(load("satellite"), "mrac"), board("stm32f4")))
    command = [
        "cppcheck", "--std=c99", "--enable=warning,performance,portability", "--error-exitcode=1", "--inline-suppr",
        "--suppress=comparePointers:cortexm.c",  # the linker's symbols
        "-q", "-DMEHVAR_FLOAT", "-I.", "-Ilibc", ".",
    ]  # fmt: skip
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_no_allocation_and_no_standard_input_or_output():
    portable = [path for path in FIRMWARE.rglob("*.[ch]") if path.name != "posix.c"]
    assert len(portable) > 10
    for path in portable:
        assert not re.search(r"\b(malloc|calloc|free\(|printf|stdio\.h|stdlib\.h|double)\b", path.read_text()), path


def campaign(folder, name, flags, frames):
    """Compile the server with a program that sends it frames, run it, and return what it prints."""
    write_sources(folder, sources(program(load("satellite"), "mrac"), None))
    for file in (f"{name}.c", "process.h"):
        shutil.copyfile(HERE / file, folder / file)
    units = ["satellite.c", "app.c", "link.c", "server.c", f"{name}.c"]
    command = [*host_toolchain().command, "-O1", "-std=c99", *flags, "-I.", "-ffp-contract=off", "-DMEHVAR_FLOAT"]
    subprocess.run([*command, *units, "-o", name, "-lm"], cwd=folder, check=True)
    done = subprocess.run([f"./{name}", "5", str(frames)], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_no_damaged_frame_is_taken_for_a_whole_one(tmp_path):
    """200 000; benchmarks/board.py damages a hundred million. CRC-16 let 25 of a million with four wrong bits."""
    kinds = campaign(tmp_path, "residual", (), 200_000).splitlines()
    assert len(kinds) == 11
    for kind in kinds:
        assert kind.endswith(" 0 wrong"), kind


def test_no_frame_makes_the_server_do_what_it_does_not_say(tmp_path):
    """A hundred thousand under both sanitizers; benchmarks/board.py sends ten million."""
    printed = campaign(tmp_path, "fuzz", ("-fsanitize=address,undefined", "-fno-sanitize-recover=all"), 100_000)
    sent, answered, refused, evaluated, again, cleared = map(int, re.findall(r"\d+", printed))
    assert sent == 100_000
    assert 40_000 < answered < 100_000
    assert min(refused, evaluated, again, cleared) > 500


@pytest.fixture(scope="module")
def kernels():
    own = {path.name: path.read_text() for path in (FIRMWARE / "libc" / "sqrtf.c", HERE / "kernels.c")}
    root = "mehvar/private/root.h"
    texts = native_headers() | own | {root: (FIRMWARE / root).read_text()}
    return load_library("board_kernels", texts, ["kernels.c"], ("-O2", "-DMEHVAR_FLOAT"))


def floats(rng, n):
    special = [0, -0.0, 1, np.inf, -np.inf, np.nan, 1e-45, 1.1754942e-38, 1.1754944e-38, 3.4028235e38, -1, 2, 0.5]
    return np.concatenate([rng.integers(0, 2**32, n, np.uint32).view(np.float32), np.array(special, np.float32)])


def pointer(array):
    return array.ctypes.data_as(ctypes.c_void_p)


def test_square_root_and_remainder_are_the_c_librarys(kernels):
    rng = np.random.default_rng(1)
    x = floats(rng, 200_000)
    y = np.concatenate([x[::-1][:150_000], rng.uniform(1e-3, 1e3, x.size - 150_000).astype(np.float32)])
    ours, theirs = np.zeros_like(x), np.zeros_like(x)
    kernels.square_roots(ctypes.c_long(x.size), pointer(x), pointer(ours), pointer(theirs))
    np.testing.assert_array_equal(ours, theirs)
    kernels.remainders(ctypes.c_long(x.size), pointer(x), pointer(y), pointer(ours), pointer(theirs))
    np.testing.assert_array_equal(ours, theirs)
    assert (np.signbit(ours) == np.signbit(theirs))[~np.isnan(ours)].all()


def measured(compiler):
    outcome = run_on_board(load("satellite"), BoardRequest("mrac", "unicorn", compiler=compiler, samples=420, every=50))
    assert outcome.max_ulp == 0
    profile, elf = outcome.profile, outcome.elf
    stack = outcome.stats["stack_used"]
    result = {
        "instructions": profile.most,
        "cycles": profile.cycles,
        "flash": elf.flash,
        "ram": elf.ram,
        "stack": stack,
    }
    return result, elf, outcome


@pytest.mark.parametrize("compiler", COMPILERS)
def test_a_step_and_an_image_stay_within_their_budget(compiler):
    """The adaptive law, designed for the delay; sizes of the same compiler may grow by 2 %, instructions not at all."""
    result, elf, outcome = measured(compiler)
    budget = BUDGET[compiler]
    if outcome.image.toolchain.version == budget["version"]:
        assert result["instructions"] == budget["measured"]["instructions"], "change budget.json and the pages"
        for name, value in result.items():
            assert value <= 1.02 * budget["measured"][name], f"{name} grew: change budget.json if it must"
    for name, limit in budget["limits"].items():
        assert result[name] <= limit, name
    assert elf.doubles() == []
    for coverage in outcome.covered:
        assert coverage.run >= 0.95 * coverage.lines or coverage.function == "mv_app_step", coverage


@pytest.mark.parametrize(
    ("code", "cycles"),
    [
        ("90fbf1f0", 7), ("b0fbf1f0", 7), ("80ee200a", 14), ("b1eec00a", 14), ("a0ee200a", 3), ("00ee200a", 3),
        ("0868", 2), ("0860", 2), ("0878", 2), ("90ed000a", 2), ("80ed000a", 2), ("f1ee10fa", 1), ("4018", 1),
        ("30b5", 4), ("2ded020a", 3), ("0fc8", 5),
    ],
)  # fmt: skip
def test_cycles_of_an_instruction_are_those_of_the_manual(code, cycles):
    """Cortex-M4 Technical Reference Manual; a division takes 2 to 12, of which the middle counts."""
    (instruction,) = decoded(bytes.fromhex(code), 0)
    assert _cost(instruction) == cycles


@pytest.mark.parametrize("compiler", COMPILERS)
def test_constants_of_the_text_save_what_the_pages_say(compiler):
    budget = BUDGET[compiler]
    for names, instructions in budget["constants"].items():
        tunable = tuple(filter(None, names.split(",")))
        request = BoardRequest("mrac", compiler=compiler, samples=60, every=50, selftest=0, tunable=tunable)
        outcome = run_on_board(load("satellite"), request)
        assert outcome.max_ulp == 0
        if outcome.image.toolchain.version == budget["version"]:
            assert outcome.profile.most == instructions


def test_pages_say_of_a_step_what_was_measured():
    """Wherever a page counts instructions of the adaptive law; budget.json is held by the tests above."""
    measured = {str(budget["measured"]["instructions"]) for budget in BUDGET.values()}
    measured |= {str(n) for budget in BUDGET.values() for n in budget["constants"].values()}
    docs = HERE.parents[2] / "docs"
    pages = [docs / "tutorials" / "board.md", docs / "known-limits.md", docs / "how-to" / "nucleo.md"]
    counts = [n for page in pages for n in re.findall(r"\b(\d{3,5})\s+instructions\b", page.read_text())]
    assert set(counts) == measured


@NEEDS_GCC
def test_a_double_routine_is_noticed(tmp_path):
    """The image in double has what the symbol check looks for."""
    firmware, platform = program(load("triangle"), "path"), board("stm32f4")
    texts = sources(firmware, platform)
    write_sources(tmp_path, texts)
    for command in compile_commands(texts, "triangle", platform, toolchain("gcc")):
        words = [word for word in command if word != "-DMEHVAR_FLOAT"]
        if words[-1] != "sqrtf.o":
            done = subprocess.run(
                [w for w in words if w != "sqrtf.o"] + (["-lm", "-lc", "-lnosys"] if "-T" in words else []),
                cwd=tmp_path,
                check=False,
                capture_output=True,
                text=True,
            )
    assert done.returncode == 0, done.stderr
    assert "__aeabi_dmul" in read_elf(tmp_path / "firmware.elf").doubles()


def test_names_of_double_routines():
    names = dict.fromkeys(("__aeabi_dadd", "__aeabi_f2d", "__adddf3", "sin", "sqrt", "__aeabi_d2iz"), (0, 0))
    innocent = dict.fromkeys(
        ("sqrtf", "__aeabi_uldivmod", "__aeabi_fadd", "mv_app_step", "mv_sincos", "memset"), (0, 0)
    )
    assert Elf((), names | innocent, 0, 0, 0).doubles() == sorted(names)


def test_the_layout_comes_from_the_models_names():
    manifest = load("satellite").manifest
    result = layout(manifest, manifest.controller("mrac"))
    assert result.inputs[:3] == ("roll", "pitch", "yaw")
    assert result.inputs[10:] == ("ref_roll", "ref_pitch", "ref_yaw", "Tx_applied", "Ty_applied", "Tz_applied")
    assert result.outputs == ("Tx", "Ty", "Tz")
    assert result.hash != layout(manifest, manifest.controller("pd")).hash


def test_a_program_is_compiled_once():
    firmware = program(load("triangle"), "sliding")
    build(firmware, None, host_toolchain())
    assert not build(firmware, None, host_toolchain()).built


@pytest.mark.parametrize(("name", "interrupt"), [("stm32f4", 37), ("stm32f4-usart2", 38), ("mps2-m3", 0)])
@pytest.mark.share(3)
def test_the_line_wakes_the_board_by_the_interrupt_of_its_port(name, interrupt):
    """ARMv7-M manual, B3.4: a bit each to set enabled, 0x100, and to clear pending, 0x280; RM0090, table 62; AN385."""
    place, bit = 4 * (interrupt // 32), 1 << interrupt % 32
    platform, written = board(name), []

    class Watched(EmulatedBoard):
        def _write_system(self, offset, value):
            written.append((offset, value))
            super()._write_system(offset, value)

    chosen = toolchain("gcc" if shutil.which("arm-none-eabi-gcc") else "zig")
    machine = Watched(read_elf(build(program(load("triangle"), "path"), platform, chosen).path), platform)
    machine.write(bytes(2))
    machine.read()
    assert [row for row in written if 0x100 <= row[0] < 0x180] == [(0x100 + place, bit)]
    assert {row for row in written if 0x280 <= row[0] < 0x300} == {(0x280 + place, bit)}
