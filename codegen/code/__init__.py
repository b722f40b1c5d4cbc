# SPDX-License-Identifier: Apache-2.0
"""Printers of CasADi graphs: one list of instructions, printed as C and Python."""
