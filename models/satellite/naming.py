# SPDX-License-Identifier: Apache-2.0
"""Named vectors and matrices: a definition for each entry; `*` in names and titles stands for the entry's index."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import sympy as sp

from ..system import Derivation, Expr


def vector(
    name: str, values: Iterable[Expr], title: str, unit: str, latex: str, d: Derivation, number: str = "",
    labels: Sequence[str] = "xyz",
) -> sp.Matrix:  # fmt: skip
    """Name the components of a vector."""
    return sp.Matrix(
        [
            d.define(name.replace("*", i), value, number, title.replace("*", i), unit, latex.replace("*", i))
            for i, value in zip(labels, values, strict=True)
        ]
    )


def matrix(name: str, values: sp.Matrix, title: str, unit: str, d: Derivation, number: str = "") -> sp.Matrix:
    """Name the elements of a matrix, row by row."""
    labels = [f"{i + 1}{j + 1}" for i in range(3) for j in range(3)]
    return vector(f"{name}*", values, title, unit, f"{name}_{{*}}", d, number, labels).reshape(3, 3)


def symmetric(
    name: str, values: sp.Matrix, title: str, unit: str, latex: str, d: Derivation, number: str = ""
) -> sp.Matrix:
    """Name the elements of a symmetric matrix."""
    places = [(i, j) for i in range(3) for j in range(i, 3)]
    labels = [f"{i + 1}{j + 1}" for i, j in places]
    upper = [values[place] for place in places]
    named = dict(zip(places, vector(f"{name}*", upper, title, unit, f"{latex}_{{*}}", d, number, labels), strict=True))
    return sp.Matrix(3, 3, lambda i, j: named[min(i, j), max(i, j)])
