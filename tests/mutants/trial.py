# SPDX-License-Identifier: Apache-2.0
"""Run tests on a tree in a separate process, earlier killers first, and return the outcome.

The process parts from one that has loaded the libraries, which no mutant changes, and imports the tree itself.
"""

from __future__ import annotations

import contextlib
import importlib
import json
import os
import resource
import signal
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

from tests import commands

_LIBRARIES = ("scipy.stats", "hypothesis", "pytest")
_LIMIT = 10**6
"""Processor time of tests without earlier records, s."""
_PATIENCE = 20.0
"""Time without a running process after which a trial counts as hanging, s. The longest wait of a test
is of 10 s; twice as long would only make a mutant that hangs dearer."""
_POLL = 0.3
_TICK = os.sysconf("SC_CLK_TCK")


@dataclass(frozen=True)
class Test:
    """Time of a test, in seconds, and whether it failed."""

    name: str
    seconds: float
    failed: bool
    refused: bool
    """True if the test failed because a compiler refused the code."""


@dataclass(frozen=True)
class Trial:
    """Outcome of the tests: passed, failed or timeout; those that ran, in order; processor time in seconds."""

    outcome: str
    tests: tuple[Test, ...]
    seconds: float


def preload() -> None:
    """Load the modules that all trials use."""
    commands.load()
    for name in _LIBRARIES:
        importlib.import_module(name)


def run(
    tree: Path,
    tests: Sequence[str],
    work: Path,
    without: Sequence[str] = (),
    rank: Mapping[str, float] | None = None,
    limit: float = _LIMIT,
) -> Trial:
    """Run tests on a tree.

    Parameters
    ----------
    tree : Path
        A copy of the repository's folders.
    tests : sequence of str
        Files or names, as pytest takes them.
    work : Path
        Folder of the cache, of temporary files and of the output.
    without : sequence of str
        Names of tests that are left out.
    rank : mapping, optional
        Tests run in the order of these numbers, up to the first that fails; by default all run.
    limit : float
        Seconds of processor time, of all processes together.
    """
    log, before = work / "tests.jsonl", _processor_time()
    log.unlink(missing_ok=True)
    process = os.fork()
    if process == 0:
        _test(tree, tests, work, without, rank, limit)
    outcome, group = _end(process, limit)
    lines = log.read_text(encoding="utf-8").splitlines() if log.exists() else []
    return Trial(outcome, tuple(Test(**json.loads(line)) for line in lines), max(group, _processor_time() - before))


def _processor_time() -> float:
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def _end(process: int, limit: float) -> tuple[str, float]:
    """Wait for a process; return its outcome and the processor time of its process group.

    The group is killed when it has had its time, or waits for nothing.
    """
    active, used = time.monotonic(), 0.0
    try:
        while True:
            done, status = os.waitpid(process, os.WNOHANG)
            if done:
                slow = os.WIFSIGNALED(status) and os.WTERMSIG(status) in (signal.SIGXCPU, signal.SIGKILL)
                return "timeout" if slow else "failed" if status else "passed", used
            group = list(_group(process))
            if any(state != "S" for state, _ in group):
                active = time.monotonic()
            used = max(used, sum(seconds for _, seconds in group))
            if time.monotonic() - active > _PATIENCE or used > limit:
                os.killpg(process, signal.SIGKILL)
            time.sleep(_POLL)
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process, signal.SIGKILL)


def _group(group: int) -> Iterator[tuple[str, float]]:
    """Yield the state of each process of a group (S: waiting) and its processor time so far.

    The time is its own and that of children that ended, as compilers.
    """
    for path in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            state, _parent, its_group, *rest = path.read_text().rpartition(")")[2].split()
            if int(its_group) == group:
                yield state, sum(map(int, rest[8:12])) / _TICK


class _Log:
    """A pytest plugin that orders the tests and records their outcomes."""

    def __init__(self, path: Path, rank: Mapping[str, float], tests: Sequence[str]) -> None:
        self._path, self._rank, self._tests = path, rank, tests

    def pytest_collection_modifyitems(self, items: list[Any]) -> None:
        items.sort(key=lambda item: (self._rank.get(item.nodeid, 0.0), self._place(item.nodeid)))

    def _place(self, name: str) -> int:
        """Return the file or folder that contains a test."""
        return next((k for k, test in enumerate(self._tests) if name.startswith(test)), len(self._tests))

    def pytest_runtest_logreport(self, report: Any) -> None:
        self._write(report, report.when == "call" or report.failed)

    def pytest_collectreport(self, report: Any) -> None:
        self._write(report, report.failed)

    def _write(self, report: Any, worth: bool) -> None:
        if worth:
            refused = report.failed and "BuildError" in report.longreprtext
            test = {"name": report.nodeid, "failed": report.failed, "refused": refused}
            with self._path.open("a", encoding="utf-8") as file:
                file.write(json.dumps(test | {"seconds": round(getattr(report, "duration", 0.0), 2)}) + "\n")


def _test(
    tree: Path,
    tests: Sequence[str],
    work: Path,
    without: Sequence[str],
    rank: Mapping[str, float] | None,
    limit: float,
) -> NoReturn:
    status = 1
    try:
        import hypothesis
        import pytest

        # an example that fails is enough: the smallest of its kind costs minutes and is read by nobody
        phases = (hypothesis.Phase.explicit, hypothesis.Phase.generate)
        hypothesis.settings.register_profile("mutants", phases=phases, database=None, derandomize=True)
        hypothesis.settings.load_profile("mutants")
        os.setpgid(0, 0)  # a session of its own would leave the priority that was given to the campaign
        resource.setrlimit(resource.RLIMIT_CPU, (int(limit), int(limit) + 5))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        os.chdir(tree)
        sys.path.insert(0, str(tree))
        sys.modules["tests"].__path__ = [str(tree / "tests")]
        silent = os.open(work / "output", os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        os.dup2(silent, 1)
        os.dup2(silent, 2)
        os.environ |= {"PYTHONPATH": str(tree), "MEHVAR_TEST_CACHE": str(work / "cache"), "OPENBLAS_NUM_THREADS": "1"}
        sys.dont_write_bytecode = True
        commands.python()  # before anything of the tree is imported: from a fork, not from four seconds of imports
        arguments = ["-q", "--assert=plain", "-p", "no:cacheprovider", f"--basetemp={work / 'pytest'}", *tests]
        arguments += [f"--deselect={name}" if "::" in name else f"--ignore={name}" for name in without]
        arguments += [] if rank is None else ["-x"]
        status = int(pytest.main(arguments, plugins=[_Log(work / "tests.jsonl", rank or {}, tests)]))
    finally:
        os._exit(status)
