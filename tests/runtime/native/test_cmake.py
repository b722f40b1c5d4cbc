# SPDX-License-Identifier: Apache-2.0
"""The CMake package of generated C: the example of the reference, built and run as the page says."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

from tests.docs.test_docs import blocks

ROOT = Path(__file__).parents[3]
PAGE = ROOT / "docs" / "reference" / "generated-c.md"


def test_the_example_of_the_page_is_built_by_cmake(tmp_path):
    programs = [shutil.which(name) for name in ("cmake", "g++", "make")]
    if None in programs:
        pytest.skip("no cmake, g++ or make: apt install cmake g++ make")
    text = PAGE.read_text(encoding="utf-8")
    for name in ("CMakeLists.txt", "rods.cpp"):
        (block,) = (block for block in blocks(text) if name in block.marker)
        (tmp_path / name).write_text("\n".join(block.lines) + "\n")
    chosen = [f"-Dmehvar_DIR={ROOT / 'runtime/native/cmake'}", f"-DMODEL={ROOT / 'generated/triangle'}"]
    for command in (["cmake", "-B", "build", *chosen], ["cmake", "--build", "build"]):
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == 0, done.stdout + done.stderr
    printed = subprocess.run([tmp_path / "build" / "rods"], check=True, capture_output=True, text=True).stdout
    (shown,) = (block for block in blocks(text) if "build/rods" in "\n".join(block.lines))
    assert printed.strip() == shown.lines[-1]
