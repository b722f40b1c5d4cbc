# SPDX-License-Identifier: Apache-2.0
"""Campaigns of edited systems: each edited system is refused by name, or its generated code runs."""

from __future__ import annotations

import random
import re
import traceback
from collections.abc import Iterator
from itertools import islice
from pathlib import Path

from mehvar.base.manifest import FILE, manifest_text
from mehvar.codegen.code.files import code_files, printed_functions
from mehvar.codegen.functions.graphs import generate_functions
from mehvar.codegen.functions.verify import VerificationError, check_counterparts, verify
from mehvar.codegen.manifest import manifest_of
from mehvar.models.check import check
from mehvar.models.clock import with_clock
from mehvar.models.forms import with_mass
from mehvar.models.system import ModelError, System
from mehvar.runtime import load
from tests.fuzz.campaign import Outcome
from tests.gates.test_sanitizers import watched
from tests.models import exercise_edits
from tests.models.edits import Edit, edits

_PLACED = re.compile(r"\S+\.py:\d+: .+", re.DOTALL)
"""Beginning of a message with file and line."""


def edited(base: System, seed: str, count: int, folder: Path) -> Outcome:
    """Edit a system; run accepted systems in Python."""
    outcome = Outcome()
    for k, edit in enumerate(islice(edits(base, random.Random(seed)), count)):
        try:
            refusal = _refusal(edit.system)
            outcome.counts["refused" if refusal else "taken"] += 1
            if refusal:
                assert _PLACED.match(refusal), refusal
            else:
                exercise_edits.run(load(_written(edit.system, folder / str(k)), "python"))
        except Exception:
            outcome.findings.append(f"{base.name} {seed}, {edit.path} {edit.what}:\n{traceback.format_exc()[-1500:]}")
    return outcome


def sanitized(base: System, seed: str, count: int, folder: Path) -> Outcome:
    """Generate edited systems, and run their C in a process with sanitizers."""
    chosen = list(islice(_accepted(base, seed), count))
    folders = [_written(edit.system, folder / f"{k}") for k, edit in enumerate(chosen)]
    done = watched(folder, "gcc", [exercise_edits.__file__, *map(str, folders)])
    outcome = Outcome()
    if (done.returncode, done.stdout) == (0, f"{count} systems\n"):
        outcome.counts["watched"] += count
    else:
        made = "\n".join(f"{path}: {edit.path} {edit.what}" for path, edit in zip(folders, chosen, strict=True))
        outcome.findings.append(f"{base.name} {seed}, status {done.returncode}:\n{made}\n{done.stderr[-4000:]}")
    return outcome


def _accepted(base: System, seed: str) -> Iterator[Edit]:
    return (edit for edit in edits(base, random.Random(seed)) if not _refusal(edit.system))


def _refusal(system: System) -> str:
    try:
        check(system)
        verify(system)
    except (ModelError, VerificationError) as error:
        return str(error)
    return ""


def _written(system: System, folder: Path) -> Path:
    check_counterparts(system)
    system = with_clock(with_mass(system))
    functions = printed_functions(generate_functions(system))
    manifest = manifest_of(system, functions, {})
    folder.mkdir()
    for name, text in {**code_files(manifest, functions), FILE: manifest_text(manifest)}.items():
        (folder / name).write_text(text)
    return folder
