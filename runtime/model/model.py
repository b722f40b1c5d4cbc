# SPDX-License-Identifier: Apache-2.0
"""A model ready for use: names, parameter and state vectors, right-hand side, Jacobians, functions."""

from __future__ import annotations

import os
import warnings
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from mehvar.errors import InputError, bad_value, unknown_name
from mehvar.manifest import Manifest

from ..arguments import check_arguments
from ..compiling.compiler import find_compiler, require_compiler
from .casadi_c import CasadiBackend, casadi_manifest
from .catalogue import find_model
from .functions import BackendName, CBackend, FloatArray, Functions, PythonBackend
from .parameters import Setting, named_values, vector

_DIFFERENCE = float(np.cbrt(np.finfo(np.float64).eps))
"""Relative step of central differences: a smaller one loses more by rounding (eps / h) than it gains in truncation
(h^2), a larger one the other way round; half or twice of it costs less than a digit."""


class Model:
    """A generated model on one backend; `load` makes it.

    Parameters
    ----------
    manifest : Manifest
        Describes it.
    backend : CBackend or PythonBackend
        Evaluates its functions.

    Attributes
    ----------
    state_names, input_names, output_names, parameter_names : tuple of str
        In the order of the vectors x, u, y, p.
    functions : mapping of str to callable
        Every generated function by name.
    evaluator : CBackend or PythonBackend
        What evaluates the functions.
    manifest : Manifest
        Units, defaults, bounds, laws, scenarios.
    """

    def __init__(self, manifest: Manifest, backend: CBackend | PythonBackend) -> None:
        self.manifest = manifest
        self.functions = Functions(backend, manifest)
        self.state_names = tuple(q.name for q in manifest.states)
        self.input_names = tuple(q.name for q in manifest.inputs)
        self.output_names = tuple(q.name for q in manifest.outputs)
        self.parameter_names = tuple(q.name for q in manifest.parameters)
        self.evaluator = backend

    def __reduce__(self) -> tuple[object, ...]:
        """Pickle as a folder and a backend: compiled code belongs to one process."""
        return _reloaded, (str(self.manifest.folder.absolute()), self.backend, self.manifest.hash)

    def __repr__(self) -> str:
        return f"<mehvar model {self.name!r}, {len(self.state_names)} states, backend {self.backend!r}>"

    @property
    def name(self) -> str:
        """The model's name."""
        return self.manifest.model

    @property
    def backend(self) -> BackendName:
        """What evaluates the functions: "c", "python" or "casadi"."""
        return self.evaluator.name

    def parameters(self, **values: float) -> FloatArray:
        """Return the plant's parameter vector p, defaults filled in.

        Raises
        ------
        InputError
            For an unknown name, a value that is not a finite number, or one out of bounds.
        """
        for name in values:
            if name not in self.parameter_names:
                raise unknown_name(f"parameter of {self.name}", name, self.parameter_names)
        return vector(self.manifest.parameters, {name: Setting(value, "") for name, value in values.items()})

    def state(self, **values: float) -> FloatArray:
        """Return the state vector x; states that are not given are zero.

        Raises
        ------
        InputError
            For an unknown name or a value that is not a finite number.
        """
        numbers = named_values(self.state_names, f"state of {self.name}", values)
        return np.array([numbers.get(name, 0.0) for name in self.state_names], dtype=np.float64)

    def rhs(self, x: ArrayLike, u: ArrayLike, p: ArrayLike) -> FloatArray:
        """Return the state derivative, shape (..., nx); leading axes of x, u, p broadcast."""
        result: FloatArray = self.functions["rhs"](x, u, p)
        return result

    def jac_x(self, x: ArrayLike, u: ArrayLike, p: ArrayLike) -> FloatArray:
        """Return d rhs / d x, shape (..., nx, nx)."""
        result: FloatArray = self.functions["jac_x"](x, u, p)
        return result

    def jac_u(self, x: ArrayLike, u: ArrayLike, p: ArrayLike) -> FloatArray:
        """Return d rhs / d u, shape (..., nx, nu)."""
        result: FloatArray = self.functions["jac_u"](x, u, p)
        return result

    def linearize(
        self,
        x: ArrayLike,
        u: ArrayLike,
        p: ArrayLike,
        outputs: Sequence[str] | None = None,
        r: ArrayLike | None = None,
    ) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Return the matrices (A, B, C, D) of the linear system around x, u.

        A and B are exact. Without `outputs` every state is an output: C is the identity and D zero. Rows of C
        and D that belong to named outputs are central differences, good to about nine digits.

        Parameters
        ----------
        x, u, p : array_like
            State, input and parameters; leading axes broadcast.
        outputs : sequence of str, optional
            Names of outputs or states, one row of C and D each.
        r : array_like, optional
            Reference that the outputs are taken at; zero unless given.

        Raises
        ------
        InputError
            For an unknown output or an argument of the wrong shape.
        """
        A, B = self.jac_x(x, u, p), self.jac_u(x, u, p)
        nx, nu, leading = len(self.state_names), len(self.input_names), A.shape[:-2]
        C = np.broadcast_to(np.eye(nx), (*leading, nx, nx)).copy()
        D = np.zeros((*leading, nx, nu))
        if outputs is None:
            return A, B, C, D
        names = (*self.state_names, *self.output_names)
        for name in outputs:
            if name not in names:
                raise unknown_name(f"output of {self.name}", name, names)
        rows = [names.index(name) for name in outputs]
        if max(rows, default=0) >= nx:
            C_outputs, D_outputs = self._output_differences(np.asarray(x, float), np.asarray(u, float), p, r)
            C, D = np.concatenate([C, C_outputs], axis=-2), np.concatenate([D, D_outputs], axis=-2)
        return A, B, C[..., rows, :], D[..., rows, :]

    def _output_differences(
        self, x: FloatArray, u: FloatArray, p: ArrayLike, r: ArrayLike | None
    ) -> tuple[FloatArray, FloatArray]:
        reference = np.zeros(len(self.manifest.references)) if r is None else np.asarray(r, float)
        values = np.asarray(p, float)
        wide_x, wide_u = x[..., None, :], u[..., None, :]
        wide_r, wide_p = reference[..., None, :], values[..., None, :]
        outputs = self.functions["outputs"]
        dx, du = _steps(x), _steps(u)
        change_x = outputs(wide_x + dx, wide_u, wide_r, wide_p) - outputs(wide_x - dx, wide_u, wide_r, wide_p)
        change_u = outputs(wide_x, wide_u + du, wide_r, wide_p) - outputs(wide_x, wide_u - du, wide_r, wide_p)
        C = change_x / (2 * np.diagonal(dx, axis1=-2, axis2=-1)[..., :, None])
        D = change_u / (2 * np.diagonal(du, axis1=-2, axis2=-1)[..., :, None])
        return np.swapaxes(C, -1, -2), np.swapaxes(D, -1, -2)


def _steps(v: FloatArray) -> FloatArray:
    """Return one row per component of v: the step of that component, the rest zero."""
    result: FloatArray = (_DIFFERENCE * np.maximum(1.0, np.abs(v)))[..., None] * np.eye(v.shape[-1])
    return result


def _reloaded(folder: str, backend: BackendName, digest: str) -> Model:
    """Load what another process pickled, or raise InputError when the folder holds another model by now."""
    model = load(folder, backend)
    if model.manifest.hash != digest:
        raise InputError(f"{folder} has changed since the model was pickled: its hash is {model.manifest.hash[:12]}")
    return model


def load(model: str | os.PathLike[str], backend: BackendName | None = None) -> Model:
    """Load a generated model.

    Parameters
    ----------
    model : str or path
        A name such as "triangle", or a generated folder.
    backend : {"c", "python", "casadi"}, optional
        Compiled C, the generated NumPy module, or the C that CasADi prints of the same graphs: for single runs, in
        double. C unless given; without a compiler the NumPy module, with a warning.

    Raises
    ------
    InputError
        If the model or backend is unknown, C is asked for without a compiler, or CasADi's C of a folder without it.
    """
    check_arguments("text", "the call", backend=backend)
    if backend not in (None, "c", "python", "casadi"):
        raise bad_value("backend", backend, "'c', 'python' or 'casadi'")
    manifest = find_model(model)
    if backend == "python":
        return Model(manifest, PythonBackend(manifest))
    if backend is None and find_compiler() is None:
        warnings.warn(
            "no C compiler found: using the much slower Python backend; "
            "install a C compiler or the Python package ziglang",
            RuntimeWarning,
            stacklevel=2,
        )
        return Model(manifest, PythonBackend(manifest))
    require_compiler()
    if backend == "casadi":
        manifest = casadi_manifest(manifest)
        return Model(manifest, CasadiBackend(manifest))
    return Model(manifest, CBackend(manifest))
