# SPDX-License-Identifier: Apache-2.0
"""Manifests for tests."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from mehvar.base.manifest import FILE, with_digest


def write_manifest(folder: Path, data: Mapping[str, Any]) -> None:
    """Write a manifest with its digest."""
    (folder / FILE).write_text(with_digest(json.dumps(data, indent=1)))
