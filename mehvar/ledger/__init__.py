# SPDX-License-Identifier: Apache-2.0
"""Comparison of printed equations with derived ones, as pages and text."""
