# SPDX-License-Identifier: Apache-2.0
"""The pendulum: a hand-written model in the form of a generated one."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from mehvar import runtime
from mehvar.base.manifest import FILE, with_digest

PENDULUM = Path(__file__).parent / "pendulum"


@pytest.fixture(scope="session")
def folder() -> Path:
    return PENDULUM


@pytest.fixture(scope="session")
def pendulum() -> runtime.Model:
    return runtime.load(PENDULUM, backend="c")


@pytest.fixture(scope="session")
def slow_pendulum() -> runtime.Model:
    return runtime.load(PENDULUM, backend="python")


@pytest.fixture
def edited(tmp_path: Path) -> Callable[[str, str, str], Path]:
    """Return a function that copies the pendulum's folder and edits one of its files; a manifest gets a new digest."""

    def edit(file: str, old: str, new: str) -> Path:
        copy = tmp_path / "pendulum"
        if not copy.exists():
            shutil.copytree(PENDULUM, copy)
        text = (copy / file).read_text()
        assert old in text
        changed = text.replace(old, new)
        (copy / file).write_text(with_digest(changed) if file == FILE else changed)
        return copy

    return edit
