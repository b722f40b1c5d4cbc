# SPDX-License-Identifier: Apache-2.0
"""Physics and control laws in SymPy."""
