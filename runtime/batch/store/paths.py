# SPDX-License-Identifier: Apache-2.0
"""Check that a store contains only plain files and folders; links are never followed."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from pathlib import Path, PurePosixPath


def special_files(folder: Path) -> dict[str, str]:
    """Return the paths of links, pipes and devices below a folder, with their kinds."""
    return {name: what for name, entry in entries(folder) if (what := _kind(entry))}


def entries(folder: Path, above: str = "") -> Iterator[tuple[str, os.DirEntry[str]]]:
    """Yield the paths below a folder, in order, with their entries; links are not followed."""
    try:
        with os.scandir(folder / above) as listing:
            own = sorted(listing, key=lambda entry: entry.name)
    except OSError:
        return  # a writer has removed it
    for entry in own:
        yield f"{above}{entry.name}", entry
    for entry in own:
        if entry.is_dir(follow_symlinks=False):
            yield from entries(folder, f"{above}{entry.name}/")


def _kind(place: Path | os.DirEntry[str]) -> str:
    """Return the kind of a path that is neither file nor folder."""
    if place.is_symlink():
        return "a link"
    return "" if place.is_file() or place.is_dir() else "a pipe or a device"


def is_plain(folder: Path, name: str) -> bool:
    """Return True for a plain file whose folders are not links."""
    places = [folder / name, *(folder / above for above in PurePosixPath(name).parents if above.name)]
    return (folder / name).is_file() and not any(place.is_symlink() for place in places)


def clear_path(folder: Path, name: str) -> None:
    """Make a path writable by removing a folder at the path and all but folders above it."""
    place = folder
    *above, _ = name.split("/")
    for part in above:
        place /= part
        if place.is_symlink() or (place.exists() and not place.is_dir()):
            place.unlink()
    target = folder / name
    if not os.path.lexists(target):
        return
    if _kind(target):
        target.unlink()
    elif target.is_dir():
        shutil.rmtree(target)
