# SPDX-License-Identifier: Apache-2.0
"""What batches cost, alone and beside other integrators, and what they survive."""
