# SPDX-License-Identifier: Apache-2.0
"""Version of a build: by git's tag, and by what a source distribution was called."""

from __future__ import annotations

import runpy
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
version = runpy.run_path(str(ROOT / "version.py"))["version"]


def test_a_tag_counts_its_commits_and_a_distribution_keeps_its_name(tmp_path: Path) -> None:
    def git(*words: str) -> None:
        author = ["-c", "user.name=me", "-c", "user.email=me@example.org"]
        subprocess.run(["git", *author, *words], cwd=tmp_path, check=True, capture_output=True)

    (tmp_path / "CITATION.cff").write_text("title: x\nversion: 0.4.0\n")
    assert version(tmp_path) == "0.4.0"
    git("init", "-q")
    git("commit", "--allow-empty", "-m", "one")
    assert version(tmp_path) == "0.4.0"
    git("tag", "unrelated")
    git("tag", "v0.5.0")
    assert version(tmp_path) == "0.5.0"
    git("commit", "--allow-empty", "-m", "two")
    assert version(tmp_path).startswith("0.5.0.post1+g")
    (tmp_path / "PKG-INFO").write_text("Metadata-Version: 2.4\nName: mehvar\nVersion: 0.3.0\n")
    assert version(tmp_path) == "0.3.0"


def test_the_build_asks_it() -> None:
    build = [sys.executable, "-m", "hatchling", "version"]
    done = subprocess.run(build, cwd=ROOT, check=True, capture_output=True, text=True)
    assert done.stdout.strip() == version()
