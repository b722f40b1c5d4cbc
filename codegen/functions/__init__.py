# SPDX-License-Identifier: Apache-2.0
"""From SymPy to CasADi: the functions of a system as graphs, checked against the derivation."""
