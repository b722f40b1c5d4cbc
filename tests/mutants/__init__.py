# SPDX-License-Identifier: Apache-2.0
"""Mutants of the runtime: wrong versions of its code, which tests should detect."""
