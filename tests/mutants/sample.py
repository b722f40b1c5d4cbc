# SPDX-License-Identifier: Apache-2.0
"""A sample of mutants over whole folders, drawn with a seed, and tried by the tests closest to each module."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from fnmatch import fnmatch
from itertools import islice
from pathlib import Path
from typing import Any

from tests.mutants.campaign import mutants_of
from tests.mutants.records import ROOT, Mutant, Subject

_PLAN = Path(__file__).parent / "closest.toml"


def sample(size: int, seed: int) -> list[tuple[Subject, Mutant]]:
    """Return mutants of the folders of closest.toml, drawn uniformly over all places.

    The order follows from the seed and the lines alone, so that an edit elsewhere leaves the others drawn.
    """
    plan = tomllib.loads(_PLAN.read_text(encoding="utf-8"))
    drawn = islice(mutants_of(list(_modules(plan)), f"{seed} "), size)
    return [(closest(mutant.module, plan), mutant) for mutant in drawn]


def closest(module: str, plan: dict[str, Any]) -> Subject:
    """Return the tests of the first rule for a module, preceded by the test of the same name."""
    rule = next(rule for rule in plan["closest"] if any(fnmatch(module, pattern) for pattern in rule["modules"]))
    path = Path(module)
    mirror = (Path("tests") / path.parent / f"test_{path.stem}.py").as_posix()
    own = [mirror] if (ROOT / mirror).is_file() and mirror not in rule["tests"] else []
    tests = tuple(dict.fromkeys([*own, *rule["tests"]]))
    return Subject("sample", (module,), 0, tests, tuple(plan["without"]), plan["limit"])


def _modules(plan: dict[str, Any]) -> Iterator[str]:
    for folder in plan["folders"]:
        for path in sorted((ROOT / folder).rglob("*")):
            module = path.relative_to(ROOT).as_posix()
            skipped = any(fnmatch(module, pattern) for pattern in plan["skipped"])
            if path.suffix in (".py", ".c", ".h") and not skipped:
                yield module
