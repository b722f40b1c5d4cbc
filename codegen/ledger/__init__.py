# SPDX-License-Identifier: Apache-2.0
"""Verdicts on a paper's printed equations, based on the derivation."""
