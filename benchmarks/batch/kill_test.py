# SPDX-License-Identifier: Apache-2.0
"""Kill a batch with SIGKILL at random instants, resume it, and compare its store byte for byte.

    python -m benchmarks.batch.kill_test --kills 200

Every kill hits a real `mehvar batch` process. After each one, whatever the store acknowledges must be what an
uninterrupted batch stored; when the batch is complete, every file must be the same. Then a new store begins.
"""

from __future__ import annotations

import argparse
import random
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

MODEL = ("triangle", "--controller", "path", "--seed", "1", "--t-end", "0.2", "--save", "every=0.1")
VARY = ("--vary", "l1_0=normal(0.2, 0.01)", "--vary", "theta_0=uniform(0.8, 1.2)")


@dataclass
class Tally:
    """Counts: kills by the number of acknowledged blocks, completed stores, blocks compared."""

    kills: Counter[int] = field(default_factory=Counter)
    stores: int = 0
    acknowledged: int = 0


def main(arguments: Sequence[str] | None = None) -> None:
    """Kill, resume, compare, and print the counts."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kills", type=int, default=200)
    parser.add_argument("--runs", type=int, default=20_000)
    parser.add_argument("--seed", type=int, default=0, help="of the instants")
    given = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory() as folder:
        tally = torment(Path(folder), given.kills, given.runs, random.Random(given.seed))
    total = sum(tally.kills.values())
    early = tally.kills[0]
    print(
        f"{total} kills, {early} of them before the first block was stored, {tally.stores} stores completed, "
        f"{tally.acknowledged} acknowledged blocks compared: every byte the same"
    )


def torment(folder: Path, kills: int, runs: int, chance: random.Random) -> Tally:
    """Kill and resume the given number of times; raise AssertionError if a byte differs."""
    reference, store = folder / "reference.zarr", folder / "runs.zarr"
    started = time.monotonic()
    assert start(reference, runs).wait() == 0
    longest = time.monotonic() - started
    reference_contents = contents(reference)
    tally = Tally()
    while sum(tally.kills.values()) < kills:
        process = start(store, runs)
        try:
            status = process.wait(chance.uniform(0, longest))
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
            blocks = acknowledged(store, reference_contents)
            tally.kills[blocks] += 1
            tally.acknowledged += blocks
            continue
        assert status == 0, f"the resumed batch ended with status {status}"
        finish(store, reference_contents)
        tally.stores += 1
    assert start(store, runs).wait() == 0
    finish(store, reference_contents)
    tally.stores += 1
    return tally


def start(store: Path, runs: int) -> subprocess.Popen[bytes]:
    """Start the batch, or resume it."""
    command = [sys.executable, "-m", "mehvar", "batch", *MODEL, "-n", str(runs), *VARY, "--out", str(store), "--resume"]
    return subprocess.Popen(command, stdout=subprocess.DEVNULL)


def finish(store: Path, reference_contents: dict[str, bytes]) -> None:
    """Compare a complete store, and remove it."""
    result = contents(store)
    assert result.keys() == reference_contents.keys(), sorted(result.keys() ^ reference_contents.keys())[:5]
    different = [name for name in reference_contents if result[name] != reference_contents[name]]
    assert not different, different[:5]
    shutil.rmtree(store)


def acknowledged(store: Path, reference_contents: dict[str, bytes]) -> int:
    """Compare every file of the acknowledged blocks; return how many blocks there are."""
    result = contents(store) if store.exists() else {}
    blocks = {Path(name).stem for name in result if name.startswith("records/") and Path(name).stem.isdigit()}
    for block in blocks:
        names = [
            name
            for name in reference_contents
            if name == f"records/{block}.json"
            or (name.split("/")[1:3] == ["c", block] and name.split("/")[0] not in COORDINATES)
        ]
        for name in names:
            assert result.get(name) == reference_contents[name], f"{name} of an acknowledged block differs"
    return len(blocks)


COORDINATES = ("state", "variable", "t")


def contents(store: Path) -> dict[str, bytes]:
    """Return the bytes of every file of a store by its place."""
    return {path.relative_to(store).as_posix(): path.read_bytes() for path in store.rglob("*") if path.is_file()}


if __name__ == "__main__":
    main()
