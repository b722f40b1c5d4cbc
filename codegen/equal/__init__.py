# SPDX-License-Identifier: Apache-2.0
"""Equality of expressions: the engine behind comparisons of versions and ledgers."""
