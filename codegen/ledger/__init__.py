# SPDX-License-Identifier: Apache-2.0
"""Verdicts on the equations that a paper prints, from the derivation."""
