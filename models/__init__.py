# SPDX-License-Identifier: Apache-2.0
"""The physics and the control laws, written in SymPy and nothing else."""
