# SPDX-License-Identifier: Apache-2.0
"""Arrays of parameters: vectors, matrices and interpolated tables."""

from .kinds import INCREASING, Table, Tensor, array_of, elements

__all__ = ["INCREASING", "Table", "Tensor", "array_of", "elements"]
