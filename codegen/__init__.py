# SPDX-License-Identifier: Apache-2.0
"""From SymPy to code: CasADi's graphs and derivatives, one list of instructions, and C and Python printed from it."""
