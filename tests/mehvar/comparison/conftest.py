# SPDX-License-Identifier: Apache-2.0
"""Projects for the tests of `mehvar diff`."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from tests.mehvar.comparison.projects import Project, made


@pytest.fixture(scope="session")
def committed(tmp_path_factory) -> Path:
    """The cart, generated and committed."""
    return made(tmp_path_factory.mktemp("committed")).root


@pytest.fixture
def project(committed, tmp_path) -> Project:
    """A copy that tests may change; derivations are shared."""
    shutil.copytree(committed, tmp_path / "tree")
    return Project(tmp_path / "tree")
