# SPDX-License-Identifier: Apache-2.0
"""Draw mutants, run the tests that concern them on a copy of the tree, and remember what happened."""

from __future__ import annotations

import contextlib
import dataclasses
import importlib
import json
import os
import random
import shutil
import signal
import sys
import time
import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

from tests.mutants import c_operators, python_operators

ROOT = Path(__file__).parents[2]
WORK = ROOT / "build" / "mutants"
_LIBRARIES = ("numpy", "scipy.integrate", "xarray", "zarr", "h5netcdf", "pandas")
"""Loaded once, before the processes that run tests part."""
_OWN = ("mehvar", "mehvar.runtime", "mehvar.runtime.batch.fill", "mehvar.runtime.batch.statistics")
"""Likewise, of the copy, where C is mutated and Python is not."""
_COPIED = ("mehvar", "models", "codegen", "generated", "runtime", "tests", "pyproject.toml")
_TWICE = 2.0
"""A mutant has so many times the seconds of its tests without one, and ten more: it compiles anew, in company."""


@dataclass(frozen=True)
class Subject:
    """Modules that are mutated alike: how many mutants are drawn, and the tests that concern them.

    `tests` are tried first, but those in `slow`; what they let live meets `more`.
    """

    area: str
    modules: tuple[str, ...]
    draw: int
    tests: tuple[str, ...]
    more: tuple[str, ...] = ()
    slow: tuple[str, ...] = ()

    @property
    def python(self) -> bool:
        """Whether Python is mutated, not C."""
        return self.modules[0].endswith(".py")


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
        """Say which mutant it is; it stays while the text around it does."""
        return f"{self.module}: {self.before} -> {self.after}"


@dataclass(frozen=True)
class Result:
    """What the tests said: killed, timeout (which also kills) or survived."""

    area: str
    module: str
    line: int
    before: str
    after: str
    outcome: str
    killer: str
    seconds: float


def subjects() -> list[Subject]:
    """Read subjects.toml."""
    rows = tomllib.loads((Path(__file__).parent / "subjects.toml").read_text(encoding="utf-8"))["subject"]
    return [Subject(**{key: tuple(v) if isinstance(v, list) else v for key, v in row.items()}) for row in rows]


def draw(subject: Subject) -> Iterator[Mutant]:
    """Yield the mutants of a subject that are tried: in an order that the texts fix, up to `draw` of them."""
    texts = {module: (ROOT / module).read_text(encoding="utf-8") for module in subject.modules}
    every = [(module, place) for module, text in texts.items() for place in _operators(module).places(text)]
    random.Random(" ".join(subject.modules)).shuffle(every)
    keys: set[str] = set()
    for module, place in every:
        start, end, replacement = _operators(module).mutate(texts[module], place)
        mutant = _mutant(module, texts[module], start, end, replacement)
        idle = mutant.before == mutant.after or mutant.before.startswith("@dataclass")  # frozen is for the type checker
        if not idle and mutant.key not in keys:
            keys.add(mutant.key)
            yield mutant
        if len(keys) == subject.draw:
            return


def _operators(module: str) -> Any:
    return python_operators if module.endswith(".py") else c_operators


def _mutant(module: str, text: str, start: int, end: int, replacement: str) -> Mutant:
    first, last = text.rfind("\n", 0, start) + 1, text.find("\n", max(start, end - 1))
    before, after = text[first:last], text[first:start] + replacement + text[end:last]
    return Mutant(module, text.count("\n", 0, start) + 1, _plain(before), _plain(after), start, end, replacement)


def _plain(text: str) -> str:
    return " ".join(text.split())


class Campaign:
    """A copy of the tree in which one module at a time is wrong, and the file of results."""

    def __init__(self) -> None:
        self._tree, self._file = WORK / "tree", WORK / "results.jsonl"
        self._baseline_file = WORK / "baseline.json"
        text = self._baseline_file.read_text(encoding="utf-8") if self._baseline_file.exists() else "{}"
        self._baselines: dict[str, tuple[list[str], float]] = json.loads(text)
        self._known = {_key(result) for result in self.results()}
        self._copied = False

    def results(self) -> list[Result]:
        """Read the file of results."""
        lines = self._file.read_text(encoding="utf-8").splitlines() if self._file.exists() else []
        return [Result(**json.loads(line)) for line in lines]

    def decide(self, subject: Subject, mutant: Mutant) -> None:
        """Try a mutant that has no result yet."""
        if mutant.key in self._known:
            return
        self._prepare(subject)
        path = self._tree / mutant.module
        text = path.read_text(encoding="utf-8")
        start = time.monotonic()
        outcome, killer = "survived", ""
        for tests in filter(None, (subject.tests, subject.more)):
            failing, seconds = self._baseline(tests, subject.slow)
            path.write_text(text[: mutant.start] + mutant.replacement + text[mutant.end :], encoding="utf-8")
            try:
                outcome, killer = self._run(tests, [*failing, *subject.slow], seconds * _TWICE + 10)
            finally:
                path.write_text(text, encoding="utf-8")
            if outcome != "survived":
                break
        fields = (mutant.module, mutant.line, mutant.before, mutant.after, outcome, killer)
        self._remember(Result(subject.area, *fields, round(time.monotonic() - start, 1)))

    def _remember(self, result: Result) -> None:
        self._known.add(_key(result))
        with self._file.open("a", encoding="utf-8") as file:
            file.write(json.dumps(dataclasses.asdict(result)) + "\n")
        print(f"{result.outcome:9}{result.seconds:6.1f} s  {_key(result)}", file=sys.stderr, flush=True)

    def _prepare(self, subject: Subject) -> None:
        """Copy the tree, once, and load what no mutant of the subject changes."""
        if not self._copied:
            shutil.rmtree(self._tree, ignore_errors=True)
            self._tree.mkdir(parents=True)
            for name in _COPIED:
                copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy
                copy(ROOT / name, self._tree / name)
            for name in _LIBRARIES:
                importlib.import_module(name)
            sys.path.insert(0, str(self._tree))
            self._copied = True
        if not subject.python:
            for name in _OWN:
                importlib.import_module(name)

    def _baseline(self, tests: tuple[str, ...], slow: tuple[str, ...]) -> tuple[list[str], float]:
        """Return the tests that fail without a mutant, which tell nothing about one, and the seconds of them all."""
        name = " ".join(tests)
        if name not in self._baselines:
            report, start = WORK / "failing", time.monotonic()
            outcome, _ = self._run(tests, slow, 600, report)
            failing = report.read_text(encoding="utf-8").split("\n")[:-1]
            if outcome != "survived" and not failing:
                raise SystemExit(
                    f"{outcome} without a mutant:\n{(WORK / 'output').read_text(encoding='utf-8')[-2000:]}"
                )
            self._baselines[name] = failing, time.monotonic() - start
            self._baseline_file.write_text(json.dumps(self._baselines), encoding="utf-8")
            print(f"{self._baselines[name][1]:.0f} s without a mutant; failing: {failing}", file=sys.stderr, flush=True)
        return self._baselines[name]

    def _run(
        self, tests: tuple[str, ...], skipped: Sequence[str], limit: float, report: Path | None = None
    ) -> tuple[str, str]:
        killer = WORK / "killer"
        killer.unlink(missing_ok=True)
        process = os.fork()
        if process == 0:
            _test(self._tree, tests, skipped, killer, report)
        outcome, end = "timeout", time.monotonic() + limit
        while time.monotonic() < end:
            done, status = os.waitpid(process, os.WNOHANG)
            if done:
                outcome = "killed" if status else "survived"
                break
            time.sleep(0.02)
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process, signal.SIGKILL)
        if outcome == "timeout":
            os.waitpid(process, 0)
        return outcome, killer.read_text(encoding="utf-8").split("\n")[0] if killer.exists() else ""


def _key(result: Result) -> str:
    return f"{result.module}: {result.before} -> {result.after}"


class _Watch:
    """A pytest plugin that names the tests that fail."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def pytest_runtest_logreport(self, report: Any) -> None:
        if report.failed:
            with self._path.open("a", encoding="utf-8") as file:
                file.write(report.nodeid + "\n")


def _test(tree: Path, tests: tuple[str, ...], skipped: Sequence[str], killer: Path, report: Path | None) -> NoReturn:
    """Run in a process of its own: the tests on the tree, up to the first that fails unless all are wanted."""
    status = 1
    try:
        import pytest

        os.setsid()
        os.chdir(tree)
        silent = os.open(WORK / "output", os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        os.dup2(silent, 1)
        os.dup2(silent, 2)
        os.environ |= {"PYTHONPATH": str(tree), "MEHVAR_TEST_CACHE": str(WORK / "cache"), "OPENBLAS_NUM_THREADS": "1"}
        sys.dont_write_bytecode = True
        arguments = ["-q", "--assert=plain", "-p", "no:cacheprovider", f"--basetemp={WORK / 'pytest'}", *tests]
        arguments += [f"--deselect={name}" for name in skipped]
        if report is None:
            arguments.append("-x")
        else:
            report.write_text("", encoding="utf-8")
        status = pytest.main(arguments, plugins=[_Watch(report or killer)])
    finally:
        os._exit(status)
