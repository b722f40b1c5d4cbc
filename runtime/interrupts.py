# SPDX-License-Identifier: Apache-2.0
"""What a signal's handler raises, Ctrl-C among it, where Python cannot pass it on."""

from __future__ import annotations

import signal
import sys
import threading
import traceback
from types import TracebackType
from typing import Any


def is_of_handler(error: BaseException) -> bool:
    """Whether a signal's handler raised an error, which is then nobody's fault in the code that the signal came to."""
    codes = {getattr(signal.getsignal(number), "__code__", None) for number in signal.valid_signals()}
    return isinstance(error, KeyboardInterrupt) or any(
        frame.f_code in codes for frame, _ in traceback.walk_tb(error.__traceback__)
    )


class KeptInterrupts:
    """Keeps what handlers raise in callbacks of C and of weak references, which Python drops, and raises it later.

    It leaves its block with that error, whatever else the block ends with; `check` raises it before. Handlers run in
    the main thread: elsewhere it does nothing.
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
        """Raise what was kept."""
        if self._lost is not None:
            raise self._lost

    def _keep(self, unraisable: Any) -> None:
        if unraisable.exc_value is not None and is_of_handler(unraisable.exc_value):
            self._lost = unraisable.exc_value
        else:
            self._before(unraisable)
