# SPDX-License-Identifier: Apache-2.0
"""Batch on disk: arrays, verification records, and a lock for the writer."""
