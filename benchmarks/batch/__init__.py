# SPDX-License-Identifier: Apache-2.0
"""Cost of batches, alone and in comparison with other integrators, and recovery from faults."""
