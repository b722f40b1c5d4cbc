# SPDX-License-Identifier: Apache-2.0
"""From CasADi to code: one list of instructions, printed as C and Python."""
