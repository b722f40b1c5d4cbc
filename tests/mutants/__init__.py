# SPDX-License-Identifier: Apache-2.0
"""Mutants of the runtime: wrong versions of its text, each of which some test should notice."""
