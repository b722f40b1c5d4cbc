# SPDX-License-Identifier: Apache-2.0
"""A second closed loop, by SciPy's integrators: the reference for sampling, events, noise, delays and masses in C."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from unittest.mock import patch

from .loop import run


@contextmanager
def by_scipy() -> Iterator[None]:
    """Let every run in this block be integrated by SciPy."""
    with patch("mehvar.runtime.run.loop.run", run):
        yield
