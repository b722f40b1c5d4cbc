# SPDX-License-Identifier: Apache-2.0
"""The parts of the report of `mehvar reproduce`: charts, animations, batches, the board, and the page itself."""
