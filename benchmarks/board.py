# SPDX-License-Identifier: Apache-2.0
"""The long campaigns of the board: run once, the results are kept in results/board.md.

python benchmarks/board.py equivalence   # compilers and emulators and processors, 5000 samples each
python benchmarks/board.py day           # 172 800 samples, a day of the satellite, under Unicorn
python benchmarks/board.py fuzz          # ten million frames at the receiver, sanitizers on
"""

from __future__ import annotations

import shutil
import subprocess
import tempfile
import time
from pathlib import Path

from machine import command_line

from mehvar import runtime
from mehvar.runtime.board.image.build import program, sources, write_sources
from mehvar.runtime.board.image.toolchains import host_toolchain
from mehvar.runtime.board.run import BoardRequest, run_on_board

SAMPLES, DAY, FRAMES = 5000, 172_800, 10_000_000
FUZZ = Path(__file__).parents[1] / "tests" / "runtime" / "board" / "fuzz.c"
SANITIZERS = (
    "-g",
    "-O2",
    "-std=c99",
    "-fsanitize=address,undefined",
    "-fno-sanitize-recover=all",
    "-fno-omit-frame-pointer",
)


def equivalence() -> None:
    """Compare every target, board and compiler with the host, bit for bit."""
    print(
        "| target | board | compiler | ulp of torques, memory, states | self-test | step: instructions, cycles | "
        "flash, RAM, stack | exchanges/s |"
    )
    print("|---|---|---|---|---|---|---|---|")
    model = runtime.load("satellite", backend="c")
    cases = [("sil", None, None), ("sil", None, "zig")]
    cases += [(t, "stm32f4", c) for t in ("unicorn", "qemu") for c in ("gcc", "zig")]
    cases += [("unicorn", b, c) for b in ("mps2-m3", "mps2-m7") for c in ("gcc", "zig")]
    cases += [("qemu", b, "gcc") for b in ("mps2-m3", "mps2-m4f", "mps2-m7")]
    for target, board, compiler in cases:
        counted = board == "stm32f4"
        o = run_on_board(
            model, BoardRequest("mrac", target, board, compiler, samples=SAMPLES, selftest=SAMPLES, profiled=counted)
        )
        step = f"{o.profile.most}, {o.profile.cycles or '-'}" if o.profile else "-"
        size = f"{o.elf.flash}, {o.elf.ram}, {o.stats['stack_used']}" if o.elf else "-"
        print(
            f"| {target} | {board or '-'} | {o.image.toolchain.version} | {o.u.ulp}, {o.z.ulp}, {o.x.ulp} "
            f"({o.u.compared}, {o.z.compared}, {o.x.compared} numbers) | {o.selftest.crc:08x} | {step} | {size} | "
            f"{o.rate:.0f} |",
            flush=True,
        )


def day() -> None:
    """Run a day of the satellite under Unicorn."""
    model = runtime.load("satellite", backend="c")
    begin = time.perf_counter()
    request = BoardRequest("mrac", "unicorn", samples=DAY, every=500, selftest=0, profiled=False)
    o = run_on_board(model, request)
    print(
        f"{len(o.board.u)} samples ({DAY * 0.5 / 3600:g} h) under Unicorn in {time.perf_counter() - begin:.0f} s, "
        f"{o.rate:.0f} exchanges/s: {o.u.ulp} ulp in {o.u.compared} torques, {o.z.ulp} in {o.z.compared} numbers of "
        f"the memory, {o.x.ulp} ulp in {o.x.compared} states; {o.board.reason}; largest difference of float and double "
        f"of an input {abs(o.single.u - o.double.u).max():.3g} N m; link: {o.counters.as_dict()}"
    )


def fuzz() -> None:
    """Send random frames to the receiver, with sanitizers on."""
    with tempfile.TemporaryDirectory() as name:
        folder, program_ = Path(name), build_fuzzer(Path(name))
        halves = [subprocess.Popen([program_, str(seed), str(FRAMES // 2)], cwd=folder) for seed in (1, 2)]
        begin = time.perf_counter()
        codes = [half.wait() for half in halves]
        print(
            f"{FRAMES} frames under AddressSanitizer and UBSan in {time.perf_counter() - begin:.0f} s: "
            f"{'no finding' if not any(codes) else f'exit {codes}'}"
        )


def build_fuzzer(folder: Path) -> Path:
    """Compile the fuzzer with sanitizers."""
    made = program(runtime.load("satellite", backend="c"), "mrac")
    write_sources(folder, sources(made, None))
    shutil.copyfile(FUZZ, folder / FUZZ.name)
    compiler = host_toolchain()
    units = ["satellite.c", "app.c", "link.c", "server.c", FUZZ.name]
    command = [*compiler.command, *SANITIZERS, "-DMEHVAR_FLOAT", "-DMEHVAR_SMALL", "-ffp-contract=off", "-I.", *units]
    subprocess.run([*command, "-o", "fuzz", "-lm"], cwd=folder, check=True)
    return folder / "fuzz"


if __name__ == "__main__":
    chosen = {"equivalence": equivalence, "day": day, "fuzz": fuzz}
    for name in command_line(__doc__, chosen).parse_args().parts or chosen:
        chosen[name]()
