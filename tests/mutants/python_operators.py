# SPDX-License-Identifier: Apache-2.0
"""Mutation operators for Python: those of Cosmic Ray, without what a type checker or the next line refuses anyway.

Cosmic Ray was taken because it is maintained, has its operators apart from its runner, and changes one place of a text:
the runner here serves Python and C alike, and chooses tests by module. mutmut rewrites a package into trampolines and
needs it importable from one root; this one stands in folders at the top of the repository.
"""

from __future__ import annotations

from collections.abc import Iterator

from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import MutationVisitor
from cosmic_ray.plugins import get_operator

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


def places(text: str) -> Iterator[tuple[str, int]]:
    """Yield (operator, occurrence) of every mutant of a Python text."""
    nodes = list(ast_nodes(get_ast(text)))
    for name in _NAMES:
        operator = get_operator(f"core/{name}")()
        for occurrence in range(sum(len(list(operator.mutation_positions(node))) for node in nodes)):
            yield name, occurrence


def mutate(text: str, place: tuple[str, int]) -> tuple[int, int, str]:
    """Return (start, end, replacement) of one mutant; the replaced part is a run of whole lines."""
    name, occurrence = place
    changed = MutationVisitor.mutate_code(text, get_operator(f"core/{name}")(), occurrence)
    return _difference(text, text if changed is None else changed)


def _difference(before: str, after: str) -> tuple[int, int, str]:
    """Return the lines of a text that differ, as one replacement."""
    old, new = before.splitlines(keepends=True), after.splitlines(keepends=True)
    shortest = min(len(old), len(new))
    head = next((k for k in range(shortest) if old[k] != new[k]), shortest)
    tail = next((k for k in range(shortest - head) if old[-1 - k] != new[-1 - k]), shortest - head)
    start, end = len("".join(old[:head])), len("".join(old[: len(old) - tail]))
    return start, end, "".join(new[head : len(new) - tail])
