# SPDX-License-Identifier: Apache-2.0
"""From CasADi to text: one instruction tape, printed as C and as Python."""
