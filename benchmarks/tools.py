# SPDX-License-Identifier: Apache-2.0
"""What a call costs in the tools that a model is taken into, beside ctypes in the same process.

Run: python benchmarks/tools.py, in the environment of `make peers`; a package that is not there leaves its rows out.
"""

from __future__ import annotations

import ctypes
import importlib.util
import tempfile
from collections.abc import Callable
from pathlib import Path
from statistics import median
from time import perf_counter

import numpy as np
from machine import command_line, machine, table, write

import mehvar
from mehvar.runtime.model.functions import CBackend

MODELS = ("triangle", "slosh", "satellite")
LAWS = {"triangle": "path", "slosh": "lyapunov-v1", "satellite": "pd"}
ROUNDS, CALLS = 30, 100


def main() -> None:
    """Measure, and write the page."""
    models = {name: mehvar.load(name) for name in MODELS} | _own()
    rows = [row for name, model in models.items() for row in _calls(name, model)]
    runs = [_run(name) for name in MODELS]
    lines = [
        "# Calls from other tools",
        "",
        "Written by `python benchmarks/tools.py`. Each row takes turns with ctypes on the same compiled function, as a",
        "user would call it (`x.ctypes.data`): microseconds of the median round, and the median of the ratios.",
        "Agreement is the largest difference to that C over its largest element. `own` is what `mehvar new` writes.",
        "",
        "## Machine",
        "",
        *machine(),
        "",
        "## One call at one point",
        "",
        *table(["system", "function", "target", "lines", "agreement", "µs", "ctypes µs", "ratio"], rows),
        "",
        "## A warm run of one second",
        "",
        "The least and the median of 40 calls of `mehvar.simulate`, dataset included, and the part in C.",
        "",
        *table(["system", "least ms", "median ms", "integration ms"], runs),
    ]
    write("tools.md", lines)


def _own() -> dict[str, mehvar.Model]:
    import subprocess
    import sys

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
    if function == "jac_x" and len(x) > 15:
        return  # compiling it takes a minute and more in Numba and JAX
    symbolic = model.to_casadi(function)
    yield "CasADi", 1, lambda: symbolic(x, u, p).full()
    if importlib.util.find_spec("jax"):
        import jax

        jax.config.update("jax_enable_x64", True)
        compiled = jax.jit(getattr(model.to_jax(), function))
        yield "JAX jit", 2, lambda: compiled(x, u, p).block_until_ready()
    if importlib.util.find_spec("numba"):
        fast = getattr(model.to_numba(), function)
        yield "Numba", 1, lambda: fast(x, u, p)
    if importlib.util.find_spec("control"):
        plant = model.to_nlsys(p)
        if function == "rhs":
            yield "python-control", 1, lambda: plant.dynamics(0.0, x, u)


def _paired(first: Callable[[], object], second: Callable[[], object]) -> tuple[list[float], list[float]]:
    times: tuple[list[float], list[float]] = ([], [])
    for _ in range(ROUNDS):
        for job, into in zip((first, second), times, strict=True):
            start = perf_counter()
            for _ in range(CALLS):
                job()
            into.append((perf_counter() - start) / CALLS * 1e6)
    return times


def _run(name: str) -> list[str]:
    from mehvar.runtime.run.simulate import simulate

    times = []
    for _ in range(41):
        start = perf_counter()
        mehvar.simulate(name, LAWS[name], t_end=1.0)
        times.append((perf_counter() - start) * 1e3)
    inside = simulate(name, LAWS[name], t_end=1.0).run_seconds * 1e3
    return [name, f"{min(times[1:]):.2f}", f"{median(times[1:]):.2f}", f"{inside:.2f}"]


if __name__ == "__main__":
    command_line(__doc__).parse_args()
    main()
