# SPDX-License-Identifier: Apache-2.0
"""Exceptions of signal handlers, such as Ctrl-C, at points where Python would drop them."""

from __future__ import annotations

import signal
import sys
import threading
import traceback
from types import TracebackType
from typing import Any


def is_of_handler(error: BaseException) -> bool:
    """Return True if a signal handler raised an error; the interrupted code is then not at fault."""
    codes = {getattr(signal.getsignal(number), "__code__", None) for number in signal.valid_signals()}
    return isinstance(error, KeyboardInterrupt) or any(
        frame.f_code in codes for frame, _ in traceback.walk_tb(error.__traceback__)
    )


class KeptInterrupts:
    """Keeps exceptions of handlers in callbacks of C and of weak references, which Python drops; raises them later.

    The block ends with that exception, whatever else it raises; `check` raises it earlier. Handlers run in the main
    thread: in other threads this does nothing.
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
        """Raise the kept exception."""
        if self._lost is not None:
            raise self._lost

    def _keep(self, unraisable: Any) -> None:
        if unraisable.exc_value is not None and is_of_handler(unraisable.exc_value):
            self._lost = unraisable.exc_value
        else:
            self._before(unraisable)
