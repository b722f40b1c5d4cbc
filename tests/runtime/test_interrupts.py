# SPDX-License-Identifier: Apache-2.0
"""Handlers of signals wait for the end of a block that must not be interrupted."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator

import pytest

from mehvar.runtime import interrupts
from mehvar.runtime.interrupts import deferred


class PressedError(Exception):
    """Exception of the handler."""


@pytest.fixture(autouse=True)
def handler() -> Iterator[object]:
    """A handler that raises."""

    def pressed(*_: object) -> None:
        raise PressedError

    before = signal.signal(signal.SIGALRM, pressed)
    yield pressed
    signal.signal(signal.SIGALRM, before)


def press(steps: list[int]) -> None:
    """Send the signal after each of three steps."""
    with deferred():
        for step in range(3):
            steps.append(step)
            signal.raise_signal(signal.SIGALRM)


def test_a_handler_is_called_after_the_block(handler: object) -> None:
    steps: list[int] = []
    with pytest.raises(PressedError):
        press(steps)
    assert steps == [0, 1, 2]
    assert signal.getsignal(signal.SIGALRM) is handler


def test_a_handler_is_called_after_the_outermost_block(handler: object) -> None:
    steps: list[int] = []

    def twice() -> None:
        with deferred():
            press(steps)
            press(steps)
            raise ValueError

    with pytest.raises(PressedError):
        twice()
    assert steps == [0, 1, 2, 0, 1, 2]
    assert signal.getsignal(signal.SIGALRM) is handler


def test_a_signal_long_after_the_first_is_served_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(interrupts, "_PATIENCE", -1.0)
    steps: list[int] = []
    with pytest.raises(PressedError):
        press(steps)
    assert steps == [0, 1]


def test_another_thread_has_no_handlers_to_wait_for(handler: object) -> None:
    seen = []

    def work() -> None:
        with deferred():
            seen.append(signal.getsignal(signal.SIGALRM))

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert seen == [handler]
