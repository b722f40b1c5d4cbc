# SPDX-License-Identifier: Apache-2.0
"""Comparison of two versions of derived equations: sources, verdicts, text, pages."""
