# SPDX-License-Identifier: Apache-2.0
"""Installed packages and the current project."""

from __future__ import annotations

import platform
import re
from pathlib import Path


def installed(*packages: str) -> dict[str, str]:
    """Return the versions of installed packages by name; "python" is Python itself."""
    from importlib.metadata import PackageNotFoundError, version  # costs more to import than all of the runtime

    numbers = {}
    for package in packages:
        try:
            numbers[package] = platform.python_version() if package == "python" else version(package)
        except PackageNotFoundError:
            continue
    return numbers


def required() -> frozenset[str]:
    """Return the names of mehvar's dependencies, including those of extras."""
    from importlib.metadata import PackageNotFoundError, requires

    try:
        return frozenset(re.split(r"[^\w-]", line.lower())[0] for line in requires("mehvar") or ())
    except PackageNotFoundError:
        return frozenset()


def extra_of(package: str) -> str:
    """Return the first extra that installs a package, except combined extras, or an empty text."""
    from importlib.metadata import PackageNotFoundError, requires

    try:
        lines = requires("mehvar") or ()
    except PackageNotFoundError:
        return ""
    pattern = re.compile(rf"{re.escape(package)}\b(?!-).*extra == ['\"](?!all|dev|docs)(\w+)", re.IGNORECASE)
    return next((match[1] for line in lines if (match := pattern.match(line))), "")


def project_root(start: Path) -> Path | None:
    """Return the nearest folder, from `start` upwards, that has generated/ and a model in models/.

    A model is recognised by system.py, by plant.toml for a law, by parameters.toml, or by `system` in its
    `__init__.py`.
    """
    patterns = ("system.py", "*/system.py", "*/plant.toml", "*/parameters.toml")
    for folder in (start, *start.parents):
        models = folder / "models"
        if (folder / "generated").is_dir() and (
            any(any(models.glob(pattern)) for pattern in patterns)
            or any(b"def system(" in file.read_bytes() for file in models.glob("*/__init__.py"))
        ):
            return folder
    return None
