# SPDX-License-Identifier: Apache-2.0
"""From a generated model to an image for a board, and what is in it."""
