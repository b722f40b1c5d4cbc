# SPDX-License-Identifier: Apache-2.0
"""Draw mutants, run their tests on a copy of the tree, and record the outcomes."""

from __future__ import annotations

import fcntl
import hashlib
import json
import shutil
import sys
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence
from itertools import islice
from pathlib import Path
from typing import Any

from tests.mutants import c_operators, python_operators, trial
from tests.mutants.records import RESULTS, ROOT, Mutant, Result, Subject, line_of, read

WORK = ROOT / "build" / "mutants"
_COPIED = ("mehvar", "models", "codegen", "generated", "runtime", "papers", "tests", "docs", "benchmarks",
           "pyproject.toml", "version.py", "Makefile", "README.md", "CHANGELOG.md")  # fmt: skip
_TWICE = 2.0
"""Time limit of a mutant as a multiple of its tests' time, plus ten seconds for compilation."""


def draw(subject: Subject) -> Iterator[Mutant]:
    """Yield up to `draw` mutants of a subject, in an order that depends only on the lines."""
    return islice(mutants_of(subject.modules), subject.draw)


def mutants_of(modules: Sequence[str], seed: str = "") -> Iterator[Mutant]:
    """Yield every mutant of modules once, in an order that depends only on a seed and the lines."""
    texts = {module: (ROOT / module).read_text(encoding="utf-8") for module in modules}
    keys: set[str] = set()
    for module, place in _in_order(texts, seed):
        start, end, replacement = _operators(module).mutate(texts[module], place)
        mutant = _mutant(module, texts[module], start, end, replacement)
        if mutant.before != mutant.after and mutant.key not in keys:
            keys.add(mutant.key)
            yield mutant


def _in_order(texts: Mapping[str, str], seed: str) -> list[tuple[str, Any]]:
    """Order mutants by a digest of line and change, so that edits of other lines do not change the selection."""
    ranks: list[tuple[bytes, str, Any]] = []
    seen: Counter[str] = Counter()
    for module, text in texts.items():
        lines = text.splitlines()
        for number, change, place in _operators(module).places(text):
            name = f"{module} {_plain(lines[number - 1])} {change}"
            seen[name] += 1
            ranks.append((hashlib.sha256(f"{seed}{name} {seen[name]}".encode()).digest(), module, place))
    return [(module, place) for _, module, place in sorted(ranks)]


def _operators(module: str) -> Any:
    return python_operators if module.endswith(".py") else c_operators


def _mutant(module: str, text: str, start: int, end: int, replacement: str) -> Mutant:
    first, last = text.rfind("\n", 0, start) + 1, text.find("\n", max(start, end - 1))
    before, after = text[first:last], text[first:start] + replacement + text[end:last]
    return Mutant(module, text.count("\n", 0, start) + 1, _plain(before), _plain(after), start, end, replacement)


def _plain(text: str) -> str:
    return " ".join(text.split())


class Campaign:
    """A copy of the tree with one mutant at a time, and the committed file of results."""

    def __init__(self, file: Path = RESULTS) -> None:
        self._tree, self._file, self._plain_file = WORK / "tree", file, WORK / "plain.json"
        self._plain_runs: dict[str, Any] = _json(self._plain_file)
        self._results = {result.key: result for result in read(self._file)}
        self._kills = Counter((result.module, result.killer) for result in self._results.values())
        self._copied = False
        self._green: set[str] = set()
        self._red: set[str] = set()

    @property
    def results(self) -> list[Result]:
        """Last result of each mutant."""
        return list(self._results.values())

    def keep(self, drawn: set[str]) -> None:
        """Remove results of mutants that are no longer drawn, such as those of edited lines."""
        self._results = {key: result for key, result in self._results.items() if key in drawn}
        self._file.write_text("".join(map(line_of, self.results)), encoding="utf-8")

    def is_open(self, mutant: Mutant) -> bool:
        """Return True if a mutant has no result yet."""
        return mutant.key not in self._results

    def decide(self, subject: Subject, mutant: Mutant) -> None:
        """Try a mutant."""
        self._prepare()
        names, failing, seconds = ({}, [], 0.0) if subject.limit else self._plain(subject)
        rank = defaultdict[str, float](float, names)
        for (module, name), kills in self._kills.items():
            rank[name] -= 1e6 * kills * (module == mutant.module)
        path = self._tree / mutant.module
        text = path.read_text(encoding="utf-8")
        without = [*failing, *subject.without, *self._red]
        limit = subject.limit or seconds * _TWICE + 10
        while True:
            path.write_text(text[: mutant.start] + mutant.replacement + text[mutant.end :], encoding="utf-8")
            try:
                done = trial.run(self._tree, subject.tests, WORK, without, rank, limit)
            finally:
                path.write_text(text, encoding="utf-8")
            killer = next((test.name for test in done.tests if test.failed), "")
            if not killer or self._is_green(killer):
                break
            without.append(killer)
        last = next((test for test in done.tests if test.failed), None)
        late = "survived" if subject.limit else "timeout"
        outcome = {"passed": "survived", "failed": "killed", "timeout": late}[done.outcome]
        if last and last.refused and mutant.module.endswith((".c", ".h")):
            outcome = "refused"
        fields = (mutant.module, mutant.line, mutant.before, mutant.after, outcome, last.name if last else "")
        self._remember(Result(subject.area, *fields, round(done.seconds, 1)))

    def _is_green(self, test: str) -> bool:
        """Return True if a test passes without a mutant; failing tests are not used."""
        if test not in self._green | self._red:
            passes = trial.run(self._tree, [test], WORK).outcome == "passed"
            (self._green if passes else self._red).add(test)
        return test in self._green

    def _remember(self, result: Result) -> None:
        self._results[result.key] = result
        self._kills[result.module, result.killer] += 1
        with self._file.open("a", encoding="utf-8") as file:
            file.write(line_of(result))
        print(f"{result.outcome:9}{result.seconds:6.1f} s  {result.key}", file=sys.stderr, flush=True)

    def _prepare(self) -> None:
        """Copy the tree, once, and load the libraries. Two campaigns in one tree would try two mutants at once."""
        if self._copied:
            return
        WORK.mkdir(parents=True, exist_ok=True)
        self._lock = (WORK / "lock").open("w")
        try:
            fcntl.lockf(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)  # not inherited by a trial
        except OSError:
            raise SystemExit(f"another campaign runs in {WORK}") from None
        shutil.rmtree(self._tree, ignore_errors=True)
        self._tree.mkdir(parents=True)
        for name in _COPIED:
            if (ROOT / name).is_dir():  # links stay links: a copy of a room in the package would hide its mutants
                shutil.copytree(ROOT / name, self._tree / name, symlinks=True)
            else:
                shutil.copy(ROOT / name, self._tree / name)
        trial.preload()
        self._copied = True

    def _plain(self, subject: Subject) -> tuple[dict[str, float], list[str], float]:
        """Return the time of each test without a mutant, s, the failing tests, and the total time.

        They run once with an empty cache, as every mutant of C does.
        """
        name = " ".join(subject.tests)
        if name not in self._plain_runs:
            done = trial.run(self._tree, subject.tests, WORK, subject.without)
            if not done.tests or done.outcome == "timeout":
                raise SystemExit(f"{done.outcome}: {(WORK / 'output').read_text(encoding='utf-8')[-2000:]}")
            times = {test.name: test.seconds for test in done.tests}
            failing = [test.name for test in done.tests if test.failed]
            self._plain_runs[name] = times, failing, done.seconds
            self._plain_file.write_text(json.dumps(self._plain_runs), encoding="utf-8")
            print(f"{done.seconds:.0f} s without a mutant; failing: {failing}", file=sys.stderr, flush=True)
        times, failing, seconds = self._plain_runs[name]
        return times, failing, seconds


def _json(path: Path) -> Any:
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
