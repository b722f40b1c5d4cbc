# SPDX-License-Identifier: Apache-2.0
"""Pages about a law on a board: part of the report, own page, facts, evidence."""
