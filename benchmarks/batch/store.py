# SPDX-License-Identifier: Apache-2.0
"""Damage, kills and cost of large stores; writes benchmarks/results/store.md.

    python -m benchmarks.batch.store                      # all parts, an hour
    python -m benchmarks.batch.store damage starts        # some; the sections of the others stay as they are

- damage: a file of a finished store is removed, cut, emptied or has a bit flipped, 325 times: seen, named, mended.
- starts: 50 times two processes begin a batch under one name at once: one has it, the other is told who.
- million: a batch of 10^6 runs is killed, resumed, damaged in three places, resumed: the bits of an undisturbed one.
- cost: one batch of 10^6 runs, in which the time within digests, forced writes and records is counted.
"""

from __future__ import annotations

import random
import shutil
import subprocess
import sys
import tempfile
import time
import warnings
from argparse import Namespace
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from unittest import mock

from benchmarks.machine import RESULTS, command_line, machine, table, write
from mehvar.base.errors import MehvarError
from mehvar.runtime.batch.evaluation.statistics import summarise
from mehvar.runtime.batch.fill import run_batch
from mehvar.runtime.batch.plan import Campaign
from mehvar.runtime.batch.store import files
from mehvar.runtime.batch.store.records import STORE
from mehvar.runtime.batch.store.store import open_store
from mehvar.runtime.batch.store.verification import verify

MODEL, LAW = "triangle", "path"
VARY = {"l1_0": "normal(0.2, 0.01)", "theta_0": "uniform(0.8, 1.2)"}
SHORT = Campaign(LAW, n=2000, seed=1, vary=VARY, options={"t_end": 0.2}, save_every=0.1)
FAST = {"t_end": 35.0, "dt_out": 0.1, "method": "dopri5", "rtol": 1e-6, "atol": 1e-6}
"""Options of `batch_closed_loop.py`: 0.27 ms a run on one thread."""
BROKEN = (("final/c/{}/0", "removed"), ("status/c/{}", "a bit flipped"), ("travel/c/{}", "cut"))
PAGE = "store.md"
SIZES = {"damages": 325, "starts": 50, "runs": 1_000_000}
USES = {"damage": ("damages",), "starts": ("starts",), "million": ("runs",), "cost": ("runs",)}
"""Sizes of each part."""


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the parts, and write the result of each at its end."""
    parts = {"damage": damage, "starts": starts, "million": million, "cost": cost}
    parser = command_line(__doc__, parts)
    for name, size in SIZES.items():
        parser.add_argument(f"--{name}", type=int, default=size, metavar="N", help=f"default: {size}")
    given = parser.parse_args(arguments)
    sizes = {name: getattr(given, name) for name in SIZES}
    for name in given.parts or list(parts):
        about = machine()
        with tempfile.TemporaryDirectory() as folder:
            title, *lines = parts[name](Path(folder), Namespace(**sizes))
        own = "".join(f" --{size} {sizes[size]}" for size in SIZES if size in USES[name])
        line = f"`python -m benchmarks.batch.store {name}{own}`"
        _write_section(title, [line, "", *lines, "", *about])


def _write_section(title: str, lines: Sequence[str]) -> None:
    """Replace the section of the page that has the same title."""
    head, *sections = (RESULTS / PAGE).read_text(encoding="utf-8").split("\n## ")
    kept = {name: text.strip("\n") for name, _, text in (section.partition("\n") for section in sections)}
    kept[title] = "\n".join(lines)
    write(PAGE, [head.strip("\n"), *(f"\n## {name}\n\n{text}" for name, text in kept.items())])


def damage(folder: Path, sizes: Namespace) -> list[str]:
    """Damage one file after the other, some twice, and repair after each."""
    store = folder / "runs.zarr"
    run_batch(MODEL, SHORT, store, chunk=512)
    wanted = contents(store)
    names = sorted(wanted.keys() - {STORE})  # without this record nothing identifies the batch
    seen: Counter[str] = Counter()
    for number in range(sizes.damages):
        chance = random.Random(number)
        name, kind = names[(7 * number) % len(names)], chance.choice(("removed", "cut", "emptied", "a bit flipped"))
        spoil(store / name, kind, chance)
        unseen = verify(store).complete
        refused, blocks = False, []
        try:
            summarise(open_store(store))
        except MehvarError:
            refused = True
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            run_batch(MODEL, SHORT, store, resume=True, chunk=512, report=lambda *now, b=blocks: b.append(now[0]))
        again = len(blocks) - 1
        own = name.split("/")[2] if "/c/" in name and name.split("/")[0] not in ("state", "variable", "t") else ""
        own = own or (name.split("/")[1].removesuffix(".json") if name.startswith("records/") else "")
        exact = contents(store) == wanted and again == int(own.isdigit())
        seen["damaged"] += 1
        seen["unseen"] += unseen
        seen["refused by statistics"] += refused
        seen["resumed to the same bytes, exactly the damaged block computed"] += exact
        seen["blocks computed again"] += again
        seen["told"] += len(said)
    rows = [[name, str(number)] for name, number in seen.items()]
    note = (
        "A removed `records/end.json` is no damage to a statistic: `verify` says that the end is not recorded, `stats` "
        "goes on. A traceback would have ended the script."
    )
    return ["Damaged files", *table(["what", "times"], rows), "", note]


def starts(folder: Path, sizes: Namespace) -> list[str]:
    """Start one batch in two processes at once, and check the store."""
    line = [sys.executable, "-m", "mehvar", "batch", MODEL, "--controller", LAW, "-n", "600", "--t-end", "0.1"]
    reference = folder / "reference.zarr"
    assert subprocess.run([*line, "--out", str(reference)], stdout=subprocess.DEVNULL, check=False).returncode == 0
    wanted, told = contents(reference), Counter[str]()
    for number in range(sizes.starts):
        out = folder / f"{number}.zarr"
        pair = [
            subprocess.Popen([*line, "--out", str(out)], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
            for _ in range(2)
        ]
        ended = [(process.communicate()[1], process.returncode) for process in pair]
        winners = [said for said, status in ended if status == 0]
        assert len(winners) == 1, ended
        loser = next(said for said, status in ended if status != 0)
        assert "Traceback" not in loser
        told["was told which process writes it" if "another process is writing" in loser else "was told it exists"] += 1
        assert contents(out) == wanted
        shutil.rmtree(out)
    assert [path.name for path in folder.iterdir()] == ["reference.zarr"], "nothing is left behind"
    rows = [[f"the second {what}", str(times)] for what, times in told.items()]
    rows += [["the first had the bytes of a batch alone; no file left behind", str(sizes.starts)]]
    return ["Two first starts on one name", *table(["what", "times"], rows)]


def million(folder: Path, sizes: Namespace) -> list[str]:
    """Kill, damage and resume a large batch."""
    line = [sys.executable, "-m", "mehvar", "batch", MODEL, "--controller", LAW, "-n", str(sizes.runs), "--seed", "1"]
    line += [text for name, value in VARY.items() for text in ("--vary", f"{name}={value}")]
    line += ["--t-end", "1", "--resume", "--out"]
    quiet = {"stdout": subprocess.DEVNULL}
    begun = time.monotonic()
    assert subprocess.run([*line, str(folder / "reference.zarr")], **quiet, check=False).returncode == 0
    seconds, store = time.monotonic() - begun, folder / "runs.zarr"
    records = len(list((folder / "reference.zarr").glob("records/*.json")))
    process = subprocess.Popen([*line, str(store)], **quiet)
    while process.poll() is None and len(list(store.glob("records/*.json"))) < records // 2:
        time.sleep(0.1)
    process.kill()
    assert process.wait() < 0, "it came to its end before it was killed"
    kept = len(open_store(store).stored())
    assert subprocess.run([*line, str(store)], **quiet, check=False).returncode == 0
    blocks, chance = len(verify(store).whole), random.Random(2)
    places = chance.sample(range(blocks), 3)
    for block, (name, kind) in zip(places, BROKEN, strict=True):
        spoil(store / name.format(block), kind, chance)
    damaged = [block.block for block in verify(store).damaged]
    assert damaged == sorted(places)
    assert subprocess.run([*line, str(store)], **quiet, stderr=subprocess.DEVNULL, check=False).returncode == 0
    assert contents(store) == contents(folder / "reference.zarr")
    rows = [
        ["runs", str(sizes.runs)],
        ["blocks", str(blocks)],
        ["blocks stored when it was killed", str(kept)],
        ["blocks damaged then, and computed again", ", ".join(map(str, damaged))],
        ["files compared with an undisturbed batch", str(len(contents(store)))],
        ["bytes that differ", "0"],
        ["time of the undisturbed batch", f"{seconds:.0f} s"],
    ]
    return ["A large batch, killed and damaged", *table(["what", "how many"], rows)]


def cost(folder: Path, sizes: Namespace) -> list[str]:
    """Measure the time in digests, forced writes and records of one batch."""
    run_batch(MODEL, Campaign(LAW, n=2000, seed=1, vary=VARY, options=FAST))  # compiles
    campaign, meter = Campaign(LAW, n=sizes.runs, seed=1, vary=VARY, options=FAST), Meter()
    with meter.counting():
        wall, used = time.perf_counter(), time.process_time()
        run_batch(MODEL, campaign, folder / "runs.zarr")
        wall, used = time.perf_counter() - wall, time.process_time() - used
    stored = sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())
    rows = [
        [name, f"{cpu:.2f} s", f"{100 * cpu / used:.2f} %", f"{waited:.1f} s", f"{100 * waited / wall:.2f} %"]
        for name, (cpu, waited) in {**meter.times, "all three": meter.total(), "the batch": (used, wall)}.items()
    ]
    return [
        "Cost of digests and forced writes",
        *table(["what", "processor time", "share", "time", "share"], rows),
        "",
        f"{sizes.runs} runs of the triangle (35 s, 350 samples, dopri5, rtol 1e-6), {stored / 1e6:.0f} MB. A block is "
        "stored while the next one is computed: what is waited for the disk lengthens a batch only where a block is "
        "computed in less.",
    ]


class Meter:
    """Processor time and waiting time within functions, over all threads."""

    def __init__(self) -> None:
        self.times = dict.fromkeys(("digests", "forced writes", "records"), (0.0, 0.0))

    def total(self) -> tuple[float, float]:
        """Return the sum over all functions."""
        cpu, waited = zip(*self.times.values(), strict=True)
        return sum(cpu), sum(waited)

    @contextmanager
    def counting(self) -> Iterator[None]:
        """Measure the work of a store beyond writing arrays."""
        with (
            mock.patch.object(files, "digest", self._timed("digests", files.digest)),
            mock.patch.object(files, "force_files", self._timed("forced writes", files.force_files)),
            mock.patch.object(files, "write_record", self._timed("records", files.write_record)),
        ):
            yield

    def _timed(self, name: str, function: Callable[..., Any]) -> Callable[..., Any]:
        def timed(*arguments: Any) -> Any:
            wall, used = time.perf_counter(), time.thread_time()
            try:
                return function(*arguments)
            finally:
                cpu, waited = self.times[name]
                self.times[name] = cpu + time.thread_time() - used, waited + time.perf_counter() - wall

        return timed


def spoil(path: Path, kind: str, chance: random.Random) -> None:
    """Damage a file."""
    if kind == "removed":
        path.unlink()
        return
    content = bytearray(path.read_bytes())
    if kind == "cut":
        del content[chance.randrange(len(content)) :]
    elif kind == "emptied":
        content.clear()
    else:
        content[chance.randrange(len(content))] ^= 1 << chance.randrange(8)
    path.write_bytes(content)


def contents(store: Path) -> dict[str, bytes]:
    """Return the bytes of every file of a store by its place."""
    return {path.relative_to(store).as_posix(): path.read_bytes() for path in store.rglob("*") if path.is_file()}


if __name__ == "__main__":
    main()
