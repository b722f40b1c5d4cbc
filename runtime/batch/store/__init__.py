# SPDX-License-Identifier: Apache-2.0
"""Batch on disk: arrays, the records that verify them, and the writer's lock."""
