# SPDX-License-Identifier: Apache-2.0
"""User laws in Python, and inputs over time without a law."""
