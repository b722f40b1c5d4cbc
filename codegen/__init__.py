# SPDX-License-Identifier: Apache-2.0
"""Code generation: SymPy expressions become CasADi graphs, then one list of instructions, printed as C and Python."""
