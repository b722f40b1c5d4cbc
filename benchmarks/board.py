# SPDX-License-Identifier: Apache-2.0
"""Long campaigns of the board, whose results are in results/board.md.

python -m benchmarks.board equivalence   # compilers and emulators and processors, 5000 samples each
python -m benchmarks.board day           # 172 800 samples, a day of the satellite, under Unicorn
python -m benchmarks.board fuzz          # ten million frames at the server, sanitizers on
python -m benchmarks.board guided        # an hour of frames that clang's libFuzzer chooses; Debian: libclang-rt-14-dev
python -m benchmarks.board residual      # a hundred million damaged frames at the receiver
"""

from __future__ import annotations

import re
import shutil
import subprocess
import tempfile
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from benchmarks.machine import command_line
from mehvar import runtime
from mehvar.runtime.board.image.build import program, sources, write_sources
from mehvar.runtime.board.image.toolchains import host_toolchain
from mehvar.runtime.board.run import BoardRequest, run_on_board

SAMPLES, DAY, FRAMES, DAMAGED = 5000, 172_800, 10_000_000, 100_000_000
SLICE = 5_000_000
"""Frames of one process of a campaign; each process has a seed, so finished slices are not repeated."""
SECONDS, LONGEST_INPUT = 3600, 512
"""Duration of the guided campaign, s, and bytes of an input: about thirty frames, enough for a session from hello to
reboot."""
TURN = 300
"""Time between two records of the counts, s; a stop loses at most this time."""
RECORD = Path(__file__).parents[1] / "build" / "guided"
TESTS = Path(__file__).parents[1] / "tests" / "runtime" / "board"
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
    """Send random frames to the server, with sanitizers on; check each reply against the server's state."""
    with tempfile.TemporaryDirectory() as name:
        begin = time.perf_counter()
        printed = slices(build_campaign(Path(name), "fuzz", SANITIZERS), FRAMES)
        print(f"under AddressSanitizer and UBSan in {time.perf_counter() - begin:.0f} s, no finding: {summed(printed)}")


def residual() -> None:
    """Damage frames in eleven ways and count undetected damages."""
    with tempfile.TemporaryDirectory() as name:
        begin = time.perf_counter()
        printed = slices(build_campaign(Path(name), "residual", ("-O2",)), DAMAGED)
        print(f"{DAMAGED} damaged frames in {time.perf_counter() - begin:.0f} s:", summed(printed), sep="\n")


def guided() -> None:
    """Let clang's libFuzzer choose frames by coverage, with sanitizers on; a stopped campaign continues."""
    RECORD.mkdir(parents=True, exist_ok=True)
    flags = (*SANITIZERS, "-fsanitize=fuzzer", "-DGUIDED")
    path, corpus = build_campaign(RECORD / "program", "fuzz", flags, ("clang",)), RECORD / "corpus"
    corpus.mkdir(exist_ok=True)
    command = [path, f"-max_len={LONGEST_INPUT}", f"-max_total_time={TURN}", "-print_final_stats=1", corpus]
    while len(turns := sorted(RECORD.glob("turn*.txt"))) < SECONDS // TURN:
        done = subprocess.run(command, cwd=RECORD, capture_output=True, text=True, check=True)
        edges = re.findall(r"cov: (\d+)", done.stderr)[-1]
        executed = re.findall(r"number_of_executed_units: (\d+)", done.stderr)[-1]
        (RECORD / f"turn{len(turns):03}.txt").write_text(f"{executed} inputs, {done.stdout.strip()}, {edges} edges\n")
    printed = [turn.read_text().strip() for turn in turns]
    sums = [sum(map(int, column)) for column in zip(*(re.findall(r"\d+", text) for text in printed), strict=True)]
    counts = re.sub(r"\d+", lambda _: str(sums.pop(0)), printed[-1].rpartition(", ")[0])
    edges = printed[-1].rpartition(", ")[2]
    print(f"{SECONDS} s: {counts}; {edges}, {len(list(corpus.iterdir()))} inputs kept")


def slices(path: Path, frames: int) -> list[str]:
    """Run a campaign in slices, two at a time; return the output of each, or raise if one fails."""

    def run(seed: int) -> str:
        command = [path, str(seed), str(SLICE)]
        return subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True).stdout.strip()

    with ThreadPoolExecutor(2) as pool:
        return list(pool.map(run, range(1, frames // SLICE + 1)))


def summed(printed: Sequence[str]) -> str:
    """Add the counts of texts that differ only in counts; numbers in names of kinds are not counts."""
    count = re.compile(r"(?<=: )\d+|(?<=of )\d+|(?<=, )\d+|^\d+(?= frames)", re.MULTILINE)
    columns = (sum(map(int, column)) for column in zip(*map(count.findall, printed), strict=True))
    return count.sub(lambda _: str(next(columns)), printed[0])


def build_campaign(folder: Path, name: str, flags: Sequence[str], compiler: Sequence[str] = ()) -> Path:
    """Compile the server with a program that sends frames to it."""
    firmware = program(runtime.load("satellite", backend="c"), "mrac")
    write_sources(folder, sources(firmware, None))
    for file in (f"{name}.c", "process.h"):
        shutil.copyfile(TESTS / file, folder / file)
    units = ["satellite.c", "app.c", "link.c", "server.c", f"{name}.c"]
    command = [
        *(compiler or host_toolchain().command),
        *flags,
        "-DMEHVAR_FLOAT",
        "-DMEHVAR_SMALL",
        "-ffp-contract=off",
        "-I.",
    ]
    subprocess.run([*command, *units, "-o", name, "-lm"], cwd=folder, check=True)
    return folder / name


if __name__ == "__main__":
    campaigns = {"equivalence": equivalence, "day": day, "fuzz": fuzz, "guided": guided, "residual": residual}
    for name in command_line(__doc__, campaigns).parse_args().parts or campaigns:
        campaigns[name]()
