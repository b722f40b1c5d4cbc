# SPDX-License-Identifier: Apache-2.0
"""Generated functions as Python callables, from compiled C or from the generated NumPy module."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterator, Mapping
from types import ModuleType
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mehvar.base.display import heading, table
from mehvar.base.errors import FunctionNameError, InputError, unknown_name
from mehvar.base.manifest import Array, Function, Manifest
from mehvar.base.names import identifier

from ..compiling.library import begin_native, load_library, load_native, native_headers
from .derived import folder_with
from .generated import generated_text
from .header import check_module
from .point import Point

FloatArray = NDArray[np.float64]
BackendName = Literal["c", "python", "casadi"]
Real = Literal["double", "float"]

_MAX_AXES = 32
"""Largest number of axes in `mv_map` (MV_MAX_ARRAYS in map.c), as in NumPy 1."""
_POINTER = ctypes.c_void_p


class Backend(Protocol):
    """Evaluator of generated functions over arrays with checked leading axes."""

    name: BackendName

    def prepare(self) -> None:
        """Load everything but the Jacobians."""

    def evaluate(self, function: Function, arguments: list[FloatArray], shape: tuple[int, ...]) -> list[FloatArray]:
        """Return all results with leading axes `shape`."""

    def point(self, function: Function) -> Callable[[tuple[Any, ...]], Any]:
        """Return an evaluator for single points of plain arrays, which returns None for other arguments."""


class GeneratedFunction:
    """A generated function whose arguments broadcast over leading axes.

    A vector argument has the shape (..., n), a scalar one (...). A single result is an array, several are a tuple.
    NaN arguments give NaN results.
    """

    def __init__(self, backend: Backend, function: Function) -> None:
        self._backend = backend
        self._function = function
        self._point = backend.point(function)
        self.__name__ = function.name
        self.__doc__ = f"{self!r}, {function.operations} operations."

    def __repr__(self) -> str:
        function = self._function
        arguments = ", ".join(_signature(a.name, a.shape) for a in function.arguments)
        results = ", ".join(
            _signature(r.name, shape) for r, shape in zip(function.results, function.shapes, strict=True)
        )
        return f"{function.name}({arguments}) -> {results}"

    def _repr_html_(self) -> str:
        function, what = self._function, f"{self!r}, {self._function.operations} operations"
        shapes = zip(function.results, function.shapes, strict=True)
        rows = [
            *((a.name, "argument", a.shape or "number") for a in function.arguments),
            *((result.name, "result", shape or "number") for result, shape in shapes),
        ]
        return heading(f"{what}: {function.description}") + table("", ("name", "description", "shape"), rows)

    @property
    def function(self) -> Function:
        """Entry in the manifest: arguments and results."""
        return self._function

    def __call__(self, *arguments: ArrayLike) -> Any:
        """Evaluate the function; raise InputError for a wrong number, shape or type of arguments."""
        at_point = self._point(arguments)
        if at_point is not None:
            return at_point
        arrays, shape = self._checked(arguments)
        results = self._backend.evaluate(self._function, arrays, shape)
        return results[0][()] if len(results) == 1 else tuple(result[()] for result in results)

    def argument(self, name: str, value: ArrayLike) -> FloatArray:
        """Return an argument at a single point as an array of doubles; raise InputError for others."""
        spec = next(spec for spec in self._function.arguments if spec.name == name)
        array = _as_array(self._function, spec, value)
        if array.shape != spec.shape:
            raise InputError(f"{self._function.name}: {name} must have the shape {spec.shape}, got {array.shape}")
        return array

    def _checked(self, arguments: tuple[ArrayLike, ...]) -> tuple[list[FloatArray], tuple[int, ...]]:
        """Return the arguments as arrays, and the leading shape to which they broadcast."""
        specs = self._function.arguments
        if len(arguments) != len(specs):
            raise InputError(f"{self!r} takes {len(specs)} arguments, got {len(arguments)}")
        arrays = [_as_array(self._function, spec, value) for spec, value in zip(specs, arguments, strict=True)]
        leading = [array.shape[: array.ndim - len(spec.shape)] for spec, array in zip(specs, arrays, strict=True)]
        try:
            shape = np.broadcast_shapes(*leading)
        except ValueError as error:
            axes = ", ".join(f"{spec.name} {lead}" for spec, lead in zip(specs, leading, strict=True))
            raise InputError(f"{self!r}: leading axes must broadcast, got {axes}") from error
        if len(shape) > _MAX_AXES:
            raise InputError(f"{self!r}: at most {_MAX_AXES} leading axes, got {len(shape)}")
        return arrays, shape


class Functions(Mapping[str, GeneratedFunction]):
    """Generated functions of a model by the manifest's names, where `a-b` and `a_b` are equivalent."""

    def __init__(self, backend: Backend, manifest: Manifest) -> None:
        self._model = manifest.model
        self._functions = {name: GeneratedFunction(backend, f) for name, f in manifest.functions.items()}
        self._names = {identifier(name): name for name in manifest.functions}

    def __getitem__(self, name: str) -> GeneratedFunction:
        function = None
        if isinstance(name, str):
            function = self._functions.get(name) or self._functions.get(self._names.get(identifier(name), ""))
        if function is None:
            raise FunctionNameError(str(unknown_name(f"function of {self._model}", name, self._functions)))
        return function

    def _ipython_key_completions_(self) -> list[str]:
        return list(self._functions)

    def __iter__(self) -> Iterator[str]:
        return iter(self._functions)

    def __len__(self) -> int:
        return len(self._functions)


class CBackend:
    """Compiled functions; each C file becomes a library at first use."""

    name: BackendName = "c"

    def __init__(self, manifest: Manifest) -> None:
        self._manifest = manifest
        self._libraries: dict[tuple[str, Real], ctypes.CDLL] = {}
        self._map: Any = None

    def prepare(self) -> None:
        """Compile or load integrators and model, without Jacobians and batch functions."""
        self._native_map()
        self._library(f"{self._manifest.model}.c")

    def evaluate(self, function: Function, arguments: list[FloatArray], shape: tuple[int, ...]) -> list[FloatArray]:
        """Run one C loop over all leading indices; contiguous arguments are not copied."""
        axes = len(shape)
        results = [np.empty(shape + own) for own in function.shapes]
        strides: list[int] = []
        for spec, array in zip(function.arguments, arguments, strict=True):
            own = array.ndim - len(spec.shape)
            strides += [0] * (axes - own)
            strides += [0 if array.shape[d] == 1 else array.strides[d] for d in range(own)]
        self._native_map()(
            ctypes.cast(self._entry(function), _POINTER),
            len(arguments),
            len(results),
            axes,
            (ctypes.c_int64 * axes)(*shape),
            (_POINTER * len(arguments))(*[array.ctypes.data for array in arguments]),
            (ctypes.c_int64 * len(strides))(*strides),
            (_POINTER * len(results))(*[array.ctypes.data for array in results]),
            (ctypes.c_int64 * len(results))(*[spec.size for spec in function.results]),
        )
        return results

    def point(self, function: Function) -> Point:
        """Return a direct call of the C function, without a loop."""
        return Point(function, lambda: self._entry(function))

    def _entry(self, function: Function) -> Any:
        entry = getattr(self._library(function.file), f"call_{identifier(function.name)}")
        entry.restype = None
        return entry

    def address(self, name: str, real: Real = "double") -> int:
        """Return a C function's address for the native loop, on doubles; `real` is its internal number type."""
        function = self._manifest.functions[name]
        symbol = self._manifest.c_name(function.name) if real == "double" else f"narrow_{identifier(name)}"
        return ctypes.cast(getattr(self._library(function.file, real), symbol), _POINTER).value or 0

    def narrow(self, name: str, *arguments: FloatArray) -> Any:
        """Evaluate a function at a point in float, as boards do; several results are a tuple."""
        function = next(f for f in self._manifest.functions.values() if identifier(f.name) == identifier(name))
        arrays = [_as_array(function, spec, value) for spec, value in zip(function.arguments, arguments, strict=True)]
        results = [np.empty(shape) for shape in function.shapes]
        call = ctypes.CFUNCTYPE(None, *[_POINTER] * (len(arrays) + len(results)))(self.address(function.name, "float"))
        call(*[array.ctypes.data for array in (*arrays, *results)])
        return results[0] if len(results) == 1 else tuple(results)

    def _native_map(self) -> Any:
        if self._map is None:
            self._map = load_native().mv_map
            self._map.restype = None
            self._map.argtypes = [_POINTER, *[ctypes.c_int64] * 3, *[_POINTER] * 5]
        return self._map

    def _library(self, file: str, real: Real = "double") -> ctypes.CDLL:
        if (file, real) not in self._libraries:
            self._libraries[file, real] = self._build(file, real)
        return self._libraries[file, real]

    def _build(self, file: str, real: Real) -> ctypes.CDLL:
        """Return the compiled library of a generated file, whose functions evaluate many points in a call."""
        functions = [f for f in self._manifest.functions.values() if f.file == file]
        header = f"{self._manifest.model}.h"
        sources = {name: generated_text(self._manifest, name) for name in (file, header)}
        sources |= native_headers()
        calls = _calls_text if real == "double" else _narrow_text
        sources["calls.c"] = calls(self._manifest, file, functions)
        # Derivatives are long and rarely called: compile time matters more than run time. Those of the loops
        # of the largest model take 0.6 s and 20 us; with -O1, 4.6 s and 13 us. Elsewhere, vectorising straight-line
        # scalar code costs more moves than it saves.
        optimise = "-O0" if all(f.file.endswith("_jac.c") for f in functions) else "-O2"
        name = identifier(file.removesuffix(".c"))
        begin_native()
        flags = [optimise, "-fno-tree-slp-vectorize", *(["-DMEHVAR_FLOAT"] if real == "float" else [])]
        return load_library(name, sources, ["calls.c"], flags)


class PythonBackend:
    """Generated NumPy modules, imported at first use."""

    name: BackendName = "python"

    def __init__(self, manifest: Manifest) -> None:
        self._manifest = manifest
        self._modules: dict[str, ModuleType] = {}

    def prepare(self) -> None:
        """Import the module."""
        self.raw("rhs")

    def evaluate(self, function: Function, arguments: list[FloatArray], shape: tuple[int, ...]) -> list[FloatArray]:
        """Call the module and broadcast its results to the full shape."""
        wide = [np.broadcast_to(a, shape + s.shape) for s, a in zip(function.arguments, arguments, strict=True)]
        with np.errstate(all="ignore"):
            out = self.raw(function.name)(*wide)
        results = [out] if len(function.results) == 1 else list(out)
        return [
            np.array(np.broadcast_to(result, shape + own), dtype=np.float64)
            for own, result in zip(function.shapes, results, strict=True)
        ]

    def point(self, function: Function) -> Callable[[tuple[Any, ...]], None]:  # noqa: ARG002
        """Return an evaluator that passes all points to `evaluate`; NumPy is not faster for single points."""
        return lambda _: None

    def raw(self, name: str) -> Callable[..., Any]:
        """Return the module's own, unchecked function."""
        by_identifier = {identifier(other): f for other, f in self._manifest.functions.items()}
        file = self._manifest.module_of(by_identifier[identifier(name)])
        if file not in self._modules:
            self._modules[file] = self._import(file)
        function: Callable[..., Any] = getattr(self._modules[file], identifier(name))
        return function

    def _import(self, file: str) -> ModuleType:
        manifest = folder_with(self._manifest, file)
        path = manifest.folder / file
        module = ModuleType(f"mehvar_generated_{identifier(path.stem)}")
        module.__file__ = str(path)
        exec(compile(generated_text(manifest, file), path, "exec"), module.__dict__)
        check_module(manifest, module, path)
        return module


def _signature(name: str, shape: tuple[int, ...]) -> str:
    return name + "".join(f"[{n}]" for n in shape)


def _calls_text(manifest: Manifest, file: str, functions: list[Function]) -> str:
    """Return C code that includes a generated file and gives its functions a common signature."""
    lines = [f'#include "{file}"', ""]
    for function in functions:
        arguments = [f"a[{i}]" for i in range(len(function.arguments))]
        results = [f"r[{i}]" for i in range(len(function.results))]
        lines += [
            f"void call_{identifier(function.name)}(const double *const *a, double *const *r)",
            f"{{ {manifest.c_name(function.name)}({', '.join(arguments + results)}); }}",
        ]
    return "\n".join(lines) + "\n"


def _narrow_text(manifest: Manifest, file: str, functions: list[Function]) -> str:
    """Return C code that includes a generated file in float, with arguments in double."""
    lines = [f'#include "{file}"', ""]
    for function in functions:
        arguments, results = function.arguments, function.results
        signature = [f"const double *{a.name}" for a in arguments] + [f"double *{r.name}" for r in results]
        lines.append(f"void narrow_{identifier(function.name)}({', '.join(signature)})\n{{")
        lines += [f"    float {a.name}_f[{max(a.size, 1)}];" for a in (*arguments, *results)]
        lines += [f"    for (int i = 0; i < {a.size}; i++) {a.name}_f[i] = (float){a.name}[i];" for a in arguments]
        names = ", ".join(f"{a.name}_f" for a in (*arguments, *results))
        lines.append(f"    {manifest.c_name(function.name)}({names});")
        lines += [f"    for (int i = 0; i < {r.size}; i++) {r.name}[i] = (double){r.name}_f[i];" for r in results]
        lines.append("}")
    return "\n".join(lines) + "\n"


def _as_array(function: Function, spec: Array, value: ArrayLike) -> FloatArray:
    """Return a float array with an argument's trailing shape and a contiguous last axis."""
    numbers = _numbers(function, spec, value)
    if numbers.dtype.kind not in "biuf":
        raise InputError(f"{function.name}: {spec.name} must hold real numbers, got {numbers.dtype}")
    array = numbers.astype(np.float64, copy=False)
    trailing = array.shape[array.ndim - len(spec.shape) :] if array.ndim >= len(spec.shape) else None
    if trailing != spec.shape:
        allowed = f"(..., {', '.join(map(str, spec.shape))})" if spec.shape else "(...)"
        raise InputError(f"{function.name}: {spec.name} must have the shape {allowed}, got {array.shape}")
    contiguous = not spec.shape or spec.shape[-1] <= 1 or array.strides[-1] == array.itemsize
    return array if contiguous and array.flags.aligned else np.array(array, order="C")


def unmasked(values: object) -> NDArray[Any]:
    """Return an argument as an array, with NaN in place of masked elements."""
    if isinstance(values, np.ma.MaskedArray):
        return np.asarray(np.ma.filled(values.astype(np.float64), np.nan))
    return np.asarray(values)


def _numbers(function: Function, spec: Array, value: ArrayLike) -> NDArray[Any]:
    try:
        numbers = unmasked(value)
        return numbers.astype(np.float64) if numbers.dtype.kind == "O" else numbers
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(f"{function.name}: {spec.name} must be an array of numbers: {error}") from error


START_OFF = 1e-3
"""Largest change of an initial state by the projection, enough for a quaternion with three decimals."""


def displacement(manifest: Manifest, functions: Functions, x: ArrayLike, p: ArrayLike) -> FloatArray:
    """Return the projection of states minus the states, of shape (..., 0) without a projection.

    Parameters
    ----------
    x : array, shape (..., n_x)
        States.
    p : array, shape (..., n_p)
        Model parameters.
    """
    if "project" not in manifest.functions or "to_coordinates" in manifest.functions:
        return np.empty((*np.shape(x)[:-1], 0))
    more = (p,) if manifest.projects_by_parameters else ()
    change: FloatArray = np.asarray(functions["project"](x, *more)) - np.asarray(x)
    return change


def check_manifold(manifest: Manifest, functions: Functions, x: ArrayLike, p: ArrayLike, what: str) -> None:
    """Refuse a state that the projection changes, such as a quaternion without unit length.

    Parameters
    ----------
    x : array, shape (..., n_x)
        States.
    p : array, shape (..., n_p)
        Model parameters.
    what : str
        The state in the message.

    Raises
    ------
    InputError
        With the nearest possible numbers.
    """
    moved = displacement(manifest, functions, x, p)
    impossible = ~(np.abs(moved) <= START_OFF)
    if not impossible.any():
        return
    first = tuple(np.argwhere(impossible.any(axis=-1))[0])
    rows = zip(manifest.states, np.broadcast_to(x, moved.shape)[first], moved[first], impossible[first], strict=True)
    parts = ", ".join(f"{q.name} = {value:g} ({value + change:.6g})" for q, value, change, is_wrong in rows if is_wrong)
    raise InputError(
        f"{what} is impossible: {parts}. The numbers in parentheses are the nearest possible ones; a quaternion or "
        "direction has length 1, the rate of a direction is normal to it"
    )
