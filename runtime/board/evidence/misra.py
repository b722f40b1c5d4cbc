# SPDX-License-Identifier: Apache-2.0
"""Findings about a law and its firmware, by rule of MISRA C:2012."""

from __future__ import annotations

import re
import shutil
import subprocess
import tempfile
from collections import Counter
from pathlib import Path

from ...compiling.compiler import write_sources
from ..image.build import Image, sources

Findings = Counter[tuple[str, str]]
"""Number of findings by rule and file."""


def findings(image: Image) -> Findings | None:
    """Return the findings of cppcheck's addon; None if cppcheck is not installed."""
    if shutil.which("cppcheck") is None:
        return None
    with tempfile.TemporaryDirectory() as name:
        write_sources(Path(name), sources(image.program, image.board))
        command = [
            "cppcheck", "--std=c99", "--addon=misra", "--enable=style", "--quiet", "-DMEHVAR_FLOAT", "-DMEHVAR_SMALL",
            "-I.", "-Ilibc", "--template={file}:{line} {id}", ".",
        ]  # fmt: skip
        done = subprocess.run(command, cwd=name, capture_output=True, text=True, check=False)
    findings = re.findall(r"^(\S+):\d+ misra-c2012-(\S+)$", done.stderr, re.MULTILINE)
    return Counter((rule, file) for file, rule in findings)
