# SPDX-License-Identifier: Apache-2.0
"""Batches of closed loops: dispersions, computation, storage and statistics."""
