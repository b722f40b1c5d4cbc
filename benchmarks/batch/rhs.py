# SPDX-License-Identifier: Apache-2.0
"""One right-hand side in vector lanes, as a batch calls it, against CasADi's own C of the same graph.

Run: python -m benchmarks.batch.rhs
"""

from __future__ import annotations

import ctypes
import functools
import subprocess
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from time import process_time

import numpy as np

from benchmarks.machine import command_line, machine, table, write
from mehvar.codegen.generate import generate, installed_tree
from mehvar.runtime import Model, load
from mehvar.runtime.compiling.compiler import require_compiler
from mehvar.runtime.compiling.library import INCLUDE
from mehvar.runtime.compiling.processor import vector_flags, widest

REPEATS = 11
CALLS = 200_000
BLOCKS = 4  # of lanes that take turns; they stay in the first-level cache
CASES: dict[str, tuple[str, dict[str, str]]] = {
    "triangle": ("triangle", {}),
    "slosh": ("slosh", {}),
    "slosh on ball joints": ("slosh", {"inertia": "ball", "attitude": "quaternion"}),
    "satellite": ("satellite", {}),
}

OURS = """
#include "{model}.h"
#include "mehvar/private/arithmetic.h"
static real x[{blocks}][{nx}], dx[{blocks}][{nx}], u[{blocks}][{nu}], p[{blocks}][{np} + 1];
static real h[{blocks}][{nh} + 1], w[{blocks}][{nw} + 1];
static void fill(real *to, const double *from, int n)
{{
    for (int i = 0; i < n; i++) to[i] = SPLAT(from[i]);
}}
void start(const double *x0, const double *u0, const double *p0)
{{
    for (int b = 0; b < {blocks}; b++) {{
        fill(x[b], x0, {nx});
        fill(u[b], u0, {nu});
        fill(p[b], p0, {np});
        real *h_ = h[b], *w_ = w[b], *x_ = x[b], *u_ = u[b], *p_ = p[b];
        (void)h_; (void)w_; (void)x_; (void)u_; (void)p_;
        {before}
    }}
}}
void work(long calls)
{{
    for (long i = 0; i < calls / MEHVAR_LANES; i++) {{
        real *h_ = h[i % {blocks}], *w_ = w[i % {blocks}], *x_ = x[i % {blocks}], *u_ = u[i % {blocks}];
        real *p_ = p[i % {blocks}], *dx_ = dx[i % {blocks}];
        (void)h_; (void)w_; (void)x_; (void)u_; (void)p_;
        {call}
    }}
}}
void result(double *to)
{{
    for (int i = 0; i < {nx}; i++) to[i] = ((scalar *)&dx[0][i])[MEHVAR_LANES - 1];
}}
"""

CASADI = """
#include "{model}_casadi.h"
static double x[{nx}], u[{nu}], p[{np} + 1], dx[{nx}], space[100000];
static long long int integers[1000];
void start(const double *x0, const double *u0, const double *p0)
{{
    for (int i = 0; i < {nx}; i++) x[i] = x0[i];
    for (int i = 0; i < {nu}; i++) u[i] = u0[i];
    for (int i = 0; i < {np}; i++) p[i] = p0[i];
}}
void work(long calls)
{{
    const double *arguments[64] = {{x, u, p}};
    double *results[64] = {{dx}};
    for (long i = 0; i < calls; i++) {model}_rhs(arguments, results, integers, space, 0);
}}
void result(double *to)
{{
    for (int i = 0; i < {nx}; i++) to[i] = dx[i];
}}
"""


@dataclass(frozen=True)
class Build:
    """A way to compile the right-hand side."""

    title: str
    lanes: int
    flags: tuple[str, ...]
    parts: bool = False
    single: bool = False


VECTORS = ("-O2", *vector_flags(), *require_compiler().scheduling)
BUILDS = (
    Build("CasADi's C, -O3", 0, ("-O3",)),
    Build("CasADi's C, -O3, vector instructions", 0, ("-O3", *vector_flags())),
    Build("one lane", 1, ("-O2", "-ffp-contract=off")),
    Build("lanes, portable", widest(), ("-ffp-contract=off", *VECTORS)),
    Build("lanes, portable, in parts", widest(), ("-ffp-contract=off", *VECTORS), True),
    Build("lanes, fast, in parts", widest(), VECTORS, True),
    Build("lanes of float, fast, in parts", 2 * widest(), ("-DMEHVAR_FLOAT", *VECTORS), True, True),
)


def main() -> None:
    """Measure every case and write the table."""
    rows = []
    with tempfile.TemporaryDirectory() as scratch:
        for title, (name, structure) in CASES.items():
            folder = Path(scratch) / title.replace(" ", "_")
            generate(installed_tree(), name, folder, structure, casadi=True)
            rows += [[title, *row] for row in measured(load(folder, backend="c"), folder)]
    columns = ["right-hand side", "build", "operations", "ns per call and run", "least", "CasADi -O3 over it"]
    lines = ["# The right-hand side in lanes", "", *_head(), "", *table(columns, rows), "", *_verdicts(rows)]
    write("batch_rhs.md", lines)


def _head() -> list[str]:
    return [
        "Written by `python -m benchmarks.batch.rhs`. `rhs` of each model as a batch calls it, against CasADi's own C",
        "of the same graph; 'in parts': without what is computed once per run or held input.",
        "",
        *machine(),
        f"- {widest()} lanes of double, {2 * widest()} of float; processor time, medians of {REPEATS} repeats in which",
        "  all builds take turns; no AVX-512 on this processor: not run" if widest() < 8 else "  all builds take turns",
    ]


def _verdicts(rows: list[list[str]]) -> list[str]:
    """Compare with the targets: 6 times (AVX-512) or 4 times the speed of CasADi's C, float 1.7 times double."""
    least, found = (6 if widest() == 8 else 4), []
    for title in CASES:
        ns = {row[1]: float(row[3]) for row in rows if row[0] == title}
        double = min(v for k, v in ns.items() if k.startswith("lanes,"))
        ratio, single = ns[BUILDS[0].title] / double, double / ns[BUILDS[-1].title]
        found.append([title, f"{ratio:.1f}", "yes" if ratio >= least else "no", f"{single:.1f}",
                      "yes" if single >= 1.7 else "no"])  # fmt: skip
    columns = ["right-hand side", "CasADi -O3 over the best double", f"at least {least}", "double over float",
               "at least 1.7"]  # fmt: skip
    return table(columns, found)


def measured(model: Model, folder: Path) -> list[list[str]]:
    """Time all builds of one model, in turns."""
    jobs = {build.title: compiled(model, folder, build) for build in BUILDS}
    times: dict[str, list[float]] = {title: [] for title in jobs}
    for _ in range(REPEATS):
        for title, job in jobs.items():
            start = process_time()
            job()
            times[title].append((process_time() - start) / CALLS * 1e9)
    functions, base = model.manifest.functions, median(times[BUILDS[0].title])
    rows = []
    for build in BUILDS:
        name = "rhs_prepared" if build.parts and "rhs_prepared" in functions else "rhs"
        ns, least = median(times[build.title]), min(times[build.title])
        rows.append([build.title, str(functions[name].operations), f"{ns:.1f}", f"{least:.1f}", f"{base / ns:.1f}"])
    return rows


def compiled(model: Model, folder: Path, build: Build) -> Callable[[], object]:
    """Compile one build, check its result, and return the function that calls it."""
    sizes = {"nx": len(model.state_names), "nu": len(model.input_names), "np": len(model.parameter_names)}
    common = {"model": model.name, "blocks": BLOCKS, **sizes}
    driver = OURS.format(**common, **_parts(model, build.parts)) if build.lanes else CASADI.format(**common)
    tag = f"{build.lanes}-{abs(hash(build))}"
    (folder / f"{tag}.c").write_text(driver)
    units = [f"{model.name}.c", f"{model.name}_prepared.c"] if build.lanes else [f"{model.name}_casadi.c"]
    flags = ["-std=gnu11", "-fPIC", "-shared", "-fno-math-errno", "-fno-trapping-math", "-Wno-psabi", *build.flags]
    flags += [f"-DMEHVAR_LANES={build.lanes}", f"-I{INCLUDE}"] if build.lanes else []
    command = [*require_compiler().command, *flags, f"{tag}.c", *units, "-o", f"{tag}.so", "-lm"]
    subprocess.run(command, cwd=folder, check=True)
    library = ctypes.CDLL(str(folder / f"{tag}.so"))
    generator = np.random.default_rng(1)
    x, u, p = generator.uniform(0.1, 0.5, sizes["nx"]), generator.uniform(0.1, 0.5, sizes["nu"]), model.parameters()
    library.start(*(v.ctypes.data_as(ctypes.c_void_p) for v in (x, u, p)))
    library.work(ctypes.c_long(64))
    found = np.empty(sizes["nx"])
    library.result(found.ctypes.data_as(ctypes.c_void_p))
    tolerance = 1e-3 if build.single else 1e-11
    np.testing.assert_allclose(found, model.rhs(x, u, p), rtol=tolerance, atol=tolerance)
    return functools.partial(library.work, ctypes.c_long(CALLS))


def _parts(model: Model, parts: bool) -> dict[str, object]:
    """Return the preparation, the call, and the sizes of the vectors that pass between them."""
    functions = model.manifest.functions
    steps = [f"rhs_{step}" for step in ("prepare", "hold") if parts and f"rhs_{step}" in functions]
    sizes = {f"n{functions[name].results[0].name}": functions[name].results[0].size for name in steps}
    call = "rhs_prepared" if steps else "rhs"
    return {"nh": 0, "nw": 0, **sizes, "before": " ".join(_call(model, s) for s in steps), "call": _call(model, call)}


def _call(model: Model, name: str) -> str:
    function = model.manifest.functions[name]
    arrays = ", ".join(f"{a.name}_" for a in (*function.arguments, *function.results))
    return f"{model.name}_{name}({arrays});"


if __name__ == "__main__":
    command_line(__doc__).parse_args()
    main()
