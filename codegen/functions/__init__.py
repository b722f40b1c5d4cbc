# SPDX-License-Identifier: Apache-2.0
"""From SymPy to CasADi: which functions a system has, as graphs, checked against the derivation."""
