# SPDX-License-Identifier: Apache-2.0
"""Check that a store contains only plain files and folders; links are never followed."""

from __future__ import annotations

import os
import shutil
import stat
from pathlib import Path, PurePosixPath


def special_files(folder: Path) -> dict[str, str]:
    """Return the paths of links, pipes and devices below a folder, with their kinds."""
    result: dict[str, str] = {}
    for parent, folders, files in os.walk(folder):
        for path in (Path(parent, name) for name in sorted((*folders, *files))):
            if what := _kind(path):
                result[path.relative_to(folder).as_posix()] = what
    return result


def is_plain(folder: Path, name: str) -> bool:
    """Return True for a plain file whose folders are not links."""
    places = [folder / name, *(folder / above for above in PurePosixPath(name).parents if above.name)]
    return (folder / name).is_file() and not any(place.is_symlink() for place in places)


def _kind(path: Path) -> str:
    """Return the kind of a path that is neither file nor folder; empty if it has disappeared."""
    try:
        mode = path.lstat().st_mode
    except FileNotFoundError:
        return ""
    if stat.S_ISLNK(mode):
        return "a link"
    return "" if stat.S_ISREG(mode) or stat.S_ISDIR(mode) else "a pipe or a device"


def remove_special_files(folder: Path) -> None:
    """Remove links (not their targets), pipes and devices."""
    for name in special_files(folder):
        (folder / name).unlink()


def clear_path(folder: Path, name: str) -> None:
    """Make a path writable by removing a folder at the path and all but folders above it."""
    place = folder
    *above, _ = name.split("/")
    for part in above:
        place /= part
        if place.is_symlink() or (place.exists() and not place.is_dir()):
            place.unlink()
    target = folder / name
    if target.is_dir() and not target.is_symlink():
        shutil.rmtree(target)
    elif _kind(target):
        target.unlink()
