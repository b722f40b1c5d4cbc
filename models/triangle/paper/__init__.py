# SPDX-License-Identifier: Apache-2.0
"""What the triangle's paper prints, for the ledger."""
