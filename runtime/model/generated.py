# SPDX-License-Identifier: Apache-2.0
"""Verified contents of a generated folder, and a check for changed sources."""

from __future__ import annotations

import hashlib
import warnings

from mehvar.base.errors import InputError
from mehvar.base.manifest import Manifest

from .derived import folder_with


def generated_text(manifest: Manifest, name: str) -> str:
    """Return the text of a generated file, derived if folder and cache lack it.

    Parameters
    ----------
    manifest : Manifest
        Manifest of the folder.
    name : str
        Name of the file, such as "triangle.c".

    Raises
    ------
    InputError
        If it cannot be read or made, or its SHA-256 differs from the manifest's.
    """
    manifest = folder_with(manifest, name)
    path = manifest.folder / name
    try:
        content = path.read_bytes()
        text = content.decode()
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else error
        raise InputError(f"cannot read {path} ({reason}); generate the model again") from error
    if name in manifest.files_sha256 and _sha256(content) != manifest.files_sha256[name]:
        raise InputError(
            f"{path} was changed after generation: its digest does not match. Change the sources and run mehvar "
            "generate, or restore the file"
        )
    return text


def check_unedited(manifest: Manifest) -> None:
    """Refuse a folder with edited generated files; files may be missing.

    Raises
    ------
    InputError
        Naming the file.
    """
    for name in manifest.files_sha256:
        if (manifest.folder / name).is_file():
            generated_text(manifest, name)


def warn_if_stale(manifest: Manifest) -> None:
    """Warn if a model's sources have changed since generation.

    New sources and changes of mehvar are not reported; `mehvar generate --check` checks all inputs.
    """
    root, own = manifest.folder.absolute().parent.parent, f"models/{manifest.model}/"
    changed = [
        name
        for name, digest in manifest.inputs_sha256.items()
        if name.startswith(own) and (root / name).is_file() and _sha256((root / name).read_bytes()) != digest
    ]
    if changed:
        others = f" and {len(changed) - 1} more" if len(changed) > 1 else ""
        warnings.warn(
            f"{manifest.model} is stale: {changed[0]}{others} changed after generation. The old code is used; "
            f"to update it, run: mehvar generate {manifest.model}",
            RuntimeWarning,
            stacklevel=3,
        )


def _sha256(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()
