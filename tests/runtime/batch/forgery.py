# SPDX-License-Identifier: Apache-2.0
"""Stores that were changed together with their records, which are not signatures."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from mehvar.runtime.batch.store.attributes import IDENTITY, batch_hash
from mehvar.runtime.batch.store.records import END, STORE, block_record, digest, file_digest


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
        identity = {key: attributes[key] for key in IDENTITY if key in attributes}
        facts["about"] |= {"batch": batch_hash(identity, facts["about"]["chunk"]), **about}
        facts["files"] = {file: file_digest(store / file) for file in facts["files"]}
        facts.pop("sha256")
        content = json.dumps(facts, indent=1, sort_keys=True, ensure_ascii=False) + "\n"
        facts["sha256"] = digest(content.encode())
        (store / name).write_text(json.dumps(facts, indent=1, sort_keys=True, ensure_ascii=False) + "\n")
