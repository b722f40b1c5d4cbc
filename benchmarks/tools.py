# SPDX-License-Identifier: Apache-2.0
"""Cost of a call in the tools to which a model is exported, compared with ctypes in the same process.

Run: python -m benchmarks.tools, in the environment of `make peers`; a package that is not there leaves its rows out.
"""

from __future__ import annotations

import ctypes
import importlib.util
import resource
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from statistics import median
from time import perf_counter, process_time
from typing import Any

import numpy as np

import mehvar
from benchmarks.machine import command_line, machine, table, write
from mehvar.runtime.compiling.library import INCLUDE
from mehvar.runtime.model.functions import CBackend

MODELS = ("triangle", "slosh", "satellite")
LAWS = {"triangle": "path", "slosh": "lyapunov-v1", "satellite": "pd"}
TRIMS: dict[str, dict[str, Any]] = {
    "triangle": {"fix": {"rho": 0.3, "mu": 1.0}, "free": ["w1", "w2", "w3"], "steady": ["rho", "phi", "mu"]},
    "slosh": {
        "fix": {"vx": 3000.0},
        "free": ["My", "Mz", "delta1", "delta2"],
        "steady": ["vy", "vz", "wx", "wy", "wz"],
    },
    "satellite": {"fix": {"hy": 0.05}, "free": (turn := ["roll", "pitch", "yaw", "wx", "wy", "wz"]), "steady": turn},
}
"""Inputs of the tutorials; a user's own system has free inputs."""
ROUNDS, CALLS = 30, 100
STARTS = 15


def main() -> None:
    """Measure, and write the page."""
    models = {name: mehvar.load(name) for name in MODELS} | _own()
    rows = [row for name, model in models.items() for row in _calls(name, model)]
    runs = [_run(name, model) for name, model in models.items()]
    trims = [_trim(name, model) for name, model in models.items()]
    lines = [
        "# Calls from other tools",
        "",
        "Written by `python -m benchmarks.tools`. Each row takes turns with ctypes on the same compiled function, as a",
        "user would call it (`x.ctypes.data`): microseconds of the median round, and the median of the ratios.",
        "Agreement is the largest difference to that C over its largest element. `own` is what `mehvar new` writes.",
        "*C++17* is a loop in C++ around the generated C, without Python; *FMU* the plant by FMI 2.0 in FMPy, with",
        "one directional derivative for each state; *lines* are what a user writes after the imports. JAX and Numba",
        "compile the Jacobian of the largest system for a minute and more: not measured.",
        "",
        "## Machine",
        "",
        *machine(),
        "",
        "## One call at one point",
        "",
        *table(["system", "function", "target", "lines", "agreement", "µs", "ctypes µs", "ratio"], rows),
        "",
        "## Trim",
        "",
        "`mehvar.trim` with the unknowns of the tutorials: the largest rate that is left, and time of the median call.",
        "",
        *table(["system", "lines", "unknowns", "evaluations", "rate left", "ms"], trims),
        "",
        "## A warm run of one second",
        "",
        "Processor time of 40 calls of `mehvar.simulate`, dataset included, and the part in C, which is wall time.",
        "",
        *table(["system", "least ms", "median ms", "integration ms", "target ms"], runs),
        "",
        "## Starting",
        "",
        f"Processor time of {STARTS} new processes; for the import, less that of an empty Python.",
        "",
        *table(["command", "least s", "median s", "target s"], _starts()),
    ]
    write("tools.md", lines)


def _own() -> dict[str, mehvar.Model]:
    folder = Path(tempfile.mkdtemp())
    for words in (["new", "own"], ["generate", "own"]):
        command = [sys.executable, "-m", "mehvar", *words]
        place = folder if words[0] == "new" else folder / "own"
        if subprocess.run(command, cwd=place, capture_output=True, check=False).returncode:
            return {}
    return {"own": mehvar.load(folder / "own" / "generated" / "own")}


def _calls(name: str, model: mehvar.Model) -> list[list[str]]:
    p = model.parameters()
    case = model.manifest.scenario(None)
    s = np.array([case.values.get(q.name, q.default) for q in model.manifest.scenario_parameters])
    x, u = np.asarray(model.functions["initial"](p, s)), np.full(len(model.input_names), 0.1)
    rows = []
    for function in ("rhs", "jac_x"):
        reference = model.functions[function](x, u, p)
        rows.append([name, function, *_cplusplus(model, function, x, u, p, reference)])
        plain = _ctypes(model, function, x, u, p, np.empty_like(reference))
        for target, lines, call in _targets(model, function, x, u, p):
            value = np.asarray(call()).reshape(reference.shape)
            scale = np.max(np.abs(reference)) or 1.0
            ours, theirs = _paired(call, plain)
            ratio = median(a / b for a, b in zip(ours, theirs, strict=True))
            numbers = [
                f"{np.max(np.abs(value - reference)) / scale:.1e}",
                f"{median(ours):.2f}",
                f"{median(theirs):.2f}",
            ]
            rows.append([name, function, target, str(lines), *numbers, f"{ratio:.2f}"])
    return rows


def _ctypes(model: mehvar.Model, function: str, x, u, p, out) -> Callable[[], object]:
    assert isinstance(model.evaluator, CBackend)
    call = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 4)(model.evaluator.address(function))
    return lambda: call(x.ctypes.data, u.ctypes.data, p.ctypes.data, out.ctypes.data)


def _targets(model: mehvar.Model, function: str, x, u, p):
    """Yield a name, the lines that a user writes, and the call."""
    method = getattr(model, function)
    yield "mehvar", 1, lambda: method(x, u, p)
    fun, jac, _, _ = model.as_solve_ivp(u=u, p=p)
    yield "SciPy", 1, (lambda: fun(0.0, x)) if function == "rhs" else (lambda: jac(0.0, x))
    symbolic = model.to_casadi(function)
    yield "CasADi", 1, lambda: symbolic(x, u, p).full()
    if importlib.util.find_spec("fmpy"):
        yield "FMU", 3, _unit(model, function, x, u, p)
    if function == "jac_x" and len(x) > 15:
        return  # compiling it takes a minute and more in Numba and JAX
    if importlib.util.find_spec("jax"):
        import jax

        jax.config.update("jax_enable_x64", True)
        compiled = jax.jit(getattr(model.to_jax(), function))
        yield "JAX jit", 2, lambda: compiled(x, u, p).block_until_ready()
        if function == "jac_x":
            derived = jax.jit(jax.jacfwd(model.to_jax().rhs))
            yield "JAX jit of jacfwd of rhs", 2, lambda: derived(x, u, p).block_until_ready()
        else:
            many = jax.jit(jax.vmap(model.to_jax().rhs, (0, None, None)))
            yield "JAX jit of vmap, a batch of one", 2, lambda: many(x[None], u, p).block_until_ready()
    if importlib.util.find_spec("numba"):
        fast = getattr(model.to_numba(), function)
        yield "Numba", 1, lambda: fast(x, u, p)
    if importlib.util.find_spec("control"):
        plant = model.to_nlsys(p)
        if function == "rhs":
            yield "python-control", 1, lambda: plant.dynamics(0.0, x, u)


def _unit(model: mehvar.Model, function: str, x, u, p) -> Callable[[], object]:
    """Return a function that evaluates the plant as a functional mock-up unit."""
    import fmpy
    from fmpy.fmi2 import FMU2Model

    path, size = Path(tempfile.mkdtemp()) / "plant.fmu", len(x)
    mehvar.export_fmu(model.manifest.folder, path, kind="me")
    about = fmpy.read_model_description(str(path))
    references = {variable.name: variable.valueReference for variable in about.modelVariables}
    names = {"guid": about.guid, "modelIdentifier": about.modelExchange.modelIdentifier}
    unit = FMU2Model(unzipDirectory=fmpy.extract(str(path)), **names)
    unit.instantiate()
    values = dict(zip(model.parameter_names, p, strict=True)) | dict(zip(model.input_names, u, strict=True))
    known = {references[name]: float(value) for name, value in values.items() if name in references}
    unit.setReal(list(known), list(known.values()))
    unit.setupExperiment(startTime=0.0)
    unit.enterInitializationMode()
    unit.exitInitializationMode()
    state, rates = (ctypes.c_double * size)(*x), (ctypes.c_double * size)()
    states = [references[name] for name in model.state_names]
    derivatives = [d.variable.valueReference for d in about.derivatives]

    def rhs() -> object:
        unit.setContinuousStates(state, size)
        unit.getDerivatives(rates, size)
        return np.array(rates)

    def jac_x() -> object:
        unit.setContinuousStates(state, size)
        return np.array([unit.getDirectionalDerivative(derivatives, [s], [1.0]) for s in states]).T

    return rhs if function == "rhs" else jac_x


_LOOP = """#include "{header}.h"
extern "C" double repeat(const double *x, const double *u, const double *p, double *out, long calls);
#include <chrono>
double repeat(const double *x, const double *u, const double *p, double *out, long calls)
{{
    const auto start = std::chrono::steady_clock::now();
    for (long k = 0; k < calls; k++) {name}_{function}(x, u, p, out);
    return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count() / calls;
}}
"""


def _cplusplus(model: mehvar.Model, function: str, x, u, p, reference) -> list[str]:
    """Return target, lines, agreement and time of a loop in C++, built with two lines of CMake."""
    folder, place, name = model.manifest.folder, Path(tempfile.mkdtemp()), model.name
    (place / "loop.cc").write_text(_LOOP.format(header=name, name=name, function=function))
    source = folder / model.manifest.functions[function].file
    paths = ["-O2", "-ffp-contract=off", "-fPIC", f"-I{folder}", f"-I{INCLUDE}"]
    subprocess.run(["cc", *paths, "-c", source, "-o", place / "model.o"], check=True)
    made = [place / "loop.cc", place / "model.o", "-lm", "-o", place / "loop.so"]
    subprocess.run(["c++", "-std=c++17", *paths, "-shared", *made], check=True)
    repeat = ctypes.CDLL(str(place / "loop.so")).repeat
    repeat.restype = ctypes.c_double
    out = np.empty_like(reference)
    pointers = [ctypes.c_void_p(array.ctypes.data) for array in (x, u, p, out)]
    times = [repeat(*pointers, ctypes.c_long(CALLS)) for _ in range(ROUNDS)]
    scale = np.max(np.abs(reference)) or 1.0
    return ["C++17", "4", f"{np.max(np.abs(out - reference)) / scale:.1e}", f"{median(times):.2f}", "", ""]


def _trim(name: str, model: mehvar.Model) -> list[str]:
    search, times = TRIMS.get(name) or {"free": list(model.input_names)}, []
    for _ in range(ROUNDS):
        start = perf_counter()
        point = mehvar.trim(model, **search)
        times.append((perf_counter() - start) * 1e3)
    left = f"{np.max(np.abs(point.residual)):.1e}"
    return [name, "1", str(len(search["free"])), str(point.evaluations), left, f"{median(times):.2f}"]


def _paired(first: Callable[[], object], second: Callable[[], object]) -> tuple[list[float], list[float]]:
    times: tuple[list[float], list[float]] = ([], [])
    for _ in range(ROUNDS):
        for job, into in zip((first, second), times, strict=True):
            start = perf_counter()
            for _ in range(CALLS):
                job()
            into.append((perf_counter() - start) / CALLS * 1e6)
    return times


def _run(name: str, model: mehvar.Model) -> list[str]:
    from mehvar.runtime.run.simulate import simulate

    law, times = LAWS.get(name) or next(iter(model.manifest.controllers)), []
    for _ in range(41):
        start = process_time()
        mehvar.simulate(model.manifest.folder, law, t_end=1.0)
        times.append((process_time() - start) * 1e3)
    inside = simulate(model.manifest.folder, law, t_end=1.0).run_seconds * 1e3
    return [name, f"{min(times[1:]):.2f}", f"{median(times[1:]):.2f}", f"{inside:.2f}", "2"]


def _starts() -> list[list[str]]:
    """Return the processor time of a start; the commands take turns."""
    commands = {
        "mehvar --version": ("-m", "mehvar", "--version"),
        "import mehvar": ("-c", "import mehvar"),
        "empty": ("-c", "0"),
    }
    times: dict[str, list[float]] = {name: [] for name in commands}
    for _ in range(STARTS):
        for name, words in commands.items():
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            subprocess.run([sys.executable, *words], check=True, capture_output=True)
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            times[name].append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    empty = times.pop("empty")
    times["import mehvar"] = [a - b for a, b in zip(times["import mehvar"], empty, strict=True)]
    targets = {"mehvar --version": "0.2", "import mehvar": "0.06"}
    return [[f"`{name}`", f"{min(t):.3f}", f"{median(t):.3f}", targets[name]] for name, t in times.items()]


if __name__ == "__main__":
    command_line(__doc__).parse_args()
    main()
