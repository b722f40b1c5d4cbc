# SPDX-License-Identifier: Apache-2.0
"""From SymPy to text: CasADi's graph and derivatives, one instruction tape, C and Python printed from it."""
