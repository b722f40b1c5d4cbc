# SPDX-License-Identifier: Apache-2.0
"""A law on a board: its part of the report, a page of its own, its facts, its evidence."""
