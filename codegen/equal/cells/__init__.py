# SPDX-License-Identifier: Apache-2.0
"""Comparison of expressions with branches, cell by cell."""
