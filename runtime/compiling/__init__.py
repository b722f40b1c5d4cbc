# SPDX-License-Identifier: Apache-2.0
"""Compilation of C code into loaded libraries: compiler, processor, cache."""
