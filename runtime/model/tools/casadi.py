# SPDX-License-Identifier: Apache-2.0
"""Generated functions as CasADi functions, with CasADi's derivatives."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import nullcontext
from types import SimpleNamespace
from typing import Any

from mehvar.base.manifest import Function

from .replacement import library, with_globals

_RENAMED = {
    "abs": "fabs", "arcsin": "asin", "arccos": "acos", "arctan": "atan", "arctan2": "atan2", "arcsinh": "asinh",
    "arccosh": "acosh", "arctanh": "atanh", "logical_not": "logic_not", "logical_and": "logic_and",
    "logical_or": "logic_or", "where": "if_else",
}  # fmt: skip
_SAME = ("sin", "cos", "tan", "sinh", "cosh", "tanh", "exp", "log", "log1p", "expm1", "sqrt", "sign", "copysign",
         "fmin", "fmax", "floor", "ceil", "fmod", "hypot", "power")  # fmt: skip


class _Vector:
    """A column of expressions with the array operations of generated code: `x[..., k]`, `J.reshape(r, c)`."""

    def __init__(self, casadi: Any, column: Any) -> None:
        self._casadi, self.column = casadi, column
        self.shape = (column.numel(),)

    def __getitem__(self, place: tuple[object, int]) -> Any:
        return self.column[place[1]]

    def reshape(self, rows: int, columns: int) -> _Vector:
        """Return the elements row by row, because CasADi counts down the columns."""
        return _Vector(self._casadi, self._casadi.reshape(self.column, columns, rows).T)


def casadi_function(function: Function, generated: Callable[..., Any]) -> Any:
    """Return a `casadi.Function` on SX with the manifest's names and shapes.

    Parameters
    ----------
    function : Function
        Of the manifest.
    generated : callable
        Function of the generated Python module, which is called with symbols.

    Raises
    ------
    InputError
        If CasADi is not installed.
    """
    casadi = library("casadi", "casadi", "to_casadi")
    symbols = [casadi.SX.sym(spec.name, spec.size) for spec in function.arguments]
    arguments = [_Vector(casadi, s) if spec.shape else s for spec, s in zip(function.arguments, symbols, strict=True)]
    numpy = SimpleNamespace(
        errstate=lambda **_: nullcontext(),
        asarray=lambda value: {(): value},  # generated code takes the scalar out again: np.asarray(value)[()]
        **{name: getattr(casadi, name) for name in _SAME},
        **{ours: getattr(casadi, theirs) for ours, theirs in _RENAMED.items()},
    )
    call = with_globals(
        generated,
        np=numpy,
        _arrays=lambda *values: values,
        _vector=lambda *elements: _Vector(casadi, casadi.vertcat(casadi.SX(0, 1), *elements)),
        _erf=casadi.erf,
        _columns=lambda change, point, sizes, place: _columns(casadi, change, point, sizes, place),
    )
    out = call(*arguments)
    results = [out] if len(function.results) == 1 else list(out)
    columns = [result.column if isinstance(result, _Vector) else result for result in results]
    names = ([array.name for array in group] for group in (function.arguments, function.results))
    return casadi.Function(function.name, symbols, columns, *names)


def _columns(
    casadi: Any, change: Callable[..., Any], point: Sequence[Any], sizes: Sequence[int], place: int
) -> _Vector:
    """Return a Jacobian whose columns are changes along unit vectors, as generated code computes it."""
    columns = []
    for k in range(sizes[place]):
        along = [casadi.SX(size, 1) for size in sizes]
        along[place][k] = 1
        columns.append(change(*point, *(_Vector(casadi, casadi.densify(vector)) for vector in along)).column)
    return _Vector(casadi, casadi.horzcat(casadi.SX(point[0].shape[0], 0), *columns))
