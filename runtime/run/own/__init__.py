# SPDX-License-Identifier: Apache-2.0
"""A law of one's own in Python, and inputs over time without a law."""
