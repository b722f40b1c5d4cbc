# SPDX-License-Identifier: Apache-2.0
"""Results and batches in the formats of other programs."""
