# SPDX-License-Identifier: Apache-2.0
"""Cost of batches, alone and beside other integrators, and the faults they survive."""
