# SPDX-License-Identifier: Apache-2.0
"""Subjects, mutants, and the committed files of their results."""

from __future__ import annotations

import dataclasses
import json
import tomllib
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
RESULTS = Path(__file__).parent / "results.jsonl"


@dataclass(frozen=True)
class Subject:
    """Modules with common settings: number of mutants, their tests, and excluded tests."""

    area: str
    modules: tuple[str, ...]
    draw: int
    tests: tuple[str, ...]
    without: tuple[str, ...] = ()
    limit: float = 0.0
    """Processor time after which a mutant survives, s; by default twice the time of its tests kills it."""


@dataclass(frozen=True)
class Mutant:
    """One replacement in one module, with the line before and after it, which name it in lists."""

    module: str
    line: int
    before: str
    after: str
    start: int
    end: int
    replacement: str

    @property
    def key(self) -> str:
        """Return the key of the mutant, which depends only on its line and change."""
        return f"{self.module}: {self.before} -> {self.after}"


@dataclass(frozen=True)
class Result:
    """Outcome of the tests: killed, timeout (which also kills), refused (it does not compile) or survived.

    `seconds` are of processor time.
    """

    area: str
    module: str
    line: int
    before: str
    after: str
    outcome: str
    killer: str
    seconds: float

    @property
    def key(self) -> str:
        """Return the key of the mutant."""
        return f"{self.module}: {self.before} -> {self.after}"


def subjects() -> list[Subject]:
    """Read subjects.toml."""
    rows = tomllib.loads((Path(__file__).parent / "subjects.toml").read_text(encoding="utf-8"))["subject"]
    return [Subject(**{key: tuple(v) if isinstance(v, list) else v for key, v in row.items()}) for row in rows]


def sample_file(seed: int) -> Path:
    """Return the file of a seed's results."""
    return Path(__file__).parent / f"sample-{seed}.jsonl"


def line_of(result: Result) -> str:
    """Return the line of a file of results."""
    return json.dumps(dataclasses.asdict(result)) + "\n"


def read(path: Path) -> list[Result]:
    """Read a file of results: the last of each mutant."""
    lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
    results = [Result(**json.loads(line)) for line in lines]
    return list({result.key: result for result in results}.values())
