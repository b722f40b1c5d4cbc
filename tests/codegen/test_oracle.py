# SPDX-License-Identifier: Apache-2.0
"""Every generated function against CasADi's machine, CasADi's own C, mpmath, and itself in lanes and in float.

Points where a rounding of the arguments would already change the result (next to a switch) are left out and counted.
"""

import ctypes
import functools
import subprocess
from pathlib import Path

import mpmath
import numpy as np
import pytest

from mehvar.base.manifest import file_of
from mehvar.codegen.code.casadi_c import casadi_c
from mehvar.codegen.functions.function import FunctionGraph, Part
from mehvar.codegen.functions.graphs import generate_functions
from mehvar.codegen.functions.requests import Request, bindings, requests
from mehvar.models.system import System
from mehvar.runtime.compiling.compiler import require_compiler
from mehvar.runtime.compiling.processor import widest
from mehvar.runtime.model.catalogue import find_model
from mehvar.runtime.model.functions import Functions, PythonBackend
from tests.codegen.high_precision import HighPrecision
from tests.derived import system, variant
from tests.sampling import sample

# the committed texts are held against CasADi's own C by tests/mehvar/report/test_backends.py, slosh's too, which takes
# the compilers more than a minute here
CASES = [
    pytest.param(("triangle", {}), marks=pytest.mark.soak),
    ("triangle", {"masses": "general"}),
    pytest.param(("satellite", {}), marks=pytest.mark.soak),
    pytest.param(("satellite", {"chart": "quaternion"}), marks=pytest.mark.soak),
    pytest.param(("slosh", {}), marks=pytest.mark.soak),
    pytest.param(("slosh", {"inertia": "hinge"}), marks=pytest.mark.soak),
    pytest.param(("slosh", {"inertia": "ball", "attitude": "quaternion"}), marks=pytest.mark.soak),
]
BUILDS = [("double", 1), ("double", widest()), ("float", 2 * widest())]
"""Builds of every case; the paper's triangle has all widths, since gcc is slow beyond the registers."""
FURTHER_BUILDS = [("double", 4), ("double", 8), ("float", 1), ("float", 8), ("float", 16)]
POINTS = 240
TOLERANCE = {"double": 1e-13, "float": 5e-6}
FLOAT_DERIVATIVE = 5e-5
"""Quotients of a law are differentiated with their squares, which loses a digit more: 1.5e-5 is the most seen, so half
of it still passes. A wrong operation shows in double."""
INCLUDE = Path(__file__).parents[2] / "runtime" / "native" / "include"


class Case:
    """A derived model, its texts in a folder, and random arguments for each function."""

    def __init__(self, model: str, structure: dict[str, str], folder: Path) -> None:
        self.model, self.folder = model, folder
        self.system: System = system(model, **structure)
        functions = generate_functions(self.system)
        for name, text in (variant(model, **structure) | casadi_c(model, functions)).items():
            (folder / name).write_text(text)
        self.functions: list[FunctionGraph] = [f for f in functions if any(size != 0 for _, size in f.results)]
        self.builds = list(dict.fromkeys(BUILDS + (FURTHER_BUILDS if (model, structure) == ("triangle", {}) else [])))
        self.requests = {request.name: request for request in requests(self.system)}
        self.arguments = {f.name: self._arguments(f) for f in self.functions}

    def _arguments(self, function):
        request = self.requests[function.of or function.name]
        rng = np.random.default_rng(sum(map(ord, function.name)))
        values = [sample(self.model, group, 4 * POINTS, rng) for group in request.arguments]
        directions = function.arguments[len(request.arguments) :]
        values += [rng.uniform(-1, 1, size=(4 * POINTS, size)) for _, size in directions]
        kept = np.flatnonzero(self._smooth(function, values, 1e-8))
        assert len(kept) >= POINTS, f"{function.name}: only {len(kept)} of {4 * POINTS} points are away from switches"
        return [v[kept[:POINTS]] for v in values]

    def _smooth(self, function, values, change, slope=30):
        """Tell the points whose result follows a small change of the arguments with a bounded slope."""
        base, rng = machine(function, values), np.random.default_rng(1)
        signs = [rng.choice((-1, 1), size=v.shape) for v in values]
        near = [
            machine(function, [v * (1 + turn * change * sign) for v, sign in zip(values, signs, strict=True)])
            for turn in (-1, 1)
        ]
        scale = np.maximum(1, np.abs(base).max(axis=1))
        return np.all([np.abs(n - base).max(axis=1) <= slope * change * scale for n in near], axis=0)

    @functools.cached_property
    def casadi_library(self) -> ctypes.CDLL:
        return compile_library(self.folder, [f"{self.model}_casadi.c"], ["-O0"], "casadi")

    @functools.cache  # noqa: B019
    def library(self, real: str, lanes: int, part: Part) -> ctypes.CDLL:
        # derivatives are long: optimised, those of the largest model take ten times as long to compile
        flags = ["-O0" if part else "-O1", f"-DMEHVAR_LANES={lanes}", *(["-DMEHVAR_FLOAT"] if real == "float" else [])]
        flags += ["-march=native", "-ffp-contract=off", "-Wno-psabi", f"-I{INCLUDE}"]
        return compile_library(self.folder, [file_of(self.model, part)], flags, f"{real}{lanes}{part}")


def compile_library(folder: Path, sources: list[str], flags: list[str], tag: str) -> ctypes.CDLL:
    target = folder / f"{tag}.so"
    command = [
        *require_compiler().command,
        "-std=gnu11",
        "-fPIC",
        "-shared",
        *flags,
        *sources,
        "-o",
        str(target),
        "-lm",
    ]
    subprocess.run(command, cwd=folder, check=True)
    return ctypes.CDLL(str(target))


def machine(function: FunctionGraph, values: list[np.ndarray]) -> np.ndarray:
    """Evaluate on CasADi's virtual machine; one row a point, results side by side."""
    results = function.graph.map(len(values[0]))(*(v.T for v in values))
    results = [results] if function.graph.n_out() == 1 else list(results)
    return np.concatenate([np.asarray(r).T for r in results], axis=1)


def aligned(shape: tuple[int, ...], kind: type) -> np.ndarray:
    """Return zeros aligned for vector loads."""
    count = int(np.prod(shape)) * np.dtype(kind).itemsize
    raw = np.zeros(count + 64, dtype=np.uint8)
    start = -raw.ctypes.data % 64
    return raw[start : start + count].view(kind).reshape(shape)


def generated(case: Case, function: FunctionGraph, values: list[np.ndarray], real: str, lanes: int) -> np.ndarray:
    """Evaluate the generated C, `lanes` points a call."""
    kind = np.float32 if real == "float" else np.float64
    call = getattr(case.library(real, lanes, function.part), f"{case.model}_{function.name}")
    sizes = [function.graph.nnz_out(k) for k in range(function.graph.n_out())]
    results = np.zeros((len(values[0]), sum(sizes)))
    for first in range(0, len(values[0]), lanes):
        inputs = [aligned((v.shape[1], lanes), kind) for v in values]
        for array, v in zip(inputs, values, strict=True):
            array[...] = v[first : first + lanes].T
        outputs = [aligned((size, lanes), kind) for size in sizes]
        call(*(ctypes.c_void_p(a.ctypes.data) for a in (*inputs, *outputs)))
        results[first : first + lanes] = np.concatenate(outputs).T
    return results


def casadi_compiled(case: Case, function: FunctionGraph, values: list[np.ndarray]) -> np.ndarray:
    """Evaluate CasADi's own C through its calling convention."""
    call = getattr(case.casadi_library, f"{case.model}_{function.name}")
    sizes = [function.graph.nnz_out(k) for k in range(function.graph.n_out())]
    results = np.zeros((len(values[0]), sum(sizes)))
    pointer = ctypes.POINTER(ctypes.c_double)
    work = (ctypes.c_double * (function.graph.sz_w() + 1))()
    for k in range(len(values[0])):
        rows = [np.ascontiguousarray(v[k]) for v in values]
        outputs = [np.zeros(size) for size in sizes]
        arg = (pointer * max(function.graph.sz_arg(), 1))(*(r.ctypes.data_as(pointer) for r in rows))
        res = (pointer * max(function.graph.sz_res(), 1))(*(o.ctypes.data_as(pointer) for o in outputs))
        assert call(arg, res, None, work, 0) == 0
        results[k] = np.concatenate(outputs)
    return results


def assert_close(found: np.ndarray, wanted: np.ndarray, tolerance: float, name: str) -> None:
    error = np.abs(found - wanted).max(axis=1) / np.maximum(1, np.abs(wanted).max(axis=1))
    assert np.all(error <= tolerance), f"{name}: error {np.nanmax(error):.2e} at point {int(np.nanargmax(error))}"


@pytest.fixture(scope="module", params=CASES, ids=lambda c: f"{c[0]}-{'-'.join(c[1].values()) or 'default'}")
def case(request, tmp_path_factory):
    return Case(*request.param, tmp_path_factory.mktemp("oracle"))


@pytest.mark.share(2)
def test_casadis_own_c_agrees(case):
    for function in case.functions:
        values = case.arguments[function.name]
        wanted = machine(function, values)
        assert_close(casadi_compiled(case, function, values), wanted, TOLERANCE["double"], function.name)


@pytest.mark.share(2)
def test_generated_c_agrees_lane_by_lane(case):
    for real, lanes in case.builds:
        for function in case.functions:
            agrees_lane_by_lane(case, function, real, lanes)


def agrees_lane_by_lane(case: Case, function: FunctionGraph, real: str, lanes: int) -> None:
    values = case.arguments[function.name]
    if real == "float":
        values = [v.astype(np.float32).astype(float) for v in values]
    found = generated(case, function, values, real, lanes)
    if real == "float":
        kept = case._smooth(function, values, 2e-7, slope=10)
        assert kept.mean() > 0.7, f"{function.name}: too few points away from switches"
        found, values = found[kept], [v[kept] for v in values]
    tolerance = FLOAT_DERIVATIVE if function.of and real == "float" else TOLERANCE[real]
    assert_close(found, machine(function, values), tolerance, f"{function.name} {real} x{lanes}")


def test_lanes_do_not_change_a_bit(case):
    for function in case.functions:
        values = case.arguments[function.name]
        scalar = generated(case, function, values, "double", 1)
        for lanes in {lanes for real, lanes in case.builds if real == "double"} - {1}:
            assert np.array_equal(scalar, generated(case, function, values, "double", lanes)), function.name


def test_generated_python_agrees(case):
    functions = Functions(PythonBackend(find_model(case.folder)), find_model(case.folder))
    for function in case.functions:
        values = case.arguments[function.name]
        sizes = [size for _, size in function.arguments]
        arguments = [v[:, 0] if size is None else v[:, :size] for v, size in zip(values, sizes, strict=True)]
        found = functions[function.name](*arguments)
        found = found if isinstance(found, tuple) else (found,)
        flat = np.concatenate([np.reshape(f, (POINTS, -1)) for f in found], axis=1)
        assert_close(flat, machine(function, values), TOLERANCE["double"], function.name)


def test_agrees_with_mpmath(case):
    for function in case.functions:
        points = [[v[k] for v in case.arguments[function.name]] for k in range(3)]
        found = generated(case, function, [v[:3] for v in case.arguments[function.name]], "double", 1)
        if function.of:
            found = along_directions(case, function, found)
            wanted = [precise_change(case, function, point) for point in points]
        else:
            wanted = [precise(case, case.requests[function.name], point) for point in points]
        assert_close(found, np.array(wanted, dtype=float), TOLERANCE["double"], function.name)


def precise(case: Case, request: Request, point: list) -> list:
    """Evaluate a function in 40 digits, without CasADi."""
    symbols = [s for group in request.arguments for s in group.symbols]
    bound = {k: v for k, v in bindings(case.system, request).items() if k not in symbols}
    row = [value for v, group in zip(point, request.arguments, strict=True) for value in v[: len(group)]]
    evaluate = HighPrecision(dict(zip(symbols, row, strict=True)), case.system.definitions | bound)
    return [evaluate(expr) for _, exprs in request.results for expr in exprs]


def along_directions(case: Case, function: FunctionGraph, found: np.ndarray) -> np.ndarray:
    """Multiply each Jacobian by a direction; a derivative along one is what it is."""
    if function.name.endswith("jvp"):
        return found
    changes, start = [], 0
    for (_, size), direction in zip(function.results, directions(case, function), strict=True):
        matrix = found[:, start : start + size].reshape(len(found), -1, len(direction[1]))
        changes.append(matrix @ direction[1])
        start += size
    return np.concatenate(changes, axis=1)


def directions(case: Case, function: FunctionGraph) -> list[tuple[int, np.ndarray]]:
    """Return for each result of a Jacobian the place of its argument, and a direction: an error in any entry shows."""
    names = [name for name, _ in function.arguments]
    by = [function.name[-1] if name == "J" else name.removeprefix("J_") for name, _ in function.results]
    rng = np.random.default_rng(2)
    return [(names.index(name), rng.uniform(0.5, 1, function.arguments[names.index(name)][1])) for name in by]


def precise_change(case: Case, function: FunctionGraph, point: list) -> list:
    """Differentiate a function by differences in 40 digits: a step of 1e-12 leaves an error of 1e-24."""
    request, step = case.requests[function.of], mpmath.mpf(10) ** -12
    count = len(request.arguments)
    if function.name.endswith("jvp"):
        names = [name for name, _ in function.arguments]
        along = {names.index(n.removeprefix("along_")): v for n, v in zip(names[count:], point[count:], strict=True)}
        steps = [along]
    else:
        steps = [{place: direction} for place, direction in directions(case, function)]
    change = []
    for along in steps:
        ahead, behind = (
            precise(case, request, [moved(v, along.get(k), sign * step) for k, v in enumerate(point[:count])])
            for sign in (1, -1)
        )
        change += [(a - b) / (2 * step) for a, b in zip(ahead, behind, strict=True)]
    return change


def moved(v: np.ndarray, direction: np.ndarray | None, step: mpmath.mpf) -> list:
    if direction is None:
        return list(v)
    return [mpmath.mpf(float(a)) + step * mpmath.mpf(float(d)) for a, d in zip(v, direction, strict=False)]


def test_a_directional_derivative_is_the_jacobians_product(case):
    by_name = {f.name: f for f in case.functions}
    values = case.arguments["jvp"]
    *point, along_x, along_u = values
    shapes = [(POINTS, along_x.shape[1], -1)] * 2
    J_x, J_u = (
        machine(by_name[name], point).reshape(shape) for name, shape in zip(("jac_x", "jac_u"), shapes, strict=True)
    )
    wanted = np.einsum("kij,kj->ki", J_x, along_x) + np.einsum("kij,kj->ki", J_u, along_u)
    assert_close(machine(by_name["jvp"], values), wanted, 1e-12, "jvp")
