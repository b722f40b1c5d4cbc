# SPDX-License-Identifier: Apache-2.0
"""Numerics of a batch: sources, compiler flags and processor, which affect the rounding of its runs."""

from __future__ import annotations

import json
import platform
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from mehvar.base.cache import key
from mehvar.base.manifest import Manifest, manifest_text

from ..compiling.compiler import require_compiler
from ..compiling.library import FLAGS, native_headers, native_sources
from ..run.results import versions
from .kernel import Kernel, kernel_flags
from .source import generated_sources

_DRAWING = (
    *("batch/plan.py", "batch/sampling.py", "batch/dispersions.py", "batch/blocks.py", "batch/kernel.py"),
    *("run/ticks.py", "run/problem.py", "model/parameters.py"),
)
"""Modules that compute the numbers of runs, pass them to the loop, or decide which runs are possible."""

_MEANINGS = {
    "generated": "the generated text of the model",
    "native": "mehvar's own C",
    "drawing": "code that draws values",
    "flags": "compiler flags",
    "options": "options",
    "profile": "the profile",
    "processor": "compiler and lanes, on which profile=fast depends",
}
"""Parts of the numerics, as hashes or texts. The options of every run include those at their defaults. In the portable
profile, compilers, lanes and processors do not affect results, and `processor` is empty.
"""


def numerics_of(kernel: Kernel, sampling: str, options: Mapping[str, object]) -> str:
    """Return JSON that is equal for bit-identical runs.

    Parameters
    ----------
    kernel : Kernel
        The kernel on this machine.
    sampling : str
        Sampling design.
    options : mapping
        Options of every run.
    """
    manifest, profile = kernel.loop.manifest, kernel.options.profile
    own = generated_sources(manifest)
    native = {name: text for name, text in kernel.loop.sources.items() if name not in own}
    if kernel.loop.stiff_test:
        native["stiff"] = kernel.loop.stiff.sources["kernel.h"]
    compiler = require_compiler()
    flags = kernel_flags(kernel.loop, profile, kernel.lanes)
    machine = (platform.machine(), compiler.version, *compiler.command[1:], *flags)
    parts = {
        "generated": generated_digest(manifest),
        "native": _digest(native),
        "drawing": _drawing(sampling),
        "options": json.dumps(options),
        "flags": " ".join(FLAGS),
        "profile": profile,
        "processor": "" if profile == "portable" else " ".join(machine),
    }
    return json.dumps(parts, sort_keys=True)


def generated_digest(manifest: Manifest) -> str:
    """Return a hash of the generated code that a batch compiles, and of its manifest without the hashes of sources.

    An edit of a source that leaves the generated code unchanged leaves the batch unchanged.
    """
    none: dict[str, str] = {}
    code = replace(manifest, versions=none, inputs_sha256=none, files_sha256=none, shapes_sha256=none)
    return _digest({**generated_sources(manifest), "manifest.json": manifest_text(code)})


def provenance(kernel: Kernel) -> dict[str, str | int]:
    """Return the origin of a block: compiler, lanes, flags, machine, versions. Host and time are omitted."""
    flags = " ".join((*FLAGS, *kernel_flags(kernel.loop, kernel.options.profile, kernel.lanes)))
    about = {"compiler": require_compiler().version, "flags": flags, "machine": platform.machine()}
    return {**about, "lanes": kernel.lanes, **versions()}


def other_numerics(stored: str, here: str) -> str:
    """Return the differences of two numerics in JSON; empty if they are equal."""
    old, new = json.loads(stored), json.loads(here)
    names = [name for name in new if name != "options" and old.get(name) != new[name]]
    parts = [f"{_MEANINGS[name]} ({_short(old.get(name))}, here {_short(new[name])})" for name in names]
    return ", ".join([*other_options(old.get("options", "{}"), json.loads(new["options"])), *parts])


def other_options(stored: str, here: Mapping[str, object]) -> list[str]:
    """Return the differences between a store's options, in JSON, and those of a plan."""
    old = json.loads(stored)
    return [
        f"{name} = {old.get(name)!r}, here {here.get(name)!r}"
        for name in {**old, **here}
        if old.get(name) != here.get(name)
    ]


def _short(value: object) -> str:
    text = str(value)
    return text[:12] if len(text) == len(key()) else repr(text)


def _drawing(sampling: str) -> str:
    folder = Path(__file__).parents[1]
    texts = {name: (folder / name).read_text(encoding="utf-8") for name in _DRAWING}
    sequence = {} if sampling in ("random", "latin") else {"scipy": versions()["scipy"]}
    return _digest({**texts, **native_headers(), **native_sources("random/*.[ch]"), **sequence})


def _digest(texts: Mapping[str, str]) -> str:
    return key(*(part for item in sorted(texts.items()) for part in item))
