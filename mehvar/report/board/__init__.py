# SPDX-License-Identifier: Apache-2.0
"""Pages about a law on a board: section of the report, separate page, facts, evidence."""
