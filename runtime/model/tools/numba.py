# SPDX-License-Identifier: Apache-2.0
"""Generated functions compiled by Numba, for one point, with plain loops and branches.

Numba supports neither `np.errstate` nor the broadcasting of generated code. The syntax tree is therefore rewritten for
scalars; the arithmetic does not change.
"""

from __future__ import annotations

import ast
import inspect
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from mehvar.base.manifest import Function, Manifest

from .replacement import Translation, library


def numba_functions(manifest: Manifest) -> Translation:
    """Return all generated functions compiled by Numba, on vectors of doubles, for one point.

    Raises
    ------
    InputError
        If Numba is not installed.
    """
    njit = library("numba", "numba", "to_numba").njit

    def translate(name: str, generated: Callable[..., Any]) -> Any:
        tree = ast.parse(inspect.getsource(generated))
        names: dict[str, Any] = {"np": np, "_erf": math.erf}
        if calls := _calls_of_columns(tree):
            change = ast.unparse(calls[0].args[0])
            names[change] = translate(change, generated.__globals__[change])
            return njit(_jacobian(calls, names, manifest.functions[name]))
        scalar = ast.fix_missing_locations(_Scalar(manifest.functions[name].shapes).visit(tree))
        exec(compile(scalar, f"<{manifest.model} {name} for numba>", "exec"), names)
        return njit(names[generated.__name__])

    return Translation(manifest, translate)


def _calls_of_columns(tree: ast.Module) -> list[ast.Call]:
    """Return the calls of `_columns` that compute the results of a Jacobian; empty for other functions."""
    calls = (node for node in ast.walk(tree) if isinstance(node, ast.Call))
    return [call for call in calls if ast.unparse(call.func) == "_columns"]


def _jacobian(calls: Sequence[ast.Call], names: Mapping[str, Any], function: Function) -> Callable[..., Any]:
    """Return a Jacobian whose columns are changes along unit vectors, as generated code computes it.

    Parameters
    ----------
    calls : sequence of ast.Call
        One for each result: the directional derivative, the point, the sizes of the directions, and the place of the
        one that varies.
    names : mapping
        The compiled directional derivative by its name, and NumPy.
    function : Function
        Of the manifest.
    """
    change, _, sizes, _ = calls[0].args
    arguments = ", ".join(argument.name for argument in function.arguments)
    directions = [f"along_{k}" for k in range(len(ast.literal_eval(sizes)))]
    lines = [f"{name} = np.zeros({n})" for name, n in zip(directions, ast.literal_eval(sizes), strict=True)]
    for result, shape, call in zip(function.results, function.shapes, calls, strict=True):
        direction = f"{directions[ast.literal_eval(call.args[3])]}[k]"
        lines += [
            f"{result.name} = np.empty({shape})",
            f"for k in range({shape[1]}):",
            f"    {direction} = 1.0",
            f"    {result.name}[:, k] = {ast.unparse(change)}({arguments}, {', '.join(directions)})",
            f"    {direction} = 0.0",
        ]
    lines.append(f"return {', '.join(result.name for result in function.results)}")
    namespace = dict(names)
    exec("\n    ".join([f"def jacobian({arguments}):", *lines]), namespace)
    return namespace["jacobian"]  # type: ignore[no-any-return]


class _Scalar(ast.NodeTransformer):
    """Transformer that rewrites code for arrays with leading axes as code for one point."""

    def __init__(self, shapes: tuple[tuple[int, ...], ...]) -> None:
        self._shapes = shapes

    def visit_With(self, node: ast.With) -> list[ast.stmt]:
        """Omit `with np.errstate(...)`, as compiled arithmetic does not warn."""
        return [new for statement in node.body for new in self._statements(statement)]

    def visit_Assign(self, node: ast.Assign) -> ast.stmt | None:
        """Omit the conversion of arguments."""
        if isinstance(node.value, ast.Call) and ast.unparse(node.value.func) == "_arrays":
            return None
        return ast.Assign(node.targets, self.visit(node.value))

    def visit_Subscript(self, node: ast.Subscript) -> ast.expr:
        """Replace `x[..., k]` by `x[k]`."""
        assert isinstance(node.slice, ast.Tuple)
        return ast.Subscript(node.value, node.slice.elts[1], node.ctx)

    def visit_Call(self, node: ast.Call) -> ast.expr:
        """Replace `np.where(m, a, b)` by `a if m else b`."""
        arguments = [self.visit(argument) for argument in node.args]
        if ast.unparse(node.func) == "np.where":
            return ast.IfExp(*arguments)
        return ast.Call(node.func, arguments, [])

    def visit_Return(self, node: ast.Return) -> list[ast.stmt]:
        """Replace stacked elements by filled arrays of the results' shapes."""
        assert node.value is not None
        several = len(self._shapes) > 1
        values = node.value.elts if several and isinstance(node.value, ast.Tuple) else [node.value]
        lines: list[ast.stmt] = []
        for k, (shape, value) in enumerate(zip(self._shapes, values, strict=True)):
            elements = [self.visit(element) for element in _elements(value)]
            lines += _filled(f"result{k}", shape, elements) if shape else [_assign(f"result{k}", elements[0])]
        names = ", ".join(f"result{k}" for k in range(len(values)))
        return [*lines, *ast.parse(f"def f():\n return {names}").body[0].body]  # type: ignore[attr-defined]

    def _statements(self, statement: ast.stmt) -> list[ast.stmt]:
        new = self.visit(statement)
        return new if isinstance(new, list) else [new] if new is not None else []


def _elements(value: ast.expr) -> list[ast.expr]:
    """Return the elements of a result: `_vector(...)`, its reshaped form in a lambda, or `np.asarray(...)[()]`."""
    call = value.value if isinstance(value, ast.Subscript) else value
    assert isinstance(call, ast.Call)
    if isinstance(call.func, ast.Lambda):
        return _elements(call.args[0])
    return call.args


def _filled(name: str, shape: tuple[int, ...], elements: list[ast.expr]) -> list[ast.stmt]:
    lines: list[ast.stmt] = [*ast.parse(f"{name} = np.empty({shape})").body]
    for place, element in zip(np.ndindex(*shape), elements, strict=True):
        lines.append(_assign(f"{name}[{', '.join(map(str, place))}]", element))
    return lines


def _assign(target: str, value: ast.expr) -> ast.Assign:
    line = ast.parse(f"{target} = 0").body[0]
    assert isinstance(line, ast.Assign)
    return ast.Assign(line.targets, value)
