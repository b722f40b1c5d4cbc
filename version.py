# SPDX-License-Identifier: Apache-2.0
"""The version that a wheel or a source distribution built from this folder has: of git's tag. See decision 0027."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

HERE = Path(__file__).resolve().parent


def version(folder: Path = HERE) -> str:
    """Return the version of an unpacked source distribution, of the last tag of a checkout, or of CITATION.cff."""
    return _written(folder / "PKG-INFO") or _tagged(folder) or _written(folder / "CITATION.cff")


def _tagged(folder: Path) -> str:
    """Return the last tag `vNUMBER`, as a post-release of it where commits follow; nothing where there is none."""
    if not (folder / ".git").exists():  # a worktree has a file of that name
        return ""
    command = ["git", "describe", "--tags", "--long", "--match", "v[0-9]*"]
    try:
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    except FileNotFoundError:  # no git
        return ""
    match = re.fullmatch(r"v(.+)-(\d+)-g(\w+)\s*", done.stdout)
    if match is None:
        return ""
    number, commits, commit = match.groups()
    return number if commits == "0" else f"{number}.post{commits}+g{commit}"


def _written(file: Path) -> str:
    text = file.read_text(encoding="utf-8") if file.is_file() else ""
    match = re.search(r"^version: *(\S+)$", text, flags=re.MULTILINE | re.IGNORECASE)
    return match[1] if match else ""
