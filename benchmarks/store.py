# SPDX-License-Identifier: Apache-2.0
"""A store that proves itself, at full size; writes benchmarks/results/store.md.

    python benchmarks/store.py                      # all parts, an hour
    python benchmarks/store.py damage starts        # some

- damage: a file of a finished store is removed, cut, emptied or has a bit flipped, 325 times: seen, named, mended.
- starts: 50 times two processes begin a batch under one name at once: one has it, the other is told who.
- million: a batch of 10^6 runs is killed, resumed, damaged in three places, resumed: the bits of an undisturbed one.
- block: one block of runs stored with and without digests and forced writes, in turns, beside the time to compute it.
- cost: the same of a whole batch.
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
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext
from pathlib import Path
from statistics import median
from unittest import mock

from machine import command_line, machine, table, write

from mehvar.errors import MehvarError
from mehvar.runtime.batch.blocks import Blocks
from mehvar.runtime.batch.fill import run_batch
from mehvar.runtime.batch.plan import Campaign, Plan
from mehvar.runtime.batch.statistics import summarise
from mehvar.runtime.batch.store import chunks
from mehvar.runtime.batch.store import store as store_module
from mehvar.runtime.batch.store.layout import Layout
from mehvar.runtime.batch.store.store import create, open_store
from mehvar.runtime.batch.store.verification import verify
from mehvar.runtime.model.model import load

MODEL, LAW = "triangle", "path"
VARY = {"l1_0": "normal(0.2, 0.01)", "theta_0": "uniform(0.8, 1.2)"}
SHORT = Campaign(LAW, n=2000, seed=1, vary=VARY, options={"t_end": 0.2}, save_every=0.1)
FAST = {"method": "dopri5", "rtol": 1e-6, "atol": 1e-6}
BLOCKS = 24
SIZES = {"damages": 325, "starts": 50, "runs": 1_000_000, "pairs": 3}


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the parts, and write what came of them."""
    parts = {"damage": damage, "starts": starts, "million": million, "block": block, "cost": cost}
    parser = command_line(__doc__, parts)
    for name, size in SIZES.items():
        parser.add_argument(f"--{name}", type=int, default=size, metavar="N", help=f"{size} unless given")
    given = parser.parse_args(arguments)
    names = given.parts or list(parts)
    line = " ".join(sys.argv[1:] if arguments is None else arguments)
    lines = ["# Stores: damage, first starts, cost", "", *machine(), "", f"`python benchmarks/store.py {line}`"]
    with tempfile.TemporaryDirectory() as folder:
        for name in names:
            place = Path(folder) / name
            place.mkdir()
            lines += ["", *parts[name](place, given)]
            shutil.rmtree(place)
    write("store.md", lines)


def damage(folder: Path, sizes: Namespace) -> list[str]:
    """Damage one file after the other, some twice; mend after each."""
    chance, store = random.Random(1), folder / "runs.zarr"
    run_batch(MODEL, SHORT, store, chunk=512)
    wanted = contents(store)
    names = sorted(wanted)
    seen: Counter[str] = Counter()
    for number in range(sizes.damages):
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
    head = "## Damaged files"
    rows = [[name, str(number)] for name, number in seen.items()]
    note = (
        "A removed `records/end.json` is no damage to a statistic: `verify` says that the end is not recorded, `stats` "
        "goes on. A traceback would have ended the script."
    )
    return [head, "", *table(["what", "times"], rows), "", note]


def starts(folder: Path, sizes: Namespace) -> list[str]:
    """Begin one batch in two processes at once, and look at what is left."""
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
    return ["## Two first starts on one name", "", *table(["what", "times"], rows)]


def million(folder: Path, sizes: Namespace) -> list[str]:
    """Kill, damage and resume a large batch."""
    line = [sys.executable, "-m", "mehvar", "batch", MODEL, "--controller", LAW, "-n", str(sizes.runs), "--seed", "1"]
    line += [text for name, value in VARY.items() for text in ("--vary", f"{name}={value}")]
    line += ["--t-end", "1", "--resume", "--out"]
    quiet = {"stdout": subprocess.DEVNULL}
    begun = time.monotonic()
    assert subprocess.run([*line, str(folder / "reference.zarr")], **quiet, check=False).returncode == 0
    seconds, store = time.monotonic() - begun, folder / "runs.zarr"
    process = subprocess.Popen([*line, str(store)], **quiet)
    time.sleep(seconds / 2)
    process.kill()
    process.wait()
    kept = len(open_store(store).stored())
    assert subprocess.run([*line, str(store)], **quiet, check=False).returncode == 0
    blocks, chance = len(verify(store).whole), random.Random(2)
    for name, kind in (("final", "removed"), ("status", "a bit flipped"), ("travel", "cut")):
        piece = "/0" if name == "final" else ""
        spoil(store / name / "c" / f"{chance.randrange(blocks)}{piece}", kind, chance)
    damaged = [block.block for block in verify(store).damaged]
    assert len(damaged) == 3
    assert subprocess.run([*line, str(store)], **quiet, stderr=subprocess.DEVNULL, check=False).returncode == 0
    assert contents(store) == contents(folder / "reference.zarr")
    return [
        f"## A batch of {sizes.runs} runs, killed and damaged",
        "",
        f"Killed when {kept} of {blocks} blocks were stored, resumed, damaged in the blocks {damaged}, resumed: every "
        f"byte of {blocks} blocks is that of an undisturbed batch ({seconds:.0f} s).",
    ]


def block(folder: Path, _sizes: Namespace) -> list[str]:
    """Time the storing of blocks of 4096 runs, which a batch of a million has 245 of."""
    campaign = Campaign(LAW, n=4096 * BLOCKS, seed=1, vary=VARY, options=FAST)
    run_batch(MODEL, Campaign(LAW, n=2000, seed=1, vary=VARY, options=FAST))  # compiles
    computed = Blocks(Plan(load(MODEL, "c"), campaign), threads=1)
    begun = time.process_time()
    values = computed.compute(0, 4096)
    compute = time.process_time() - begun
    assert values is not None
    identity = {"numerics": computed.numerics.text()}
    layout = Layout(campaign.n, 4096, computed.variables(), computed.coordinates(), identity)
    stores = {name: create(folder / f"{name}.zarr", layout) for name in ("with", "without")}
    times: dict[str, list[tuple[float, float]]] = {name: [] for name in stores}
    for number in range(BLOCKS):
        for name in sorted(stores, reverse=bool(number % 2)):
            with unproved() if name == "without" else nullcontext():
                wall, used = time.perf_counter(), time.process_time()
                stores[name].write(number, values, provenance=computed.provenance, refusals={})
                times[name].append((time.perf_counter() - wall, time.process_time() - used))
    rows = [
        [name, *(f"{1e3 * pick(pair[k] for pair in pairs):.1f} ms" for k in (0, 1) for pick in (median, min))]
        for name, pairs in times.items()
    ]
    heads = ["digests, forced writes", "time, median", "shortest", "processor time, median", "shortest"]
    return [
        f"## Cost of storing a block of 4096 runs, {BLOCKS} times each",
        "",
        *table(heads, rows),
        "",
        f"Computing the block took {compute:.2f} s of processor time (dopri5, rtol 1e-6). It is stored while the "
        "next one is computed: what is waited for the disk is time only where a block is computed in less.",
    ]


def cost(folder: Path, sizes: Namespace) -> list[str]:
    """Time a batch with and without digests and forced writes, in turns."""
    campaign = Campaign(LAW, n=sizes.runs, seed=1, vary=VARY, options=FAST)
    run_batch(MODEL, Campaign(LAW, n=2000, seed=1, vary=VARY, options=FAST))  # compiles
    times: dict[str, list[tuple[float, float]]] = {"with": [], "without": []}
    for pair in range(sizes.pairs):
        for name in ("with", "without") if pair % 2 else ("without", "with"):
            with unproved() if name == "without" else nullcontext():
                wall, used = time.perf_counter(), time.process_time()
                run_batch(MODEL, campaign, folder / "runs.zarr")
                times[name].append((time.perf_counter() - wall, time.process_time() - used))
            shutil.rmtree(folder / "runs.zarr")
    ratios = [(a / b - 1, c / d - 1) for (a, c), (b, d) in zip(times["with"], times["without"], strict=True)]
    rows = [
        [f"{wall:.1f} s", f"{bare:.1f} s", f"{100 * (wall / bare - 1):+.2f} %", f"{100 * (used / plain - 1):+.2f} %"]
        for (wall, used), (bare, plain) in zip(times["with"], times["without"], strict=True)
    ]
    return [
        f"## Cost of digests and forced writes: {sizes.runs} runs of the triangle",
        "",
        *table(["with", "without", "more time", "more processor time"], rows),
        "",
        f"Median of the pairs: {100 * median(r[0] for r in ratios):+.2f} % of the time, "
        f"{100 * median(r[1] for r in ratios):+.2f} % of the processor time.",
    ]


@contextmanager
def unproved() -> Iterator[None]:
    """Leave digests and forced writes out."""
    with (
        mock.patch.object(chunks, "digest", return_value="0"),
        mock.patch.object(store_module, "force", return_value=None),
        mock.patch("os.fsync", return_value=None),
    ):
        yield


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
