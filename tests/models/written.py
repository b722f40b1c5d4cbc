# SPDX-License-Identifier: Apache-2.0
"""A system of a test as a generated folder."""

from pathlib import Path

from mehvar.base.manifest import manifest_text
from mehvar.codegen.code.casadi_c import casadi_c
from mehvar.codegen.code.files import code_files, printed_functions
from mehvar.codegen.functions.graphs import generate_functions
from mehvar.codegen.manifest import manifest_of
from mehvar.models.check import check
from mehvar.models.clock import with_clock
from mehvar.models.forms import with_samples
from mehvar.models.system import System


def written(system: System, path: Path) -> Path:
    """Check a system and write its folder."""
    check(system)
    whole = with_clock(with_samples(system))
    graphs = generate_functions(whole)
    functions = printed_functions(graphs)
    manifest = manifest_of(whole, functions, {})
    files = {
        **code_files(manifest, functions),
        **casadi_c(system.name, graphs),
        "manifest.json": manifest_text(manifest),
    }
    for name, text in files.items():
        (path / name).write_text(text)
    return path
