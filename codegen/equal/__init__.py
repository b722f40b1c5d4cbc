# SPDX-License-Identifier: Apache-2.0
"""Equality of expressions: one engine for comparisons of versions and for ledgers."""
