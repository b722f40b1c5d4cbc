# SPDX-License-Identifier: Apache-2.0
"""Distribution of the tests over processes, the longest first, and the cache that all share.

A process has the tests of a module, which share fixtures; all of the papers and their report, which share runs; all of
one model, which share what is derived; a page of the documentation, which shares nothing.
"""

from __future__ import annotations

import gc
import multiprocessing.spawn
import os
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import hypothesis
import pytest

from tests import commands

gc.disable()  # while modules are imported and tests are collected
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # for the processes of the run: idle threads wait in a loop
os.environ.setdefault("SYMPY_CACHE_SIZE", "10000")  # ten times its default: saves a tenth of deriving and comparing

hypothesis.settings.register_profile("any load", deadline=None)
hypothesis.settings.load_profile("any load")

PAPERS = (
    *("tests/papers/", "tests/mehvar/report/test_backends.py"),
    *("tests/mehvar/reproduction/test_ledger_page.py", "tests/mehvar/cli/test_reproduce.py"),
)
TOGETHER = (PAPERS, ("tests/models/slosh/",), ("tests/mehvar/physics/",))
PAGES = "tests/docs/test_docs.py::test_what_a_page_shows_runs["
LONG = (
    *PAPERS,
    "tests/mehvar/comparison/",
    "tests/mehvar/test_effects.py",
    "tests/codegen/test_generate.py",
    "tests/codegen/test_oracle.py",
    "tests/models/slosh/",
    "tests/runtime/board/",
    "tests/examples/",
    "tests/mehvar/cli/test_batch.py",
    "tests/codegen/diff/",
    "tests/gates/",
    PAGES,
)
"""Modules that take a minute or more; they start first, so that no process is idle at the end."""


_CASES: Counter[str] = Counter()


@pytest.hookimpl(optionalhook=True)
def pytest_configure_node(node: Any) -> None:
    """Name the server of commands to a process of the run; it imports while they collect."""
    node.workerinput["python"] = commands.started()


def pytest_configure(config: pytest.Config) -> None:
    """Use that server; report briefly."""
    commands.adopt(getattr(config, "workerinput", {}).get("python", ""))
    for plugin in config.pluginmanager.get_plugins():
        if type(plugin).__name__ == "WorkerInteractor":
            _report_briefly(plugin)


def _report_briefly(interactor: Any) -> None:
    """Send one message for a test that passed, where xdist sends six; this saves a millisecond of two processors."""
    send = interactor.sendevent

    def sendevent(name: str, **facts: Any) -> None:
        if name == "testreport":
            report = facts["data"]
            if report["when"] != "call" and report["outcome"] == "passed" and report["duration"] < 0.1:
                return
        if name not in ("logstart", "logfinish"):
            send(name, **facts)

    interactor.sendevent = sendevent


def pytest_itemcollected(item: pytest.Item) -> None:
    """Move the cases of a test beyond its `share` to soak."""
    if share := item.get_closest_marker("share"):
        test = item.nodeid.partition("[")[0]
        if _CASES[test] % share.args[0]:
            item.add_marker(pytest.mark.soak)
        _CASES[test] += 1


def _place(item: pytest.Item) -> int:
    return next((k for k, start in enumerate(LONG) if item.nodeid.startswith(start)), len(LONG))


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Sort tests by expected time, longest first; the sort is stable."""
    items.sort(key=_place)


def pytest_collection_finish() -> None:
    """Collect garbage rarely, and never imported objects; this saves a sixth of the time of deriving."""
    gc.freeze()
    gc.set_threshold(100_000, 20, 100)
    gc.enable()


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Schedule by module; some folders as a whole, pages one by one."""
    from xdist.scheduler import LoadScopeScheduling

    class ByModule(LoadScopeScheduling):  # type: ignore[misc]  # xdist has no annotations
        def _split_scope(self, nodeid: str) -> str:
            if nodeid.startswith(PAGES):
                return nodeid
            together = (places[0] for places in TOGETHER if nodeid.startswith(places))
            return next(together, None) or str(super()._split_scope(nodeid))

    config.option.loadscopereorder = False  # which would begin with the modules that have most tests
    return ByModule(config, log) if config.getvalue("dist") == "loadscope" else None


@pytest.fixture(scope="session", autouse=True)
def _cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Set a cache that all processes of this run share, empty at the start."""
    own = tmp_path_factory.getbasetemp()
    run = own.parent if "PYTEST_XDIST_WORKER" in os.environ else own
    with pytest.MonkeyPatch.context() as patch:
        # a run over many mutants keeps what did not change compiled
        kept = os.environ.get("MEHVAR_TEST_CACHE")
        patch.setenv("MEHVAR_CACHE", str(Path(kept).resolve() if kept else run / "compiled"))
        patch.setattr(sys, "executable", commands.python())  # and derive without importing the libraries each time
        multiprocessing.spawn.set_executable(sys.executable)
        # a module that a test edits within a second, in as many bytes, would be taken for the former one
        patch.setattr(sys, "dont_write_bytecode", True)
        patch.setenv("PYTHONDONTWRITEBYTECODE", "1")
        patch.setattr(os, "fsync", lambda _: None)  # a test is not about a loss of power, unless it counts the calls
        yield
