# SPDX-License-Identifier: Apache-2.0
"""What is installed."""

from __future__ import annotations

import platform
import re


def installed(*packages: str) -> dict[str, str]:
    """Return the versions of packages by name, without those that are not installed; "python" is Python itself."""
    from importlib.metadata import PackageNotFoundError, version  # costs more to import than all of the runtime

    numbers = {}
    for package in packages:
        try:
            numbers[package] = platform.python_version() if package == "python" else version(package)
        except PackageNotFoundError:
            continue
    return numbers


def required() -> frozenset[str]:
    """Return the packages that ours depends on, extras included."""
    from importlib.metadata import PackageNotFoundError, requires

    try:
        return frozenset(re.split(r"[^\w-]", line.lower())[0] for line in requires("mehvar") or ())
    except PackageNotFoundError:
        return frozenset()
