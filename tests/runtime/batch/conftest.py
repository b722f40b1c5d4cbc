# SPDX-License-Identifier: Apache-2.0
"""A finished store of three blocks, and a copy of it to damage."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from mehvar.runtime.batch.fill import run_batch
from tests.runtime.batch.forgery import CAMPAIGN, CHUNK, PENDULUM


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("whole") / "runs.zarr"
    run_batch(PENDULUM, CAMPAIGN, path, chunk=CHUNK)
    return path


@pytest.fixture
def store(whole: Path, tmp_path: Path) -> Path:
    shutil.copytree(whole, tmp_path / "runs.zarr")
    return tmp_path / "runs.zarr"
