# SPDX-License-Identifier: Apache-2.0
"""A signal's handler that raises, whenever it comes to a run or a batch with functions in Python, ends it with that."""

from __future__ import annotations

import pytest

from mehvar import runtime

from .interrupts import campaign, runs


# pathlib may be interrupted between opening a file or an iterator over a folder and its `with`
@pytest.mark.filterwarnings(
    "ignore:Exception ignored in. <(posix.ScandirIterator|_io.FileIO):pytest.PytestUnraisableExceptionWarning"
)
@pytest.mark.parametrize("kind", ["law", "memory", "inputs", "progress", "batch"])
def test_no_interrupt_is_swallowed_or_changed(pendulum: runtime.Model, kind: str) -> None:
    counts = campaign(runs(pendulum)[kind], 16, seed=4)
    assert counts["raised"] == 16, counts
