# SPDX-License-Identifier: Apache-2.0
"""What may stand in a store: plain files and folders. Nothing else is followed or written through."""

from __future__ import annotations

import os
import shutil
from pathlib import Path


def foreign(folder: Path) -> dict[str, str]:
    """Return the places of links, pipes and devices below a folder, and what each is."""
    result: dict[str, str] = {}
    for parent, folders, files in os.walk(folder):
        for name in sorted((*folders, *files)):
            path = Path(parent, name)
            if path.is_symlink():
                result[path.relative_to(folder).as_posix()] = "a link"
            elif name in files and not path.is_file():
                result[path.relative_to(folder).as_posix()] = "a pipe or a device"
    return result


def remove_foreign(folder: Path) -> None:
    """Remove links, never what they lead to, pipes and devices."""
    for name in foreign(folder):
        (folder / name).unlink()


def make_place(folder: Path, name: str) -> None:
    """Remove what stands where a file is to be written: a folder in its place, no folder in that of one above it."""
    place = folder
    *above, _ = name.split("/")
    for part in above:
        place /= part
        if place.is_symlink() or (place.exists() and not place.is_dir()):
            place.unlink()
    target = folder / name
    if target.is_dir() and not target.is_symlink():
        shutil.rmtree(target)
