# SPDX-License-Identifier: Apache-2.0
"""Exact linear systems of plants and closed loops around a point."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mehvar.base.capabilities import Operation, refuse
from mehvar.base.display import heading, table
from mehvar.base.errors import InputError, bad_value, unknown_name
from mehvar.base.manifest import Controller, Manifest, Quantity
from mehvar.base.names import CLOCK, identifier

from .functions import FloatArray, Functions, GeneratedFunction

_Slopes: TypeAlias = dict[str, FloatArray]
"""Derivatives by argument."""

_STEP = 1e-4
"""Step of differences for a sensor's slope, with errors of 1e-12 for linear sensors of size one."""
_SLOPE = 1e-6
"""Allowed deviation of that slope from one, far below the scale error of any sensor."""
_SAMPLES = 1000
"""Number of samples, and of draws of noise, in which a sensor that skips samples shows it."""
_SHOWN = 3
_ENTRIES = 1e-13
"""Relative error of a matrix of derivatives: some hundred roundings."""
COUNTER = "held_for"
"""Counter in the memory of a law that skips samples, added by codegen; zero at a command."""


@dataclass(frozen=True, eq=False, repr=False)
class LinearSystem:
    """Matrices of a linear system with names of rows and columns; unpacks as (A, B, C, D).

    Attributes
    ----------
    A, B, C, D : array, (..., rows, columns)
        dx' = A dx + B du, dy = C dx + D du; of a sampled loop dx(k+1) = A dx(k) + B du(k).
    states, inputs, outputs : tuple of str
        Names of the elements of x, u and y. In a closed loop the inputs are the references. With memory in a sampled
        law, the states are the plant's, `applied_INPUT` for the previous sample's input, and the memory.
    period : array or None
        Sampling period, s; None for continuous time.
    """

    A: FloatArray
    B: FloatArray
    C: FloatArray
    D: FloatArray
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    period: FloatArray | None = None

    def __repr__(self) -> str:
        time = "continuous" if self.period is None else f"sampled every {self.period} s"
        return f"<linear system, {time}: states {', '.join(self.states)}; inputs {', '.join(self.inputs)}>"

    def _repr_html_(self) -> str:
        """Return the matrices as tables in HTML, with the names of their rows and columns."""
        sides = {"A": (self.states, self.states), "B": (self.states, self.inputs)}
        sides |= {"C": (self.outputs, self.states), "D": (self.outputs, self.inputs)}
        text = heading(repr(self).strip("<>"))
        for name, matrix in zip(sides, self, strict=True):
            if matrix.ndim == 2:
                rows, columns = sides[name]
                entries = [[row, *(f"{v:.6g}" for v in values)] for row, values in zip(rows, matrix, strict=True)]
                text += table(name, ("", *columns), entries)
        return text

    def __iter__(self) -> Iterator[FloatArray]:
        return iter((self.A, self.B, self.C, self.D))

    def __len__(self) -> int:
        return 4

    def __getitem__(self, place: int) -> FloatArray:
        return (self.A, self.B, self.C, self.D)[place]

    @property
    def eigenvalues(self) -> NDArray[np.complex128]:
        """Eigenvalues of A, in 1/s. For a sampled loop they have no unit and are inside the unit circle if stable.

        They are NaN if A is not finite.
        """
        finite = np.all(np.isfinite(self.A), axis=(-2, -1))
        values = np.linalg.eigvals(np.where(finite[..., None, None], self.A, 0.0))
        return np.where(finite[..., None], values, np.nan + 0j)


def modes(matrix: NDArray[Any]) -> tuple[NDArray[np.complex128], FloatArray]:
    """Return the eigenvalues of a matrix and their errors to first order: rounding times the condition of each.

    Multiple eigenvalues, such as those of integrators, have large errors, a slow mode beside a fast one a small one.
    Source: Golub, Van Loan: Matrix Computations, 4th ed., section 7.2.2.
    """
    from scipy.linalg import eig, matrix_balance  # takes a tenth of a second, which a run does not need

    balanced, _ = matrix_balance(matrix)
    eigenvalues, left, right = eig(balanced, left=True, right=True)
    with np.errstate(divide="ignore", over="ignore"):
        conditions = 1 / np.abs(np.sum(left.conj() * right, axis=0))
    return eigenvalues, _ENTRIES * np.linalg.norm(balanced) * conditions


def linearize_plant(
    manifest: Manifest,
    functions: Functions,
    x: ArrayLike,
    u: ArrayLike,
    p: ArrayLike,
    r: ArrayLike,
    outputs: Sequence[str] | None,
) -> LinearSystem:
    """Return the plant's linear system around x, u; see `Model.linearize`."""
    A, B, C, D, _ = _plant(manifest, functions, x, u, p, r, outputs)
    states = _names(manifest.states)
    return LinearSystem(A, B, C, D, states, _names(manifest.inputs), states if outputs is None else tuple(outputs))


@dataclass(frozen=True)
class ClosedLoop:
    """A plant under a law, to be linearised around a point; see `Model.linearize`.

    Attributes
    ----------
    manifest, functions : Manifest, Functions
        Those of the model.
    law : Controller
        The law.
    x, u, p, r, c, z : array_like
        The point. u is the previous sample's input, which only a sampled law with memory receives; z its memory.
    """

    manifest: Manifest
    functions: Functions
    law: Controller
    x: ArrayLike
    u: ArrayLike | None
    p: ArrayLike
    r: ArrayLike
    c: ArrayLike
    z: ArrayLike | None

    def linear(self, outputs: Sequence[str] | None) -> LinearSystem:
        """Return the closed loop's linear system, driven by the reference."""
        slope_u, slope_z, (A, B, C, D, E), period = self._parts(outputs)
        u_s, u_r = self._by_state_and_reference(slope_u)
        A, B, C, D = _widened(A, u_s) + B @ u_s, B @ u_r, _widened(C, u_s) + D @ u_s, E + D @ u_r
        if self.law.memory:
            z_s, z_r = self._by_state_and_reference(slope_z)
            if period is not None:
                A, B = _stacked(A, u_s), _stacked(B, u_r)
            A, B = _stacked(A, z_s), _stacked(B, z_r)
        shown = _names(self.manifest.states) if outputs is None else tuple(outputs)
        return LinearSystem(A, B, C, D, self._states(), _names(self.manifest.references), shown, period)

    def cut(self) -> LinearSystem:
        """Return the loop, cut between law and plant.

        Its inputs act on the plant, and its outputs are the law's commands, so that A + B C is the closed loop.
        """
        slope_u, slope_z, (A, B, *_), period = self._parts(None)
        u_s, _ = self._by_state_and_reference(slope_u)
        A, nu = _widened(A, u_s), len(self.manifest.inputs)
        if self.law.memory:
            z_s, _ = self._by_state_and_reference(slope_z)
            if period is not None:
                A, B = _stacked(A, np.zeros((nu, A.shape[-1]))), _stacked(B, np.eye(nu))
            A, B = _stacked(A, z_s), _stacked(B, np.zeros((len(self.law.memory), nu)))
        inputs, none = _names(self.manifest.inputs), np.zeros((*u_s.shape[:-2], nu, nu))
        return LinearSystem(A, B, u_s, none, self._states(), inputs, inputs, period)

    def _parts(self, outputs: Sequence[str] | None) -> tuple[_Slopes, _Slopes, tuple[FloatArray, ...], Any]:
        """Return the derivatives of input and next memory, the plant's matrices, and the period."""
        if self.law.period:
            self._check_samples()
        acting, slope_u, slope_z = self._answer()
        A, B, *others = _plant(self.manifest, self.functions, self.x, acting, self.p, self.r, outputs)
        if not self.law.period:
            return slope_u, slope_z, (A, B, *others), None
        period = self._parameter(self.law.period)
        return slope_u, slope_z, (*_held(A, B, period), *others), period

    def _parameter(self, name: str) -> Any:
        """Return a plant parameter at all points."""
        place = [q.name for q in self.manifest.parameters].index(name)
        return np.take(np.asarray(self.p, dtype=np.float64), place, axis=-1)

    def _answer(self) -> tuple[FloatArray, _Slopes, _Slopes]:
        """Return the acting input under the law, with the derivatives of input and next memory."""
        law, nu = identifier(self.law.name), len(self.manifest.inputs)
        memory = self._memory()
        seen, slope_seen = self._seen()
        arguments = (seen, self.r, *memory, self.p, self.c)
        results, slope = self.functions[law](*arguments), slopes(self.functions[f"{law}_jvp"], *arguments)
        if self.law.period and memory:
            self._check_every(self.functions[law], arguments)
        if slope_seen is not None:
            slope["x"] = slope.pop("seen") @ slope_seen
        command, slope_u = results[0] if memory else results, {name: J[..., :nu, :] for name, J in slope.items()}
        return *self._acting(command, slope_u), {name: J[..., nu:, :] for name, J in slope.items()}

    def _seen(self) -> tuple[ArrayLike, FloatArray | None]:
        """Return the noise-free vector that the law receives.

        If this vector is not the state itself, also return its derivative with respect to the state.
        """
        if not self.manifest.measured and not (self.law.period and "measure" in self.functions):
            return self.x, None
        point = self.x, np.zeros(len(self.manifest.noise)), self.p
        measured = self.functions["measure"](*point)
        if self.manifest.measured:
            return measured, slopes(self.functions["measure_jvp"], *point)["x"]
        self._check_sensor()
        return measured, None

    def _slope(self, function: str, noise: int) -> FloatArray:
        """Return the derivative of a function with respect to the state by differences, because none is generated."""
        states, parameters = (np.asarray(v, dtype=np.float64)[..., None, :] for v in (self.x, self.p))
        step, quiet = _STEP * np.eye(len(self.manifest.states)), np.zeros(noise)
        above, below = (self.functions[function](states + h, quiet, parameters) for h in (step, -step))
        slope: FloatArray = (above - below) / (2 * _STEP)
        return slope

    def _check_sensor(self) -> None:
        """Refuse sensors of the state other than additive ones."""
        slope = self._slope("measure", len(self.manifest.noise))
        if not np.allclose(slope, np.eye(len(self.manifest.states)), rtol=0, atol=_SLOPE):
            raise InputError(
                f"the sensor of {self.manifest.model} has measurements without names: give them names by seen= of "
                "the System"
            )

    def _check_samples(self) -> None:
        """Refuse what acts between the samples of a law and has no part in the map over one period."""
        for given, name in self.manifest.delays.items():
            if np.any(self._parameter(name) > 0):
                raise InputError(f"the input {given} is delayed by {name} samples: set {name} = 0 for a linear system")
        if "jump" in self.functions:
            self._check_jump()
        if self.manifest.measured:
            self._check_skipped()

    def _check_jump(self) -> None:
        """Refuse states that change at a sample by more than noise, such as the queue of a delayed sensor."""
        slope = self._slope("jump", len(self.manifest.random_step))
        off = np.abs(slope - np.eye(len(self.manifest.states)))
        states = np.asarray(self.x, dtype=np.float64)[..., None, :]
        changed = np.any(off > _SLOPE * np.maximum(1, np.abs(states)), axis=tuple(range(off.ndim - 1)))
        if changed.any():
            few = [name for name, moves in zip(_names(self.manifest.states), changed, strict=True) if moves]
            raise InputError(
                f"sensors change states at samples ({', '.join(few[:_SHOWN])}{', ...' if few[_SHOWN:] else ''}), as "
                "with a delay or a mean over a period; a linear system leaves that out"
            )

    def _check_skipped(self) -> None:
        """Refuse sensors that skip samples: measured flags that switch between 0 and 1 over time or by chance."""
        first, numbers = (np.asarray(v, dtype=np.float64).reshape(-1, np.shape(v)[-1])[0] for v in (self.x, self.p))
        states, noise = np.tile(first, (2 * _SAMPLES, 1)), np.zeros((2 * _SAMPLES, len(self.manifest.noise)))
        if CLOCK in (names := _names(self.manifest.states)):
            period = numbers[[q.name for q in self.manifest.parameters].index(str(self.law.period))]
            states[:_SAMPLES, names.index(CLOCK)] += period * np.arange(_SAMPLES)
        noise[_SAMPLES:] = np.random.default_rng(0).standard_normal((_SAMPLES, len(self.manifest.noise)))
        seen = np.asarray(self.functions["measure"](states, noise, numbers))
        skipping = (seen.min(axis=0) == 0) & (seen.max(axis=0) == 1) & np.all((seen == 0) | (seen == 1), axis=0)
        if skipping.any():
            flags = [name for name, is_flag in zip(_names(self.manifest.measured), skipping, strict=True) if is_flag]
            raise InputError(
                f"sensors skip samples ({', '.join(flags)} switch); a linear system needs a measurement at every sample"
            )

    def _check_every(self, law: GeneratedFunction, arguments: Sequence[ArrayLike]) -> None:
        """Refuse a law that skips samples, because its counter changes after a command."""
        names = _names(self.law.memory)
        if COUNTER not in names:
            return
        seen, r, before, z, *numbers = arguments
        place, commanding = names.index(COUNTER), np.array(z, dtype=np.float64)
        commanding[..., place] = 0
        if np.any(law(seen, r, before, commanding, *numbers)[1][..., place] > 0):
            raise InputError(
                f"the law {self.law.name} commands only at some samples; a linear system needs a command at every "
                "sample"
            )

    def _states(self) -> tuple[str, ...]:
        held = self.law.memory and self.law.period
        applied = (f"applied_{name}" for name in _names(self.manifest.inputs)) if held else ()
        return (*_names(self.manifest.states), *applied, *_names(self.law.memory))

    def _memory(self) -> tuple[ArrayLike, ...]:
        """Return the previously applied input and the memory; refuse both for a law without memory."""
        if not self.law.memory:
            for name, value in (("u", self.u), ("z", self.z)):
                if value is not None:
                    raise bad_value(name, value, f"None: the law {self.law.name} gives the input and has no memory")
            return ()
        start = self.functions[f"{identifier(self.law.name)}_start"]
        memory = start(self.x, self.r, self.p, self.c) if self.z is None else self.z
        if self.law.period:
            return np.zeros(len(self.manifest.inputs)) if self.u is None else self.u, memory
        if self.u is not None:
            raise bad_value("u", self.u, f"None: the law {self.law.name} gives the input")
        return (memory,)

    def _acting(self, command: FloatArray, slope: _Slopes) -> tuple[FloatArray, _Slopes]:
        """Return the acting input and its derivatives from those of the command."""
        if "actuate" not in self.functions:
            return command, slope
        actuator = slopes(self.functions["actuate_jvp"], self.x, command, self.p)
        changed = {name: actuator["u_cmd"] @ J for name, J in slope.items()}
        return self.functions["actuate"](self.x, command, self.p), changed | {"x": changed["x"] + actuator["x"]}

    def _by_state_and_reference(self, slope: _Slopes) -> tuple[FloatArray, FloatArray]:
        """Join the derivatives with respect to state, applied input and memory; a model may have no reference."""
        parts = ("x", "v", "z") if self.law.period else ("x", "z")
        none = np.zeros((*slope["x"].shape[:-1], 0))  # of a model without inputs
        by_state = np.concatenate([slope.get(name, none) for name in (parts if self.law.memory else ("x",))], axis=-1)
        return by_state, slope["r"] if self.manifest.references else np.zeros((*by_state.shape[:-1], 0))


def slopes(derivative: GeneratedFunction, *arguments: ArrayLike) -> dict[str, FloatArray]:
    """Return the Jacobians of a function's results, stacked, from its directional derivative.

    Parameters
    ----------
    derivative : GeneratedFunction
        Such as `jvp`, or the `LAW_jvp` of a law.
    *arguments : array_like
        Arguments of the function.

    Returns
    -------
    dict of str to array, (..., results, elements)
        Jacobians by argument, without those of other arguments.

    Examples
    --------
    >>> import mehvar
    >>> model = mehvar.load("triangle")
    >>> x, u, p = model.state(rho=0.3, mu=0.2), [0.0, 0.1, 0.0], model.parameters()
    >>> bool((slopes(model.functions["jvp"], x, u, p)["u"] == model.jac_u(x, u, p)).all())
    True
    """
    along = [a for a in derivative.function.arguments if a.name.startswith("along_")]
    edges = np.cumsum([a.size for a in along])
    unit = np.split(np.eye(int(edges[-1])), edges[:-1], axis=1)
    changes = derivative(*(np.asarray(v, dtype=np.float64)[..., None, :] for v in arguments), *unit)
    rows = np.concatenate(changes if isinstance(changes, tuple) else (changes,), axis=-1)
    matrices = np.split(np.swapaxes(rows, -1, -2), edges[:-1], axis=-1)
    return {a.name.removeprefix("along_"): matrix for a, matrix in zip(along, matrices, strict=True)}


def jacobians(derivative: GeneratedFunction, *arguments: ArrayLike) -> dict[str, FloatArray]:
    """Return a generated Jacobian's matrices by argument."""
    values = derivative(*arguments)
    results = derivative.function.results
    matrices = values if isinstance(values, tuple) else (values,)
    return {result.name.removeprefix("J_"): J for result, J in zip(results, matrices, strict=True)}


def output_rows(manifest: Manifest, outputs: Sequence[str]) -> list[int]:
    """Return the positions of outputs in the vector of states and outputs.

    Raises
    ------
    InputError
        If a name is neither a state nor an output.
    """
    names = (*_names(manifest.states), *_names(manifest.outputs))
    if not isinstance(outputs, tuple | list):
        raise bad_value("outputs", outputs, "names of outputs or states, as in a list", "the call")
    for name in outputs:
        if name not in names:
            raise unknown_name(f"output of {manifest.model}", name, names)
    return [names.index(name) for name in outputs]


def slope_of_inputs(functions: Functions, x: ArrayLike, u: ArrayLike, p: ArrayLike, nu: int) -> FloatArray:
    """Return `jac_u` with a row per state, also without inputs."""
    if not nu:
        return np.zeros((*np.shape(functions["rhs"](x, u, p)), 0))
    slope: FloatArray = functions["jac_u"](x, u, p)
    return slope


def _plant(
    manifest: Manifest,
    functions: Functions,
    x: ArrayLike,
    u: ArrayLike,
    p: ArrayLike,
    r: ArrayLike,
    outputs: Sequence[str] | None,
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return A, B, C, D, and the outputs' derivatives with respect to the reference."""
    refuse(manifest, Operation.LINEARIZE)
    nx, nu, nr = len(manifest.states), len(manifest.inputs), len(manifest.references)
    A = functions["jac_x"](x, u, p)
    B = slope_of_inputs(functions, x, u, p, nu)
    C, D, E = (np.zeros((*A.shape[:-2], nx, size)) for size in (nx, nu, nr))
    C += np.eye(nx)
    rows = list(range(nx)) if outputs is None else output_rows(manifest, outputs)
    if max(rows, default=0) >= nx:
        exact = jacobians(functions["outputs_jac"], x, u, r, p)
        none = np.zeros((len(manifest.outputs), 0))
        C, D, E = (_stacked(own, exact.get(name, none)) for own, name in ((C, "x"), (D, "u"), (E, "r")))
    return A, B, C[..., rows, :], D[..., rows, :], E[..., rows, :]


def _held(A: FloatArray, B: FloatArray, period: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the map of a linear system over a period with constant input."""
    from scipy.linalg import expm  # the import takes 0.1 s, which a plant without a law does not need

    nx, n = A.shape[-1], A.shape[-1] + B.shape[-1]
    both = np.zeros((*np.broadcast_shapes(A.shape[:-2], np.shape(period)), n, n))
    both[..., :nx, :nx], both[..., :nx, nx:] = A, B
    grown = expm(both * np.asarray(period)[..., None, None])
    return grown[..., :nx, :nx], grown[..., :nx, nx:]


def _widened(matrix: FloatArray, by_state: FloatArray) -> FloatArray:
    """Return a matrix with columns of zeros for the law's additional states."""
    missing = by_state.shape[-1] - matrix.shape[-1]
    return np.concatenate([matrix, np.zeros((*matrix.shape[:-1], missing))], axis=-1)


def _stacked(above: FloatArray, below: FloatArray) -> FloatArray:
    leading = np.broadcast_shapes(above.shape[:-2], below.shape[:-2])
    return np.concatenate([np.broadcast_to(m, (*leading, *m.shape[-2:])) for m in (above, below)], axis=-2)


def _names(quantities: Sequence[Quantity]) -> tuple[str, ...]:
    return tuple(q.name for q in quantities)
