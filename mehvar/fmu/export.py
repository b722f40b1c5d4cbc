# SPDX-License-Identifier: Apache-2.0
"""An FMU as a file: description, sources, and a binary for this platform."""

from __future__ import annotations

import hashlib
import io
import os
import platform
import sys
import zipfile
from collections.abc import Mapping
from pathlib import Path

from mehvar.base.errors import bad_value
from mehvar.base.names import identifier
from mehvar.runtime.arguments import check_arguments
from mehvar.runtime.compiling.library import ENDING, compiled
from mehvar.runtime.files import check_file, write_atomic
from mehvar.runtime.model.model import Model, load

from .description import Interface, Version, description
from .sources import UNITS, c_sources
from .variables import subject

_EPOCH = (1980, 1, 1, 0, 0, 0)
"""Fixed date of all members of the archive, so that the same model gives the same bytes."""


def export_fmu(
    model: Model | str | os.PathLike[str],
    out: str | os.PathLike[str],
    *,
    controller: str | None = None,
    scenario: str | None = None,
    fmi: Version = "2.0",
    kind: Interface = "cs",
) -> None:
    """Write a functional mock-up unit.

    Parameters
    ----------
    model : Model, str or path
        A loaded or built model, a name or a generated folder.
    out : path
        The file, whose name ends in `.fmu`.
    controller : str, optional
        The law of the closed loop; default: the plant without a law.
    scenario : str, optional
        Gives the start values; default: the model's first one.
    fmi : {"2.0", "3.0"}
        Version of the standard.
    kind : {"cs", "me"}
        Co-simulation with mehvar's integrator, or model exchange.

    Raises
    ------
    InputError
        For anything unknown, or without a C compiler.
    BuildError
        If compilation fails.
    OSError
        If the file cannot be written.
    """
    check_arguments("text", "the call", controller=controller, scenario=scenario, fmi=fmi, kind=kind)
    check_arguments("path", "the call", out=out)
    if fmi not in ("2.0", "3.0"):
        raise bad_value("fmi", fmi, "'2.0' or '3.0'")
    if kind not in ("me", "cs"):
        raise bad_value("kind", kind, "'me' or 'cs'")
    if out is None or Path(out).suffix.lower() != ".fmu":
        raise bad_value("out", out, "a file name that ends in .fmu")
    check_file(out)
    what = subject(model if isinstance(model, Model) else load(model), controller, scenario)
    name = identifier("_".join(filter(None, (what.model.name, controller))))
    draft = c_sources(what, fmi, "")
    digest = hashlib.sha256("".join(text for item in sorted(draft.items()) for text in item).encode()).hexdigest()
    token = f"{{{digest[:8]}-{digest[8:12]}-{digest[12:16]}-{digest[16:20]}-{digest[20:32]}}}"
    sources = c_sources(what, fmi, token)
    files = {"modelDescription.xml": description(what, fmi, kind, name, token)}
    files |= {f"sources/{path}": text.encode() for path, text in sources.items()}
    if fmi == "3.0":
        files["sources/buildDescription.xml"] = _build_description(name)
    files[_binary_path(name, fmi)] = compiled("fmu", sources, UNITS, ("-O2", "-I.")).read_bytes()
    write_atomic(out, _zipped(files))


def _binary_path(name: str, fmi: Version) -> str:
    """Return the path of this platform's binary inside an FMU."""
    machine = platform.machine().lower()
    system = {"win32": "win", "darwin": "darwin"}.get(sys.platform, "linux")
    if fmi == "2.0":
        return f"binaries/{system}64/{name}{ENDING}"
    architecture = {"amd64": "x86_64", "arm64": "aarch64"}.get(machine, machine)
    folder = {"win": "windows"}.get(system, system)
    return f"binaries/{architecture}-{folder}/{name}{ENDING}"


def _build_description(name: str) -> bytes:
    """Return buildDescription.xml of FMI 3.0, which lists the C sources."""
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<fmiBuildDescription fmiVersion="3.0">\n'
        f'  <BuildConfiguration modelIdentifier="{name}">\n'
        '    <SourceFileSet language="C99">\n'
        + "".join(f'      <SourceFile name="{unit}"/>\n' for unit in UNITS)
        + "    </SourceFileSet>\n"
        "  </BuildConfiguration>\n</fmiBuildDescription>\n"
    ).encode()


def _zipped(files: Mapping[str, bytes]) -> bytes:
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, data in files.items():
            archive.writestr(zipfile.ZipInfo(path, _EPOCH), data, zipfile.ZIP_DEFLATED)
    return content.getvalue()
