# SPDX-License-Identifier: Apache-2.0
"""The environment: installed packages and the current project."""

from __future__ import annotations

import platform
import re
from pathlib import Path


def installed(*packages: str) -> dict[str, str]:
    """Return the versions of installed packages by name; "python" stands for Python itself."""
    from importlib.metadata import PackageNotFoundError, version  # costs more to import than all of the runtime

    numbers = {}
    for package in packages:
        try:
            numbers[package] = platform.python_version() if package == "python" else version(package)
        except PackageNotFoundError:
            continue
    return numbers


def required() -> frozenset[str]:
    """Return the names of our dependencies, extras included."""
    from importlib.metadata import PackageNotFoundError, requires

    try:
        return frozenset(re.split(r"[^\w-]", line.lower())[0] for line in requires("mehvar") or ())
    except PackageNotFoundError:
        return frozenset()


def extra_of(package: str) -> str:
    """Return the first extra that installs a package, without combined extras; an empty text if no extra does."""
    from importlib.metadata import PackageNotFoundError, requires

    try:
        lines = requires("mehvar") or ()
    except PackageNotFoundError:
        return ""
    pattern = re.compile(rf"{re.escape(package)}\b(?!-).*extra == ['\"](?!all|dev|docs)(\w+)", re.IGNORECASE)
    return next((match[1] for line in lines if (match := pattern.match(line))), "")


def project_root(start: Path) -> Path | None:
    """Return the nearest folder, from `start` upwards, that has generated/ and a model in models/.

    A model has system.py, or plant.toml if it is a law; where that is missing or misspelt, it has at least parameters.
    One of a single file defines `system` in its `__init__.py`.
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
