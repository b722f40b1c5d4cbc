# SPDX-License-Identifier: Apache-2.0
"""What a command says besides its answer: one message at its end, warnings in a line, nothing to a reader who left."""

from __future__ import annotations

import io
import os
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NoReturn


def fail(message: object, status: int) -> NoReturn:
    """Print one message on standard error and exit."""
    print(f"mehvar: {message}", file=sys.stderr)
    sys.exit(status)


@contextmanager
def interruptible() -> Iterator[None]:
    """End with a message and status 130 when the user presses Ctrl-C in the block."""
    try:
        yield
    except KeyboardInterrupt:
        fail("interrupted", 130)


def warn_in_a_line() -> None:
    """Show a warning as its message alone: the line of our code that gave it means nothing to who types a command."""
    warnings.formatwarning = lambda message, *_, **__: f"mehvar: {message}\n"


def let_readers_leave() -> None:
    """Go on without a word when the reader of the output has seen enough, as in `mehvar show slosh | head -3`."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout = _Output(sys.stdout)
    if isinstance(sys.stderr, io.TextIOWrapper):
        sys.stderr = _Output(sys.stderr)


class _Output(io.TextIOWrapper):
    """A stream that turns to the null device once its pipe is broken."""

    def __init__(self, stream: io.TextIOWrapper) -> None:
        stream.flush()
        super().__init__(
            stream.buffer,
            encoding=stream.encoding,
            errors=stream.errors,
            line_buffering=stream.line_buffering,
            write_through=stream.write_through,
        )

    def write(self, text: str) -> int:
        """Write, or drop what nobody reads."""
        try:
            return super().write(text)
        except BrokenPipeError:
            self._drop()
            return len(text)

    def flush(self) -> None:
        """Flush, or drop what nobody reads."""
        try:
            super().flush()
        except BrokenPipeError:
            self._drop()

    def _drop(self) -> None:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, self.fileno())
        os.close(nowhere)
