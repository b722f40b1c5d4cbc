# SPDX-License-Identifier: Apache-2.0
"""mehvar's kernel and other integrators on one problem; each returns the final states of the first n runs."""

from __future__ import annotations

import importlib
import subprocess
import tempfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import numpy as np

from benchmarks.peers.equations import ARITHMETIC, Compiled, Operations, array_operations, walk
from benchmarks.peers.problem import Array, Problem
from mehvar.runtime.compiling.compiler import require_compiler
from mehvar.runtime.compiling.processor import widest

Integrate = Callable[[int], Array]
"""Integrates the first n runs and returns their states at the end, one row each."""


@dataclass(frozen=True)
class Contender:
    """One integrator at one setting.

    Attributes
    ----------
    name, setting : str
        What it is, and its tolerance or number of steps.
    runs : int
        How many are integrated for one timing.
    set_up : float
        Processor time of building it, s.
    """

    name: str
    setting: str
    runs: int
    integrate: Integrate
    set_up: float


OURS = (("dop853", "fast"), ("dop853", "portable"), ("dopri5", "portable"))
OURS_IN_LOOPS = (*OURS, *((method, "portable") for method in ("rock4", "rodas5p", "auto")))


def ours(
    given: Problem, tolerances: tuple[float, ...], ways: tuple[tuple[str, str], ...] = OURS
) -> Iterator[Contender]:
    """mehvar's kernel: methods and profiles."""
    for method, profile in ways:
        for tolerance in tolerances:
            options = {"method": method, "profile": profile, "rtol": tolerance, "atol": tolerance}
            yield _built(
                f"mehvar {method}, {profile}", f"{tolerance:.0e}", len(given.start), Problem.ours, given, options
            )


def ours_rk4(given: Problem, steps: int, real: tuple[str, ...] = ("portable", "fast")) -> Iterator[Contender]:
    """mehvar's kernel with the same number of steps of rk4."""
    for profile in real:
        options = {"method": "rk4", "profile": profile, "step": given.case.t_end / steps}
        yield _built(f"mehvar rk4, {profile}", f"{steps} steps", len(given.start), Problem.ours, given, options)


def heyoka(given: Problem, tolerances: tuple[float, ...], compact: bool) -> Iterator[Contender]:
    """Taylor series in batches of the width that heyoka recommends, one object for all batches."""
    for tolerance in tolerances:
        name = f"heyoka taylor batch, compact_mode={compact}"
        yield _built(name, f"{tolerance:.0e}", 256, _heyoka, given, tolerance, compact)
    yield _built("heyoka, its calls from Python alone", "no steps", 256, _heyoka, given, 1e-6, compact, 0.0)


def heyoka_flags(given: Problem, tolerances: tuple[float, ...]) -> Iterator[Contender]:
    """heyoka with `fast_math`, and with mehvar's width: it recommends four lanes where AVX-512 has eight."""
    recommended, ours = importlib.import_module("heyoka").recommended_simd_size(), widest()
    ways: list[tuple[int, dict[str, bool]]] = [(recommended, {"fast_math": True})]
    if ours == 8:
        ways.append((ours, {"fast_math": True, "force_avx512": True}))
    for width, flags in ways:
        name = f"heyoka taylor batch, {width} lanes, {', '.join(flags)}"
        for tolerance in tolerances:
            yield _built(name, f"{tolerance:.0e}", 256, _heyoka, given, tolerance, False, 1.0, width, flags)


def heyoka_operations(hy: Any) -> Operations:
    """Return heyoka's operations; piecewise expressions become selects, whose kinks it does not locate."""
    same = {name: getattr(hy, name) for name in ("sin", "cos", "sqrt", "asin", "acos", "atan2", "select")}

    def choose(condition: Any, one: Any, other: Any) -> Any:
        return hy.select(condition, hy.expression(one), hy.expression(other))

    return {
        **ARITHMETIC,
        **same,
        "select": choose,
        "select0": lambda m, a: choose(m, a, 0.0),
        "lt": lambda a, b: hy.lt(hy.expression(a), hy.expression(b)),
        "le": lambda a, b: hy.lte(hy.expression(a), hy.expression(b)),
        "min": lambda a, b: choose(hy.lt(hy.expression(a), hy.expression(b)), a, b),
        "max": lambda a, b: choose(hy.lt(hy.expression(a), hy.expression(b)), b, a),
        "fabs": lambda a: choose(hy.lt(a, hy.expression(0.0)), -a, a),
        "sign": lambda a: choose(hy.lt(a, hy.expression(0.0)), -1.0, 1.0),
    }


def _heyoka_system(given: Problem) -> Any:
    hy = importlib.import_module("heyoka")
    operations = heyoka_operations(hy)
    x = hy.make_vars(*(f"x{i}" for i in range(given.start.shape[1])))
    k = [hy.par[i] for i in range(given.k.shape[1])]
    (slopes,) = walk(given.slope.tape, [x, k], operations)
    return list(zip(x, (slope + 0.0 * x[0] if isinstance(slope, float) else slope for slope in slopes), strict=True))


def _heyoka(
    given: Problem,
    tolerance: float,
    compact: bool,
    part: float = 1.0,
    width: int | None = None,
    flags: Mapping[str, bool] | None = None,
) -> Integrate:
    hy = importlib.import_module("heyoka")
    width = width or hy.recommended_simd_size()
    nx, nk = given.start.shape[1], given.k.shape[1]
    zeros = np.zeros((nx, width))
    integrator = hy.taylor_adaptive_batch(
        _heyoka_system(given), zeros, pars=np.zeros((nk, width)), tol=tolerance, compact_mode=compact, **(flags or {})
    )
    goal = np.full(width, part * given.case.t_end)

    def integrate(n: int) -> Array:
        final = np.empty((n, nx))
        for first in range(0, n, width):
            integrator.set_time(0.0)
            integrator.state[:] = given.start[first : first + width].T
            integrator.pars[:] = given.k[first : first + width].T
            integrator.propagate_until(goal)
            final[first : first + width] = integrator.state.T
        return final

    return integrate


def heyoka_ensemble(given: Problem, tolerances: tuple[float, ...]) -> Iterator[Contender]:
    """heyoka's ensemble call, which copies its object for each batch."""
    for tolerance in tolerances:
        yield _built("heyoka ensemble of batches", f"{tolerance:.0e}", 128, _heyoka_ensemble, given, tolerance)


def _heyoka_ensemble(given: Problem, tolerance: float) -> Integrate:
    hy = importlib.import_module("heyoka")
    width, (nx, nk) = hy.recommended_simd_size(), (given.start.shape[1], given.k.shape[1])
    integrator = hy.taylor_adaptive_batch(
        _heyoka_system(given), np.zeros((nx, width)), pars=np.zeros((nk, width)), tol=tolerance, compact_mode=True
    )

    def start(copy: Any, iteration: int) -> Any:
        rows = slice(iteration * width, (iteration + 1) * width)
        copy.set_time(0.0)
        copy.state[:] = given.start[rows].T
        copy.pars[:] = given.k[rows].T
        return copy

    def integrate(n: int) -> Array:
        found = hy.ensemble_propagate_until_batch(integrator, given.case.t_end, n // width, start)
        return np.concatenate([row[0].state.T for row in found])

    return integrate


def numba_rk4(given: Problem, steps: int) -> Iterator[Contender]:
    """Classical rk4 over compiled scalar code, with fastmath."""
    yield _built("numba rk4, fastmath", f"{steps} steps", 512, _numba_rk4, given, steps)


_RK4 = """
def rk4(x0, k, h, steps, final):
    n = x0.shape[1]
    k1, k2, k3, k4, y = np.empty(n), np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    for run in range(x0.shape[0]):
        x = final[run]
        x[:] = x0[run]
        for _ in range(steps):
            slope(x, k[run], k1)
            for i in range(n):
                y[i] = x[i] + 0.5 * h * k1[i]
            slope(y, k[run], k2)
            for i in range(n):
                y[i] = x[i] + 0.5 * h * k2[i]
            slope(y, k[run], k3)
            for i in range(n):
                y[i] = x[i] + h * k3[i]
            slope(y, k[run], k4)
            for i in range(n):
                x[i] += h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i])
"""


def _numba_rk4(given: Problem, steps: int) -> Integrate:
    numba = importlib.import_module("numba")
    namespace = {"np": np, "slope": Compiled(numba).add(given.slope)}
    exec(_RK4, namespace)
    rk4: Any = numba.njit(fastmath=True)(namespace["rk4"])

    def integrate(n: int) -> Array:
        final = np.empty((n, given.start.shape[1]))
        rk4(given.start[:n], given.k[:n], given.case.t_end / steps, steps, final)
        return final

    return integrate


def scipy_lsoda(given: Problem, tolerances: tuple[float, ...]) -> Iterator[Contender]:
    """LSODA of ODEPACK through odeint, on a right-hand side that numba has compiled."""
    for tolerance in tolerances:
        yield _built("scipy LSODA, numba right-hand side", f"{tolerance:.0e}", 64, _scipy_lsoda, given, tolerance)


def _scipy_lsoda(given: Problem, tolerance: float) -> Integrate:
    numba, odeint = importlib.import_module("numba"), importlib.import_module("scipy.integrate").odeint
    namespace = {"np": np, "slope": Compiled(numba).add(given.slope)}
    exec("def right(x, t, k):\n    dx = np.empty_like(x)\n    slope(x, k, dx)\n    return dx\n", namespace)
    right: Any = numba.njit(namespace["right"])
    times = np.array([0.0, given.case.t_end])

    def integrate(n: int) -> Array:
        return np.array(
            [
                odeint(right, x, times, args=(k,), rtol=tolerance, atol=tolerance, mxstep=100_000)[-1]
                for x, k in zip(given.start[:n], given.k[:n], strict=True)
            ]
        )

    return integrate


ADAMS = {"linear_multistep_method": "adams", "nonlinear_solver_iteration": "functional"}
BDF = {"linear_multistep_method": "bdf", "nonlinear_solver_iteration": "newton"}


def casadi_cvodes(given: Problem, tolerances: tuple[float, ...], scratch: Path) -> Iterator[Contender]:
    """CVODES of SUNDIALS through casadi.integrator, on casadi's C, compiled with -O3; by Adams."""
    for tolerance in tolerances:
        yield _built("casadi cvodes, compiled right-hand side", f"{tolerance:.0e}", 64, _cvodes, given, tolerance,
                     scratch, ADAMS)  # fmt: skip


def casadi_bdf(given: Problem, tolerances: tuple[float, ...], scratch: Path) -> Iterator[Contender]:
    """The same with backward differences and the compiled Jacobian, for stiff loops."""
    for tolerance in tolerances:
        yield _built("casadi cvodes, BDF, compiled Jacobian", f"{tolerance:.0e}", 64, _cvodes, given, tolerance,
                     scratch, BDF)  # fmt: skip


def _casadi_operations(ca: Any) -> Operations:
    """Return CasADi's operations, in which conditions are numbers."""
    same = ("sin", "cos", "sqrt", "asin", "acos", "atan", "atan2", "fabs", "sign")
    return {
        **ARITHMETIC,
        **{name: getattr(ca, name) for name in same},
        **{"min": ca.fmin, "max": ca.fmax, "lt": lambda a, b: a < b, "le": lambda a, b: a <= b},
        **{"select": ca.if_else, "select0": lambda m, a: ca.if_else(m, a, 0.0)},
    }


def _cvodes(given: Problem, tolerance: float, scratch: Path, method: Mapping[str, str]) -> Integrate:
    ca = importlib.import_module("casadi")
    operations = _casadi_operations(ca)
    x, k = ca.SX.sym("x", given.start.shape[1]), ca.SX.sym("k", given.k.shape[1])
    (slopes,) = walk(given.slope.tape, [ca.vertsplit(x), ca.vertsplit(k)], operations)
    graph = ca.Function("slope", [x, k], [ca.vertcat(*slopes)])
    source, library = scratch / "slope.c", Path(tempfile.mkdtemp(dir=scratch)) / "slope.so"
    code = ca.CodeGenerator(source.name)
    for wanted in (graph, graph.jacobian()):  # cvodes asks for the Jacobian, though Adams' iteration does not use it
        code.add(wanted)
    code.generate(f"{scratch}/")
    flags = ["-O3", "-march=native", "-shared", "-fPIC"]
    subprocess.run([*require_compiler().command, *flags, str(source), "-o", str(library), "-lm"], check=True)
    slope = ca.external("slope", str(library))
    x, k = ca.MX.sym("x", given.start.shape[1]), ca.MX.sym("k", given.k.shape[1])
    dae = {"x": x, "p": k, "ode": slope(x, k)}
    options = {
        **{"abstol": tolerance, "reltol": tolerance, "max_num_steps": 1_000_000},
        **method,
    }
    integrator = ca.integrator("I", "cvodes", dae, 0.0, given.case.t_end, options)

    def integrate(n: int) -> Array:
        rows = zip(given.start[:n], given.k[:n], strict=True)
        return np.array([integrator(x0=row, p=constants)["xf"].full()[:, 0] for row, constants in rows])

    return integrate


def jax_rk4(given: Problem, steps: int) -> Iterator[Contender]:
    """The same rk4 over jax.vmap, compiled by XLA for the processor."""
    yield _built("jax vmap rk4", f"{steps} steps", 512, _jax_rk4, given, steps)


def _jax_slope(given: Problem) -> Callable[[Any, Any], Any]:
    jax = importlib.import_module("jax")
    jax.config.update("jax_enable_x64", True)
    xp: Any = importlib.import_module("jax.numpy")
    operations = array_operations(xp)
    return lambda x, k: xp.stack([xp.asarray(v) for v in walk(given.slope.tape, [x, k], operations)[0]])


def _jax_rk4(given: Problem, steps: int) -> Integrate:
    jax = importlib.import_module("jax")
    slope, h = _jax_slope(given), given.case.t_end / steps

    def step(_: Any, x: Any, k: Any) -> Any:
        k1 = slope(x, k)
        k2 = slope(x + 0.5 * h * k1, k)
        k3 = slope(x + 0.5 * h * k2, k)
        return x + h / 6 * (k1 + 2 * k2 + 2 * k3 + slope(x + h * k3, k))

    run = jax.jit(jax.vmap(lambda x, k: jax.lax.fori_loop(0, steps, lambda i, y: step(i, y, k), x)))
    return lambda n: np.asarray(run(given.start[:n], given.k[:n]))


def diffrax(
    given: Problem, tolerances: tuple[float, ...], solvers: tuple[str, ...] = ("Dopri8", "Tsit5")
) -> Iterator[Contender]:
    """Solvers with adaptive steps over jax.vmap; Kvaerno3 and Kvaerno5 are the implicit ones."""
    for solver in solvers:
        shared = _diffrax(given, solver)
        for tolerance in tolerances:
            yield _built(f"diffrax {solver}", f"{tolerance:.0e}", 256, _at, given, shared, tolerance)


def _at(given: Problem, shared: Callable[[int, float], Array], tolerance: float) -> Integrate:
    return lambda n: shared(n, tolerance)


def _diffrax(given: Problem, solver: str) -> Callable[[int, float], Array]:
    jax, dfx = importlib.import_module("jax"), importlib.import_module("diffrax")
    slope = _jax_slope(given)
    term, t_end = dfx.ODETerm(lambda t, x, k: slope(x, k)), given.case.t_end

    def one(x: Any, k: Any, tolerance: Any) -> Any:
        control = dfx.PIDController(rtol=tolerance, atol=tolerance)
        found = dfx.diffeqsolve(
            term, getattr(dfx, solver)(), 0.0, t_end, None, x, k, stepsize_controller=control, max_steps=None
        )
        return found.ys[-1]

    run = jax.jit(jax.vmap(one, in_axes=(0, 0, None)))
    return lambda n, tolerance: np.asarray(run(given.start[:n], given.k[:n], tolerance))


def _built(name: str, setting: str, runs: int, build: Callable[..., Integrate], given: Any, *more: Any) -> Contender:
    started, wall = process_time(), perf_counter()
    share = given.case.share
    integrate = build(given, *more)
    integrate(8)
    took = process_time() - started
    print(f"  built {name} {setting}: {took:.1f} s CPU, {perf_counter() - wall:.1f} s", flush=True)
    return Contender(name, setting, max(8, round(runs * share)), integrate, took)
