# SPDX-License-Identifier: Apache-2.0
"""Compilation of C code to loaded libraries: compiler, processor, cache."""
