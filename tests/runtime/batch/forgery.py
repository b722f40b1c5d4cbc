# SPDX-License-Identifier: Apache-2.0
"""A store to damage or to change together with its records, which are not signatures."""

from __future__ import annotations

import json
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

from mehvar.runtime.batch.fill import run_batch
from mehvar.runtime.batch.plan import Campaign
from mehvar.runtime.batch.store.attributes import batch_hash
from mehvar.runtime.batch.store.records import END, STORE, DamageError, block_record, digest, file_digest
from mehvar.runtime.batch.store.verification import verify

PENDULUM = Path(__file__).parents[1] / "pendulum"
CAMPAIGN = Campaign("pd", n=40, vary={"g": "uniform(-2, 9)"}, options={"t_end": 0.1}, save_every=0.05)
CHUNK = 16


def edit(file: Path, change: Callable[[dict[str, Any]], object]) -> None:
    """Change a file of JSON."""
    content = json.loads(file.read_bytes())
    change(content)
    file.write_text(json.dumps(content))


def seal(store: Path, **about: Any) -> None:
    """Write the digests of a store's files, and given facts, into its records."""
    attributes = json.loads((store / "zarr.json").read_bytes()).get("attributes", {})
    names = [STORE, *(block_record(b) for b in range(999) if (store / block_record(b)).exists()), END]
    for name in names:
        facts = json.loads((store / name).read_bytes())
        facts["about"] |= {"batch": batch_hash(attributes, facts["about"]["chunk"]), **about}
        facts["files"] = {file: file_digest(store / file) for file in facts["files"]}
        facts.pop("sha256")
        content = json.dumps(facts, indent=1, sort_keys=True, ensure_ascii=False) + "\n"
        facts["sha256"] = digest(content.encode())
        (store / name).write_text(json.dumps(facts, indent=1, sort_keys=True, ensure_ascii=False) + "\n")


def is_complete(store: Path) -> bool:
    """Return the verdict on a store; one whose own record is not intact is refused."""
    try:
        return verify(store).complete
    except DamageError:
        return False


def remove(path: Path) -> None:
    path.unlink()


def flip(path: Path) -> None:
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 4
    path.write_bytes(content)


def cut(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-3])


def empty(path: Path) -> None:
    path.write_bytes(b"")


DAMAGES = (remove, flip, cut, empty)


def contents(folder: Path) -> dict[str, bytes]:
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def mend(store: Path) -> list[str]:
    """Resume; return what was said."""
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        run_batch(PENDULUM, CAMPAIGN, store, resume=True)
    return [str(warning.message) for warning in said]
