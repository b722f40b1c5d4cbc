# SPDX-License-Identifier: Apache-2.0
"""WebAssembly module of a model: generated C and the loop of a single run, compiled by zig."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

from mehvar.base import cache
from mehvar.base.errors import MissingError
from mehvar.base.manifest import Controller, Manifest, file_of
from mehvar.base.names import identifier
from mehvar.runtime.board.image.toolchains import Toolchain, toolchain
from mehvar.runtime.compiling.compiler import run_compiler, write_sources
from mehvar.runtime.compiling.library import native_headers, native_sources
from mehvar.runtime.model.generated import generated_text
from mehvar.runtime.run.calls import loop_calls, model_fields
from mehvar.runtime.run.options import INTEGRATORS, RunOptions, first_integrator
from mehvar.runtime.run.user.law import describe

from .cases import Case

_UNIT, _MODULE = "unit.c", "module.wasm"
FLAGS = (
    "-std=gnu11", "-O2", "-ffp-contract=off", "-fno-math-errno", "-fno-trapping-math", "-fno-sanitize=all", "-s", "-I.",
)  # fmt: skip
"""Compiler flags that affect rounding, as for native libraries; WebAssembly has no fused multiply-add."""
_BARE = ("-target", "wasm32-freestanding", "-ffreestanding", "-nostdlib", "-Wl,--no-entry")
_HOSTED = ("-target", "wasm32-wasi", "-mexec-model=reactor")
"""Flags for a C library, which zig compiles once in a minute and a half; without it, two seconds suffice."""


def compiled_module(manifest: Manifest, cases: Sequence[Case]) -> bytes:
    """Return the compiled module, which has no imports.

    Parameters
    ----------
    manifest : Manifest
        Of the model.
    cases : sequence of Case
        The runs, of which the longest determine the amount of memory.

    Raises
    ------
    MissingError
        Without zig.
    BuildError
        If compilation fails.
    """
    sources, zig = c_sources(manifest, cases), zig_toolchain()
    options = (*(_HOSTED if _needs_library(sources) else _BARE), *FLAGS)
    key = cache.key(zig.version, *options, *(text for item in sorted(sources.items()) for text in item))
    folder = cache.entry("web", f"{manifest.model}-{key}", lambda folder: _compile(folder, sources, zig, options))
    return (folder / _MODULE).read_bytes()


def zig_available() -> bool:
    """Return True if zig is installed."""
    try:
        zig_toolchain()
    except MissingError:
        return False
    return True


def zig_toolchain() -> Toolchain:
    """Return the compiler for WebAssembly, or raise MissingError with install instructions."""
    try:
        return toolchain("zig")
    except MissingError as error:
        what = "a page that runs needs zig, which compiles to WebAssembly"
        raise MissingError(f'{what}: pip install "mehvar[cc]"') from error


def _compile(folder: Path, sources: Mapping[str, str], zig: Toolchain, options: Sequence[str]) -> None:
    with tempfile.TemporaryDirectory() as scratch:
        write_sources(Path(scratch), sources)
        run_compiler([*zig.command, *options, _UNIT, "-o", str(folder / _MODULE)], Path(scratch), "zig failed")


def _needs_library(sources: Mapping[str, str]) -> bool:
    """Return True if a model calls functions of the C library that mehvar lacks, such as hyperbolic ones."""
    names = re.findall(r"^MV_DEFINE_LIBM\((\w+)\)", sources["mehvar/private/libm.h"], re.MULTILINE)
    calls = re.compile(rf"\bmv_(?:{'|'.join(names)})\(")
    return any(calls.search(text) for name, text in sources.items() if "/" not in name)


def c_sources(manifest: Manifest, cases: Sequence[Case]) -> dict[str, str]:
    """Return the module's C files by path; unit.c is compiled."""
    own = file_of(manifest.model, "")
    native = native_sources("step/*.h", "single/*.[ch]", "methods/*.[ch]", "methods/*.inc", "random/noise.[ch]",
                            "random/philox.h", "web/*.c")  # fmt: skip
    units = (own, "tableaux.c", "single.c", "noise.c", "web_model.h", "web.c")
    return {
        **native_headers(),
        **native,
        **{name: generated_text(manifest, name) for name in (f"{manifest.model}.h", own)},
        "web_model.h": _header(manifest, cases),
        _UNIT: "".join(f'#include "{name}"\n' for name in units),
    }


def _header(manifest: Manifest, cases: Sequence[Case]) -> str:
    """Return the text of web_model.h; native/web/web.c explains its names."""
    laws = list(manifest.controllers.values())
    sizes = {
        "NP": len(manifest.parameters),
        "NC": max(len(law.parameters) for law in laws),
        "NS": len(manifest.scenario_parameters),
        "NX": len(manifest.states),
        "NQ": max(len(manifest.states), len(manifest.coordinates)) + max(len(law.memory) for law in laws),
        "NU": len(manifest.inputs),
        "NR": len(manifest.references),
        "NY": len(manifest.outputs),
        "NZ": max(len(law.memory) for law in laws),
        "NE": len(manifest.noise),
        "SEEN": len(manifest.seen),
        "CONSTRAINTS": len(manifest.constraints),
        "MARGINS": len(manifest.constraints) + max(len(law.constraints) for law in laws) + len(manifest.limits),
        "TICKS": max(len(case.t) for case in cases),
        "ROWS": max(case.rows for case in cases),
        "EVALUATIONS": max(case.evaluations for case in cases),
        "POINTS": 3 * sum(shape.points for shape in manifest.geometry),
    }
    lines = [f"#define WEB_{name} {size}" for name, size in sizes.items()]
    functions = {identifier(name) for name in manifest.functions}
    optional = {"constraints": "p, s, margin", "to_coordinates": "x, q", "geometry": "x, u, r, p, points"}
    lines.append(f"#define web_initial(p, s, x) {manifest.c_name('initial')}(p, s, x)")
    for name, arguments in optional.items():
        body = f"{manifest.c_name(name)}({arguments})" if name in functions else "(void)0"
        lines.append(f"#define web_{name}({arguments}) {body}")
    entries = ",\n".join(f"    {{{_law(manifest, law)}}}" for law in (*laws, _OWN))
    return "\n".join([*lines, _STRUCTURE, f"static const web_law web_laws[] = {{\n{entries}\n}};", ""])


_STRUCTURE = """
typedef struct {
    mv_model model;
    int32_t charted, count;   /* whether q are coordinates of a chart; constraints of the law */
    int32_t own;              /* whether the page computes the input, at every sample */
    mv_4_1 *start;            /* x, r, p, c -> z; null without memory */
    mv_1_1 *defaults;         /* c -> what formulas give; null without formulas */
    mv_3_1 *constraints;      /* p, c, s -> margin; null without constraints */
} web_law;
"""


_OWN = describe("page:own", "computed by the page")
"""The last law of a module: it is sampled, and the page computes its input."""


def _law(manifest: Manifest, law: Controller) -> str:
    """Return the fields of a law's web_law structure."""
    sampled, name = law.period is not None or law is _OWN, identifier(law.name)
    calls = loop_calls(manifest, law, "", sampled)
    charted = not sampled and "to_coordinates" in calls
    numbers = {
        "nq": len(manifest.coordinates if charted else manifest.states) + (0 if sampled else len(law.memory)),
        "nx": len(manifest.states),
        "nseen": len(manifest.seen),
        "nu": len(manifest.inputs),
        "nz": len(law.memory),
        "ny": len(manifest.outputs),
        "nr": len(manifest.references),
        "nm": len(manifest.limits),
        "ne": len(manifest.noise),
        "sampled": int(sampled),
        "reference_constant": int(manifest.reference_constant),
        "limits_of_state": int(manifest.limits_of_state),
        "method": INTEGRATORS.index(first_integrator(RunOptions().method)),
    }
    model = {**numbers, **{field: manifest.c_name(f.name) for field, f in model_fields(calls, manifest, law).items()}}
    fields: dict[str, object] = {"charted": int(charted), "count": len(law.constraints), "own": int(law is _OWN)}
    for field, present in (
        ("start", law.memory),
        ("defaults", any(q.formula is not None for q in law.parameters)),
        ("constraints", law.constraints),
    ):
        if present:
            fields[field] = manifest.c_name(f"{name}_{field}")
    return f".model = {{{_fields(model)}}},\n     {_fields(fields)}"


def _fields(values: dict[str, object]) -> str:
    return ", ".join(f".{name} = {value}" for name, value in values.items())
