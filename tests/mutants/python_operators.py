# SPDX-License-Identifier: Apache-2.0
"""Mutation operators for Python from Cosmic Ray, without mutants that a type checker or the next line refuses.

Cosmic Ray was taken because it is maintained, has its operators apart from its runner, and changes one place of a text:
the runner here serves Python and C alike, and chooses tests by module. mutmut rewrites a package into trampolines and
needs it importable from one root; this one stands in folders at the top of the repository.
"""

from __future__ import annotations

import ast
import functools
import pickle
from collections.abc import Iterator

from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import MutationVisitor
from cosmic_ray.plugins import get_operator

Span = tuple[tuple[int, int], tuple[int, int]]

_NAMES = (
    *(f"ReplaceComparisonOperator_{pair}" for pair in (
        "Eq_NotEq", "NotEq_Eq", "Lt_LtE", "LtE_Lt", "Gt_GtE", "GtE_Gt", "Lt_GtE", "Gt_LtE", "Is_IsNot", "IsNot_Is",
    )),
    *(f"ReplaceBinaryOperator_{pair}" for pair in (
        "Add_Sub", "Sub_Add", "Mul_Div", "Div_Mul", "FloorDiv_Mul", "Mod_Mul", "Pow_Mul", "LShift_RShift",
        "RShift_LShift", "BitAnd_BitOr", "BitOr_BitAnd", "BitXor_BitOr",
    )),
    "AddNot", "NumberReplacer", "ReplaceAndWithOr", "ReplaceOrWithAnd", "ReplaceTrueWithFalse", "ReplaceFalseWithTrue",
    "ReplaceBreakWithContinue", "ReplaceContinueWithBreak", "ReplaceUnaryOperator_Delete_Not",
    "ReplaceUnaryOperator_Delete_USub", "ZeroIterationForLoop",
)  # fmt: skip


def places(text: str) -> Iterator[tuple[int, str, tuple[str, int]]]:
    """Yield the line, the operator and (operator, occurrence) of every mutant of a Python text."""
    nodes, closed = list(ast_nodes(get_ast(text))), list(_closed(ast.parse(text)))
    for name in _NAMES:
        operator = get_operator(f"core/{name}")()
        spans = (span for node in nodes for span in operator.mutation_positions(node))
        for occurrence, (start, end) in enumerate(spans):
            if not any(first <= start and end <= last for first, last in closed):
                yield start[0], name, (name, occurrence)


def _closed(tree: ast.Module) -> Iterator[Span]:
    """Yield places at which a mutant is the same program or changes only words.

    Annotations are not evaluated; a message's text is not what a test holds; whether zip is strict and a dataclass is
    frozen are checks of our own calls, which no input reaches.
    """
    for node in ast.walk(tree):
        if isinstance(node, ast.Raise) and node.exc:
            yield from map(_span, _texts(node.exc))
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "zip":
            yield from (_span(keyword.value) for keyword in node.keywords)
        elif isinstance(node, ast.ClassDef):
            yield from map(_span, node.decorator_list)
        for part in (getattr(node, "annotation", None), getattr(node, "returns", None)):
            if isinstance(part, ast.expr):
                yield _span(part)


def _texts(error: ast.expr) -> Iterator[ast.expr]:
    """Yield the f-strings of an error that is raised."""
    return (node for node in ast.walk(error) if isinstance(node, ast.JoinedStr))


def _span(node: ast.expr) -> Span:
    return (node.lineno, node.col_offset), (node.end_lineno or node.lineno, node.end_col_offset or 0)


def mutate(text: str, place: tuple[str, int]) -> tuple[int, int, str]:
    """Return (start, end, replacement) of one mutant; the replaced part is a run of whole lines."""
    name, occurrence = place
    visitor = MutationVisitor(occurrence, get_operator(f"core/{name}")())
    return _difference(text, visitor.walk(pickle.loads(_parsed(text))).get_code())


@functools.cache
def _parsed(text: str) -> bytes:
    """Return the pickled syntax tree of a text; unpickling takes a tenth of the time of parsing."""
    return pickle.dumps(get_ast(text))


def _difference(before: str, after: str) -> tuple[int, int, str]:
    """Return the lines of a text that differ, as one replacement."""
    old, new = before.splitlines(keepends=True), after.splitlines(keepends=True)
    shortest = min(len(old), len(new))
    head = next((k for k in range(shortest) if old[k] != new[k]), shortest)
    tail = next((k for k in range(shortest - head) if old[-1 - k] != new[-1 - k]), shortest - head)
    start, end = len("".join(old[:head])), len("".join(old[: len(old) - tail]))
    return start, end, "".join(new[head : len(new) - tail])
