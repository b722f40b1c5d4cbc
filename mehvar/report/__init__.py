# SPDX-License-Identifier: Apache-2.0
"""Report of `mehvar reproduce` and pages of `mehvar report`: charts, animations, batches, boards."""
