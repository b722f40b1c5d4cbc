# SPDX-License-Identifier: Apache-2.0
"""Parallel derivation of several models, one process each."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterable
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context
from typing import TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")


def in_processes(work: Callable[[Item, ProcessPoolExecutor], Result], items: Iterable[Item]) -> list[Result]:
    """Return the results of `work` for all items in order; `work` may submit long tasks to the processes.

    Ctrl-C ends the processes silently.
    """
    several = list(items)
    workers = min(len(several), os.cpu_count() or 1)
    if not several:
        return []
    ended_by_ctrl_c = (signal.SIGINT, signal.SIG_DFL)
    with (
        ProcessPoolExecutor(workers, get_context("spawn"), signal.signal, ended_by_ctrl_c) as processes,
        ThreadPoolExecutor(len(several)) as threads,
    ):
        return list(threads.map(lambda item: work(item, processes), several))
