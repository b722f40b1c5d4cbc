# SPDX-License-Identifier: Apache-2.0
"""Cache of files that generated folders omit, derived from the model's sources at first use.

A derivation runs in its own process, so that runs import no derivation code.
"""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
from pathlib import Path

from mehvar.base import cache, errors
from mehvar.base.errors import InputError
from mehvar.base.manifest import Manifest, files_on_first_use, read_manifest
from mehvar.base.versions import installed

from .catalogue import shipped_models

_HERE = Path(errors.__file__).resolve().parents[2]
_NEEDED = ("sympy", "casadi")


def folder_with(manifest: Manifest, name: str) -> Manifest:
    """Return the manifest of the folder that has a file, the model's or a cached one, derived if necessary.

    Parameters
    ----------
    manifest : Manifest
        Of the model's generated folder.
    name : str
        Name of the file, such as "triangle_loops_jac.c".

    Raises
    ------
    InputError
        If the file cannot be made, because its sources are missing or changed or a package is missing.
    """
    present = name in manifest.files_sha256 if manifest.files_sha256 else (manifest.folder / name).is_file()
    if present or name not in files_on_first_use(manifest.model):
        return manifest
    what = f"{name} of {manifest.model} is made when it is first used"
    versions = sorted(installed(*_NEEDED, "mehvar", "python").items())
    entry = f"{manifest.model}-{cache.key(manifest.text, repr(versions))}"
    folder = None if _tree(manifest) else cache.find("derived", entry)  # a copy away from its sources, made before
    made = read_manifest(folder or _made(manifest, name, entry, what))
    if made.hash != manifest.hash:
        raise InputError(
            f"{what}, and this version of mehvar derives other functions (hash {made.hash[:8]}) than {manifest.folder} "
            f"has ({manifest.hash[:8]}); generate the model again (mehvar generate {manifest.model})"
        )
    return made


def _made(manifest: Manifest, name: str, entry: str, what: str) -> Path:
    """Return the folder of a cache entry; derive a missing one."""
    root = _root(manifest, name)
    for package in _NEEDED:
        if not installed(package):
            raise InputError(f"{what}, which needs {package}: pip install {package}")
    return cache.entry("derived", entry, lambda folder: _fill(root, manifest, folder, what))


def _tree(manifest: Manifest) -> bool:
    """Return True if a folder belongs to a project, with its sources."""
    own = manifest.folder.absolute()
    return own.parent.name == "generated" and (own.parent.parent / "models" / manifest.model).is_dir()


def _root(manifest: Manifest, name: str) -> Path:
    """Return the folder with the unchanged models/ of a generated folder."""
    own, model = manifest.folder.absolute(), manifest.model
    shipped = shipped_models().get(model)
    folders = [own, *([shipped] if shipped and read_manifest(shipped).text == manifest.text else [])]
    for folder in folders:
        root = folder.parent.parent
        if folder == root / "generated" / model and (root / "models" / model).is_dir():
            _check_unchanged(manifest, root, name)
            return root
    raise InputError(
        f"{own} lacks {name}, which cannot be derived without the sources models/{model}. "
        f"Write every file where the sources are: mehvar generate {model} --out DIR (--emit casadi for CasADi's C)"
    )


def _check_unchanged(manifest: Manifest, root: Path, name: str) -> None:
    for source, digest in manifest.inputs_sha256.items():
        path = root / source
        if source.startswith("models/") and path.is_file() and hashlib.sha256(path.read_bytes()).hexdigest() != digest:
            raise InputError(
                f"{name} cannot be made: {source} has changed since {manifest.model} was generated. "
                f"To update it, run: mehvar generate {manifest.model}"
            )


def _fill(root: Path, manifest: Manifest, folder: Path, what: str) -> None:
    choices = [part for name, value in manifest.structure.items() for part in ("--structure", f"{name}={value}")]
    options = [*choices, "--emit", "casadi", "--out", str(folder)]
    process = run_python(root, "-m", "mehvar", "generate", manifest.model, *options)
    if process.returncode:
        raise InputError(f"{what}, which failed: {last_line(process)}")


def run_python(root: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run Python with this mehvar in a project, in a new process that may import its models."""
    path = os.pathsep.join([str(_HERE), *filter(None, [os.environ.get("PYTHONPATH")])])
    return subprocess.run(
        [sys.executable, "-P", *arguments],
        cwd=root,
        env={**os.environ, "PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=False,
    )


def last_line(process: subprocess.CompletedProcess[str]) -> str:
    """Return the last line that a process printed."""
    return "".join((process.stderr.strip() or process.stdout.strip()).splitlines()[-1:])
