# SPDX-License-Identifier: Apache-2.0
"""Model ready for use: vectors by name, right-hand side, Jacobians, functions."""

from __future__ import annotations

import functools
import os
import warnings
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from mehvar.base.capabilities import Operation, refuse
from mehvar.base.display import displayed_formulas, heading, table
from mehvar.base.errors import InputError, bad_value
from mehvar.base.manifest import Manifest, parameter_table

from ..arguments import check_arguments
from ..compiling.compiler import find_compiler, require_compiler
from .casadi_c import CasadiBackend, casadi_manifest
from .catalogue import find_folder, find_model
from .equations import rates
from .functions import BackendName, CBackend, FloatArray, Functions, PythonBackend, check_manifold, displacement
from .generated import warn_if_stale
from .header import check_header
from .linear import ClosedLoop, LinearSystem, linearize_plant, output_rows, slope_of_inputs
from .named import NamedVector, named
from .parameters import Setting, given, law_vector, named_values, vector

if TYPE_CHECKING:
    from .tools.ivp import InitialValueProblem
    from .tools.replacement import Translation


class Model:
    """A generated model on one backend; `load` makes it.

    Parameters
    ----------
    manifest : Manifest
        Its manifest.
    backend : CBackend or PythonBackend
        Evaluator of its functions.

    Attributes
    ----------
    state_names, input_names, output_names, parameter_names : tuple of str
        In the order of the vectors x, u, y, p.
    functions : mapping of str to callable
        All generated functions by name.
    evaluator : CBackend or PythonBackend
        Evaluation of the functions.
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
        """Pickle only folder and backend, because compiled code belongs to one process."""
        return _reloaded, (str(self.manifest.folder.absolute()), self.backend, self.manifest.hash)

    def __repr__(self) -> str:
        return f"<mehvar model {self.name!r}, {len(self.state_names)} states, backend {self.backend!r}>"

    def _repr_latex_(self) -> str:
        return displayed_formulas(rates(self.manifest))

    def _repr_html_(self) -> str:
        """Return quantities, equations, parameters, laws and scenarios as tables in HTML."""
        manifest, columns = self.manifest, ("name", "unit", "meaning")
        groups = (("states x", manifest.states), ("inputs u", manifest.inputs), ("outputs y", manifest.outputs))
        laws = [(law.name, law.title) for law in manifest.controllers.values()]
        scenarios = [(case.name, case.title) for case in manifest.scenarios.values()]
        return "".join(
            (
                heading(f"{manifest.model}: {manifest.title}"),
                *(table(title, columns, [(q.name, q.unit, q.description) for q in group]) for title, group in groups),
                self._repr_latex_(),
                parameter_table("parameters p", manifest.parameters),
                table("laws", ("name", "description"), laws),
                table("scenarios", ("name", "description"), scenarios),
            )
        )

    @property
    def name(self) -> str:
        """Name of the model."""
        return self.manifest.model

    @property
    def backend(self) -> BackendName:
        """Evaluator: "c", "python" or "casadi"."""
        return self.evaluator.name

    def parameters(self, **values: ArrayLike) -> NamedVector:
        """Return the plant's parameter vector p: given values, else defaults. Elements have names, as in `p.mass`.

        An array of parameters may be given as a whole, as in `K=[[1.0, 0.0], [0.0, 2.0]]`.

        Raises
        ------
        InputError
            For an unknown name, a value that is not a finite number, or one out of bounds.
        """
        settings = given(self.manifest.parameters, values, self.name)
        return named(vector(self.manifest.parameters, settings), self.parameter_names)

    def law_parameters(self, controller: str, **values: ArrayLike) -> FloatArray:
        """Return the parameter vector c of a law: given values, else defaults.

        Raises
        ------
        InputError
            For an unknown law or name, a value that is not a finite number, or one out of bounds.
        """
        return law_vector(self.functions, self.manifest.controller(controller), values)

    def state(self, **values: float) -> NamedVector:
        """Return the state vector x with named elements, zero unless given.

        A quaternion, direction or other group that cannot be zero has the values at the start of a scenario with
        default parameters, unless a part of it is given: hub axes along the inertial ones. Where the rates are not
        finite then, as at the centre of the Earth, every state that is not given has its value at that start.

        Raises
        ------
        InputError
            For an unknown name or a value that is not a finite number.
        """
        numbers = named_values(self.state_names, f"state of {self.name}", values)
        x = np.array([numbers.get(name, 0.0) for name in self.state_names])
        p = self.parameters()
        start = self.functions["initial"](p, vector(self.manifest.scenario_parameters, {}))
        with np.errstate(all="ignore"):
            if (impossible := np.isnan(displacement(self.manifest, self.functions, x, p))).any():
                x = np.where(impossible, start, x)
            if not np.isfinite(self.rhs(x, np.zeros(len(self.input_names)), p)).all():
                x = np.array([numbers.get(name, value) for name, value in zip(self.state_names, start, strict=True)])
        return named(x, self.state_names)

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
        return slope_of_inputs(self.functions, x, u, p, len(self.input_names))

    def jac_p(
        self,
        x: ArrayLike,
        u: ArrayLike,
        p: ArrayLike,
        outputs: Sequence[str] | None = None,
        r: ArrayLike | None = None,
    ) -> FloatArray:
        """Return d rhs / d p, shape (..., nx, np).

        Parameters
        ----------
        x, u, p : array_like
            State, input and parameters; leading axes broadcast.
        outputs : sequence of str, optional
            Names of outputs or states, one row each, instead of rates. Derivatives of states are zero.
        r : array_like, optional
            Reference of the outputs; default: zero.

        Raises
        ------
        InputError
            For an unknown output or an argument of the wrong shape.
        """
        if outputs is None:
            result: FloatArray = self.functions["jac_p"](x, u, p)
            return result
        rows = output_rows(self.manifest, outputs)
        exact = self.functions["outputs_jac_p"](x, u, self._reference(r), p)
        own = np.zeros((*exact.shape[:-2], len(self.state_names), exact.shape[-1]))
        result = np.concatenate([own, exact], axis=-2)[..., rows, :]
        return result

    def linearize(
        self,
        x: ArrayLike,
        u: ArrayLike | None = None,
        p: ArrayLike | None = None,
        outputs: Sequence[str] | None = None,
        r: ArrayLike | None = None,
        controller: str | None = None,
        c: ArrayLike | None = None,
        z: ArrayLike | None = None,
    ) -> LinearSystem:
        """Return the linear system of the plant, or of its closed loop under a law, around a point.

        All matrices are exact derivatives. Angles are differentiated across their cut, and saturated or rounded
        values have the derivative zero. Undefined derivatives, such as that of a root at zero, are NaN.

        Parameters
        ----------
        x, u, p : array_like
            State, input and parameters; leading axes broadcast. Default: `u` is zero, `p` has its defaults. With
            a law, which computes the input itself, `u` is the input of the previous sample if the law has a memory.
        outputs : sequence of str, optional
            Names of outputs or states, one row of C and D each. Without it every state is an output.
        r : array_like, optional
            Reference; default: zero.
        controller : str, optional
            A law; the input of the linear system is then the reference. For a sampled law the result is the map over
            one period, with the plant linearised at the acting input, which is held. The map is exact at an
            equilibrium. Noise and the option `delay` are neglected.
        c : array_like, optional
            Parameters of the law, as from `law_parameters`; default: those of the model.
        z : array_like, optional
            Memory of the law; default: the initial memory.

        Returns
        -------
        LinearSystem
            Unpacks as (A, B, C, D); `states`, `inputs`, `outputs` name rows and columns, `period` is that of a sampled
            law.

        Raises
        ------
        InputError
            If an output or law is unknown, an argument has the wrong shape or no effect, or x is impossible; for a
            sampled law also if a sensor has a delay, averages over a period, or skips samples.

        Examples
        --------
        >>> import mehvar
        >>> model = mehvar.load("satellite")
        >>> loop = model.linearize(model.state(), controller="pd")
        >>> loop.states[:3], loop.inputs, loop.A.shape
        (('roll', 'pitch', 'yaw'), ('ref_roll', 'ref_pitch', 'ref_yaw'), (23, 23))
        """
        reference = self._reference(r)
        if p is None:
            p = self.parameters()
        if controller is not None:
            law = self.manifest.controller(controller)
            constants = law_vector(self.functions, law, {}) if c is None else c
            loop = ClosedLoop(self.manifest, self.functions, law, x, u, p, reference, constants, z)
            system = loop.linear(outputs)
        else:
            for name, value in (("c", c), ("z", z)):
                if value is not None:
                    raise bad_value(name, value, "None without a controller")
            inputs = np.zeros(len(self.input_names)) if u is None else u
            system = linearize_plant(self.manifest, self.functions, x, inputs, p, reference, outputs)
        check_manifold(self.manifest, self.functions, x, p, "x")
        return system

    def to_casadi(self, name: str = "rhs") -> Any:
        """Return a generated function as a `casadi.Function` on SX, with CasADi's derivatives.

        Raises
        ------
        InputError
            For an unknown function, or if CasADi is not installed.

        Examples
        --------
        >>> import mehvar
        >>> rhs = mehvar.load("triangle").to_casadi("rhs")
        >>> rhs.name_in(), rhs.jacobian().name()
        (['x', 'u', 'p'], 'jac_rhs')
        """
        from .tools.casadi import casadi_function

        evaluator = PythonBackend(self.manifest)
        function = Functions(evaluator, self.manifest.whole)[name].function
        return casadi_function(function, evaluator.raw(function.name))

    def to_jax(self) -> Translation:
        """Return the generated functions for JAX arrays, as attributes `rhs(x, u, p)`, `jac_x`, `jac_u`, ...

        For double precision, set `jax_enable_x64` first.

        Raises
        ------
        InputError
            If JAX is not installed.
        """
        from .tools.jax import jax_functions

        return jax_functions(self.manifest)

    def to_numba(self) -> Translation:
        """Return the generated functions compiled by Numba, as attributes `rhs(x, u, p)`, `jac_x`, `jac_u`, ...

        They take vectors of doubles at one point, without leading axes. Other compiled code can call them.

        Raises
        ------
        InputError
            If Numba is not installed.
        """
        from .tools.numba import numba_functions

        return numba_functions(self.manifest)

    def as_solve_ivp(
        self,
        u: ArrayLike | Callable[[float], ArrayLike] | None = None,
        p: ArrayLike | None = None,
        scenario: str | None = None,
    ) -> InitialValueProblem:
        """Return the plant as arguments for `scipy.integrate.solve_ivp`.

        Parameters
        ----------
        u : array_like or callable, optional
            The input, or a function of time that returns it; default: zero.
        p : array_like, optional
            Parameters of the plant; default: the scenario's.
        scenario : str, optional
            Scenario with start and duration; default: the model's first.

        Returns
        -------
        InitialValueProblem
            Unpacks as (fun, jac, y0, t_span).

        Raises
        ------
        InputError
            For an unknown scenario, or an argument of the wrong shape.

        Examples
        --------
        >>> import mehvar
        >>> from scipy.integrate import solve_ivp
        >>> fun, jac, y0, t_span = mehvar.load("triangle").as_solve_ivp(u=[0.0, 0.1, 0.0])
        >>> solve_ivp(fun, t_span, y0, "LSODA", jac=jac).status
        0
        """
        from .tools.ivp import initial_value_problem

        refuse(self.manifest, Operation.IVP)
        case = self.manifest.scenario(scenario)
        settings = {name: Setting(value, f"scenario {case.name}") for name, value in case.values.items()}
        rhs = self.functions["rhs"]
        plant = vector(self.manifest.parameters, settings) if p is None else rhs.argument("p", p)
        start = self.functions["initial"](plant, vector(self.manifest.scenario_parameters, settings))
        if callable(u):
            given = u
            return initial_value_problem(
                self.functions, lambda t: rhs.argument("u", given(t)), plant, start, case.duration
            )
        constant = np.zeros(len(self.input_names)) if u is None else rhs.argument("u", u)
        return initial_value_problem(self.functions, lambda _: constant, plant, start, case.duration)

    def to_control(
        self,
        x: ArrayLike,
        u: ArrayLike | None,
        p: ArrayLike,
        outputs: Sequence[str] | None = None,
        r: ArrayLike | None = None,
        *,
        controller: str | None = None,
        c: ArrayLike | None = None,
        z: ArrayLike | None = None,
    ) -> Any:
        """Return the result of `linearize` as a labelled `control.StateSpace`.

        Parameters
        ----------
        x, u, p : array_like
            One point, without leading axes.
        outputs, r, controller, c, z
            As of `linearize`.

        Raises
        ------
        InputError
            As `linearize`, and if python-control is not installed.
        """
        from .tools.control import state_space

        return state_space(self.linearize(x, u, p, outputs, r, controller=controller, c=c, z=z))

    def to_nlsys(
        self,
        p: ArrayLike | None = None,
        controller: str | None = None,
        c: ArrayLike | None = None,
        part: Literal["plant", "law", "loop"] | None = None,
    ) -> Any:
        """Return plant, law or closed loop as a labelled `control.NonlinearIOSystem`.

        Parameters
        ----------
        p, c : array_like, optional
            Parameters of plant and law; default: those of the model.
        controller : str, optional
            The law.
        part : {"plant", "law", "loop"}, optional
            Default: the loop if a law is given, else the plant. Inputs of the law are x, r and, with memory, the
            previous sample's input; the input of the loop is r.

        Raises
        ------
        InputError
            If law or part is unknown, an argument has the wrong shape, the loop has a sampled law, or python-control
            is not installed.
        """
        from .tools.control import law_system, loop_system, plant_system

        check_arguments("text", "the call", part=part)
        chosen = ("plant" if controller is None else "loop") if part is None else part
        plant = self.parameters() if p is None else self.functions["rhs"].argument("p", p)
        if chosen == "plant":
            return plant_system(self.manifest, self.functions, plant)
        if chosen not in ("law", "loop"):
            raise bad_value("part", part, "'plant', 'law' or 'loop'")
        if controller is None:
            raise bad_value("controller", controller, f"a law: {', '.join(self.manifest.controllers)}")
        law = self.manifest.controller(controller)
        constants = law_vector(self.functions, law, {}) if c is None else self.functions[law.name].argument("c", c)
        build = law_system if chosen == "law" else loop_system
        return build(self.manifest, self.functions, law, plant, constants)

    def _reference(self, r: ArrayLike | None) -> ArrayLike:
        return np.zeros(len(self.manifest.references)) if r is None else r


def _reloaded(folder: str, backend: BackendName, digest: str) -> Model:
    """Load a model that another process pickled; raise InputError if its folder now has another model."""
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
        Compiled C, the generated NumPy module, or C printed by CasADi (single runs in double only). Default: C or,
        without a compiler, the NumPy module with a warning; runs need a compiler.

    Raises
    ------
    InputError
        If model or backend is unknown, C is requested without a compiler, or the folder lacks CasADi's C.
    """
    check_arguments("text", "the call", backend=backend)
    if backend not in (None, "c", "python", "casadi"):
        raise bad_value("backend", backend, "'c', 'python' or 'casadi'")
    manifest = find_model(model)
    warn_if_stale(manifest)
    if backend == "python":
        return Model(manifest.whole, PythonBackend(manifest))
    if backend is None and find_compiler() is None:
        warnings.warn(
            "no C compiler found: functions are evaluated by NumPy, and runs need a compiler; "
            'install gcc or clang, or run: pip install "mehvar[cc]"',
            RuntimeWarning,
            stacklevel=2,
        )
        return Model(manifest.whole, PythonBackend(manifest))
    require_compiler()
    check_header(manifest)
    if backend == "casadi":
        manifest = casadi_manifest(manifest)
        return Model(manifest, CasadiBackend(manifest))
    return Model(manifest, CBackend(manifest))


def shared_model(model: str | os.PathLike[str], backend: BackendName | None = None) -> Model:
    """Return a loaded model as `load` does, the same object while folder and compiler are unchanged."""
    compiler = find_compiler()
    if backend not in (None, "c") or compiler is None:
        return load(model, backend)
    folder = find_folder(model)
    with os.scandir(folder) as files:
        stamps = [(f.name, s.st_ino, s.st_size, s.st_mtime_ns) for f in files for s in (f.stat(),)]
    return _shared(str(folder), compiler, os.environ.get("MEHVAR_CACHE"), tuple(sorted(stamps)))


@functools.lru_cache(maxsize=8)  # models at work at once; one more is loaded again, as all were without this
def _shared(folder: str, *_: object) -> Model:
    return load(folder, "c")
