# SPDX-License-Identifier: Apache-2.0
"""The satellite under its sampled law, written for integrators without batches of closed loops.

Measurement, law, actuator and right-hand side are the generated functions, translated from their tapes; the loop
around them is written here once as text and compiled by numba. Between samples rk4 with fixed steps, LSODA or heyoka
integrate.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.peers.contenders import Contender, Integrate, _built, heyoka_operations
from benchmarks.peers.equations import Compiled, Equations, packed, walk
from benchmarks.peers.problem import CHECKED, REFERENCE_TOLERANCE, Array, Case, dispersed
from mehvar.runtime import Model, load
from mehvar.runtime.batch.kernel import compile_kernel
from mehvar.runtime.run.options import RunOptions

SAMPLES = 600
LAW = "mrac"


@dataclass(frozen=True)
class Sampled:
    """The runs, the arguments of their functions, and their final states."""

    case: Case
    model: Model
    equations: Equations
    vectors: tuple[Array, ...]
    given: Mapping[str, Array]
    period: float
    z0: Array
    reference: Array

    def error(self, final: Array) -> Array:
        """Return the relative difference of final states from the reference, for each run."""
        n = min(CHECKED, len(final))
        wanted = self.reference[:n]
        distance: Array = np.max(np.abs(final[:n] - wanted) / (1 + np.abs(wanted)), axis=1)
        return distance

    def ours(self, options: Mapping[str, Any]) -> Integrate:
        """Return mehvar's compiled loop with some options."""
        kernel = compile_kernel(self.model, LAW, options=RunOptions(**options))

        def integrate(n: int) -> Array:
            block = kernel.run(0, *(v[:n] for v in self.vectors), seed=0, t_end=self.case.t_end, dt=self.period)
            assert block is not None
            assert not block.status.any(), "a run ended early"
            return block.final

        return integrate


def sampled(runs: int, share: float) -> Sampled:
    """Draw the runs of the scenario `paper`, which has no noise."""
    model = load("satellite", backend="c")
    p, c, s, x0 = dispersed(model, LAW, "paper", {}, runs)
    c[:] = c[0]  # the law is one; plant and start differ
    period = float(p[0, model.parameter_names.index("Ts")])
    case = Case(f"satellite, {LAW}, {SAMPLES} samples", "satellite", LAW, SAMPLES * period, sample=period, share=share)
    equations, given = Equations("satellite", {}), {"p": p, "c": c, "s": s}
    for role in ("measure", LAW, "actuate", "rhs"):
        for part in equations.parts(role):
            name = f"{part.results[0][0]}_{role}"
            given[name] = np.array(model.functions[part.name](*(given[argument] for argument, _ in part.arguments)))
    r0 = np.array(model.functions["reference"](0.0, p, s))
    arguments = {"x": x0, "r": r0, "p": p, "c": c}
    start = equations[f"{LAW}_start"]
    z0 = np.array(model.functions[start.name](*(arguments[argument] for argument, _ in start.arguments)))
    found = Sampled(case, model, equations, (p, c, s, x0), given, period, z0, np.empty(0))
    exact = found.ours({"rtol": REFERENCE_TOLERANCE, "atol": REFERENCE_TOLERANCE})(CHECKED)
    return Sampled(case, model, equations, (p, c, s, x0), given, period, z0, exact)


_SAMPLE = """
def sample(t, x, u, z, u_cmd, z_next, seen, e, r, {vectors}):
    {reference}
    {measure}
    {law}
    {actuate}
    z[:] = z_next

def run(x0, z0, period, steps, final, {vectors}):
    nx = x0.shape[1]
    k1, k2, k3, k4, y = np.empty(nx), np.empty(nx), np.empty(nx), np.empty(nx), np.empty(nx)
    u, u_cmd, r, e, seen = np.empty({nu}), np.empty({nu}), np.empty({nr}), np.zeros({ne}), np.empty(nx)
    z, z_next, h = np.empty({nz}), np.empty({nz}), period / steps
    for i in range(x0.shape[0]):
        x = final[i]
        x[:] = x0[i]
        z[:] = z0[i]
        u[:] = 0.0
        for tick in range({samples}):
            sample(tick * period, x, u, z, u_cmd, z_next, seen, e, r, {rows})
            for _ in range(steps):
                slope(x, u, k1, {rows})
                for j in range(nx):
                    y[j] = x[j] + 0.5 * h * k1[j]
                slope(y, u, k2, {rows})
                for j in range(nx):
                    y[j] = x[j] + 0.5 * h * k2[j]
                slope(y, u, k3, {rows})
                for j in range(nx):
                    y[j] = x[j] + h * k3[j]
                slope(y, u, k4, {rows})
                for j in range(nx):
                    x[j] += h / 6 * (k1[j] + 2 * k2[j] + 2 * k3[j] + k4[j])

def slope(x, u, dx, {vectors}):
    {rhs}
"""


def _compiled(given: Sampled) -> dict[str, Any]:
    """Compile the functions and the loop around them."""
    numba = importlib.import_module("numba")
    functions, equations = Compiled(numba), given.equations
    names = {"reference": "reference", "measure": "measure", "law": LAW, "actuate": "actuate", "rhs": "rhs"}
    local = {"measure": {}, "law": {"x": "seen", "v": "u"}, "actuate": {}, "rhs": {}, "reference": {}}
    results = {"reference": "r", "measure": "seen", "law": "u_cmd, z_next", "actuate": "u", "rhs": "dx"}
    namespace: dict[str, Any] = {"np": np}
    calls = {}
    for role, name in names.items():
        function = equations.best(name)
        namespace[role] = functions.add(function)
        arguments = [
            f"{argument}_{name}" if argument in ("h", "w") else local[role].get(argument, argument)
            for argument, _ in function.arguments
        ]
        calls[role] = f"{role}({', '.join(arguments)}, {results[role]})"
    sizes = {"nu": given.model.input_names, "nr": given.model.manifest.references, "ne": given.model.manifest.noise}
    text = _SAMPLE.format(
        **calls,
        **{name: len(group) for name, group in sizes.items()},
        nz=given.z0.shape[1],
        samples=SAMPLES,
        vectors=", ".join(given.given),
        rows=", ".join(f"{name}[i]" for name in given.given),
    )
    exec(text, namespace)
    for name in ("slope", "sample", "run"):
        namespace[name] = numba.njit(fastmath=True, error_model="numpy")(namespace[name])
    return namespace


def ours(given: Sampled, tolerances: tuple[float, ...]) -> Iterator[Contender]:
    """mehvar's batch kernel, with each profile, method and tolerance."""
    for profile in ("portable", "fast"):
        for method in ("dopri5", "dop853"):
            for tolerance in tolerances:
                options = {"method": method, "profile": profile, "rtol": tolerance, "atol": tolerance}
                yield _built(f"mehvar {method}, {profile}", f"{tolerance:.0e}", 2048, Sampled.ours, given, options)
        yield _built(
            f"mehvar rk4, {profile}", "1 step", 2048, Sampled.ours, given, {"method": "rk4", "profile": profile}
        )


def numba_rk4(given: Sampled, steps: tuple[int, ...]) -> Iterator[Contender]:
    """The compiled sampled loop, with a number of steps of rk4 from sample to sample."""
    namespace = _compiled(given)
    for count in steps:
        yield _built("numba, rk4", f"{count} a sample", 512, _numba, given, namespace, count)


def _numba(given: Sampled, namespace: dict[str, Any], steps: int) -> Integrate:
    def integrate(n: int) -> Array:
        final = np.empty_like(given.vectors[-1][:n])
        rows = (v[:n] for v in given.given.values())
        namespace["run"](given.vectors[-1][:n], given.z0[:n], given.period, steps, final, *rows)
        return final

    return integrate


def scipy_lsoda(given: Sampled, tolerances: tuple[float, ...]) -> Iterator[Contender]:
    """Python's loop over samples, numba's functions, LSODA between samples."""
    namespace = _compiled(given)
    for tolerance in tolerances:
        yield _built("scipy LSODA, numba functions", f"{tolerance:.0e}", 16, _scipy, given, namespace, tolerance)


def _scipy(given: Sampled, namespace: dict[str, Any], tolerance: float) -> Integrate:
    numba, odeint = importlib.import_module("numba"), importlib.import_module("scipy.integrate").odeint
    names = ", ".join(given.given)
    scope = {"np": np, "slope": namespace["slope"]}
    text = f"def right(x, t, u, {names}):\n    dx = np.empty_like(x)\n    slope(x, u, dx, {names})\n    return dx\n"
    exec(text, scope)
    right: Any = numba.njit(scope["right"])

    def between(i: int, x: Array, u: Array) -> Array:
        rows = tuple(v[i] for v in given.given.values())
        found = odeint(right, x, (0.0, given.period), args=(u, *rows), rtol=tolerance, atol=tolerance)
        return np.ascontiguousarray(found[-1])

    return lambda n: np.array([_loop(given, namespace, i, between) for i in range(n)])


def _loop(given: Sampled, namespace: dict[str, Any], i: int, between: Callable[[int, Array, Array], Array]) -> Array:
    manifest = given.model.manifest
    rows = tuple(v[i] for v in given.given.values())
    x, z, u = given.vectors[-1][i].copy(), given.z0[i].copy(), np.zeros(len(manifest.inputs))
    u_cmd, z_next, seen = np.empty_like(u), np.empty_like(z), np.empty_like(x)
    e, r = np.zeros(len(manifest.noise)), np.empty(len(manifest.references))
    for tick in range(SAMPLES):
        namespace["sample"](tick * given.period, x, u, z, u_cmd, z_next, seen, e, r, *rows)
        x = between(i, x, u)
    return x


def heyoka(given: Sampled, tolerances: tuple[float, ...]) -> Iterator[Contender]:
    """heyoka's batches between samples, numba's functions at them."""
    namespace = _compiled(given)
    for tolerance in tolerances:
        yield _built("heyoka, numba functions", f"{tolerance:.0e}", 64, _heyoka, given, namespace, tolerance)


def _heyoka(given: Sampled, namespace: dict[str, Any], tolerance: float) -> Integrate:
    hy = importlib.import_module("heyoka")
    width, manifest, x0 = hy.recommended_simd_size(), given.model.manifest, given.vectors[-1]
    slope, held = packed(given.equations.best("rhs"), "x")
    states = hy.make_vars(*(f"x{i}" for i in range(x0.shape[1])))
    (slopes,) = walk(slope.tape, [states, [hy.par[i] for i in range(len(held))]], heyoka_operations(hy))
    integrator = hy.taylor_adaptive_batch(
        list(zip(states, slopes, strict=True)),
        np.zeros((x0.shape[1], width)),
        pars=np.zeros((len(held), width)),
        tol=tolerance,
        compact_mode=False,
    )
    fixed = {k: (f"{name}_rhs" if name in ("h", "w") else name, e) for k, (name, e) in enumerate(held) if name != "u"}
    inputs = {k: e for k, (name, e) in enumerate(held) if name == "u"}
    nu, nz = len(manifest.inputs), given.z0.shape[1]
    u_cmd, z_next, seen = np.empty(nu), np.empty(nz), np.empty(x0.shape[1])
    e, r = np.zeros(len(manifest.noise)), np.empty(len(manifest.references))
    pace = np.full(width, given.period)

    def integrate(n: int) -> Array:
        final = np.empty((n, x0.shape[1]))
        for first in range(0, n, width):
            lanes = range(first, first + width)
            integrator.set_time(0.0)
            integrator.state[:] = x0[first : first + width].T
            for k, (name, element) in fixed.items():
                integrator.pars[k] = given.given[name][first : first + width, element]
            z, u = given.z0[first : first + width].copy(), np.zeros((width, nu))
            for tick in range(SAMPLES):
                for lane, run in enumerate(lanes):
                    rows = (v[run] for v in given.given.values())
                    x = integrator.state[:, lane].copy()
                    namespace["sample"](tick * given.period, x, u[lane], z[lane], u_cmd, z_next, seen, e, r, *rows)
                for k, element in inputs.items():
                    integrator.pars[k] = u[:, element]
                integrator.propagate_for(pace)
            final[first : first + width] = integrator.state.T
        return final

    return integrate
