# SPDX-License-Identifier: Apache-2.0
"""Refusal of Python branches on symbols during derivation; the equations would contain only one branch."""

from __future__ import annotations

import ast
import contextlib
import functools
import linecache
import sys
from collections.abc import Iterator
from types import FrameType
from typing import Any

import sympy as sp
from sympy.core.relational import Relational

from ..quantities import ModelError, advise, place
from ..system import Expr

_BY_FORM = (
    *("sympy.", "mpmath.", "mehvar.models.mechanics.", "mehvar.models.parts.", "mehvar.models.estimation."),
    "mehvar.models.derivation.",
)
"""Packages whose code may test the form of expressions, for example to skip structural zeros or to look them up in a
cache."""


@contextlib.contextmanager
def no_branching() -> Iterator[None]:
    """Make a Python `if` on a symbol an error while a model is derived.

    SymPy itself refuses `if x > 0`. It accepts `if x:` and `if x == 0:` and silently takes one branch, because `==`
    compares forms. Inside this context both raise `ModelError` if a model's own source contains them.

    Two comparisons with zero are accepted, because no value of a symbol can change their result:

    - a comparison that SymPy's assumptions decide, such as `m == 0` for a positive mass;
    - `M[i, j] != 0` and `M[i, j] == 0` for an entry of a matrix, written as such. They test the structure of the
      matrix: a sum over its nonzero entries equals the sum over all. The same test of a name or a formula, `x == 0`,
      tests a value and is refused.
    """
    if "__bool__" in sp.Expr.__dict__:  # an outer context is active
        yield
        return
    advise()  # here, because a first call inside of the context would hide the frame of the model
    plain_eq, plain_ne = sp.Expr.__eq__, sp.Expr.__ne__

    def truth(expr: Expr) -> bool:
        _refuse(expr, "the truth of")
        return True

    def equal(expr: Expr, other: object) -> Any:
        same = plain_eq(expr, other)
        comparable = same is not True and not _tests_form(_caller()) and isinstance(other, int | float | sp.Expr)
        if comparable and (_symbolic(expr) or _symbolic(other)):
            _refuse(expr if _symbolic(expr) else other, "equality with", other if _symbolic(expr) else expr)
        return same

    def unequal(expr: Expr, other: object) -> Any:
        same = equal(expr, other)
        return same if same is NotImplemented else not same

    def decided(relation: Relational) -> bool:
        _refuse(relation, "the truth of")
        return bool(plain_truth(relation))

    plain_truth = Relational.__bool__
    Relational.__bool__ = decided
    sp.Expr.__bool__ = truth
    sp.Expr.__eq__, sp.Expr.__ne__ = equal, unequal
    try:
        yield
    finally:
        del sp.Expr.__bool__
        Relational.__bool__ = plain_truth
        sp.Expr.__eq__, sp.Expr.__ne__ = plain_eq, plain_ne


def _symbolic(value: object) -> bool:
    return isinstance(value, sp.Expr) and bool(value.free_symbols)


def _refuse(expr: Expr | Relational, what: str, other: object = None) -> None:
    """Refuse a test of a symbolic expression unless SymPy itself makes it or the result is the same for all values."""
    frame = _caller()
    if _tests_form(frame) or not expr.free_symbols:
        return
    zero = isinstance(other, int | float | sp.Number) and sp.sympify(other).is_zero
    if zero and (expr.is_zero is False or _is_entry_with_zero(frame)):
        return
    raise ModelError(
        f"{place(frame.f_code.co_filename, frame.f_lineno)}: a Python branch asks for {what} the symbolic expression "
        f"{expr}; use sympy.Piecewise so that both branches are kept, and sympy.Min, Max and Abs for min, max and abs"
    )


def _caller() -> FrameType:
    """Return the frame outside of this module."""
    frame = sys._getframe(2)
    while frame.f_globals.get("__name__") == __name__ and frame.f_back:
        frame = frame.f_back
    return frame


def _tests_form(frame: FrameType) -> bool:
    return _may_test_form(frame.f_globals.get("__name__", ""))


@functools.cache
def _may_test_form(module: str) -> bool:
    return f"{module}.".startswith(_BY_FORM)


def _is_entry_with_zero(frame: FrameType) -> bool:
    """Return True if a frame evaluates `M[...] == 0` or `!= 0` for a matrix M."""
    try:
        node = ast.parse(f"({_source(frame)})", mode="eval").body
    except SyntaxError:
        return False
    if not (isinstance(node, ast.Compare) and isinstance(node.left, ast.Subscript)):
        return False
    literal = node.comparators[0]
    if len(node.ops) > 1 or not (isinstance(literal, ast.Constant) and literal.value == 0):
        return False
    return isinstance(_value(node.left.value, frame), sp.MatrixBase | sp.NDimArray)


def _source(frame: FrameType) -> str:
    """Return the source text that a frame evaluates. Columns count bytes, so the end is cut before the start."""
    positions = list(frame.f_code.co_positions())[frame.f_lasti // 2]
    first, last, start, end = (position or 0 for position in positions)
    lines = [linecache.getline(frame.f_code.co_filename, k).encode() for k in range(first, last + 1)]
    if not lines:
        return ""
    lines[-1] = lines[-1][:end]
    lines[0] = lines[0][start:]
    return b"".join(lines).decode(errors="replace")


def _value(node: ast.expr, frame: FrameType) -> object:
    """Return the value of a name, or of an attribute of a name, in a frame."""
    if isinstance(node, ast.Name):
        return frame.f_locals.get(node.id, frame.f_globals.get(node.id))
    if isinstance(node, ast.Attribute):
        return getattr(_value(node.value, frame), node.attr, None)
    return None
