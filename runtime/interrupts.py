# SPDX-License-Identifier: Apache-2.0
"""Exceptions of signal handlers, such as Ctrl-C: kept where Python drops them, delayed where interrupts are unsafe."""

from __future__ import annotations

import signal
import sys
import threading
import time
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType, TracebackType
from typing import Any

_SIGNALS = tuple(map(int, signal.valid_signals()))
_PATIENCE = 2.0
"""Seconds after which another signal interrupts at once. A slow disk needs half of this for a block; twice as long
would seem stuck.
"""


def is_of_handler(error: BaseException) -> bool:
    """Return True if an error comes from a signal handler and not from the interrupted code."""
    codes = {getattr(signal.getsignal(number), "__code__", None) for number in signal.valid_signals()}
    return isinstance(error, KeyboardInterrupt) or any(
        frame.f_code in codes for frame, _ in traceback.walk_tb(error.__traceback__)
    )


@contextmanager
def deferred() -> Iterator[None]:
    """Delay signal handlers until the end of the block; after 2 s another signal interrupts at once.

    An exception inside `threading.Condition` never releases its lock, and zarr, dask and thread pools use such locks.
    Handlers run in the main thread; in other threads this function does nothing.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    handlers: dict[int, Callable[[int, FrameType | None], Any]] = {}
    due: list[tuple[int, FrameType | None]] = []
    end = float("inf")

    def later(number: int, frame: FrameType | None) -> None:
        nonlocal end
        if time.monotonic() > end:
            handlers[number](number, frame)
        else:
            due.append((number, frame))
            end = min(end, time.monotonic() + _PATIENCE)

    try:
        for number in _SIGNALS:
            handler = signal.getsignal(number)
            if callable(handler):
                handlers[number] = handler
                signal.signal(number, later)
        yield
    finally:
        end = 0.0  # a handler that is not back in its place when another one raises is called through `later`
        try:
            for number, handler in handlers.items():
                signal.signal(number, handler)
        finally:
            for number, frame in due:
                handlers[number](number, frame)


class KeptInterrupts:
    """Context that keeps exceptions of handlers in callbacks of C and of weak references, where Python drops them.

    The block ends with that exception; `check` raises it earlier. Handlers run in the main thread; in other threads
    this class does nothing.
    """

    def __init__(self) -> None:
        self._lost: BaseException | None = None
        self._before: Any = None

    def __enter__(self) -> KeptInterrupts:
        if threading.current_thread() is threading.main_thread():
            self._before, sys.unraisablehook = sys.unraisablehook, self._keep
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None) -> None:
        if self._before is not None:
            sys.unraisablehook = self._before
        self.check()

    def check(self) -> None:
        """Raise the kept exception, if any."""
        if self._lost is not None:
            raise self._lost

    def _keep(self, unraisable: Any) -> None:
        if unraisable.exc_value is not None and is_of_handler(unraisable.exc_value):
            self._lost = unraisable.exc_value
        else:
            self._before(unraisable)
